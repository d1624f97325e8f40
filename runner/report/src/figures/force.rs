//! Forces of a bearing over time, with the band that the probes' noise alone makes.

use super::axis::{Axis, extent};
use super::canvas::{BAND, Canvas, Dashes, Frame, Key, MEASURED, Stroke, TWIN, gutter, picture};
use super::line::{Point, decimated, pieces, thinned, zipped};
use super::trace::Clock;
use super::{Context, Figure, Picture, PointBudget};
use anyhow::Result;
use ballrace_twin::replay::outcome::{ForceTrace, Pictures};

const WIDTH: f64 = 620.0;
const HEIGHT: f64 = 112.0;
const GAP: f64 = 10.0;
const TITLES: [&str; 3] = ["FX, N", "FY, N", "FZ, N"];

/// Forces over time, one picture per bearing.
pub(super) struct BearingForces;

impl Figure for BearingForces {
    fn heading(&self) -> &'static str {
        "Bearing forces"
    }

    fn lines(&self, data: &Pictures) -> usize {
        12 * data.forces.len()
    }

    fn draw(&self, context: &Context<'_>) -> Result<Vec<Picture>> {
        context.data.forces.iter().map(|one| force(one, context.budget)).collect()
    }
}

/// One picture for each bearing: three components, one above another.
pub(super) fn force(force: &ForceTrace, budget: PointBudget) -> Result<Picture> {
    let clock = Clock::of(&force.time);
    let time: Vec<f64> = force.time.iter().map(|t| t * clock.scale).collect();
    let panels: Vec<Panel> = (0..3).map(|i| Panel::new(force, i, &time, budget.line())).collect();
    let frames = frames(&panels, &time, clock.title);
    let banded = panels.iter().any(|panel| !panel.band.is_empty());
    let height = frames.last().map_or(0.0, |frame| frame.bottom) + 36.0;
    let svg = picture((WIDTH, height), Dashes::Twin, |canvas| {
        canvas.legend(frames[0].left, 0.0, legend(banded))?;
        for (i, (panel, frame)) in panels.iter().zip(&frames).enumerate() {
            frame.axes(canvas, i + 1 == frames.len())?;
            panel.draw(canvas, frame)?;
        }
        Ok(())
    })?;
    Ok(Picture {
        title: format!("Force on the inner ring of bearing {} over time", force.name),
        note: note(banded),
        svg,
    })
}

fn legend(banded: bool) -> &'static [(Key, &'static str)] {
    const ALL: [(Key, &str); 3] = [
        (Key::Line(Stroke(MEASURED, 1.5)), "from measured displacement"),
        (Key::Line(Stroke(TWIN, 1.5)), "twin"),
        (Key::Band(BAND), "\u{b1} 1 sigma of probe noise"),
    ];
    if banded { &ALL } else { &ALL[..2] }
}

fn note(banded: bool) -> String {
    if banded { String::new() } else { "The noise of the probes is not known, so no band is drawn.".to_owned() }
}

/// One component.
struct Panel {
    measured: Vec<Point>,
    twin: Vec<Point>,
    /// Lower and upper edge, piece by piece.
    band: Vec<(Vec<Point>, Vec<Point>)>,
}

impl Panel {
    fn new(force: &ForceTrace, axis: usize, time: &[f64], limit: usize) -> Self {
        Self {
            measured: decimated(&zipped(time, &force.measured[axis]), limit),
            twin: decimated(&zipped(time, &force.twin[axis]), limit),
            band: band(time, &force.measured[axis], &force.sigma[axis], limit),
        }
    }

    fn extent(&self) -> Option<(f64, f64)> {
        let edges = self.band.iter().flat_map(|(low, high)| low.iter().chain(high));
        extent(self.measured.iter().chain(&self.twin).chain(edges).map(|point| point.1))
    }

    fn draw(&self, canvas: &mut Canvas, frame: &Frame) -> Result<()> {
        for (low, high) in &self.band {
            let around: Vec<Point> = low.iter().chain(high.iter().rev()).map(|point| frame.at(point)).collect();
            canvas.polygon(&around, BAND)?;
        }
        frame.curve(canvas, &self.measured, Stroke(MEASURED, 1.2))?;
        frame.curve(canvas, &self.twin, Stroke(TWIN, 1.2))?;
        frame.note_if_empty(canvas, &[&self.measured, &self.twin])
    }
}

/// Measured less and plus sigma, at fewer points than the line: an area needs less.
fn band(time: &[f64], force: &[f64], sigma: &[f64], limit: usize) -> Vec<(Vec<Point>, Vec<Point>)> {
    let edge = |sign: f64| {
        let values = force.iter().zip(sigma).map(|(force, sigma)| force + sign * sigma.abs());
        let points: Vec<Point> = time.iter().copied().zip(values).collect();
        // Thinning could step over a missing value, so the pieces come first.
        let pieces: Vec<Vec<Point>> = pieces(&points).map(|piece| thinned(piece, limit)).collect();
        pieces
    };
    edge(-1.0).into_iter().zip(edge(1.0)).filter(|(low, _)| low.len() > 1).collect()
}

fn frames(panels: &[Panel], time: &[f64], title: &str) -> Vec<Frame> {
    let axes: Vec<Axis> =
        panels.iter().zip(TITLES).map(|(panel, title)| Axis::padded(panel.extent(), 6, title)).collect();
    let left = gutter(&axes.iter().collect::<Vec<_>>());
    let x = Axis::exact(extent(time.iter().copied()), 10, title);
    let place = |(i, y): (usize, Axis)| {
        let top = 24.0 + i as f64 * (HEIGHT + GAP);
        Frame { start: 0.0, left, top, right: WIDTH - 18.0, bottom: top + HEIGHT, x: x.clone(), y }
    };
    axes.into_iter().enumerate().map(place).collect()
}
