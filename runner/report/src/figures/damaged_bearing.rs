//! Drawings of damaged bearings: place of the damage, the direction of the unexplained force around it, and beside it the force
//! while an element passes.

use super::Picture;
use super::axis::{Axis, extent};
use super::canvas::{
    Anchor, Canvas, FAULT, Frame, GRID, INK, Key, MARK, MEASURED, PAPER, RESIDUAL, SHADE, Stroke, WIDE, WIDE_RIGHT,
    gutter, picture,
};
use super::line::{Point, Thinning};
use crate::number::{alone, count, fixed, shortened};
use crate::words;
use ballrace_twin::replay::outcome::{Diagnosis, Estimate, FaultParameters, ForceRose, ReferenceFrame};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

const HEIGHT: f64 = 326.0;
/// Right edge of the drawing.
const SIDE: f64 = 284.0;
const MIDDLE: Point = (0.5 * SIDE - 4.0, 174.0);
/// Pitch circle of the elements.
const PITCH: f64 = 46.0;
/// Thickness of the rings beyond the races.
const RING: f64 = 7.0;
/// Inner and outer end of the bars of the rose.
const ROSE: [f64; 2] = [74.0, 108.0];
/// Radius of the angle labels.
const ANGLES: f64 = 121.0;
const ALONG: Stroke = Stroke(MEASURED, 1.7);
const ACROSS: Stroke = Stroke(RESIDUAL, 1.4);
/// Largest radius of an element over half the spacing of the elements on the pitch circle.
const LARGEST_ELEMENT: f64 = 0.92;
/// Step of a drawn arc, rad.
const ARC_STEP: f64 = 0.02;
/// Least extent of a drawn spall, pixels.
const MIN_SPALL: f64 = 5.0;

/// Draws the damaged bearing of a diagnosis; `forward` is the sense of rotation, +1 from +X towards +Y.
pub(super) fn damaged_bearing(diagnosis: &Diagnosis, rose: &ForceRose, forward: f64) -> Picture {
    let bearing = Drawing::new(&diagnosis.parameters, rose);
    let drawing = picture((WIDE, HEIGHT), |canvas| {
        canvas.legend(8.0, 0.0, &legend(rose.frame));
        bearing.angles(canvas);
        bearing.bars(canvas);
        bearing.rings(canvas);
        bearing.elements(canvas);
        bearing.damage(canvas);
        sense(canvas, forward);
        mean_pass(canvas, &diagnosis.parameters, rose);
    });
    let bearing = shortened(diagnosis.bearing.as_deref().unwrap_or_default(), 30);
    Picture {
        title: format!("Bearing {bearing}: {}", words::place(diagnosis)),
        note: note(rose),
        drawing,
        ..Picture::default()
    }
}

fn legend(frame: ReferenceFrame) -> [(Key, &'static str); 4] {
    let place = match frame {
        ReferenceFrame::Cage => "damaged element",
        _ => "damage, 95 %",
    };
    [
        (Key::Band(MEASURED), "direction of the force"),
        (Key::Line(Stroke(FAULT, 3.0)), place),
        (Key::Line(ALONG), "force along it"),
        (Key::Line(ACROSS), "across it"),
    ]
}

fn note(rose: &ForceRose) -> String {
    let seen = match rose.frame {
        ReferenceFrame::Fixed => "Angles from +X towards +Y, Z towards the reader, elements as at a keyphasor pulse.",
        ReferenceFrame::Shaft => {
            "Angles on the shaft from the keyphasor mark (triangle), Z towards the reader, elements as at a keyphasor pulse."
        }
        ReferenceFrame::Cage => "Angles in the cage from element 1, Z towards the reader.",
    };
    format!(
        "{seen} Over the damage an element carries less, and the machine without the damage leaves this force unexplained. Left: \
         energy of the force by its direction; bars that point at the damage confirm its place. Right: the force, up to {} N, \
         of a pass. Both are the mean of {} passes and come from the measured motion; direction {}\u{b0}.",
        alone(rose.peak_n),
        count(rose.passes.max(0.0).round() as u64),
        fixed(rose.direction_deg, 0)
    )
}

/// Draws the force while an element passes the damage, whose extent is shaded.
fn mean_pass(canvas: &mut Canvas, parameters: &FaultParameters, rose: &ForceRose) {
    let curve = |i: usize| -> Vec<Point> { rose.pass.iter().map(|point| (point[0], point[i])).collect() };
    let (along, across) = (curve(1), curve(2));
    let y = Axis::padded(extent(along.iter().chain(&across).map(|point| point.1)), 6, "Force, N");
    let title = match rose.frame {
        ReferenceFrame::Cage => "Contact from damage, deg",
        _ => "Element from damage, deg",
    };
    let x = Axis::exact(extent(along.iter().map(|point| point.0)), 4, title);
    let start = SIDE + 4.0;
    let frame = Frame { start, left: start + gutter(&[&y]), top: 64.0, right: WIDE_RIGHT, bottom: HEIGHT - 42.0, x, y };
    let half = parameters.half_width_deg.map_or(f64::NAN, |half| half.value);
    if half.is_finite() {
        frame.shade(canvas, [[-half, half]], SHADE);
    }
    frame.axes(canvas, true);
    frame.series(canvas, ("force across the direction of the damage", &across), Thinning::None, ACROSS);
    frame.series(canvas, ("force along the direction of the damage", &along), Thinning::None, ALONG);
    if half.is_finite() {
        let middle = 0.5 * (frame.left + frame.right);
        canvas.text("shaded: extent of the damage", (middle, frame.top - 9.0), Anchor::Middle, INK);
    }
    frame.note_if_empty(canvas, &[&along]);
}

/// Geometry of one drawing, pixels.
struct Drawing<'a> {
    rose: &'a ForceRose,
    parameters: &'a FaultParameters,
    element: f64,
}

/// Returns the point at an angle (rad) and a radius (pixels) about the middle.
fn around(angle: f64, radius: f64) -> Point {
    (MIDDLE.0 + radius * angle.cos(), MIDDLE.1 - radius * angle.sin())
}

/// Returns the points of an arc between two angles, rad.
fn arc(from: f64, to: f64, radius: f64) -> Vec<Point> {
    let steps = ((to - from).abs() / ARC_STEP).ceil().clamp(1.0, 400.0) as u32;
    (0..=steps).map(|i| around(from + (to - from) * f64::from(i) / f64::from(steps), radius)).collect()
}

impl<'a> Drawing<'a> {
    fn new(parameters: &'a FaultParameters, rose: &'a ForceRose) -> Self {
        let room = LARGEST_ELEMENT * PI * PITCH / rose.element_azimuths.len().max(3) as f64;
        let given = PITCH * rose.ball_over_pitch;
        let element = if given.is_finite() { given.clamp(3.0, 0.38 * PITCH).min(room) } else { room.min(12.0) };
        Self { rose, parameters, element }
    }

    /// Draws the circles of the rose and the four quarters with their angles.
    fn angles(&self, canvas: &mut Canvas) {
        canvas.circle(MIDDLE.0, MIDDLE.1, ROSE[0], Stroke(GRID, 0.9));
        canvas.circle(MIDDLE.0, MIDDLE.1, ROSE[1], Stroke(GRID, 0.9));
        let zero = match self.rose.frame {
            ReferenceFrame::Fixed => "0\u{b0} +X",
            ReferenceFrame::Shaft => "0\u{b0} mark",
            ReferenceFrame::Cage => "0\u{b0}",
        };
        let ninety = if self.rose.frame == ReferenceFrame::Fixed { "90\u{b0} +Y" } else { "90\u{b0}" };
        for (quarter, name) in [zero, ninety, "180\u{b0}", "270\u{b0}"].into_iter().enumerate() {
            let angle = FRAC_PI_2 * quarter as f64;
            canvas.line(&[around(angle, ROSE[0]), around(angle, ROSE[1])], Stroke(GRID, 0.9));
            let (x, y) = around(angle, ANGLES);
            let (at, anchor) = match quarter {
                0 => ((x - ANGLES + ROSE[1] + 8.0, y), Anchor::Start),
                _ => ((x, y), Anchor::Middle),
            };
            canvas.text(name, at, anchor, INK);
        }
    }

    /// Draws the rose: one bar per sector, the longest up to the outer circle.
    fn bars(&self, canvas: &mut Canvas) {
        let energy = &self.rose.energy;
        let largest = energy.iter().copied().filter(|share| share.is_finite()).fold(0.0, f64::max);
        let half = 0.5 * TAU / energy.len().max(1) as f64;
        for (i, share) in energy.iter().enumerate().filter(|(_, share)| share.is_finite() && **share > 0.002 * largest)
        {
            let end = ROSE[0] + (ROSE[1] - ROSE[0]) * share / largest;
            let middle = 2.0 * half * i as f64;
            let (from, to) = (middle - 0.86 * half, middle + 0.86 * half);
            let corners = [around(from, ROSE[0]), around(from, end), around(to, end), around(to, ROSE[0])];
            canvas.polygon(&corners, MEASURED);
        }
        if largest > 0.0 {
            let label = format!("outer circle: {} % of the energy", fixed(100.0 * largest, 0));
            canvas.text(&label, (8.0, HEIGHT - 8.0), Anchor::Start, MARK);
        }
    }

    /// Draws both bearing rings, each between two circles, and the keyphasor mark on the shaft.
    fn rings(&self, canvas: &mut Canvas) {
        let (outer, inner) = (PITCH + self.element, PITCH - self.element);
        for radius in [outer, outer + RING, inner, inner - RING] {
            canvas.circle(MIDDLE.0, MIDDLE.1, radius, Stroke(MARK, 1.1));
        }
        // The shaft is drawn at angle 0, with its keyphasor mark. In the cage frame the shaft angle varies.
        if self.rose.frame != ReferenceFrame::Cage {
            canvas.triangle(around(0.0, inner - RING - 1.0), PI, 8.0, MARK);
        }
    }

    fn elements(&self, canvas: &mut Canvas) {
        let damaged = self.parameters.element.filter(|_| self.rose.frame == ReferenceFrame::Cage);
        for (i, angle) in self.rose.element_azimuths.iter().enumerate().filter(|(_, angle)| angle.is_finite()) {
            let (x, y) = around(*angle, PITCH);
            if damaged == Some(i + 1) {
                canvas.dot(x, y, self.element - 1.0, FAULT);
                canvas.dot(x, y, self.element - 4.0, PAPER);
            }
            canvas.circle(x, y, self.element - 1.0, Stroke(MARK, 1.1));
            let is_numbered = self.element > 6.5 && self.rose.frame == ReferenceFrame::Cage;
            if is_numbered {
                canvas.text(&format!("{}", i + 1), (x, y), Anchor::Middle, INK);
            }
        }
    }

    /// Draws the spall on its surface, its azimuth through the rose, and the interval of the azimuth at the end.
    fn damage(&self, canvas: &mut Canvas) {
        let (race, azimuth) = match self.rose.frame {
            ReferenceFrame::Fixed => (PITCH + self.element, self.parameters.azimuth_deg),
            ReferenceFrame::Shaft => (PITCH - self.element, self.parameters.azimuth_deg),
            ReferenceFrame::Cage => {
                let damaged = self.parameters.element.and_then(|e| self.rose.element_azimuths.get(e.wrapping_sub(1)));
                let angle = damaged.map(|angle| angle.to_degrees());
                (PITCH + self.element, angle.map(|angle| Estimate { value: angle, low: angle, high: angle }))
            }
        };
        let Some(azimuth) = azimuth.filter(|a| [a.value, a.low, a.high].iter().all(|x| x.is_finite())) else {
            return;
        };
        let [value, low, high] = [azimuth.value, azimuth.low, azimuth.high].map(f64::to_radians);
        let from = if self.rose.frame == ReferenceFrame::Cage { race + RING } else { race };
        canvas.line(&[around(value, from), around(value, ROSE[1] + 6.0)], Stroke(FAULT, 1.2));
        if high - low > 0.0 && high - low < TAU {
            canvas.line(&arc(low, high, ROSE[1] + 6.0), Stroke(FAULT, 3.0));
        }
        if self.rose.frame != ReferenceFrame::Cage {
            let half = self.parameters.half_width_deg.map_or(0.0, |e| e.value.to_radians());
            let half = if half.is_finite() { half.clamp(MIN_SPALL / race, PI) } else { MIN_SPALL / race };
            canvas.line(&arc(value - half, value + half, race), Stroke(FAULT, 5.0));
        }
    }
}

/// Draws an arrow inside the shaft in the sense of rotation.
fn sense(canvas: &mut Canvas, forward: f64) {
    let radius = 13.0;
    let turn = |share: f64| PI * (0.5 + forward * (1.5 * share - 0.75));
    canvas.line(&arc(turn(0.0), turn(1.0), radius), Stroke(MARK, 1.3));
    let end = around(turn(1.0) + forward * 0.3, radius);
    canvas.triangle(end, turn(1.0) - forward * FRAC_PI_2, 7.0, MARK);
}
