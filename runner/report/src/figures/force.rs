//! Forces of a bearing over time, with the band of one standard deviation due to the noise of the probes.

use super::axis::{Axis, extent};
use super::canvas::{
    BAND, BELOW, Canvas, Frame, Key, MEASURED_LINE, TWIN_LINE, WIDE, gutter, legend_height, picture, stacked,
};
use super::line::{Point, Thinning, pieces, zipped};
use super::trace::Clock;
use super::{Context, Figure, Picture, PointBudget};
use crate::words;
use ballrace_twin::replay::Source;
use ballrace_twin::replay::outcome::{FORCE_COMPONENTS, ForceTrace, Pictures};

const HEIGHT: f64 = 96.0;
const GAP: f64 = 12.0;

/// Forces over time, one picture per bearing.
pub(super) struct BearingForces;

impl Figure for BearingForces {
    fn heading(&self) -> &'static str {
        "Bearing forces"
    }

    fn lines(&self, data: &Pictures) -> usize {
        12 * data.forces.len()
    }

    fn draw(&self, context: &Context<'_>) -> Vec<Picture> {
        context.data.forces.iter().map(|one| force(one, context.budget)).collect()
    }
}

/// Draws the force of one bearing: three components, one above another.
pub(super) fn force(force: &ForceTrace, budget: PointBudget) -> Picture {
    let clock = Clock::of(&force.time);
    let time: Vec<f64> = force.time.iter().map(|t| t * clock.scale).collect();
    let panels: Vec<Panel> = (0..3).map(|i| Panel::new(force, i, &time, budget.path())).collect();
    let is_banded = panels.iter().any(|panel| !panel.band.is_empty());
    let legend = &legend(force.source, is_banded);
    let axis =
        |(panel, (name, unit)): (&Panel, (&str, &str))| Axis::padded(panel.extent(), 5, &format!("{name}, {unit}"));
    let axes: Vec<Axis> = panels.iter().zip(FORCE_COMPONENTS).map(axis).collect();
    let top = legend_height(gutter(&axes.iter().collect::<Vec<_>>()), legend) + 8.0;
    let frames = stacked(&Axis::exact(extent(time.iter().copied()), 8, clock.title), axes, (top, HEIGHT, GAP));
    let height = frames.last().map_or(0.0, |frame| frame.bottom) + BELOW;
    let drawing = picture((WIDE, height), |canvas| {
        canvas.legend(frames[0].left, 0.0, legend);
        for (i, (panel, frame)) in panels.iter().zip(&frames).enumerate() {
            frame.axes(canvas, i + 1 == frames.len());
            panel.draw(canvas, frame, budget);
        }
    });
    Picture {
        title: format!("Force on the inner ring of bearing {} over time", force.name),
        note: note(force.source, is_banded),
        drawing,
        ..Picture::default()
    }
}

fn legend(source: Source, is_banded: bool) -> Vec<(Key, &'static str)> {
    let mut legend = vec![(Key::Line(MEASURED_LINE), words::force_source(source)), (Key::Line(TWIN_LINE), "twin")];
    legend.extend(is_banded.then_some((Key::Band(BAND), "\u{b1} 1 sigma of probe noise")));
    legend
}

fn note(source: Source, is_banded: bool) -> String {
    match (source, is_banded) {
        (Source::Displacement, false) => "The noise of the probes is not known, so no band is drawn.".to_owned(),
        _ => String::new(),
    }
}

/// One component.
struct Panel {
    source: Source,
    measured: Vec<Point>,
    twin: Vec<Point>,
    /// Lower and upper edge, piece by piece.
    band: Vec<(Vec<Point>, Vec<Point>)>,
}

impl Panel {
    fn new(force: &ForceTrace, axis: usize, time: &[f64], thinning: Thinning) -> Self {
        Self {
            source: force.source,
            measured: zipped(time, &force.measured[axis]),
            twin: zipped(time, &force.twin[axis]),
            band: band(time, &force.measured[axis], &force.sigma[axis], thinning),
        }
    }

    fn extent(&self) -> Option<(f64, f64)> {
        let edges = self.band.iter().flat_map(|(low, high)| low.iter().chain(high));
        extent(self.measured.iter().chain(&self.twin).chain(edges).map(|point| point.1))
    }

    fn draw(&self, canvas: &mut Canvas, frame: &Frame, budget: PointBudget) {
        frame.inside(canvas, |canvas| {
            for (low, high) in &self.band {
                let around: Vec<Point> = low.iter().chain(high.iter().rev()).map(|point| frame.at(point)).collect();
                canvas.polygon(&around, BAND);
            }
        });
        frame.series(canvas, (words::force_source(self.source), &self.measured), budget.time(), MEASURED_LINE);
        frame.series(canvas, ("twin", &self.twin), budget.time(), TWIN_LINE);
        frame.note_if_empty(canvas, &[&self.measured, &self.twin]);
    }
}

/// Returns the edges of the band, force minus and plus sigma, piece by piece.
fn band(time: &[f64], force: &[f64], sigma: &[f64], thinning: Thinning) -> Vec<(Vec<Point>, Vec<Point>)> {
    let edge = |sign: f64| {
        let values = force.iter().zip(sigma).map(|(force, sigma)| force + sign * sigma.abs());
        let points: Vec<Point> = time.iter().copied().zip(values).collect();
        // Thinning could step over a missing value, so the pieces come first.
        let pieces: Vec<Vec<Point>> = pieces(&points).map(|piece| thinning.drawn(piece)).collect();
        pieces
    };
    edge(-1.0).into_iter().zip(edge(1.0)).filter(|(low, _)| low.len() > 1).collect()
}
