//! Motion with and without a fault: two revolutions at a probe, and below it the residual of each estimate.

use super::axis::Axis;
use super::canvas::{BELOW, Key, MEASURED_LINE, RESIDUAL, Stroke, TWIN_LINE, WIDE, picture};
use super::line::{Point, zipped};
use super::trace::{keyphasor, two_frames};
use super::{Picture, PointBudget};
use crate::number::{alone, shortened};
use crate::words;
use ballrace_twin::replay::outcome::{Diagnosis, FaultMotion};

const WITHOUT: Stroke = Stroke(RESIDUAL, 1.5);

/// Draws the motion of one diagnosis.
pub(super) fn fault_motion(diagnosis: &Diagnosis, motion: &FaultMotion, budget: PointBudget) -> Picture {
    let curve = |values: &[f64]| zipped(&motion.revolutions, values);
    let left_by = |estimate: &[f64]| -> Vec<f64> { motion.measured.iter().zip(estimate).map(|(m, e)| m - e).collect() };
    let [measured, without, with] = [&motion.measured, &motion.without, &motion.with].map(|values| curve(values));
    let left = [left_by(&motion.without), left_by(&motion.with)];
    let [missed, missed_with]: [Vec<Point>; 2] = left.each_ref().map(|left| curve(left));
    let x = Axis::exact(Some((0.0, 2.0)), 9, "Revolutions of the shaft, from the keyphasor mark");
    let [upper, lower] = two_frames(x, [&[&measured, &without, &with], &[&missed, &missed_with]]);
    let drawing = picture((WIDE, lower.bottom + BELOW), |canvas| {
        let legend = [
            (Key::Line(MEASURED_LINE), "measured"),
            (Key::Line(WITHOUT), "twin without the fault"),
            (Key::Line(TWIN_LINE), "twin with the fault"),
        ];
        canvas.legend(upper.left, 0.0, &legend);
        upper.axes(canvas, false);
        lower.axes(canvas, true);
        keyphasor(canvas, [&upper, &lower], [0.0, 1.0, 2.0].into_iter());
        upper.series(canvas, ("measured", &measured), budget.time(), MEASURED_LINE);
        upper.series(canvas, ("twin without the fault", &without), budget.time(), WITHOUT);
        upper.series(canvas, ("twin with the fault", &with), budget.time(), TWIN_LINE);
        lower.series(canvas, ("without the fault", &missed), budget.time(), WITHOUT);
        lower.series(canvas, ("with the fault", &missed_with), budget.time(), TWIN_LINE);
        upper.note_if_empty(canvas, &[&measured, &without, &with]);
        lower.note_if_empty(canvas, &[&missed, &missed_with]);
    });
    let [before, after] = left.each_ref().map(|left| rms(left));
    Picture {
        title: format!(
            "Motion at {} with and without the fault: {}",
            shortened(&motion.probe, 30),
            words::cause(diagnosis).to_lowercase()
        ),
        note: format!(
            "Two revolutions of the recording. Lower frame: residual, {} um rms without the fault and {} um with it. The \
             twin's motion is estimated from the forces at the measured position, without integration: it holds for chaotic \
             motion too.",
            alone(before),
            alone(after)
        ),
        drawing,
        ..Picture::default()
    }
}

fn rms(values: &[f64]) -> f64 {
    let finite = values.iter().filter(|x| x.is_finite());
    (finite.clone().map(|x| x * x).sum::<f64>() / finite.count().max(1) as f64).sqrt()
}
