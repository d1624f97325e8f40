//! Rows on disk: parts that are complete or absent, from which a stopped run continues.

use super::files;
use super::row::{Key, Row};
use ballrace_base::folder_lock::FolderLock;
use ballrace_base::output;
use ballrace_plant::error::FleetError;
use std::collections::{BTreeMap, HashMap};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Number of rows at which a part is written.
const MAX_ROWS: usize = 64;
/// Time after which the rows that are not on disk are written as a part.
const LONGEST_WAIT: Duration = Duration::from_secs(2);

/// Locks the folder of the results of a fleet, which is created if it does not exist.
///
/// # Errors
/// Returns an error if the folder cannot be written or another process has locked it.
pub fn lock(folder: &Path) -> Result<FolderLock, FleetError> {
    Ok(FolderLock::acquire(folder, ".fleet.lock")?)
}

/// Rows in `FOLDER/part-NNNNNN.parquet`. A row with the key of an earlier one replaces it.
///
/// One process may use a folder at a time, see [`lock`].
pub struct Store {
    folder: PathBuf,
    /// Parts on disk by their numbers.
    parts: BTreeMap<u64, PathBuf>,
    rows: HashMap<Key, Row>,
    waiting: Vec<Key>,
    /// Time at which the first waiting row was added.
    since: Option<Instant>,
}

impl Store {
    /// Opens the store of a folder, which is created if it does not exist, and reads its rows.
    ///
    /// # Errors
    /// Returns an error if the folder cannot be read or written, or if a part cannot be read.
    pub fn open(folder: &Path) -> Result<Self, FleetError> {
        let failed = |source| FleetError::Write { file: folder.to_owned(), source };
        std::fs::create_dir_all(folder).map_err(failed)?;
        let mut parts = BTreeMap::new();
        for entry in std::fs::read_dir(folder).map_err(failed)? {
            let path = entry.map_err(failed)?.path();
            if path.extension() == Some(OsStr::new("new")) {
                // A process that was killed left an incomplete part.
                std::fs::remove_file(&path).map_err(failed)?;
            } else if let Some(number) = number(&path) {
                parts.insert(number, path);
            }
        }
        let mut rows = HashMap::new();
        for part in parts.values() {
            rows.extend(files::read_parquet(part)?.into_iter().map(|row| (row.key(), row)));
        }
        Ok(Self { folder: folder.to_owned(), parts, rows, waiting: vec![], since: None })
    }

    /// Returns the row of a key.
    #[must_use]
    pub fn get(&self, key: &Key) -> Option<&Row> {
        self.rows.get(key)
    }

    /// Adds a row; writes a part if enough rows wait.
    ///
    /// # Errors
    /// Returns an error if a part cannot be written.
    pub fn add(&mut self, row: Row) -> Result<(), FleetError> {
        self.waiting.push(row.key());
        self.rows.insert(row.key(), row);
        self.since.get_or_insert_with(Instant::now);
        if self.waiting.len() >= MAX_ROWS { self.flush() } else { self.flush_if_due().map(drop) }
    }

    /// Writes the waiting rows as a part if the first of them was added at least two seconds ago; returns the time until the next
    /// check is due.
    ///
    /// # Errors
    /// Returns an error if a part cannot be written.
    pub(crate) fn flush_if_due(&mut self) -> Result<Duration, FleetError> {
        let left = self.since.map_or(LONGEST_WAIT, |since| LONGEST_WAIT.saturating_sub(since.elapsed()));
        if !left.is_zero() {
            return Ok(left);
        }
        self.flush()?;
        Ok(LONGEST_WAIT)
    }

    /// Writes the waiting rows as a part.
    ///
    /// # Errors
    /// Returns an error if the part cannot be written.
    pub fn flush(&mut self) -> Result<(), FleetError> {
        self.since = None;
        let keys = std::mem::take(&mut self.waiting);
        if keys.is_empty() {
            return Ok(());
        }
        let rows: Vec<&Row> = keys.iter().filter_map(|key| self.rows.get(key)).collect();
        let (number, path) = self.next_part();
        write(&path, rows)?;
        self.parts.insert(number, path);
        Ok(())
    }

    /// Returns true where at most one part is on disk, so that no row stands there twice.
    #[must_use]
    pub fn is_compact(&self) -> bool {
        self.parts.len() <= 1
    }

    /// Replaces all parts by one: the rows of `order` in this order, then all others.
    ///
    /// A process that is killed meanwhile leaves parts with equal rows; [`Store::open`] keeps one of each.
    ///
    /// # Errors
    /// Returns an error if a part cannot be written or removed.
    pub fn compact(&mut self, order: &[Key]) -> Result<(), FleetError> {
        self.flush()?;
        if self.rows.is_empty() {
            return Ok(());
        }
        let places: HashMap<&Key, usize> = order.iter().zip(0..).collect();
        let mut rows: Vec<(&Key, &Row)> = self.rows.iter().collect();
        rows.sort_by_key(|(key, _)| (places.get(key).copied().unwrap_or(usize::MAX), *key));
        let (number, path) = self.next_part();
        write(&path, rows.into_iter().map(|(_, row)| row))?;
        let old = std::mem::replace(&mut self.parts, BTreeMap::from([(number, path)]));
        for part in old.into_values() {
            std::fs::remove_file(&part).map_err(|source| FleetError::Write { file: part, source })?;
        }
        Ok(())
    }

    fn next_part(&self) -> (u64, PathBuf) {
        let number = self.parts.keys().next_back().map_or(1, |last| last + 1);
        (number, self.folder.join(format!("part-{number:06}.parquet")))
    }
}

fn write<'a>(path: &Path, rows: impl IntoIterator<Item = &'a Row>) -> Result<(), FleetError> {
    let mut bytes = Vec::new();
    files::parquet(&mut bytes, rows)?;
    output::replace(path, &bytes).map_err(|source| FleetError::Write { file: path.to_owned(), source })?;
    Ok(())
}

/// Returns the number of a part; `None` for another file.
fn number(path: &Path) -> Option<u64> {
    path.file_name()?.to_str()?.strip_prefix("part-")?.strip_suffix(".parquet")?.parse().ok()
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use crate::fleet::State;
    use crate::fleet::row::tests::{limited, row};

    fn parts(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap();
        let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn rows_come_back_and_the_last_one_of_a_key_counts() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("outcomes");
        let mut store = Store::open(&path).unwrap();
        for i in 0..MAX_ROWS + 1 {
            store.add(row(&format!("m{i:03}"), State::Normal)).unwrap();
        }
        assert_eq!(parts(&path), ["part-000001.parquet"]);
        store.flush().unwrap();
        std::fs::write(path.join("part-000003.parquet.new"), "half a part").unwrap();
        let mut store = Store::open(&path).unwrap();
        assert_eq!(store.rows.len(), MAX_ROWS + 1);
        let new = limited("m001", 2.0);
        store.add(new.clone()).unwrap();
        store.flush().unwrap();
        assert_eq!(parts(&path).len(), 3);
        let order = [new.key()];
        Store::open(&path).unwrap().compact(&order).unwrap();
        assert_eq!(parts(&path), ["part-000004.parquet"]);
        let store = Store::open(&path).unwrap();
        assert_eq!((store.rows.len(), store.get(&new.key())), (MAX_ROWS + 1, Some(&new)));
        assert_eq!(files::read_parquet(&path.join("part-000004.parquet")).unwrap()[0], new);
    }

    #[test]
    fn rows_that_wait_are_written_after_two_seconds() {
        let folder = tempfile::tempdir().unwrap();
        let mut store = Store::open(folder.path()).unwrap();
        store.add(row("a", State::Normal)).unwrap();
        assert!(store.flush_if_due().unwrap() <= LONGEST_WAIT && parts(folder.path()).is_empty());
        store.since = Instant::now().checked_sub(LONGEST_WAIT);
        store.flush_if_due().unwrap();
        assert_eq!(parts(folder.path()).len(), 1);
    }

    #[test]
    fn a_damaged_part_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("part-000001.parquet"), "PAR1").unwrap();
        let message = Store::open(folder.path()).err().unwrap().to_string();
        assert!(message.contains("part-000001.parquet: unreadable outcomes"), "{message}");
    }
}
