//! Polar plots: the 1X vector over the speed. Zero lag is at the probe; the lag increases against rotation.

use super::axis::Axis;
use super::canvas::{
    Anchor, Canvas, Colour, GRID, INK, Key, MARK, MEASURED, RESIDUAL, SMALL, Stroke, picture, text_width,
};
use super::line::{Point, pieces};
use super::one_x::{OneX, amplitude, lag};
use super::{Context, Figure, Picture, Shape};

const SIDE: f64 = 340.0;
const MIDDLE: Point = (0.5 * SIDE, 196.0);
const RADIUS: f64 = 132.0;
const COMPENSATED: Stroke = Stroke(MEASURED, 1.8);
const RAW: Stroke = Stroke(RESIDUAL, 1.4);

/// Scales of the figure: angle of a lag, radius of an amplitude.
struct Dial {
    /// Angle of the probe, rad from +X towards +Y.
    probe: f64,
    /// Sense of rotation: +1 from +X towards +Y.
    forward: f64,
    radial: Axis,
}

impl Dial {
    /// Returns the point at a lag (degrees) and a share of the radius.
    fn around(&self, lag: f64, share: f64) -> Point {
        let (sine, cosine) = self.angle(lag).sin_cos();
        (MIDDLE.0 + RADIUS * share * cosine, MIDDLE.1 - RADIUS * share * sine)
    }

    fn angle(&self, lag: f64) -> f64 {
        self.probe - self.forward * lag.to_radians()
    }

    fn at(&self, vector: &[f64; 2]) -> Point {
        let size = amplitude(vector);
        if size.is_finite() { self.around(lag(vector), self.radial.place(size)) } else { (f64::NAN, f64::NAN) }
    }
}

/// Polar plots of 1X, one per radial probe of a recording over speed.
pub(super) struct PolarPlots;

impl Figure for PolarPlots {
    fn heading(&self) -> &'static str {
        "Polar plots"
    }

    fn shape(&self) -> Shape {
        Shape::Square
    }

    fn draw(&self, context: &Context<'_>) -> Vec<Picture> {
        if !context.over_speed {
            return vec![];
        }
        let one = |(i, name, angle)| polar(name, angle, context.forward, &OneX::new(&context.data.blocks, i));
        context.radial_probes().map(one).collect()
    }
}

/// Draws the polar plot of one probe at an angle (rad); `forward` is the sense of rotation, +1 from +X towards +Y.
pub(super) fn polar(name: &str, angle: f64, forward: f64, one_x: &OneX) -> Picture {
    let all = one_x.raw.iter().chain(&one_x.compensated).map(amplitude).filter(|size| size.is_finite());
    let radial = Axis::from_zero(Some(all.fold(0.0, f64::max)), 4, "");
    let dial = Dial { probe: angle, forward, radial };
    let drawing = picture((SIDE, MIDDLE.1 + RADIUS + 28.0), |canvas| {
        canvas.legend(8.0, 0.0, &[(Key::Line(COMPENSATED), "compensated"), (Key::Line(RAW), "as measured")]);
        let mut taken = rings(canvas, &dial);
        for (vectors, stroke) in [(&one_x.raw, RAW), (&one_x.compensated, COMPENSATED)] {
            let points: Vec<Point> = vectors.iter().map(|vector| dial.at(vector)).collect();
            for piece in pieces(&points) {
                canvas.line(piece, stroke);
            }
        }
        speeds(canvas, &dial, one_x, &mut taken);
    });
    let note = format!("{} Rings in um pp, zero lag at the probe.", one_x.words());
    Picture { title: format!("Polar plot of {name}: 1X over speed"), note, drawing, ..Picture::default() }
}

/// Draws circles of equal amplitude, the four quarters and the probe; returns the texts with the areas that they cover.
fn rings(canvas: &mut Canvas, dial: &Dial) -> Vec<Place> {
    let mut taken = Vec::new();
    canvas.circle(MIDDLE.0, MIDDLE.1, RADIUS, Stroke(MARK, 0.9));
    for quarter in [0.0, 90.0, 180.0, 270.0] {
        canvas.line(&[MIDDLE, dial.around(quarter, 1.0)], Stroke(GRID, 0.75));
        let place = Place::new(dial.around(quarter, 1.12), &format!("{quarter:.0}\u{b0}"));
        place.write(canvas, INK);
        taken.push(place);
    }
    canvas.triangle(dial.around(0.0, 1.0), dial.probe, 11.0, MARK);
    for (value, label) in dial.radial.ticks.iter().filter(|tick| tick.0 > 0.0) {
        let share = dial.radial.place(*value);
        canvas.circle(MIDDLE.0, MIDDLE.1, RADIUS * share, Stroke(GRID, 0.9));
        let place = Place::new(dial.around(135.0, share), label);
        place.write(canvas, MARK);
        taken.push(place);
    }
    taken
}

/// Draws rings with the speed where there is space for the number beside the curve.
fn speeds(canvas: &mut Canvas, dial: &Dial, one_x: &OneX, taken: &mut Vec<Place>) {
    let curves = one_x.compensated.iter().chain(&one_x.raw);
    let curve: Vec<Point> = curves.map(|vector| dial.at(vector)).collect();
    for (rpm, vector) in one_x.speed_rpm.iter().zip(&one_x.compensated).filter(|(_, v)| one_x.has_phase(v)) {
        let (x, y) = dial.at(vector);
        if !(x.is_finite() && y.is_finite() && rpm.is_finite()) {
            continue;
        }
        let label = format!("{rpm:.0}");
        let out = 11.0 + 0.5 * text_width(&label, SMALL);
        let beside = [(out, 0.0), (-out, 0.0), (0.5 * out, 14.0), (-0.5 * out, -14.0), (0.0, 16.0), (0.0, -16.0)];
        let free = |place: &Place| {
            !taken.iter().any(|other| place.touches(other)) && !curve.iter().any(|point| place.holds(*point))
        };
        let places = beside.into_iter().map(|(dx, dy)| Place::new((x + dx, y + dy), &label));
        if let Some(place) = places.into_iter().find(free) {
            canvas.ring(x, y, MEASURED);
            place.write(canvas, INK);
            taken.push(place);
        }
    }
}

/// A text and the area that it covers.
struct Place {
    middle: Point,
    half: f64,
    text: String,
}

impl Place {
    /// Creates a text about `middle`, moved sideways into the picture where necessary.
    fn new(middle: Point, text: &str) -> Self {
        let half = 0.5 * text_width(text, SMALL) + 3.0;
        Self { middle: (middle.0.clamp(half, SIDE - half), middle.1), half, text: text.to_owned() }
    }

    fn touches(&self, other: &Self) -> bool {
        (self.middle.0 - other.middle.0).abs() < self.half + other.half && (self.middle.1 - other.middle.1).abs() < 17.0
    }

    fn holds(&self, (x, y): Point) -> bool {
        (self.middle.0 - x).abs() < self.half && (self.middle.1 - y).abs() < 7.0
    }

    fn write(&self, canvas: &mut Canvas, colour: Colour) {
        canvas.text(&self.text, self.middle, Anchor::Middle, colour);
    }
}
