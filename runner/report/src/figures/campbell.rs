//! The Campbell diagram: natural frequencies over speed, connected mode by mode, with the lines of one and two per turn.

use super::Picture;
use super::axis::{Axis, extent};
use super::canvas::{
    Anchor, BELOW, FAULT, Frame, INK, Key, MARK, MEASURED, Marker, RESIDUAL, Stroke, TWIN, WIDE, gutter, picture,
};
use super::line::{Point, Thinning};
use ballrace_twin::campbell::{CriticalSpeed, ModeBranch, Whirl};

const HEIGHT: f64 = 330.0;
/// Width for the names of the modes to the right of the frame, pixels.
const NAMES: f64 = 34.0;
/// Least distance between two names, pixels.
const ROW: f64 = 12.0;
/// The diagram ends at this many times the frequency of 2X at the highest speed, if that shows [`MIN_SHOWN`] modes.
const BEYOND: f64 = 1.1;
/// Number of lowest modes that are shown at any frequency.
const MIN_SHOWN: usize = 4;

const FORWARD: Stroke = Stroke(MEASURED, 1.8);
const BACKWARD: Stroke = Stroke(TWIN, 1.8);
const STRAIGHT: Stroke = Stroke(RESIDUAL, 1.6);
const ORDER: Stroke = Stroke(MARK, 0.9);

/// Returns the stroke of a direction of whirl.
const fn stroke(whirl: Whirl) -> Stroke {
    match whirl {
        Whirl::Forward => FORWARD,
        Whirl::Backward => BACKWARD,
        Whirl::Straight => STRAIGHT,
    }
}

/// Draws the diagram of all modes with a ring at each critical speed.
pub(crate) fn diagram(branches: &[ModeBranch], critical: &[CriticalSpeed]) -> Picture {
    let speeds = extent(branches.iter().flat_map(|branch| branch.points.iter().map(|point| point.speed_rpm)));
    let top = highest(branches, speeds.map_or(0.0, |range| range.0.abs().max(range.1.abs())));
    let x = Axis::exact(speeds, 7, "Speed, rpm");
    let y = Axis::exact(Some((0.0, top)), 8, "Frequency, Hz");
    let left = gutter(&[&y]);
    let frame = Frame { start: 0.0, left, top: 30.0, right: WIDE - NAMES, bottom: 30.0 + HEIGHT, x, y };
    let drawing = picture((WIDE, frame.bottom + BELOW), |canvas| {
        let keys = [
            (Key::Line(FORWARD), "forward"),
            (Key::Line(BACKWARD), "backward"),
            (Key::Line(STRAIGHT), "straight"),
            (Key::Ring(FAULT), "critical"),
        ];
        canvas.legend(left, 0.0, &keys);
        frame.axes(canvas, true);
        for order in [1.0, 2.0] {
            // The line ends at the upper edge, so that its name is inside the frame.
            let ends = speeds.map_or([0.0; 2], |(low, high)| [low, high.min(60.0 * top / order)]);
            let line: Vec<Point> = ends.iter().map(|speed| (*speed, order * speed.abs() / 60.0)).collect();
            frame.curve(canvas, &line, ORDER);
            let (px, py) = frame.at(&line[1]);
            let name = format!("{order:.0}X");
            frame.inside(canvas, |canvas| canvas.text(&name, (px - 4.0, py + 12.0), Anchor::End, INK));
        }
        for branch in branches {
            // The whirl of a mode may change with the speed: each part has the stroke of its whirl.
            for run in branch.points.chunk_by(|a, b| a.mode.whirl == b.mode.whirl) {
                let whirl = run[0].mode.whirl;
                let end = branch.points.iter().find(|point| point.speed_rpm > run[run.len() - 1].speed_rpm);
                let shown = run.iter().chain(end).filter(|point| point.mode.frequency_hz <= top);
                let points: Vec<Point> = shown.map(|point| (point.speed_rpm, point.mode.frequency_hz)).collect();
                let name = format!("{} {}", branch.name(), whirl.name());
                frame.series(canvas, (&name, &points), Thinning::None, stroke(whirl));
            }
        }
        let rings: Vec<Point> = critical.iter().map(|one| (one.speed_rpm, one.frequency_hz)).collect();
        let rings: Vec<Point> = rings.into_iter().filter(|ring| ring.1 <= top).collect();
        frame.scatter(canvas, ("critical speed", &rings), Marker::Ring(FAULT));
        let mut lowest = f64::INFINITY;
        let mut ends: Vec<(f64, String)> = Vec::new();
        for branch in branches {
            let last = branch.points.iter().rfind(|point| point.mode.frequency_hz <= top);
            let is_at_end = |speed: f64| speeds.is_some_and(|range| speed >= range.1);
            if let Some(last) = last.filter(|last| is_at_end(last.speed_rpm)) {
                ends.push((frame.at(&(last.speed_rpm, last.mode.frequency_hz)).1, branch.name()));
            }
        }
        // Names are set from the lowest curve upwards; a name that would cover the one below is moved up.
        ends.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (y, name) in ends {
            let y = y.min(lowest - ROW);
            lowest = y;
            if y > 8.0 {
                canvas.text(&name, (frame.right + 5.0, y), Anchor::Start, INK);
            }
        }
    });
    let hidden = branches.iter().filter(|branch| branch.points.iter().all(|p| p.mode.frequency_hz > top)).count();
    let hidden =
        if hidden > 0 { format!(" {hidden} modes above {top:.0} Hz are in the table alone.") } else { String::new() };
    Picture {
        title: "Campbell diagram".to_owned(),
        note: format!(
            "Linearised at the static equilibrium of each speed. Modes are numbered by their frequency at the lowest speed and followed \
             by whirl and frequency. Rings: a mode crosses 1X or 2X, so that this speed is critical.{hidden}"
        ),
        drawing,
        ..Picture::default()
    }
}

/// Returns the upper end of the diagram, Hz: it includes the modes that 1X and 2X reach, and at least [`MIN_SHOWN`] modes.
fn highest(branches: &[ModeBranch], speed_rpm: f64) -> f64 {
    let mut tops: Vec<f64> = branches
        .iter()
        .map(|branch| branch.points.iter().map(|point| point.mode.frequency_hz).fold(0.0, f64::max))
        .collect();
    tops.sort_by(f64::total_cmp);
    let few = tops.get(MIN_SHOWN.min(tops.len()).saturating_sub(1)).copied().unwrap_or(1.0);
    let all = tops.last().copied().unwrap_or(1.0);
    let reached = BEYOND * 2.0 * speed_rpm / 60.0;
    let top = if few > reached { 1.08 * few } else { reached.min(1.08 * all) };
    if top > 0.0 && top.is_finite() { top } else { 1.0 }
}
