//! Output files that are complete or absent: written to a temporary file that replaces the destination at the end.

use crate::printable;
use std::borrow::Cow;
use std::fs::{File, OpenOptions, Permissions};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use tempfile::NamedTempFile;

/// Error returned when an output file cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The path is a folder.
    #[error("{}: a folder, expected the name of a file to write", file.display())]
    Folder {
        /// Path of the output.
        file: PathBuf,
    },
    /// The file cannot be created, written or moved into its destination.
    #[error("{}: this file cannot be written", file.display())]
    Write {
        /// Path of the output.
        file: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Another process has locked the folder.
    #[error(
        "{}: this folder is in use by {}, expected a folder that no other process uses",
        folder.display(),
        if owner.is_empty() { "another process".into() } else { printable::name(owner) }
    )]
    InUse {
        /// The folder.
        folder: PathBuf,
        /// Entry of the other process in the lock file.
        owner: String,
    },
}

/// An output file in progress. Dropped before [`AtomicFile::finish`], it leaves nothing behind.
pub struct AtomicFile {
    writer: BufWriter<Destination>,
    /// Path of the destination, with links resolved.
    path: PathBuf,
    /// Permissions of the file that it replaces.
    permissions: Option<Permissions>,
}

enum Destination {
    /// A new or a regular file: replaced as a whole.
    Replacement(Temporary),
    /// A pipe or a device, which cannot be replaced.
    Direct(File),
}

impl Write for Destination {
    fn write(&mut self, buffer: &[u8]) -> std::io::Result<usize> {
        match self {
            // Written through `File`: an error of `NamedTempFile` contains the temporary name.
            Self::Replacement(temporary) => temporary.file.as_file_mut().write(buffer),
            Self::Direct(file) => file.write(buffer),
        }
    }
    fn flush(&mut self) -> std::io::Result<()> {
        match self {
            Self::Replacement(temporary) => temporary.file.as_file_mut().flush(),
            Self::Direct(file) => file.flush(),
        }
    }
}

/// Temporary files that exist now, for [`exit_without_temporary_files`].
static TEMPORARY: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// A temporary file that is removed when it is dropped, and by [`exit_without_temporary_files`].
struct Temporary {
    file: NamedTempFile,
    listed: Listed,
}

/// Entry in the list of temporary files.
struct Listed(PathBuf);

impl Drop for Listed {
    fn drop(&mut self) {
        TEMPORARY.lock().unwrap_or_else(PoisonError::into_inner).retain(|path| *path != self.0);
    }
}

impl Temporary {
    fn create(folder: &Path, permissions: Option<&Permissions>) -> std::io::Result<Self> {
        // Held until the file is listed: a signal in between would leave the file behind.
        let mut listed = TEMPORARY.lock().unwrap_or_else(PoisonError::into_inner);
        let mut builder = tempfile::Builder::new();
        builder.prefix(".ballrace-");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // The system applies the user's umask to the permissions of a new file.
            builder.permissions(permissions.cloned().unwrap_or_else(|| Permissions::from_mode(0o666)));
        }
        #[cfg(not(unix))]
        let _ = permissions;
        // The system's reason alone: the temporary name means nothing to the user.
        let file = builder.tempfile_in(folder).map_err(|e| std::io::Error::from(e.kind()))?;
        listed.push(file.path().to_owned());
        let listed = Listed(file.path().to_owned());
        Ok(Self { file, listed })
    }
}

/// Removes every temporary file of this process and ends it with `code`, for a signal that ends the process.
pub fn exit_without_temporary_files(code: i32) -> ! {
    // Held until the end, so that no other thread begins a file in between.
    let listed = TEMPORARY.lock().unwrap_or_else(PoisonError::into_inner);
    for path in listed.iter() {
        // A file that cannot be removed stays: nothing else can be done about it now.
        let _ = std::fs::remove_file(path);
    }
    std::process::exit(code)
}

fn failed(path: &Path) -> impl FnOnce(std::io::Error) -> OutputError {
    move |source| OutputError::Write { file: path.to_owned(), source }
}

impl AtomicFile {
    /// Creates the temporary file; fails early if the destination cannot be written.
    ///
    /// # Errors
    /// A folder that is missing or not writable, a path that is a folder.
    pub fn create(path: &Path) -> Result<Self, OutputError> {
        if path.is_dir() {
            return Err(OutputError::Folder { file: path.to_owned() });
        }
        // A link is followed, not replaced.
        let path = path.canonicalize().unwrap_or_else(|_| link_target(path));
        let existing = path.metadata().ok();
        let special = existing.as_ref().is_some_and(|m| !m.is_file());
        let permissions = existing.filter(|m| m.is_file()).map(|m| m.permissions());
        let destination = if special {
            Destination::Direct(OpenOptions::new().write(true).open(&path).map_err(failed(&path))?)
        } else {
            let temporary = Temporary::create(folder_of(&path), permissions.as_ref());
            Destination::Replacement(temporary.map_err(failed(&path))?)
        };
        Ok(Self { writer: BufWriter::with_capacity(1 << 16, destination), path, permissions })
    }

    /// Writes the whole of `contents` to `path`.
    ///
    /// # Errors
    /// As [`AtomicFile::create`] and [`AtomicFile::finish`].
    pub fn write(path: &Path, contents: impl AsRef<[u8]>) -> Result<(), OutputError> {
        let mut file = Self::create(path)?;
        file.write_all(contents.as_ref()).map_err(failed(path))?;
        file.finish()
    }

    /// Moves the file into its destination, with the permissions of the file that it replaces, or those of a new file.
    ///
    /// # Errors
    /// A full disk, a destination that became unwritable.
    pub fn finish(self) -> Result<(), OutputError> {
        let Self { writer, path, permissions } = self;
        let Destination::Replacement(temporary) =
            writer.into_inner().map_err(|e| e.into_error()).map_err(failed(&path))?
        else {
            return Ok(());
        };
        let Temporary { file, listed } = temporary;
        if let Some(permissions) = permissions {
            file.as_file().set_permissions(permissions).map_err(failed(&path))?;
        }
        // The file in its destination has to be complete after a power failure too.
        file.as_file().sync_all().map_err(failed(&path))?;
        file.persist(&path).map_err(|e| e.error).map_err(failed(&path))?;
        drop(listed);
        sync_folder(&path);
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

/// Replaces the file `path`, which no other process writes, by `contents`, with the same permissions; durable when this
/// returns.
///
/// The temporary file has a fixed name, `PATH.new`: a process that is killed leaves at most one of them, which the next
/// call overwrites.
///
/// # Errors
/// A full disk, a folder that cannot be written.
pub fn replace(path: &Path, contents: &[u8]) -> std::io::Result<File> {
    let mut name = path.as_os_str().to_owned();
    name.push(".new");
    let temporary = PathBuf::from(name);
    let mut file = OpenOptions::new().write(true).create(true).truncate(true).open(&temporary)?;
    file.write_all(contents)?;
    if let Ok(existing) = std::fs::metadata(path) {
        file.set_permissions(existing.permissions())?;
    }
    file.sync_all()?;
    std::fs::rename(&temporary, path)?;
    sync_folder(path);
    Ok(file)
}

/// Makes a rename durable where the system can do so.
fn sync_folder(path: &Path) {
    let _ = File::open(folder_of(path)).and_then(|folder| folder.sync_all());
}

/// Returns the target of a link to a file that does not exist yet; `path` itself where it is no link.
fn link_target(path: &Path) -> PathBuf {
    std::fs::read_link(path).map_or_else(|_| path.to_owned(), |target| folder_of(path).join(target))
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Returns the text of a cell of CSV that no spreadsheet takes for a formula: a text that begins as one, with `=`, `+`, `-`,
/// `@`, a tab or a carriage return, and is no number, gets an apostrophe before it.
#[must_use]
pub fn cell_text(text: &str) -> Cow<'_, str> {
    let is_number = || text.parse::<f64>().is_ok();
    if text.len() > 1 && text.starts_with(FORMULA) && !is_number() { format!("'{text}").into() } else { text.into() }
}

/// First characters that a spreadsheet takes for the begin of a formula.
const FORMULA: [char; 6] = ['=', '+', '-', '@', '\t', '\r'];

/// Returns the name of a column without the apostrophe of [`cell_text`].
#[must_use]
pub fn without_apostrophe(name: &str) -> &str {
    name.strip_prefix('\'').filter(|rest| cell_text(rest).len() > rest.len()).unwrap_or(name)
}

/// Returns a cell as RFC 4180 writes it: the text of [`cell_text`], quoted where it holds a comma, a quote or a line break.
#[must_use]
pub fn quoted(cell: &str) -> String {
    let cell = cell_text(cell);
    if cell.contains([',', '"', '\n', '\r']) { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell.into_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_is_no_formula() {
        for text in ["=cmd|'/c calc'!A1", "+1+1", "-2+3", "@SUM(A1)", "\t=1", "\r=1", "-x"] {
            let cell = format!("'{text}");
            assert_eq!((&*cell_text(text), without_apostrophe(&cell)), (&*cell, text));
        }
        for text in ["", "-", "+", "-1.5e-3", "+4", "a=b", "DE_X", "'quoted'", "1-2"] {
            assert_eq!((&*cell_text(text), without_apostrophe(text)), (text, text));
        }
        assert_eq!(quoted("=1,2"), "\"'=1,2\"");
    }
}
