//! The C interface: its header, its libraries for firmware and for the desktop.

mod header;

use std::path::PathBuf;

/// Folder of the crate.
fn folder() -> PathBuf {
    super::root().join("kernel/c")
}
