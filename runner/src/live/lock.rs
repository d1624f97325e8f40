//! Exclusive ownership of a folder by one running monitor.

use anyhow::{Context, Result, bail};
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Write};
use std::path::Path;

/// Most bytes read of another owner's entry.
const LONGEST_ENTRY: u64 = 200;

/// A folder that belongs to this process until the lock is dropped or the process ends, however it ends.
pub struct FolderLock {
    _file: File,
}

impl FolderLock {
    /// Creates the folder where it is missing and locks it by its file `name`.
    ///
    /// # Errors
    /// A folder that cannot be written, or that another process owns; the error names that process.
    pub fn acquire(folder: &Path, name: &str) -> Result<Self> {
        let place = || folder.display().to_string();
        std::fs::create_dir_all(folder).with_context(place)?;
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
                let _ = file.take(LONGEST_ENTRY).read_to_string(&mut owner);
                let owner = owner.trim();
                let owner = if owner.is_empty() { "another process" } else { owner };
                bail!(
                    "{}: this folder is in use by {}, allowed: one running monitor for a folder",
                    folder.display(),
                    owner.escape_debug()
                )
            }
            Err(TryLockError::Error(error)) => {
                return Err(error).with_context(|| format!("{}: this folder cannot be locked", folder.display()));
            }
        }
        let since = humantime::format_rfc3339_seconds(std::time::SystemTime::now());
        // The entry is information for people only: the folder is locked without it, also on a full disk.
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
        let refused = FolderLock::acquire(&path, "a.lock").err().unwrap().to_string();
        assert!(refused.contains(&format!("process {} since", std::process::id())), "{refused}");
        FolderLock::acquire(&path, "b.lock").unwrap();
        drop(first);
        FolderLock::acquire(&path, "a.lock").unwrap();
    }
}
