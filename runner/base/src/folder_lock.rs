//! Exclusive ownership of a folder by one running process.

use crate::output::OutputError;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Write};
use std::path::Path;

/// Maximum length of the owner's entry in the lock file, bytes.
const MAX_ENTRY_LENGTH: u64 = 200;

/// Exclusive lock of a folder; released on drop and at the end of the process.
pub struct FolderLock {
    _file: File,
}

impl FolderLock {
    /// Creates the folder if it does not exist, and locks it with the file `name`.
    ///
    /// # Errors
    /// Returns an error if the folder cannot be written or is locked by another process; the message names that process.
    pub fn acquire(folder: &Path, name: &str) -> Result<Self, OutputError> {
        let path = folder.join(name);
        let failed = |source| OutputError::Write { file: path.clone(), source };
        std::fs::create_dir_all(folder).map_err(|source| OutputError::Write { file: folder.to_owned(), source })?;
        let mut options = OpenOptions::new();
        let mut file = options.create(true).read(true).write(true).truncate(false).open(&path).map_err(failed)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut owner = String::new();
                let _ = file.take(MAX_ENTRY_LENGTH).read_to_string(&mut owner);
                return Err(OutputError::InUse { folder: folder.to_owned(), owner: owner.trim().to_owned() });
            }
            Err(TryLockError::Error(source)) => return Err(failed(source)),
        }
        let since = humantime::format_rfc3339_seconds(std::time::SystemTime::now());
        // The entry is for users only; the folder is locked even if it cannot be written, for example on a full disk.
        let _ = file.set_len(0).and_then(|()| writeln!(file, "process {} since {since}", std::process::id()));
        Ok(Self { _file: file })
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    #[test]
    fn a_folder_has_one_owner() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("state");
        let first = FolderLock::acquire(&path, "a.lock").unwrap();
        let message = FolderLock::acquire(&path, "a.lock").err().unwrap().to_string();
        assert!(message.contains(&format!("process {} since", std::process::id())), "{message}");
        FolderLock::acquire(&path, "b.lock").unwrap();
        drop(first);
        FolderLock::acquire(&path, "a.lock").unwrap();
    }
}
