//! Motion with and without a fault: two revolutions at a probe, and below it what each estimate leaves.

use super::axis::{Axis, extent};
use super::canvas::{Canvas, Dashes, Frame, Key, MARK, MEASURED, RESIDUAL, Stroke, TWIN, gutter, picture};
use super::line::{Point, decimated, zipped};
use super::{Picture, PointBudget};
use crate::number::{alone, shortened};
use crate::words;
use anyhow::Result;
use ballrace_twin::replay::outcome::{FaultMotion, Finding};

const WIDTH: f64 = 620.0;
const WITHOUT: Stroke = Stroke(MARK, 1.3);
const WITH: Stroke = Stroke(TWIN, 1.5);

/// Draws the motion of one finding.
pub(super) fn fault_motion(finding: &Finding, motion: &FaultMotion, budget: PointBudget) -> Result<Picture> {
    let curve = |values: &[f64]| decimated(&zipped(&motion.revolutions, values), budget.line());
    let left_by = |estimate: &[f64]| -> Vec<f64> { motion.measured.iter().zip(estimate).map(|(m, e)| m - e).collect() };
    let (measured, without, with) = (curve(&motion.measured), curve(&motion.without), curve(&motion.with));
    let left = [left_by(&motion.without), left_by(&motion.with)];
    let [missed, missed_with] = left.each_ref().map(|left| curve(left));
    let (upper, lower) = frames([&measured, &without, &with], [&missed, &missed_with]);
    let svg = picture((WIDTH, lower.bottom + 36.0), Dashes::Twin, |canvas| {
        canvas.legend(upper.left, 0.0, &legend())?;
        upper.axes(canvas, false)?;
        lower.axes(canvas, true)?;
        keyphasor(canvas, [&upper, &lower])?;
        upper.curve(canvas, &measured, Stroke(MEASURED, 1.6))?;
        upper.curve(canvas, &without, WITHOUT)?;
        upper.curve(canvas, &with, WITH)?;
        lower.curve(canvas, &missed, WITHOUT)?;
        lower.curve(canvas, &missed_with, WITH)?;
        upper.note_if_empty(canvas, &[&measured, &without, &with])?;
        lower.note_if_empty(canvas, &[&missed, &missed_with])
    })?;
    let [before, after] = left.each_ref().map(|left| rms(left));
    Ok(Picture {
        title: format!(
            "Motion at {} with and without the fault: {}",
            shortened(&motion.probe, 30),
            words::cause(finding).to_lowercase()
        ),
        note: format!(
            "Two revolutions of the recording. Lower frame: measured less twin, {} um rms without the fault and {} um with it. The \
             twin's motion is estimated from the forces at the measured position, without integration: it holds for chaotic \
             motion too.",
            alone(before),
            alone(after)
        ),
        svg,
    })
}

fn legend() -> [(Key, &'static str); 3] {
    [
        (Key::Line(Stroke(MEASURED, 1.8)), "measured"),
        (Key::Line(WITHOUT), "twin without the fault"),
        (Key::Line(WITH), "twin with the fault"),
    ]
}

fn rms(values: &[f64]) -> f64 {
    let finite = values.iter().filter(|x| x.is_finite());
    (finite.clone().map(|x| x * x).sum::<f64>() / finite.count().max(1) as f64).sqrt()
}

fn frames(above: [&Vec<Point>; 3], below: [&Vec<Point>; 2]) -> (Frame, Frame) {
    let range = |curves: &[&Vec<Point>]| extent(curves.iter().flat_map(|curve| curve.iter().map(|point| point.1)));
    let position = Axis::padded(range(&above), 7, "Position, um");
    let difference = Axis::padded(range(&below), 5, "Diff., um");
    let x = Axis::exact(Some((0.0, 2.0)), 9, "Revolutions of the shaft, from the keyphasor mark");
    let left = gutter(&[&position, &difference]);
    let right = WIDTH - 18.0;
    let upper = Frame { start: 0.0, left, top: 34.0, right, bottom: 200.0, x: x.clone(), y: position };
    let lower = Frame { start: 0.0, left, top: 212.0, right, bottom: 300.0, x, y: difference };
    (upper, lower)
}

/// A triangle above and a fine line through the frames at each passage of the mark.
fn keyphasor(canvas: &mut Canvas, frames: [&Frame; 2]) -> Result<()> {
    for revolution in [0.0, 1.0, 2.0] {
        let x = frames[0].at(&(revolution, 0.0)).0;
        for frame in frames {
            canvas.line(&[(x, frame.top), (x, frame.bottom)], Stroke(RESIDUAL, 0.5))?;
        }
        canvas.triangle((x, frames[0].top - 1.0), std::f64::consts::FRAC_PI_2, 8.0, MARK)?;
    }
    Ok(())
}
