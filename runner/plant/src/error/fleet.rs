//! Errors of a fleet: its table of machines and its stored outcomes.

use ballrace_base::output::OutputError;
use ballrace_base::printable;
use std::fmt::{Display, Formatter};
use std::path::PathBuf;

/// Position in a table of machines, displayed as it follows the name of the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TablePosition {
    /// Line of a text file, from 1.
    Line(u64),
    /// Row of a table without lines, from 1.
    Row(u64),
    /// The columns of a table without lines.
    Columns,
}

impl Display for TablePosition {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Line(line) => write!(f, ":{line}"),
            Self::Row(row) => write!(f, ": row {row}"),
            Self::Columns => Ok(()),
        }
    }
}

/// Error returned when a table of machines or the stored outcomes of a fleet cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum FleetError {
    /// A file cannot be read.
    #[error("{}: this file cannot be read", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The file is no table.
    #[error("{}: unreadable table: {found}, expected CSV or Parquet with one row a machine", file.display())]
    Format {
        /// The file.
        file: PathBuf,
        /// The reader's error.
        found: String,
    },
    /// A required column is missing.
    #[error(
        "{}{position}: missing column {column:?}, expected the columns machine and scene; found {}",
        file.display(), found.iter().map(|name| printable::name(name)).collect::<Vec<_>>().join(", ")
    )]
    MissingColumn {
        /// The file.
        file: PathBuf,
        /// The header.
        position: TablePosition,
        /// Name of the column.
        column: &'static str,
        /// Columns of the table.
        found: Vec<String>,
    },
    /// Two columns have the same name.
    #[error("{}{position}: repeated column: {:?}, expected each name once", file.display(), printable::name(column))]
    RepeatedColumn {
        /// The file.
        file: PathBuf,
        /// The header.
        position: TablePosition,
        /// Name of the columns.
        column: String,
    },
    /// The table has no row.
    #[error("{}: empty table, expected at least one machine", file.display())]
    Empty {
        /// The file.
        file: PathBuf,
    },
    /// A row has another number of cells than the header.
    #[error("{}{position}: wrong number of cells: {found}, expected {expected} as in the header", file.display())]
    RowLength {
        /// The file.
        file: PathBuf,
        /// The row.
        position: TablePosition,
        /// Number of cells.
        found: usize,
        /// Number of columns.
        expected: usize,
    },
    /// A cell has a value that is not allowed.
    #[error(
        "{}{position}: column {column}: invalid value: {:?}, expected {expected}",
        file.display(), printable::name(found)
    )]
    Cell {
        /// The file.
        file: PathBuf,
        /// The row.
        position: TablePosition,
        /// Column of the cell.
        column: &'static str,
        /// The value.
        found: String,
        /// Allowed values.
        expected: &'static str,
    },
    /// Two rows have the same machine and recording.
    #[error(
        "{}{position}: repeated machine and recording: {:?} with {:?} as at {}{first}, expected each pair once",
        file.display(), printable::name(machine), printable::name(recording), file.display()
    )]
    RepeatedKey {
        /// The file.
        file: PathBuf,
        /// The later row.
        position: TablePosition,
        /// The earlier row.
        first: TablePosition,
        /// Name of the machine.
        machine: String,
        /// Recording of both rows.
        recording: String,
    },
    /// A part of the stored outcomes cannot be read.
    #[error("{}: unreadable outcomes: {found}, expected a file that fleet has written", file.display())]
    Part {
        /// The part.
        file: PathBuf,
        /// The reader's error.
        found: String,
    },
    /// A file or a folder of the outcomes cannot be written.
    #[error("{}: this file cannot be written", file.display())]
    Write {
        /// The file or the folder.
        file: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// An output file cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Rows cannot be written as CSV, JSON or Parquet.
    #[error("rows cannot be written: {0}")]
    Rows(String),
}

impl FleetError {
    /// Returns true where the table of machines is wrong.
    #[must_use]
    pub const fn is_usage_error(&self) -> bool {
        !matches!(self, Self::Part { .. } | Self::Write { .. } | Self::Output(_) | Self::Rows(_))
    }
}
