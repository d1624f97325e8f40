//! No code: `Cargo.toml` lists the features that all packages of the workspace give to the dependencies that they share.
