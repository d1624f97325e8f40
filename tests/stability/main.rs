//! What becomes of the kernel at the edges: of its numbers, of its parameters, of time.
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod accuracy;
mod inputs;
mod models;
mod parameters;
mod time;
