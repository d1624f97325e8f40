//! What a recording says of its machine.

pub mod least_squares;
