//! Bode plots: phase lag and amplitude of 1X over the speed.

use super::axis::{Axis, extent};
use super::canvas::{Dashes, Frame, Key, MEASURED, RESIDUAL, Stroke, TWIN, gutter, picture};
use super::line::Point;
use super::one_x::{OneX, amplitude, lag};
use super::{Context, Figure, Picture};
use anyhow::Result;

const WIDTH: f64 = 620.0;
const COMPENSATED: Stroke = Stroke(MEASURED, 1.8);
const RAW: Stroke = Stroke(RESIDUAL, 1.6);
const OF_TWIN: Stroke = Stroke(TWIN, 1.4);

/// Bode plots of 1X, one per radial probe of a recording over speed.
pub(super) struct BodePlots;

impl Figure for BodePlots {
    fn heading(&self) -> &'static str {
        "Bode plots"
    }

    fn draw(&self, context: &Context<'_>) -> Result<Vec<Picture>> {
        if !context.over_speed {
            return Ok(vec![]);
        }
        context.radial_probes().map(|(i, name, _)| bode(name, &OneX::new(&context.data.blocks, i))).collect()
    }
}

/// Draws the Bode plot of one probe.
pub(super) fn bode(name: &str, one_x: &OneX) -> Result<Picture> {
    let curves = [(&one_x.raw, RAW), (&one_x.compensated, COMPENSATED), (&one_x.twin, OF_TWIN)];
    let x = Axis::exact(extent(one_x.speed_rpm.iter().copied()), 9, "Speed, rpm");
    let largest = extent(curves.iter().flat_map(|curve| curve.0.iter().map(amplitude))).map(|range| range.1);
    let size = Axis::from_zero(largest, 6, "1X, um pp");
    let phase = lag_axis();
    let left = gutter(&[&size, &phase]);
    let upper = Frame { start: 0.0, left, top: 34.0, right: WIDTH - 18.0, bottom: 164.0, x, y: phase };
    let lower = Frame { top: 178.0, bottom: 318.0, y: size, ..upper.clone() };
    let svg = picture((WIDTH, lower.bottom + 36.0), Dashes::Twin, |canvas| {
        let names = ["compensated", "as measured", "twin"];
        let keys = [COMPENSATED, RAW, OF_TWIN].map(Key::Line);
        canvas.legend(left, 0.0, &[(keys[0], names[0]), (keys[1], names[1]), (keys[2], names[2])])?;
        upper.axes(canvas, false)?;
        lower.axes(canvas, true)?;
        for (vectors, stroke) in curves {
            upper.curve(canvas, &lags(one_x, vectors), stroke)?;
            let points = one_x.speed_rpm.iter().zip(vectors).map(|(rpm, vector)| (*rpm, amplitude(vector)));
            lower.curve(canvas, &points.collect::<Vec<_>>(), stroke)?;
        }
        let all: Vec<Point> = one_x.speed_rpm.iter().zip(&one_x.raw).map(|(rpm, v)| (*rpm, amplitude(v))).collect();
        lower.note_if_empty(canvas, &[&all])
    })?;
    Ok(Picture { title: format!("Bode plot of {}: 1X over speed", name), note: one_x.words(), svg })
}

/// 0 at the top, as the lag grows downwards.
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
