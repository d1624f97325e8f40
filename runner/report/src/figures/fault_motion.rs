//! Motion with and without a fault: two revolutions at a probe, and below it the motion that each estimate leaves unexplained.

use super::axis::Axis;
use super::canvas::{BELOW, Key, MEASURED_LINE, RESIDUAL, Stroke, TWIN_LINE, WIDE, picture};
use super::line::{Point, zipped};
use super::trace::{keyphasor, two_frames};
use super::{Picture, PointBudget};
use crate::number::shortened;
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
    let [upper, lower] = two_frames(x, [&[&measured, &without, &with], &[&missed, &missed_with]], "Unexplained, um");
    let drawing = picture((WIDE, lower.bottom + BELOW), |canvas| {
        let legend = [
            (Key::Line(MEASURED_LINE), "measured"),
            (Key::Line(WITHOUT), "estimate without the fault"),
            (Key::Line(TWIN_LINE), "estimate with the fault"),
        ];
        canvas.legend(upper.left, 0.0, &legend);
        upper.axes(canvas, false);
        lower.axes(canvas, true);
        keyphasor(canvas, [&upper, &lower], [0.0, 1.0, 2.0].into_iter());
        upper.series(canvas, ("measured", &measured), budget.time(), MEASURED_LINE);
        upper.series(canvas, ("estimate without the fault", &without), budget.time(), WITHOUT);
        upper.series(canvas, ("estimate with the fault", &with), budget.time(), TWIN_LINE);
        lower.series(canvas, ("without the fault", &missed), budget.time(), WITHOUT);
        lower.series(canvas, ("with the fault", &missed_with), budget.time(), TWIN_LINE);
        upper.note_if_empty(canvas, &[&measured, &without, &with]);
        lower.note_if_empty(canvas, &[&missed, &missed_with]);
    });
    Picture {
        title: format!(
            "Motion at {} with and without the fault: {}",
            shortened(&motion.probe, 30),
            words::cause(diagnosis).to_lowercase()
        ),
        note: format!(
            "Two revolutions of the recording. Lower frame: unexplained motion, measured less estimate. {}The estimates follow \
             from the forces at the measured position, without integration: they hold for chaotic motion too. The twin of the \
             other figures is simulated from the scene alone.",
            motion.unexplained.as_ref().map_or_else(String::new, |of| format!("{} ", words::unexplained_motion(of)))
        ),
        drawing,
        ..Picture::default()
    }
}
