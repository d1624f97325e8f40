//! Table of the forces of one ball.

use ballrace::bearing::quasi_static::TableConstants;
use ballrace::bearing::tabulated::Grid;

/// Table of a bearing.
#[derive(Clone)]
pub struct TableData {
    /// True where the speed axis is that of the outer ring.
    pub by_outer: bool,
    /// Grid of the nodes.
    pub grid: Grid<f64>,
    /// Nodes; the third number is the friction, where the inner contact has one.
    pub nodes: Vec<[f64; 3]>,
    /// Constants of the bearing.
    pub constants: TableConstants<f64>,
    /// True where the third number is used.
    pub friction: bool,
}

impl TableData {
    /// Returns the numbers of each node that are used.
    #[must_use]
    pub const fn fields(&self) -> usize {
        numbers(self.friction)
    }

    /// Returns the size of the nodes in single precision, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.nodes.len() * self.fields() * size_of::<f32>()
    }
}

/// Returns the numbers of a node.
pub(crate) const fn numbers(friction: bool) -> usize {
    if friction { 3 } else { 2 }
}
