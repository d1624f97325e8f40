//! Data of the report's figures: the first revolutions, and the sums at the end. Bounded memory.

use super::cascade::Spectra;
use super::comparison::Comparison;
use super::excerpt::ExcerptCollector;
use super::force::{AZIMUTH_BINS, BearingForces, EvaluatedForce};
use super::trend::Trend;
use ballrace::Phase;
use ballrace_outcome::options::Source;
use ballrace_outcome::{
    Block, ElementLoads, FilteredOrbit, ForceTrace, FullSpectrum, HalfSpectrum, MarkedLine, Orbit, Pictures, Trace,
};
use ballrace_plant::MountedBearing;
use ballrace_plant::probes::Plane;
use ballrace_recording::Sample;
use ballrace_scene::{Direction, Probe, Speed};
use std::f64::consts::TAU;

const UM: f64 = 1e6;
/// Revolutions shown in traces and orbits.
const TURNS: f64 = 4.0;
/// Revolutions over which element 1 is followed: about three of a cage.
const CAGE_TURNS: f64 = 8.0;
/// Largest number of samples in a trace.
const MOST: usize = 20_000;

/// Collects the data of the figures.
pub(crate) struct FigureCollector {
    pictures: Pictures,
    planes: Vec<Plane>,
    trend: Trend,
    cascade: Spectra,
    excerpt: ExcerptCollector,
    revolutions: f64,
    samples: usize,
}

impl FigureCollector {
    /// Creates the collector for the probes and bearings of a replay, with the `source` of the forces, at a sample rate and the scene's speed.
    #[must_use]
    pub fn new(
        probes: &[Probe],
        planes: Vec<Plane>,
        (mounted, source): (&[MountedBearing], Source),
        rate: f64,
        speed: Speed,
    ) -> Self {
        let traces = probes.iter().map(|p| Trace { name: p.column.clone(), ..Trace::default() }).collect();
        let orbits = planes.iter().map(|p| orbit(p, probes)).collect();
        let forces =
            mounted.iter().map(|s| ForceTrace { name: s.name.clone(), source, ..ForceTrace::default() }).collect();
        let element_loads =
            mounted.iter().map(|s| ElementLoads { name: s.name.clone(), source, ..ElementLoads::default() }).collect();
        let pictures = Pictures { traces, orbits, forces, element_loads, ..Pictures::default() };
        let trend = Trend::new(probes.len(), planes.clone());
        let cascade = Spectra::new(probes, &planes, rate, speed);
        let excerpt = ExcerptCollector::new(probes.len(), rate);
        Self { pictures, planes, trend, cascade, excerpt, revolutions: 0.0, samples: 0 }
    }

    /// Adds a sample with the twin's readings and the revolutions since the last sample.
    pub fn add(&mut self, sample: &Sample, twin: &[f64], revolutions: f64) {
        self.trend.add(sample, twin, revolutions);
        self.cascade.add(sample);
        let passed = self.samples > 0 && passes_keyphasor(sample, revolutions);
        self.excerpt.add(sample, twin, passed);
        self.revolutions += revolutions.abs();
        self.samples += 1;
        if !self.open(TURNS) {
            return;
        }
        for (trace, (&measured, &twin)) in self.pictures.traces.iter_mut().zip(sample.row.probes.iter().zip(twin)) {
            trace.time.push(sample.row.time);
            trace.measured.push(measured * UM);
            trace.twin.push(twin * UM);
            if passed {
                trace.keyphasor.push(sample.row.time);
            }
        }
        for (orbit, plane) in self.pictures.orbits.iter_mut().zip(&self.planes) {
            let um = |(x, y): (f64, f64)| (x * UM, y * UM);
            if passed {
                orbit.keyphasor.push(orbit.measured.len());
            }
            orbit.measured.push(um(plane.xy(&sample.row.probes)));
            orbit.twin.push(um(plane.xy(twin)));
        }
    }

    /// Adds the force of a bearing in the same sample, and the load on its element 1.
    pub fn add_force(
        &mut self,
        bearing: usize,
        time: f64,
        force: &EvaluatedForce,
        mounted: &MountedBearing,
        cage: Phase,
        first_load: f64,
    ) {
        if self.open(TURNS)
            && let Some(trace) = self.pictures.forces.get_mut(bearing)
        {
            trace.time.push(time);
            for i in 0..3 {
                trace.measured[i].push(force.shown.map_or(f64::NAN, |shown| shown[i]));
                trace.twin[i].push(force.twin[i]);
                if force.sigma[i].is_finite() {
                    trace.sigma[i].push(force.sigma[i]);
                }
            }
        }
        if self.open(CAGE_TURNS)
            && let Some(loads) = self.pictures.element_loads.get_mut(bearing)
        {
            let azimuth = mounted.azimuths(cage).next().unwrap_or_default().radians();
            loads.first_element.push((azimuth, first_load));
        }
    }

    /// Returns true while the force traces record samples.
    #[must_use]
    pub(crate) fn shows_forces(&self) -> bool {
        self.open(TURNS)
    }

    fn open(&self, turns: f64) -> bool {
        self.revolutions <= turns && self.samples <= MOST
    }

    /// Returns the data of the figures; `speed_hz` is the mean shaft speed.
    #[must_use]
    pub fn finish(
        mut self,
        comparison: &Comparison,
        sums: &[BearingForces],
        mounted: &[MountedBearing],
        rate: f64,
        speed_hz: f64,
    ) -> Pictures {
        let n = self.pictures.traces.len();
        let bin_hz = comparison.spectra.bin(rate);
        let um = |amplitudes: Vec<f64>| amplitudes.into_iter().map(|a| a * UM).collect::<Vec<_>>();
        let spectra = &comparison.spectra;
        self.pictures.half_spectra = (0..n)
            .map(|i| HalfSpectrum {
                name: self.pictures.traces[i].name.clone(),
                bin_hz,
                measured: um(spectra.half(i)),
                twin: um(spectra.half(n + i)),
                residual: um(spectra.half(2 * n + i)),
            })
            .collect();
        self.pictures.full_spectra = (0..self.planes.len())
            .map(|i| FullSpectrum {
                name: self.pictures.orbits[i].name.clone(),
                bin_hz,
                measured: um(spectra.full(i)),
                twin: um(spectra.full(self.planes.len() + i)),
            })
            .collect();
        self.pictures.lines = marked_lines(mounted, speed_hz);
        self.pictures.blocks = self.trend.finish();
        self.pictures.cascades = self.cascade.finish();
        self.pictures.excerpt = self.excerpt.finish();
        if let Some(first) = self.pictures.blocks.first() {
            for (orbit, plane) in self.pictures.orbits.iter_mut().zip(&self.planes) {
                orbit.one_x = Some(filtered(plane, first));
            }
        }
        for (loads, sums) in self.pictures.element_loads.iter_mut().zip(sums) {
            around(loads, sums);
        }
        // Only bearings whose elements carry a load have a picture of it.
        self.pictures.element_loads.retain(|l| l.largest.iter().any(|x| *x > 0.0));
        self.pictures
    }
}

/// Returns true where the keyphasor mark passed within the last `revolutions` before the sample.
#[must_use]
pub(crate) fn passes_keyphasor(sample: &Sample, revolutions: f64) -> bool {
    revolutions != 0.0 && sample.angle.revolutions() < revolutions.abs()
}

/// Returns the 1X motion of a block in X and Y.
#[must_use]
pub fn filtered(plane: &Plane, block: &Block) -> FilteredOrbit {
    let part = |i: usize, twin: bool| {
        let of = |p: &ballrace_outcome::BlockFigures| if twin { p.twin_one_x_um[i] } else { p.one_x_um[i] };
        plane.xy(&block.probes.iter().map(of).collect::<Vec<_>>())
    };
    let parts = |twin: bool| [part(0, twin), part(1, twin)];
    FilteredOrbit { speed_rpm: block.speed_rpm, measured: parts(false), twin: parts(true) }
}

fn around(loads: &mut ElementLoads, sums: &BearingForces) {
    let width = TAU / AZIMUTH_BINS as f64;
    for (i, at) in sums.around.iter().enumerate() {
        loads.azimuth.push((i as f64 + 0.5) * width);
        loads.mean.push(at.mean());
        loads.largest.push(at.largest());
        loads.twin_mean.push(at.twin_mean());
    }
}

fn orbit(plane: &Plane, probes: &[Probe]) -> Orbit {
    let direction = |&i: &usize| match probes[i].direction {
        Direction::Radial(angle) => (probes[i].column.clone(), angle),
        Direction::Axial => (probes[i].column.clone(), 0.0),
    };
    let probes: Vec<_> = plane.probes.iter().map(direction).collect();
    let name = probes.iter().map(|p| p.0.as_str()).collect::<Vec<_>>().join(" / ");
    Orbit { name, station_mm: plane.station * 1e3, probes, ..Orbit::default() }
}

/// Returns 1X and the lines of every bearing; bearings with equal orders share a line.
#[must_use]
pub(crate) fn marked_lines(mounted: &[MountedBearing], speed_hz: f64) -> Vec<MarkedLine> {
    let mut lines = vec![MarkedLine { label: "1X".to_owned(), order: 1.0, hz: speed_hz }];
    for bearing in mounted.iter().filter(|s| s.kinematics.cage_ratio != 0.0) {
        let orders = bearing.kinematics.orders;
        for (label, order) in [("cage", orders.cage), ("outer", orders.outer_race), ("inner", orders.inner_race)] {
            match lines.iter_mut().find(|l| (l.order - order).abs() < 1e-6) {
                Some(line) => line.label = format!("{}/{}", bearing.name, line.label),
                None => {
                    lines.push(MarkedLine { label: format!("{} {label}", bearing.name), order, hz: order * speed_hz })
                }
            }
        }
    }
    lines
}
