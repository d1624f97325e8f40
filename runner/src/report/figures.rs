//! The pictures of the report, one SVG element each.

mod axis;
mod balance;
mod campbell;
mod canvas;
mod force;
mod line;
mod mark;
mod orbit;
mod ring;
mod spectrum;
mod sweep;
mod trace;
mod trade;

pub(super) use balance::balance;
pub(super) use campbell::diagram;
pub(super) use sweep::{Curve, bifurcation, response, waterfall};
pub(super) use trade::{Dot, front};

use crate::replay::outcome::Outcome;
use anyhow::Result;

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
    pub(super) traces: Vec<Picture>,
    pub(super) half_spectra: Vec<Picture>,
    pub(super) full_spectra: Vec<Picture>,
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
            + 4 * pictures.element_loads.len();
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
    Ok(Gallery {
        orbits: each(&pictures.orbits, |orbit| orbit::orbit(orbit, forward, budget))?,
        traces: each(&pictures.traces, |trace| trace::trace(trace, budget))?,
        half_spectra: each(&pictures.half_spectra, |half| spectrum::half(half, &pictures.lines, budget))?,
        full_spectra: each(&pictures.full_spectra, |full| spectrum::full(full, &pictures.lines, budget))?,
        forces: each(&pictures.forces, |force| force::force(force, budget))?,
        loads: each(&pictures.element_loads, |loads| ring::loads(loads, budget))?,
    })
}

fn each<T>(data: &[T], draw: impl Fn(&T) -> Result<Picture>) -> Result<Vec<Picture>> {
    data.iter().map(draw).collect()
}
