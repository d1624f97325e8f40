//! Output files that are whole or not there: written beside their place, moved into it at the end.

use anyhow::{Context, Result};
use std::fs::{File, OpenOptions};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// A file under way. Dropped before [`AtomicFile::finish`], it leaves nothing behind.
pub struct AtomicFile {
    writer: BufWriter<Place>,
    /// Where it goes, links followed.
    path: PathBuf,
}

enum Place {
    /// A new or a regular file: replaced as a whole.
    Beside(NamedTempFile),
    /// A pipe or a device, which has no whole to replace.
    Straight(File),
}

impl Write for Place {
    fn write(&mut self, buffer: &[u8]) -> std::io::Result<usize> {
        match self {
            Self::Beside(file) => file.write(buffer),
            Self::Straight(file) => file.write(buffer),
        }
    }
    fn flush(&mut self) -> std::io::Result<()> {
        match self {
            Self::Beside(file) => file.flush(),
            Self::Straight(file) => file.flush(),
        }
    }
}

fn failed(path: &Path) -> impl FnOnce() -> String {
    move || format!("{}: this file cannot be written", path.display())
}

impl AtomicFile {
    /// Begins a file; fails at once where it could not be written at the end.
    ///
    /// # Errors
    /// A folder that is missing or not writable, a path that is a folder.
    pub fn create(path: &Path) -> Result<Self> {
        if path.is_dir() {
            anyhow::bail!("{}: found a folder, allowed: the name of a file to write", path.display());
        }
        // A link is followed, not replaced.
        let path = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let special = path.metadata().is_ok_and(|m| !m.is_file());
        let place = if special {
            Place::Straight(OpenOptions::new().write(true).open(&path).with_context(failed(&path))?)
        } else {
            let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
            let file = tempfile::Builder::new().prefix(".ballrace-").tempfile_in(folder);
            // The system's reason alone: the temporary name would mean nothing to the user.
            let file = file.map_err(|e| std::io::Error::from(e.kind())).with_context(failed(&path))?;
            Place::Beside(file)
        };
        Ok(Self { writer: BufWriter::with_capacity(1 << 16, place), path })
    }

    /// Writes the whole of `contents` to `path`.
    ///
    /// # Errors
    /// As [`AtomicFile::create`] and [`AtomicFile::finish`].
    pub fn write(path: &Path, contents: &str) -> Result<()> {
        let mut file = Self::create(path)?;
        file.write_all(contents.as_bytes()).with_context(failed(path))?;
        file.finish()
    }

    /// Moves the file into its place, with the permissions that a new file has.
    ///
    /// # Errors
    /// A full disk, a place that became unwritable.
    pub fn finish(self) -> Result<()> {
        let Self { writer, path } = self;
        let Place::Beside(file) = writer.into_inner().map_err(|e| e.into_error()).with_context(failed(&path))? else {
            return Ok(());
        };
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let permissions = std::fs::Permissions::from_mode(0o644);
            file.as_file().set_permissions(permissions).with_context(failed(&path))?;
        }
        // In its place it has to be whole, also after the power failed.
        file.as_file().sync_all().with_context(failed(&path))?;
        file.persist(&path).map_err(|e| e.error).with_context(failed(&path))?;
        Ok(())
    }
}

impl Write for AtomicFile {
    fn write(&mut self, buffer: &[u8]) -> std::io::Result<usize> {
        self.writer.write(buffer)
    }
    fn flush(&mut self) -> std::io::Result<()> {
        self.writer.flush()
    }
}
