//! A correction plane as its holes lie, with the masses to place.

use super::Picture;
use super::canvas::{Anchor, Canvas, FAULT, INK, MARK, Stroke, picture};
use super::line::Point;
use ballrace_twin::balance::{HoleMass, PlaneCorrection, PlaneHoles};
use ballrace_twin::printable::number;

const WIDTH: f64 = 350.0;
const HEIGHT: f64 = 240.0;
const MIDDLE: Point = (0.5 * WIDTH, 0.5 * HEIGHT);
const RADIUS: f64 = 92.0;
/// Holes beyond which only those with a mass have their number.
const MOST_NUMBERS: usize = 24;

/// Returns the point at an angle (degrees) and a share of the radius.
fn at(degrees: f64, share: f64) -> Point {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    (MIDDLE.0 + RADIUS * share * cosine, MIDDLE.1 - RADIUS * share * sine)
}

/// Returns the holes of a plane in words.
pub(crate) fn circle(of: &PlaneHoles) -> String {
    let first = if of.first_deg == 0.0 { String::new() } else { format!(", hole 1 at {} deg", number(of.first_deg)) };
    format!("{} on a radius of {} mm{first}", of.number, number(of.radius_mm))
}

/// Draws the plane of a correction; `angle` (degrees) is that of the whole moment.
pub(crate) fn plane(of: &PlaneCorrection, angle: f64) -> Picture {
    let drawing = picture((WIDTH, HEIGHT), |canvas| {
        canvas.circle(MIDDLE.0, MIDDLE.1, RADIUS, Stroke(MARK, 0.9));
        canvas.dot(MIDDLE.0, MIDDLE.1, 2.5, MARK);
        rotation(canvas);
        // The keyphasor mark.
        canvas.triangle(at(0.0, 0.76), std::f64::consts::PI, 11.0, INK);
        if let Some(circle) = &of.circle {
            (1..=circle.number).for_each(|hole| empty(canvas, hole, circle));
        } else if of.moment_g_mm > 0.0 {
            mark(canvas, angle, &format!("{:.1} g mm", of.moment_g_mm));
        }
        for mass in &of.holes {
            placed(canvas, mass);
        }
    });
    let angles = "Angles count from the keyphasor mark (triangle) in the direction of positive rotation (arrow).";
    let holes = of.circle.as_ref().map_or_else(String::new, |of| {
        let taken = if of.taken.is_empty() { "" } else { "; those with a cross take no mass" };
        format!("Holes: {}{taken}. ", circle(of))
    });
    Picture { title: format!("Plane {}", of.plane), note: holes + angles, drawing, ..Picture::default() }
}

/// Draws a hole without a mass.
fn empty(canvas: &mut Canvas, hole: usize, of: &PlaneHoles) {
    let angle = of.first_deg + 360.0 * (hole - 1) as f64 / of.number as f64;
    let (x, y) = at(angle, 1.0);
    canvas.circle(x, y, 4.0, Stroke(MARK, 0.9));
    if of.taken.contains(&hole) {
        for side in [-4.0, 4.0] {
            canvas.line(&[(x - 4.0, y - side), (x + 4.0, y + side)], Stroke(MARK, 0.9));
        }
    }
    if of.number <= MOST_NUMBERS {
        canvas.text(&hole.to_string(), at(angle, 0.86), Anchor::Middle, MARK);
    }
}

fn placed(canvas: &mut Canvas, mass: &HoleMass) {
    mark(canvas, mass.angle_deg, &format!("{}: {:.2} g", mass.hole, mass.mass_g));
}

/// Draws a mass with its text outside the circle.
fn mark(canvas: &mut Canvas, degrees: f64, text: &str) {
    let (x, y) = at(degrees, 1.0);
    canvas.dot(x, y, 5.5, FAULT);
    let cosine = degrees.to_radians().cos();
    let anchor = match cosine {
        c if c > 0.3 => Anchor::Start,
        c if c < -0.3 => Anchor::End,
        _ => Anchor::Middle,
    };
    canvas.text(text, at(degrees, 1.14), anchor, INK);
}

/// Draws an arc with its head in the direction of positive rotation.
fn rotation(canvas: &mut Canvas) {
    let arc: Vec<Point> = (0..=20).map(|i| at(50.0 + 4.0 * f64::from(i), 0.4)).collect();
    canvas.line(&arc, Stroke(MARK, 1.2));
    canvas.triangle(at(136.0, 0.4), 40.0_f64.to_radians(), 9.0, MARK);
}
