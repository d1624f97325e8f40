//! Figures of the reports, one SVG element each.
//!
//! A figure of the replay's report is a type in a file of its own that implements [`Figure`], and an entry in
//! [`REGISTRY`], whose order is that of the report. The other reports call their figures directly.

mod axis;
mod balance;
mod bode;
mod cage_orbit;
mod campbell;
mod canvas;
mod cascade;
mod centreline;
mod damaged_bearing;
mod deflected_line;
mod diagnosis;
mod envelope;
mod equilibria;
mod fault_motion;
mod fit;
mod force;
mod force_spectrum;
mod full_spectrum;
mod line;
mod mark;
mod mode_shape;
mod one_x;
mod orbit;
mod plane;
mod polar;
mod ring;
mod rotor;
mod snapshots;
mod spectrum;
mod sweep;
mod trace;
mod trade;
mod trend;
mod vectors;

pub(super) use balance::balance;
pub(super) use cage_orbit::cage_orbit;
pub(super) use campbell::diagram;
pub(super) use equilibria::{NamedCurve, over, over_time};
pub(super) use fit::{changes, residuals};
pub(super) use mode_shape::mode_shapes;
pub(super) use plane::{circle, plane};
pub(super) use ring::present_loads;
pub(super) use rotor::rotor;
pub(super) use sweep::{Curve, bifurcation, response, waterfall};
pub(super) use trade::{Dot, front};
pub(super) use vectors::{correction, trim};

pub(super) use axis::Axis;
pub(super) use canvas::{Curve as CurveValues, CurveKind, Drawing, Plot};

use ballrace_twin::replay::outcome::{Outcome, Pictures};
use line::Thinning;

/// Figures of the replay's report in its order: diagnoses, rotor, shape, time, frequency, force.
const REGISTRY: &[&dyn Figure] = &[
    &diagnosis::Diagnoses,
    &rotor::Rotor,
    &deflected_line::DeflectedLines,
    &orbit::Orbits,
    &centreline::Centrelines,
    &polar::PolarPlots,
    &bode::BodePlots,
    &trace::Traces,
    &trend::Trends,
    &snapshots::SnapshotTrends,
    &spectrum::HalfSpectra,
    &full_spectrum::FullSpectra,
    &cascade::Cascades,
    &envelope::EnvelopeSpectra,
    &force::BearingForces,
    &ring::ElementLoadPlots,
];

/// A kind of figure in the replay's report.
trait Figure: Sync {
    /// Returns the heading of its section.
    fn heading(&self) -> &'static str;

    /// Returns the layout of its pictures on the page.
    fn shape(&self) -> Shape {
        Shape::Wide
    }

    /// Returns the number of long lines that it draws. [`PointBudget`] divides the points among all long lines.
    fn lines(&self, _data: &Pictures) -> usize {
        0
    }

    /// Draws its pictures; none where the outcome lacks the data.
    fn draw(&self, context: &Context<'_>) -> Vec<Picture>;
}

/// Layout of a section's pictures.
#[derive(Debug, Clone, Copy)]
pub(super) enum Shape {
    /// Across the page.
    Wide,
    /// Several in a row.
    Square,
}

/// A drawn figure with its texts.
#[derive(Debug, Clone, Default)]
pub(super) struct Picture {
    /// Caption.
    pub(super) title: String,
    /// Explanation; may be empty.
    pub(super) note: String,
    /// The `svg` element and the values of its curves.
    pub(super) drawing: Drawing,
    /// Readings from which the script can compute the figure for another time range.
    pub(super) source: Option<Source>,
    /// The figure is printed.
    pub(super) is_printed: bool,
}

/// Readings that a figure shows, by the number of the probe or plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Source {
    /// Readings of a probe.
    Trace(usize),
    /// Spectrum of a probe.
    Spectrum(usize),
    /// Full spectrum of a plane.
    FullSpectrum(usize),
    /// Orbit in a plane.
    Orbit(usize),
    /// 1X orbit in a plane.
    FilteredOrbit(usize),
}

/// All pictures of one kind of figure.
#[derive(Debug, Clone)]
pub(super) struct Section {
    pub(super) heading: &'static str,
    pub(super) shape: Shape,
    pub(super) pictures: Vec<Picture>,
}

/// Input of every figure.
struct Context<'a> {
    outcome: &'a Outcome,
    data: &'a Pictures,
    budget: PointBudget,
    /// Sense of rotation: +1 from +X towards +Y.
    forward: f64,
    /// The speed changes during the recording.
    over_speed: bool,
}

impl Context<'_> {
    /// Returns index, name and angle (rad) of each radial probe, where there are enough blocks for a line.
    fn radial_probes(&self) -> impl Iterator<Item = (usize, &str, f64)> {
        let probes = self.outcome.probes.iter().enumerate().filter(|_| self.data.blocks.len() > 1);
        probes.filter_map(|(i, probe)| probe.angle_deg.map(|angle| (i, probe.name.as_str(), angle.to_radians())))
    }
}

/// Number of points of all drawn lines of a report; each point takes about ten bytes.
pub(super) const POINTS: usize = 70_000;
/// Number of values that are stored for the script per drawn point, and the largest number for one curve.
const KEPT: usize = 3;
const MAX_KEPT: usize = 4200;

/// Largest number of points in one line, so that a report of many probes stays small.
#[derive(Debug, Clone, Copy)]
struct PointBudget(usize);

impl PointBudget {
    fn new(data: &Pictures, points: usize) -> Self {
        let lines: usize = REGISTRY.iter().map(|figure| figure.lines(data)).sum();
        Self((points / lines.max(1)).clamp(64, 1500))
    }

    fn kept(self) -> usize {
        (KEPT * self.0).min(MAX_KEPT)
    }

    /// Returns the thinning of a line over time.
    fn time(self) -> Thinning {
        Thinning::Extremes([self.0, self.kept()])
    }

    /// Returns the thinning of a spectrum's line: drawn with about one peak for every half pixel.
    fn spectrum(self) -> Thinning {
        Thinning::Peaks([self.0.min(800), self.kept()])
    }

    /// Returns the thinning of a curve in a plane.
    fn path(self) -> Thinning {
        Thinning::Path(self.0)
    }
}

/// Draws all figures that have data, with about `points` points together.
pub(super) fn sections(outcome: &Outcome, points: usize) -> Vec<Section> {
    let context = context(outcome, points);
    let section = |figure: &&dyn Figure| Section {
        heading: figure.heading(),
        shape: figure.shape(),
        pictures: figure.draw(&context),
    };
    REGISTRY.iter().map(section).filter(|section| !section.pictures.is_empty()).collect()
}

/// Draws the trends of all probes.
pub(super) fn trends(outcome: &Outcome, points: usize) -> Vec<Picture> {
    trend::Trends.draw(&context(outcome, points))
}

fn context(outcome: &Outcome, points: usize) -> Context<'_> {
    let data = &outcome.pictures;
    Context {
        outcome,
        data,
        budget: PointBudget::new(data, points),
        forward: if outcome.record.mean_speed_rpm < 0.0 { -1.0 } else { 1.0 },
        over_speed: outcome.record.speed_changes(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture;
    use std::collections::BTreeSet;

    #[test]
    fn every_figure_has_a_heading_of_its_own_and_draws_data() {
        let headings: BTreeSet<&str> = REGISTRY.iter().map(|figure| figure.heading()).collect();
        assert_eq!(headings.len(), REGISTRY.len());
        let sections = sections(&fixture::with_snapshots(fixture::run_up()), POINTS);
        let drawn: Vec<&str> = sections.iter().map(|section| section.heading).collect();
        let registered: Vec<&str> = REGISTRY.iter().map(|figure| figure.heading()).collect();
        assert_eq!(drawn, registered, "in the order of the registry");
    }

    #[test]
    fn a_figure_without_data_has_no_section() {
        assert!(sections(&Outcome::default(), POINTS).is_empty());
    }
}
