//! Output of the bearing forces of every sample as a CSV file.

use super::force::EvaluatedForce;
use ballrace_base::output::{AtomicFile, OutputError, quoted};
use ballrace_outcome::options::Source;
use ballrace_plant::MountedBearing;
use ballrace_recording::status::SampleStatus;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Returns the flags of a sample whose forces are those of `source`.
pub(super) fn status_of(status: SampleStatus, source: Source) -> SampleStatus {
    if source == Source::Observer { status } else { status.without(SampleStatus::FROM_DISPLACEMENT) }
}

/// File with the forces of every sample; it appears complete at the end or not at all.
pub(super) struct ForcesFile {
    file: AtomicFile,
    path: PathBuf,
    source: Source,
}

impl ForcesFile {
    /// Creates the file and writes its header.
    pub(super) fn create(path: &Path, source: Source, bearings: &[MountedBearing]) -> Result<Self, OutputError> {
        let mut file = Self { file: AtomicFile::create(path)?, path: path.to_owned(), source };
        let mut header = "time_s".to_owned();
        for bearing in bearings {
            for component in ["FX_N", "FY_N", "FZ_N", "MX_Nm", "MY_Nm"] {
                header += ",";
                header += &quoted(&format!("{}_{component}", bearing.name));
            }
        }
        file.write(format_args!("{header},status\n"))?;
        Ok(file)
    }

    fn write(&mut self, text: std::fmt::Arguments) -> Result<(), OutputError> {
        self.file.write_fmt(text).map_err(|source| OutputError::Write { file: self.path.clone(), source })
    }

    /// Writes the row of one sample.
    pub(super) fn add(
        &mut self,
        time: f64,
        forces: &[EvaluatedForce],
        status: SampleStatus,
    ) -> Result<(), OutputError> {
        self.write(format_args!("{time:.9}"))?;
        let source = self.source;
        for component in forces.iter().flat_map(|force| force.of(source)) {
            self.write(format_args!(",{component:.9e}"))?;
        }
        self.write(format_args!(",{}\n", status_of(status, source).bits()))
    }

    /// Completes the file.
    pub(super) fn finish(self) -> Result<(), OutputError> {
        self.file.finish()
    }
}
