//! Full spectra in succession: a waterfall over time, a cascade over speed. Bounded memory.

use super::history::{History, Join};
use ballrace_outcome::{Cascade, Slice};
use ballrace_plant::probes::Plane;
use ballrace_plant::spectrum::{WindowedTransform, circular_power};
use ballrace_recording::Sample;
use ballrace_scene::{Direction, Probe, Speed};
use std::f64::consts::TAU;

const UM: f64 = 1e6;
/// Largest number of spectra.
const MOST: usize = 48;
/// Shortest length of a spectrum: time (s), and revolutions at the highest speed of the scene.
const MIN_TIME: f64 = 0.16;
const MIN_TURNS: f64 = 4.0;
/// Number of bins kept on either side of 0 Hz.
const KEPT: usize = 400;
/// Smallest and largest number of samples in a spectrum.
const LENGTHS: (f64, f64) = (256.0, 65_536.0);

/// Signal of a spectrum: a plane, or a probe without a plane.
struct Source {
    name: String,
    probe: usize,
    plane: Option<Plane>,
    /// Motion along X and Y, or the readings of the probe and zeros.
    pending: [Vec<f64>; 2],
}

/// Accumulates samples spectrum by spectrum.
pub struct Spectra {
    sources: Vec<Source>,
    transform: WindowedTransform,
    times: Vec<f64>,
    speeds: Vec<f64>,
    /// Index of the last row.
    last: u64,
    rate: f64,
    history: History<Slices>,
}

/// Power spectrum of each source.
struct Slices {
    time: f64,
    speed: f64,
    power: Vec<Vec<f64>>,
}

impl Join for Slices {
    fn join(&mut self, later: &Self, share: f64) {
        let mix = |to: &mut f64, from: f64| *to += share * (from - *to);
        mix(&mut self.time, later.time);
        mix(&mut self.speed, later.speed);
        for (to, from) in self.power.iter_mut().flatten().zip(later.power.iter().flatten()) {
            mix(to, *from);
        }
    }
}

impl Spectra {
    /// Creates the spectra of the planes, or of each radial probe where there is no plane.
    #[must_use]
    pub fn new(probes: &[Probe], planes: &[Plane], rate: f64, speed: Speed) -> Self {
        let source = |name: String, probe: usize, plane| Source { name, probe, plane, pending: Default::default() };
        let name = |i: usize| probes.get(i).map_or("", |p| p.column.as_str());
        let mut sources: Vec<Source> =
            planes.iter().map(|p| source(p.probes.map(name).join(" / "), p.probes[0], Some(p.clone()))).collect();
        if sources.is_empty() {
            let radial = probes.iter().enumerate().filter(|(_, p)| p.direction != Direction::Axial);
            sources = radial.map(|(i, p)| source(p.column.clone(), i, None)).collect();
        }
        Self {
            sources,
            transform: WindowedTransform::new(length(rate, speed)),
            times: vec![],
            speeds: vec![],
            last: 0,
            rate,
            history: History::new(MOST),
        }
    }

    /// Adds a sample. A missing one restarts the spectrum, which may not extend over a gap.
    pub fn add(&mut self, sample: &Sample) {
        let gap = sample.row.index != self.last + 1;
        self.last = sample.row.index;
        let missing = sample.row.probes.iter().any(|y| y.is_nan());
        if gap || missing {
            self.forget(self.times.len());
        }
        if missing {
            return;
        }
        for source in &mut self.sources {
            let (x, y) = match &source.plane {
                Some(plane) => plane.xy(&sample.row.probes),
                None => (sample.row.probes.get(source.probe).copied().unwrap_or(0.0), 0.0),
            };
            let [along_x, along_y] = &mut source.pending;
            along_x.push(x);
            along_y.push(y);
        }
        self.times.push(sample.row.time);
        self.speeds.push(sample.speed);
        if self.times.len() >= self.transform.length() {
            self.transform();
        }
    }

    fn forget(&mut self, count: usize) {
        self.times.drain(..count);
        self.speeds.drain(..count);
        for source in &mut self.sources {
            source.pending.iter_mut().for_each(|pending| drop(pending.drain(..count)));
        }
    }

    fn transform(&mut self) {
        let length = self.transform.length();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / length as f64;
        let power = self.sources.iter().map(|source| self.power(&source.pending)).collect();
        self.history.push(Slices { time: mean(&self.times), speed: mean(&self.speeds), power });
        // While there are few spectra they overlap by half, so that a short run-up has enough of them.
        self.forget(if self.history.is_whole() { length / 2 } else { length });
    }

    /// Returns the power from the lowest bin kept to the highest, 0 Hz in the middle, um squared.
    fn power(&self, samples: &[Vec<f64>; 2]) -> Vec<f64> {
        let [x, y] = samples.each_ref().map(|samples| self.transform.bins(samples));
        let kept = KEPT.min(self.transform.length() / 2 - 1);
        let power: Vec<[f64; 2]> = circular_power(&x, &y).take(kept + 1).collect();
        let reverse = power.iter().skip(1).rev().map(|p| p[1]);
        reverse.chain(power.iter().map(|p| p[0])).map(|power| UM * UM * power).collect()
    }

    /// Returns one cascade per source.
    #[must_use]
    pub fn finish(self) -> Vec<Cascade> {
        let bin_hz = self.rate / self.transform.length() as f64;
        let slices = self.history.into_entries();
        let of = |(i, source): (usize, Source)| {
            let two_sided = source.plane.is_some();
            // The two sides of a single probe are halves of one amplitude.
            let size = if two_sided { 1.0 } else { 2.0 };
            let slice = |s: &Slices| Slice {
                time_s: s.time,
                speed_rpm: s.speed * 60.0 / TAU,
                amplitude_um: s.power.get(i).into_iter().flatten().map(|p| size * p.sqrt()).collect(),
            };
            Cascade { two_sided, name: source.name, bin_hz, slices: slices.iter().map(slice).collect() }
        };
        self.sources.into_iter().enumerate().map(of).collect()
    }
}

/// Returns the number of samples of one spectrum, a power of two.
fn length(rate: f64, speed: Speed) -> usize {
    let fastest = match speed {
        Speed::Constant(w) => w,
        Speed::Ramp { from, to, .. } => from.abs().max(to.abs()),
        Speed::Fluctuating { mean, .. } => mean,
    };
    let turns = MIN_TURNS * TAU / fastest.abs().max(1e-9);
    let samples = (rate * MIN_TIME.max(turns)).clamp(LENGTHS.0, LENGTHS.1);
    1 << samples.log2().round() as u32
}

#[cfg(test)]
mod tests;
