//! The C interface: its header, its libraries for firmware and for the desktop.

mod checksums;
mod example;
mod expected;
mod header;
mod host;
pub mod image;
mod instructions;
mod links;
mod tables;

use std::path::PathBuf;

/// Folder of the crate.
fn folder() -> PathBuf {
    super::root().join("kernel/c")
}
