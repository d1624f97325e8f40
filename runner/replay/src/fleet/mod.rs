//! Fleets: a table of machines and recordings, each evaluated alone, to a table of outcomes.
//!
//! A [`Machine`] is one row of the table: a scene, and a recording of that machine at one time. [`evaluate`] replays it and
//! returns a [`Row`]; it never fails, because an error is part of the row. Several recordings of one machine are snapshots, from
//! which [`trends`] computes slopes and the time at which a limit is crossed. [`run`] evaluates a table on several
//! threads and keeps the rows in a [`Store`], from which a second run continues.
//!
//! ```
//! use ballrace_replay::fleet::{Machine, SceneSource, State, evaluate};
//!
//! let machine = Machine::new("pump 7", SceneSource::Path("no-such-scene.toml".into()));
//! let row = evaluate(&machine).row;
//! assert_eq!(row.state, State::Error);
//! assert!(row.error.is_some_and(|error| error.contains("no file of this name")));
//! ```

mod evaluation;
mod files;
mod machine;
mod patience;
mod rank;
mod regression;
mod row;
mod run;
mod store;
mod table;
mod trend;

pub use evaluation::{Evaluation, evaluate, evaluate_with, failed};
pub use files::{csv, parquet, trends_csv};
pub use machine::{Machine, SceneSource, report_names};
pub use rank::{current, worst_first};
pub use row::{DiagnosisRow, IndicatorValue, Key, Row, State};
pub use run::{Settings, run};
pub use store::{Store, lock};
pub use table::{Cells, machines, read_table};
pub use trend::{Crossing, Quantity, Snapshot, Trend, trends};
