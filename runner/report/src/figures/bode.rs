//! Bode plots: phase lag and amplitude of 1X over the speed.

use super::axis::{Axis, extent};
use super::canvas::{BELOW, Key, MEASURED, RESIDUAL, Stroke, TWIN_LINE, WIDE, picture, stacked};
use super::line::{Point, Thinning};
use super::one_x::{OneX, amplitude, lag};
use super::{Context, Figure, Picture};

const COMPENSATED: Stroke = Stroke(MEASURED, 1.8);
const RAW: Stroke = Stroke(RESIDUAL, 1.4);

/// Bode plots of 1X, one per radial probe of a recording over speed.
pub(super) struct BodePlots;

impl Figure for BodePlots {
    fn heading(&self) -> &'static str {
        "Bode plots"
    }

    fn draw(&self, context: &Context<'_>) -> Vec<Picture> {
        if !context.over_speed {
            return vec![];
        }
        context.radial_probes().map(|(i, name, _)| bode(name, &OneX::new(&context.data.blocks, i))).collect()
    }
}

/// Draws the Bode plot of one probe.
pub(super) fn bode(name: &str, one_x: &OneX) -> Picture {
    let curves = [
        ("as measured", &one_x.raw, RAW),
        ("compensated", &one_x.compensated, COMPENSATED),
        ("twin", &one_x.twin, TWIN_LINE),
    ];
    let x = Axis::exact(extent(one_x.speed_rpm.iter().copied()), 8, "Speed, rpm");
    let largest = extent(curves.iter().flat_map(|curve| curve.1.iter().map(amplitude))).map(|range| range.1);
    let axes = vec![lag_axis(), Axis::from_zero(largest, 6, "1X, um pp")];
    let frames = stacked(&x, axes, (34.0, 120.0, 14.0));
    let bottom = frames.last().map_or(0.0, |frame| frame.bottom);
    let drawing = picture((WIDE, bottom + BELOW), |canvas| {
        let [upper, lower] = &frames[..] else { return };
        canvas.legend(upper.left, 0.0, &[1, 0, 2].map(|i: usize| (Key::Line(curves[i].2), curves[i].0)));
        upper.axes(canvas, false);
        lower.axes(canvas, true);
        for (name, vectors, stroke) in curves {
            upper.series(canvas, (name, &lags(one_x, vectors)), Thinning::None, stroke);
            let points = one_x.speed_rpm.iter().zip(vectors).map(|(rpm, vector)| (*rpm, amplitude(vector)));
            lower.series(canvas, (name, &points.collect::<Vec<_>>()), Thinning::None, stroke);
        }
        let all: Vec<Point> = one_x.speed_rpm.iter().zip(&one_x.raw).map(|(rpm, v)| (*rpm, amplitude(v))).collect();
        lower.note_if_empty(canvas, &[&all]);
    });
    Picture { title: format!("Bode plot of {name}: 1X over speed"), note: one_x.words(), drawing, ..Picture::default() }
}

/// Returns the axis of the lag from 0 to 360 deg, with 0 at the top.
fn lag_axis() -> Axis {
    let mut axis = Axis::exact(Some((-360.0, 0.0)), 5, "Lag, deg");
    axis.ticks = [0_u16, 90, 180, 270, 360].map(|lag| (-f64::from(lag), lag.to_string())).to_vec();
    axis
}

/// Returns the line of the lag, interrupted where the lag wraps and where the phase is not significant.
fn lags(one_x: &OneX, vectors: &[[f64; 2]]) -> Vec<Point> {
    let mut points: Vec<Point> = Vec::new();
    for (rpm, vector) in one_x.speed_rpm.iter().zip(vectors) {
        let here = if one_x.has_phase(vector) { -lag(vector) } else { f64::NAN };
        if points.last().is_some_and(|last| (last.1 - here).abs() > 180.0) {
            points.push((*rpm, f64::NAN));
        }
        points.push((*rpm, here));
    }
    points
}
