//! Every sample of a replay as a table.

/// Columns of all samples that twin and observer have followed, stored row by row.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Samples {
    /// Names of the columns, which end in their units.
    pub names: Vec<String>,
    /// Values, one row after the other; NaN where a reading is missing.
    pub values: Vec<f64>,
}
