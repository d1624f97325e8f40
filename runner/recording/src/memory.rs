//! A recording in memory: named columns of numbers.

use super::error::RecordingError;
use super::table::{Cells, Table, equal_lengths};
use std::path::{Path, PathBuf};

/// Columns in memory.
pub(super) struct Memory<'a> {
    name: PathBuf,
    names: Vec<String>,
    columns: Vec<&'a [f64]>,
    selected: Vec<&'a [f64]>,
    /// Number of rows that are read.
    row: usize,
}

impl<'a> Memory<'a> {
    pub(super) fn new(columns: Vec<(String, &'a [f64])>, name: &Path) -> Self {
        let (names, columns) = columns.into_iter().unzip();
        Self { name: name.into(), names, columns, selected: vec![], row: 0 }
    }
}

impl Table for Memory<'_> {
    fn columns(&self) -> &[String] {
        &self.names
    }

    fn vector(&mut self, place: usize) -> Result<Option<Vec<f64>>, RecordingError> {
        Ok(self.columns.get(place).map(|column| column.to_vec()))
    }

    fn select(&mut self, places: &[usize]) -> Result<(), RecordingError> {
        let chosen = || places.iter().filter_map(|&place| Some((self.names.get(place)?, *self.columns.get(place)?)));
        let lengths: Vec<(&str, u64)> = chosen().map(|(name, c)| (name.as_str(), c.len() as u64)).collect();
        equal_lengths(&self.name, &lengths)?;
        self.selected = chosen().map(|(_, column)| column).collect();
        Ok(())
    }

    fn next(&mut self, cells: &mut Cells) -> Result<bool, RecordingError> {
        let is_row = cells.take_row(&self.selected, self.row, self.names.len());
        self.row += usize::from(is_row);
        Ok(is_row)
    }

    fn bytes_read(&self) -> u64 {
        (self.row * self.columns.len() * size_of::<f64>()) as u64
    }
}
