//! The pictures of the report, one SVG element each.

mod axis;
mod balance;
mod bode;
mod campbell;
mod canvas;
mod cascade;
mod centreline;
mod envelope;
mod force;
mod line;
mod mark;
mod one_x;
mod orbit;
mod polar;
mod ring;
mod spectrum;
mod sweep;
mod trace;
mod trade;
mod trend;

pub(super) use balance::balance;
pub(super) use campbell::diagram;
pub(super) use sweep::{Curve, bifurcation, response, waterfall};
pub(super) use trade::{Dot, front};

use anyhow::Result;
use ballrace_twin::replay::outcome::{Block, Orbit, Outcome, ProbeOutcome};
use line::Point;
use one_x::OneX;

/// One picture with its words.
#[derive(Debug, Clone, Default)]
pub(super) struct Picture {
    /// What it shows.
    pub(super) title: String,
    /// What the reader must know to read it; may be empty.
    pub(super) note: String,
    /// An `svg` element.
    pub(super) svg: String,
}

/// All pictures, by kind.
#[derive(Debug, Clone, Default)]
pub(super) struct Gallery {
    pub(super) orbits: Vec<Picture>,
    pub(super) centrelines: Vec<Picture>,
    pub(super) bodes: Vec<Picture>,
    pub(super) polars: Vec<Picture>,
    pub(super) traces: Vec<Picture>,
    pub(super) half_spectra: Vec<Picture>,
    pub(super) full_spectra: Vec<Picture>,
    pub(super) cascades: Vec<Picture>,
    pub(super) envelopes: Vec<Picture>,
    pub(super) trends: Vec<Picture>,
    pub(super) forces: Vec<Picture>,
    pub(super) loads: Vec<Picture>,
}

/// Points that all lines together may have: about ten bytes each.
const POINTS: usize = 160_000;

/// Points that one line may have, so that a report of many probes stays small.
#[derive(Debug, Clone, Copy)]
pub(super) struct Budget(usize);

impl Budget {
    fn of(outcome: &Outcome) -> Self {
        let pictures = &outcome.pictures;
        let lines = 3 * pictures.traces.len()
            + 2 * pictures.orbits.len()
            + 6 * pictures.half_spectra.len()
            + 2 * pictures.full_spectra.len()
            + 12 * pictures.forces.len()
            + 4 * pictures.element_loads.len()
            + 4 * pictures.traces.len()
            + pictures.envelopes.len();
        Self((POINTS / lines.max(1)).clamp(64, 2000))
    }

    /// For a line over time.
    pub(super) fn line(self) -> usize {
        self.0
    }

    /// For a line of a spectrum: one peak for about every half pixel.
    pub(super) fn spectrum(self) -> usize {
        self.0.min(1000)
    }
}

/// Draws everything.
pub(super) fn gallery(outcome: &Outcome) -> Result<Gallery> {
    let pictures = &outcome.pictures;
    let budget = Budget::of(outcome);
    let forward = if outcome.record.mean_speed_rpm < 0.0 { -1.0 } else { 1.0 };
    let over_speed = outcome.record.speed_changes();
    Ok(Gallery {
        orbits: orbits(&pictures.orbits, forward, budget)?,
        centrelines: centrelines(outcome)?,
        bodes: if over_speed { bodes(outcome)? } else { vec![] },
        polars: if over_speed { polars(outcome, forward)? } else { vec![] },
        traces: each(&pictures.traces, |trace| trace::trace(trace, budget))?,
        half_spectra: each(&pictures.half_spectra, |half| spectrum::half(half, &pictures.lines, budget))?,
        full_spectra: each(&pictures.full_spectra, |full| spectrum::full(full, &pictures.lines, budget))?,
        cascades: each(pictures.cascades.iter().filter(|one| one.slices.len() > 1), |one| {
            cascade::cascade(one, &pictures.lines, over_speed)
        })?,
        envelopes: each(&pictures.envelopes, |one| envelope::envelope(one, budget))?,
        trends: trends(outcome, budget)?,
        forces: each(&pictures.forces, |force| force::force(force, budget))?,
        loads: each(&pictures.element_loads, |loads| ring::loads(loads, budget))?,
    })
}

/// Direct and 1X side by side.
fn orbits(orbits: &[Orbit], forward: f64, budget: Budget) -> Result<Vec<Picture>> {
    let mut pictures = Vec::new();
    for direct in orbits {
        pictures.push(orbit::orbit(direct, forward, budget)?);
        pictures.extend(orbit::one_x(direct, forward, budget)?);
    }
    Ok(pictures)
}

/// The radial probes with their index and angle (rad), where there are blocks enough for a line.
fn radial(outcome: &Outcome) -> impl Iterator<Item = (usize, &str, f64)> {
    let some = outcome.pictures.blocks.len() > 1;
    let probes = outcome.probes.iter().enumerate().filter(move |_| some);
    probes.filter_map(|(i, probe)| probe.angle_deg.map(|angle| (i, probe.name.as_str(), angle.to_radians())))
}

fn bodes(outcome: &Outcome) -> Result<Vec<Picture>> {
    radial(outcome).map(|(i, name, _)| bode::bode(name, &OneX::new(&outcome.pictures.blocks, i))).collect()
}

fn polars(outcome: &Outcome, forward: f64) -> Result<Vec<Picture>> {
    let blocks = &outcome.pictures.blocks;
    radial(outcome).map(|(i, name, angle)| polar::polar(name, angle, forward, &OneX::new(blocks, i))).collect()
}

fn trends(outcome: &Outcome, budget: Budget) -> Result<Vec<Picture>> {
    let pictures = &outcome.pictures;
    let probes = outcome.probes.iter().enumerate().filter(|_| pictures.blocks.len() > 1);
    let of = |(probe, named): (usize, &ProbeOutcome)| {
        let name = named.name.as_str();
        let limits = pictures.limits.iter().filter(|limit| limit.probe == name).collect();
        let events = outcome.events.iter().filter(|event| event.probe == name).collect();
        trend::trend(&trend::Trend { name, probe, blocks: &pictures.blocks, limits, events }, budget)
    };
    probes.map(of).collect()
}

fn centrelines(outcome: &Outcome) -> Result<Vec<Picture>> {
    let pictures = &outcome.pictures;
    let planes = pictures.orbits.iter().zip(&pictures.clearances).filter(|_| pictures.blocks.len() > 1);
    planes.map(|(orbit, clearance)| centreline::centreline(orbit, &way(outcome, orbit), clearance.as_ref())).collect()
}

/// Mean places in a plane with their speeds, um.
fn way(outcome: &Outcome, orbit: &Orbit) -> Vec<(Point, f64)> {
    let place = |name: &str| outcome.probes.iter().position(|probe| probe.name == name);
    let [(a, from_a), (b, from_b), ..] = &orbit.probes[..] else { return vec![] };
    let (Some(a), Some(b)) = (place(a), place(b)) else { return vec![] };
    let determinant = (from_b - from_a).sin();
    let mean = |block: &Block| {
        let (a, b) = (block.probes.get(a)?.mean_um, block.probes.get(b)?.mean_um);
        let x = (from_b.sin() * a - from_a.sin() * b) / determinant;
        let y = (from_a.cos() * b - from_b.cos() * a) / determinant;
        Some(((x, y), block.speed_rpm))
    };
    outcome.pictures.blocks.iter().filter_map(mean).collect()
}

fn each<'a, T: 'a>(
    data: impl IntoIterator<Item = &'a T>,
    draw: impl Fn(&T) -> Result<Picture>,
) -> Result<Vec<Picture>> {
    data.into_iter().map(draw).collect()
}
