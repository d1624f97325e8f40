//! Exclusive ownership of a folder by one running process.

use anyhow::{Context, Result, bail};
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
    pub fn acquire(folder: &Path, name: &str) -> Result<Self> {
        let folder_name = || folder.display().to_string();
        std::fs::create_dir_all(folder).with_context(folder_name)?;
        let path = folder.join(name);
        let mut file = OpenOptions::new()
            .create(true)
            .read(true)
            .write(true)
            .truncate(false)
            .open(&path)
            .with_context(|| path.display().to_string())?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut owner = String::new();
                let _ = file.take(MAX_ENTRY_LENGTH).read_to_string(&mut owner);
                let owner = owner.trim();
                let owner = if owner.is_empty() { "another process" } else { owner };
                bail!(
                    "{}: this folder is in use by {}, expected a folder that no other process uses",
                    folder.display(),
                    owner.escape_debug()
                )
            }
            Err(TryLockError::Error(error)) => {
                return Err(error).with_context(|| format!("{}: this folder cannot be locked", folder.display()));
            }
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
