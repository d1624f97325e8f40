//! What every part of `ballrace` rests on: safe text for a terminal, complete or absent files, work on all processors, numerical methods.
//!
//! | modules | content |
//! | --- | --- |
//! | [`printable`], [`output`], [`bounded`], [`folder_lock`], [`npy_header`], [`sha256`] | text and files |
//! | [`parallel`], [`caught`], [`priority`], [`time_limit`] | work on all processors, and its end |
//! | [`least_squares`], [`eigenvalues`], [`moments`], [`statistics`] | numerical methods |
#![forbid(unsafe_code)]

pub mod bounded;
pub mod caught;
pub mod eigenvalues;
pub mod folder_lock;
pub mod least_squares;
pub mod moments;
pub mod npy_header;
pub mod output;
pub mod parallel;
pub mod printable;
pub mod priority;
pub mod sha256;
pub mod statistics;
pub mod time_limit;
