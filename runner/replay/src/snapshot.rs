//! The last samples and the present state, for a live display.

use ballrace_outcome::MarkedLine;
use ballrace_plant::probes::Plane;
use std::collections::VecDeque;

/// Number of samples kept: the length of a spectrum.
pub const KEPT: usize = 4096;

/// One sample of all probes, m.
#[derive(Debug, Clone, Default)]
pub struct SnapshotSample {
    /// Readings.
    pub measured: Vec<f64>,
    /// Readings of the twin.
    pub twin: Vec<f64>,
    /// True where the keyphasor passed since the previous sample.
    pub passed: bool,
}

/// State of a replay at one moment.
#[derive(Debug, Clone, Default)]
pub struct Snapshot {
    /// Time of the last sample in the recording, s.
    pub time_s: f64,
    /// Present shaft speed.
    pub speed_rpm: f64,
    /// Samples per second.
    pub rate_hz: f64,
    /// The last samples, oldest first; readings are those of the probes in the scene's order.
    pub samples: Vec<SnapshotSample>,
    /// Planes of the probes, each with its name.
    pub planes: Vec<(String, Plane)>,
    /// Name of each bearing, with azimuth (rad) and load (N) of every element at the estimated displacement.
    pub loads: Vec<(String, Vec<(f64, f64)>)>,
    /// Lines to mark in a spectrum.
    pub lines: Vec<MarkedLine>,
}

/// The last [`KEPT`] samples.
#[derive(Default)]
pub(crate) struct RecentSamples {
    /// Oldest first.
    pub samples: VecDeque<SnapshotSample>,
}

impl RecentSamples {
    /// Adds a sample; the oldest is removed and its memory used again.
    pub fn add(&mut self, measured: &[f64], twin: &[f64], passed: bool) {
        let mut sample = if self.samples.len() < KEPT { None } else { self.samples.pop_front() }.unwrap_or_default();
        for (to, from) in [(&mut sample.measured, measured), (&mut sample.twin, twin)] {
            to.clear();
            to.extend_from_slice(from);
        }
        sample.passed = passed;
        self.samples.push_back(sample);
    }
}
