//! Instants of the pulses of a keyphasor: a vector with a length of its own beside the samples.

use std::path::Path;

use super::error::RecordingError;
use super::table::Table;
use ballrace_base::printable::number;
use ballrace_scene::{KeyphasorSignal, RotationSource, units};

/// Least distance in samples of instants that are used: each sample has one at most.
const LEAST_SPACING: f64 = 1.0;

/// The instants that are used, in order.
pub(super) struct Instants {
    column: String,
    /// s, in the time of the samples.
    times: Vec<f64>,
    /// Place of the next instant.
    next: usize,
    has_begun: bool,
}

impl Instants {
    /// Reads the instants of a keyphasor from the column at `place`; of an encoder every n-th one is used. None for another keyphasor.
    ///
    /// # Errors
    /// A format whose columns have equal lengths, a unit that is not the scene's, instants that do not rise.
    pub(super) fn read(
        table: &mut dyn Table,
        place: usize,
        rotation: &RotationSource,
        file: &Path,
    ) -> Result<Option<Self>, RecordingError> {
        let RotationSource::Keyphasor {
            column,
            pulses_per_turn,
            missing,
            signal: KeyphasorSignal::Instants { seconds },
        } = rotation
        else {
            return Ok(None);
        };
        let wrong = |found: String| RecordingError::Instants { file: file.into(), column: column.clone(), found };
        if let (Some(found), Some(expected)) = (table.unit(place), units::time_name(*seconds))
            && units::contradict(found, expected)
        {
            let (found, expected) = (found.to_owned(), expected.to_owned());
            return Err(RecordingError::Unit { file: file.into(), column: column.clone(), found, expected });
        }
        let vector =
            table.vector(place)?.ok_or_else(|| wrong("a column of a file whose columns have equal lengths".into()))?;
        if let Some((before, after)) =
            vector.iter().zip(vector.iter().skip(1)).find(|(before, after)| before >= after || after.is_nan())
        {
            return Err(wrong(format!("{} after {}", number(*after), number(*before))));
        }
        let spacing = KeyphasorSignal::instant_spacing(*pulses_per_turn, *missing);
        let times: Vec<f64> = vector.iter().step_by(spacing as usize).map(|time| time * seconds).collect();
        if times.len() < 2 {
            return Err(wrong(format!("{} values", vector.len())));
        }
        Ok(Some(Self { column: column.clone(), times, next: 0, has_begun: false }))
    }

    /// Checks that the instants are at least a sample apart for the most part.
    ///
    /// # Errors
    /// A median distance of less than a sample.
    pub(super) fn check(&self, rate: f64, file: &Path) -> Result<(), RecordingError> {
        let mut steps: Vec<f64> = self.times.windows(2).map(|pair| (pair[1] - pair[0]) * rate).collect();
        steps.sort_by(f64::total_cmp);
        let median = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
        if median >= LEAST_SPACING {
            return Ok(());
        }
        let found = format!("instants that are {} samples apart", number(median));
        Err(RecordingError::Instants { file: file.into(), column: self.column.clone(), found })
    }

    /// Returns the number of samples since the last instant up to this sample at `time` (s), where it comes after the sample before;
    /// else -1.
    pub(super) fn next(&mut self, time: f64, rate: f64) -> f64 {
        let mut last = None;
        while let Some(instant) = self.times.get(self.next).filter(|instant| **instant <= time) {
            last = Some(*instant);
            self.next += 1;
        }
        let is_first = !std::mem::replace(&mut self.has_begun, true);
        let age = last.map(|last| (time - last) * rate);
        // Pulses before the recording are no pulses of a sample.
        age.filter(|age| !is_first || *age < 1.0).unwrap_or(-1.0)
    }
}
