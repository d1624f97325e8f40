//! Output files that are whole or not there: written beside their place, moved into it at the end.

use anyhow::{Context, Result};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// A file under way. Dropped before [`AtomicFile::finish`], it leaves nothing behind.
pub struct AtomicFile {
    writer: BufWriter<NamedTempFile>,
    path: PathBuf,
}

impl AtomicFile {
    /// Begins a file; fails at once where it could not be written at the end.
    ///
    /// # Errors
    /// A folder that is missing or not writable, a path that is a folder.
    pub fn create(path: &Path) -> Result<Self> {
        let failed = || format!("{}: this file cannot be written", path.display());
        if path.is_dir() {
            anyhow::bail!("{}: found a folder, allowed: the name of a file to write", path.display());
        }
        let folder = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let file = tempfile::Builder::new().prefix(".ballrace-").tempfile_in(folder).with_context(failed)?;
        Ok(Self { writer: BufWriter::with_capacity(1 << 16, file), path: path.to_owned() })
    }

    /// Writes the whole of `contents` to `path`.
    ///
    /// # Errors
    /// As [`AtomicFile::create`] and [`AtomicFile::finish`].
    pub fn write(path: &Path, contents: &str) -> Result<()> {
        let mut file = Self::create(path)?;
        file.write_all(contents.as_bytes())
            .with_context(|| format!("{}: this file cannot be written", path.display()))?;
        file.finish()
    }

    /// Moves the file into its place, with the permissions that a new file has.
    ///
    /// # Errors
    /// A full disk, a place that became unwritable.
    pub fn finish(self) -> Result<()> {
        let failed = || format!("{}: this file cannot be written", self.path.display());
        let file = self.writer.into_inner().map_err(|e| e.into_error()).with_context(failed)?;
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let permissions = std::fs::Permissions::from_mode(0o644);
            file.as_file().set_permissions(permissions).with_context(failed)?;
        }
        file.persist(&self.path).map_err(|e| e.error).with_context(failed)?;
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
