//! Records that a running monitor publishes: in its event log, its indicator files and its MQTT messages.

mod event;
#[cfg(all(test, feature = "schema"))]
mod schemas;
mod second;

pub use event::{EventMessage, EventRecord, now};
pub use second::{ColumnName, SecondRecord, TIME_OF_DAY};
