//! The last samples, for those who look on.

use super::outcome::MarkedLine;
use super::pictures::Plane;
use std::collections::VecDeque;

/// Samples that are kept: a spectrum's length.
pub const KEPT: usize = 4096;

/// One sample of all probes, m.
#[derive(Debug, Clone, Default)]
pub struct SnapshotSample {
    /// Readings.
    pub measured: Vec<f64>,
    /// The twin's.
    pub twin: Vec<f64>,
    /// The keyphasor passed since the sample before.
    pub passed: bool,
}

/// What there is to see at one moment.
#[derive(Debug, Clone, Default)]
pub struct Snapshot {
    /// In the recording's time.
    pub time_s: f64,
    /// Now.
    pub speed_rpm: f64,
    /// Samples a second of what follows.
    pub rate_hz: f64,
    /// The last samples, oldest first; readings are those of the probes in the scene's order.
    pub samples: Vec<SnapshotSample>,
    /// Planes of the probes, with what they are called.
    pub planes: Vec<(String, Plane)>,
    /// Of each bearing: its name, and azimuth (rad) and load (N) of every element where the observer sees the shaft.
    pub loads: Vec<(String, Vec<(f64, f64)>)>,
    /// Lines to mark in a spectrum.
    pub lines: Vec<MarkedLine>,
}

/// The last [`KEPT`] of them.
#[derive(Default)]
pub struct Recent {
    /// Oldest first.
    pub samples: VecDeque<SnapshotSample>,
}

impl Recent {
    /// One more; the oldest goes, its memory is used again.
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
