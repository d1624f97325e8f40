//! Vectors of a probe in the complex plane: before a correction, as expected, and with the mounted masses.

use super::Picture;
use super::canvas::{BELOW, Frame, GRID, Key, MARK, MEASURED, Marker, RESIDUAL, Stroke, TWIN, equal_scales, picture};
use super::line::Point;
use ballrace_twin::balance::{Influence, Predicted, TrimVector};
use std::f64::consts::TAU;

const SIDE: f64 = 260.0;
const WIDTH: f64 = 1.8;
/// Share of the square that the data fill.
const FILLED: f64 = 0.85;

/// A vector with the circle in which it lies with 95 %.
struct Vector {
    name: &'static str,
    tip: Point,
    radius: Option<f64>,
    stroke: Stroke,
}

impl Vector {
    /// Creates a vector of a size and an angle in degrees.
    fn new(name: &'static str, [size, degrees]: [f64; 2], deviation: Option<f64>, stroke: Stroke) -> Self {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        // The square of a complex normal value is beyond its variance times ln 20 in one of twenty cases.
        let radius = deviation.map(|deviation| deviation * 20.0_f64.ln().sqrt());
        Self { name, tip: (size * cosine, size * sine), radius, stroke }
    }

    fn circle(&self) -> Vec<Point> {
        self.radius.map_or_else(Vec::new, |radius| around(self.tip, radius))
    }
}

fn around((x, y): Point, radius: f64) -> Vec<Point> {
    let at = |i: i32| {
        let (sine, cosine) = (TAU * f64::from(i) / 64.0).sin_cos();
        (x + radius * cosine, y + radius * sine)
    };
    (0..=64).map(at).collect()
}

/// Draws the vectors of one probe at one speed before and after the correction.
pub(crate) fn correction(of: &Predicted, unit: &str) -> Picture {
    let before = [of.before, of.before_deg];
    let after = [of.after, of.after_deg];
    let vectors = [
        Vector::new("before", before, Some(of.before_deviation), Stroke(MEASURED, WIDTH)),
        Vector::new("after, expected", after, Some(of.deviation), Stroke(TWIN, WIDTH)),
    ];
    draw((&of.probe, of.speed_rpm), &vectors, unit)
}

/// Draws the vectors of one probe at one speed without added masses, as expected with the mounted ones, and as measured with them.
pub(crate) fn trim(of: &TrimVector, without: &Influence, unit: &str) -> Picture {
    let mut vectors = vec![Vector::new(
        "without masses",
        without.baseline,
        Some(without.baseline_deviation),
        Stroke(RESIDUAL, WIDTH),
    )];
    if let Some([size, angle, deviation]) = of.expected {
        vectors.push(Vector::new("expected", [size, angle], Some(deviation), Stroke(TWIN, WIDTH)));
    }
    vectors.push(Vector::new("measured", of.measured, None, Stroke(MEASURED, WIDTH)));
    draw((&of.probe, of.speed_rpm), &vectors, unit)
}

fn draw((probe, speed_rpm): (&str, f64), vectors: &[Vector], unit: &str) -> Picture {
    let all = vectors.iter().flat_map(|vector| vector.circle().into_iter().chain([vector.tip]));
    let reach = all.map(|(x, y)| x.abs().max(y.abs())).fold(f64::MIN_POSITIVE, f64::max);
    let titles = [format!("Real part, {unit}"), format!("Imaginary part, {unit}")];
    let frame =
        equal_scales(((-reach, reach), (-reach, reach)), (28.0, SIDE, FILLED), titles.each_ref().map(String::as_str));
    let drawing = picture((frame.right + 12.0, frame.bottom + BELOW), |canvas| {
        let legend: Vec<(Key, &str)> = vectors.iter().map(|vector| (Key::Line(vector.stroke), vector.name)).collect();
        canvas.legend(8.0, 0.0, &legend);
        frame.axes(canvas, true);
        rings(&frame, canvas);
        for vector in vectors {
            frame.curve(canvas, &[(0.0, 0.0), vector.tip], vector.stroke);
            frame.curve(canvas, &vector.circle(), Stroke(vector.stroke.0, 0.9));
            frame.scatter(canvas, (vector.name, &[vector.tip]), Marker::Dot(4.0, vector.stroke.0));
        }
    });
    Picture {
        title: format!("{probe} at {speed_rpm:.0} rpm"),
        note: "The circles hold the vectors with 95 %.".to_owned(),
        drawing,
        ..Picture::default()
    }
}

/// Draws circles of equal size through the ticks, and the axes of the four quarters.
fn rings(frame: &Frame, canvas: &mut super::canvas::Canvas) {
    for (size, _) in frame.x.ticks.iter().filter(|(size, _)| *size > 0.0) {
        frame.curve(canvas, &around((0.0, 0.0), *size), Stroke(GRID, 0.9));
    }
    frame.uprights(canvas, [0.0], Stroke(MARK, 0.9));
    frame.levels(canvas, [0.0], Stroke(MARK, 0.9));
}
