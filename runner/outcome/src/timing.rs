//! Timing of a replay: compute time of its samples, timeliness, and counts of its source.

use serde::Serialize;

/// Quantiles of one duration, from a histogram.
#[derive(Debug, Clone, Copy, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Quantiles {
    /// Median, ns.
    pub p50_ns: u64,
    /// 99 %.
    pub p99_ns: u64,
    /// 99.9 %.
    pub p999_ns: u64,
    /// Largest.
    pub max_ns: u64,
}

/// Deadline ledger.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Timing {
    /// In real time, from a recording or from a source.
    pub paced: bool,
    /// Number of processed samples.
    pub samples: u64,
    /// Twin, observer and forces of a sample, measured at every 7th sample.
    pub compute: Quantiles,
    /// Mean time of a sample by stage; only where the twin ran.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stages: Option<StageTimes>,
    /// The time from one sample to the next.
    pub sample_period_ns: u64,
    /// Wall time from the first row to the outcome, without the search for the observer and the run-in of the twin.
    pub wall_s: f64,
    /// Wall time of calibration and diagnosis; 0 without either, and for diagnoses beside the samples of a monitor.
    pub diagnosis_s: f64,
    /// Recording's time over wall time.
    pub times_real_time: f64,
    /// Peak resident memory of the process, where the system reports it.
    pub peak_memory_bytes: Option<u64>,
    /// Timeliness; only when paced.
    #[serde(flatten)]
    pub pacing: Option<Pacing>,
    /// Counts of the source; only when paced.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub source: Option<SourceFigures>,
    /// Counts of records that outputs could not write; only when paced.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outputs: Option<OutputFigures>,
}

/// Mean time of a sample in the stages of a replay, ns, measured at every 61st sample.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct StageTimes {
    /// The twin, and the same rotor on linear springs.
    pub twin_ns: f64,
    /// The observer, with the tracking of the cages.
    pub observer_ns: f64,
    /// Forces of the bearings, their noise bands and sums.
    pub forces_ns: f64,
    /// Comparison of readings and twin: spectra, orders, limits, figures.
    pub comparison_ns: f64,
}

/// Counts of records that outputs could not write, such as on a full disk.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct OutputFigures {
    /// Events that are not in the log.
    pub events_not_written: u64,
    /// Seconds that are not in the indicators.
    pub seconds_not_written: u64,
    /// Messages that the MQTT broker has not acknowledged.
    pub messages_not_delivered: u64,
}

/// Blocks of a timeline. A block's work is due when the next one begins.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Pacing {
    /// From one block to the next.
    pub block_ns: u64,
    /// Blocks processed after the start.
    pub blocks: u64,
    /// All work of a block.
    #[serde(rename = "block_compute")]
    pub compute: Quantiles,
    /// How much later than due the program woke for a block.
    pub lateness: Quantiles,
    /// Blocks whose work was not done when the next one was due.
    pub deadline_misses: u64,
    /// Time until the twin had started and caught up; lateness before is not counted.
    pub starting_s: f64,
    /// Idle share of one processor after the start, for all threads of the program together; none where the system does not report
    /// processor time.
    pub idle_percent: Option<f64>,
    /// Scheduling that the system granted.
    pub scheduling: String,
}

/// Counts of a source.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SourceFigures {
    /// Samples read.
    pub rows: u64,
    /// Frames missing by their sequence numbers.
    pub lost_frames: u64,
    /// Frames received twice or too late.
    pub repeated_frames: u64,
    /// Frames or datagrams of a wrong size.
    pub malformed_frames: u64,
    /// Samples that found the ring full and could not wait.
    pub dropped_rows: u64,
    /// Largest number of samples that waited between reader and loop.
    pub ring_highest: u64,
    /// Capacity of the ring, samples.
    pub ring_capacity: u64,
    /// Connections accepted.
    pub connections: u64,
    /// Number of pauses of a second or more.
    pub stalls: u64,
    /// The longest of them.
    pub longest_stall_s: f64,
}
