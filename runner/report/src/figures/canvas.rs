//! A sheet in screen pixels on top of plotters' SVG backend: lines, text, frames with axes, legends.

use super::axis::Axis;
use super::line::{Point, pieces};
use anyhow::{Context, Result};
use plotters::prelude::{Color, DrawingBackend, FontTransform, IntoFont, RGBColor, SVGBackend, ShapeStyle, TextStyle};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::f64::consts::FRAC_PI_2;

/// Scale of the drawing: the backend has whole pixels only, and the page scales it down.
const FINE: f64 = 4.0;
/// plotters divides by this for the font size of the SVG.
const PLOTTERS_FONT: f64 = 1.24;
/// Width of a character over the font's size: an upper estimate for common sans-serif fonts.
const CHARACTER: f64 = 0.58;

/// Size of numbers at the ticks and of the legend.
pub(super) const SMALL: f64 = 11.0;
/// The machine: dark blue, dark in grey print too.
pub(super) const MEASURED: RGBColor = RGBColor(0x0b, 0x3c, 0x6f);
/// The twin: orange, dashed where the picture is made with [`Dashes::Twin`].
pub(super) const TWIN: RGBColor = RGBColor(0xd5, 0x5e, 0x00);
/// Measured less twin.
pub(super) const RESIDUAL: RGBColor = RGBColor(0xa6, 0xa6, 0xa6);
/// Noise of the probes.
pub(super) const BAND: RGBColor = RGBColor(0xb9, 0xd2, 0xea);
/// Lines that the reader looks up: keyphasor, orders.
pub(super) const MARK: RGBColor = RGBColor(0x5a, 0x5a, 0x5a);
/// Text and frames.
pub(super) const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
/// Marked lines inside a frame.
pub(super) const FAINT: RGBColor = RGBColor(0xb4, 0xb4, 0xb4);
/// Grid.
pub(super) const GRID: RGBColor = RGBColor(0xe2, 0xe2, 0xe2);
/// Paper.
pub(super) const PAPER: RGBColor = RGBColor(0xff, 0xff, 0xff);

/// Whether the twin's lines are dashed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Dashes {
    /// All lines of the twin.
    Twin,
    /// None: a jagged line hides its dashes.
    None,
}

/// Colour and width in pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stroke(pub(super) RGBColor, pub(super) f64);

/// Which point of a text is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    /// Left end, half height.
    Start,
    /// Middle, half height.
    Middle,
    /// Right end, half height.
    End,
}

/// A sample in a legend.
#[derive(Debug, Clone, Copy)]
pub(super) enum Key {
    /// A line.
    Line(Stroke),
    /// A filled strip.
    Band(RGBColor),
    /// A filled dot.
    Dot(RGBColor),
    /// A small ring.
    Ring(RGBColor),
    /// A triangle that points down.
    Triangle(RGBColor),
}

/// One picture being drawn.
pub(super) struct Canvas<'a> {
    backend: SVGBackend<'a>,
    width: f64,
}

/// Draws one picture and returns its `svg` element, without a size.
pub(super) fn picture(
    (width, height): (f64, f64),
    dashes: Dashes,
    draw: impl FnOnce(&mut Canvas) -> Result<()>,
) -> Result<String> {
    let mut text = String::new();
    let size = (whole(width) as u32, whole(height) as u32);
    let mut canvas = Canvas { backend: SVGBackend::with_string(&mut text, size), width };
    draw(&mut canvas)?;
    canvas.backend.present()?;
    drop(canvas);
    inline(&text, size, dashes)
}

/// The backend's file as an element of a page: no name space, no size, dashes that the backend cannot draw.
fn inline(text: &str, size: (u32, u32), dashes: Dashes) -> Result<String> {
    let (_, body) = text.split_once('>').context("the SVG has no head")?;
    let twin = format!("stroke=\"#{:02X}{:02X}{:02X}\"", TWIN.0, TWIN.1, TWIN.2);
    let body = body.replace("opacity=\"1\" ", "");
    let body = match dashes {
        Dashes::Twin => body
            .replace(
                &format!("<polyline fill=\"none\" {twin}"),
                &format!("<polyline class=\"dash\" fill=\"none\" {twin}"),
            )
            .replace(&format!("<line {twin}"), &format!("<line class=\"dash\" {twin}")),
        Dashes::None => body,
    };
    Ok(format!("<svg viewBox=\"0 0 {} {}\" aria-hidden=\"true\">{body}", size.0, size.1))
}

/// Pixels of the page to those of the backend.
fn whole(pixels: f64) -> i32 {
    (FINE * pixels).round() as i32
}

/// Width of a text, estimated.
pub(super) fn text_width(text: &str, size: f64) -> f64 {
    CHARACTER * size * text.chars().count() as f64
}

fn style(Stroke(colour, width): Stroke) -> ShapeStyle {
    ShapeStyle { color: colour.to_rgba(), filled: false, stroke_width: whole(width).max(1) as u32 }
}

fn fill(colour: RGBColor) -> ShapeStyle {
    colour.filled()
}

impl Canvas<'_> {
    /// A line through points given in pixels; a single point becomes a dot.
    pub(super) fn line(&mut self, points: &[Point], stroke: Stroke) -> Result<()> {
        match points {
            [] => {}
            [(x, y)] => self.dot(*x, *y, stroke.1.max(2.0), stroke.0)?,
            [from, to] => self.backend.draw_line(pixel(from), pixel(to), &style(stroke))?,
            _ => self.backend.draw_path(points.iter().map(pixel), &style(stroke))?,
        }
        Ok(())
    }

    /// A filled shape.
    pub(super) fn polygon(&mut self, points: &[Point], colour: RGBColor) -> Result<()> {
        Ok(self.backend.fill_polygon(points.iter().map(pixel), &fill(colour))?)
    }

    /// A filled circle.
    pub(super) fn dot(&mut self, x: f64, y: f64, radius: f64, colour: RGBColor) -> Result<()> {
        Ok(self.backend.draw_circle(pixel(&(x, y)), whole(radius).max(1) as u32, &fill(colour), true)?)
    }

    /// A small circle, white inside.
    pub(super) fn ring(&mut self, x: f64, y: f64, colour: RGBColor) -> Result<()> {
        self.dot(x, y, 3.0, colour)?;
        self.dot(x, y, 1.75, PAPER)
    }

    /// The outline of a circle.
    pub(super) fn circle(&mut self, x: f64, y: f64, radius: f64, stroke: Stroke) -> Result<()> {
        Ok(self.backend.draw_circle(pixel(&(x, y)), whole(radius).max(1) as u32, &style(stroke), false)?)
    }

    /// A triangle whose tip is at `tip`; `angle` (rad, up is +90 degrees) is where its body lies.
    pub(super) fn triangle(&mut self, tip: Point, angle: f64, size: f64, colour: RGBColor) -> Result<()> {
        let corner = |turn: f64| {
            let (sine, cosine) = (angle + turn).sin_cos();
            (tip.0 + size * cosine, tip.1 - size * sine)
        };
        self.polygon(&[tip, corner(0.5), corner(-0.5)], colour)
    }

    /// Horizontal text.
    pub(super) fn text(&mut self, text: &str, at: Point, anchor: Anchor, colour: RGBColor) -> Result<()> {
        self.write(text, at, anchor, colour, FontTransform::None)
    }

    /// Text that reads from below, about its middle.
    pub(super) fn upright(&mut self, text: &str, at: Point) -> Result<()> {
        self.write(text, at, Anchor::Middle, INK, FontTransform::Rotate270)
    }

    fn write(&mut self, text: &str, at: Point, anchor: Anchor, colour: RGBColor, turn: FontTransform) -> Result<()> {
        if text.is_empty() {
            return Ok(());
        }
        let across = match anchor {
            Anchor::Start => HPos::Left,
            Anchor::Middle => HPos::Center,
            Anchor::End => HPos::Right,
        };
        let font = ("sans-serif", FINE * PLOTTERS_FONT * SMALL).into_font().transform(turn);
        let style = TextStyle::from(font).color(&colour).pos(Pos::new(across, VPos::Center));
        Ok(self.backend.draw_text(text, &style, pixel(&at))?)
    }

    /// Samples and names in rows from (`left`, `top`), no further than the right edge. Gives the lower end.
    pub(super) fn legend(&mut self, left: f64, top: f64, entries: &[(Key, &str)]) -> Result<f64> {
        let (mut x, mut y) = (left, top + 8.0);
        for (key, name) in entries {
            let wide = 30.0 + text_width(name, SMALL);
            if x > left && x + wide > self.width - 4.0 {
                (x, y) = (left, y + 15.0);
            }
            self.key(*key, x, y)?;
            self.text(name, (x + 27.0, y), Anchor::Start, INK)?;
            x += wide + 12.0;
        }
        Ok(y + 8.0)
    }

    fn key(&mut self, key: Key, x: f64, y: f64) -> Result<()> {
        match key {
            // Three points, for a polyline: a dashed one then looks as it does in the picture.
            Key::Line(stroke) => self.line(&[(x, y), (x + 11.0, y), (x + 22.0, y)], stroke),
            Key::Band(colour) => {
                self.polygon(&[(x, y - 4.0), (x + 22.0, y - 4.0), (x + 22.0, y + 4.0), (x, y + 4.0)], colour)
            }
            Key::Dot(colour) => self.dot(x + 11.0, y, 3.5, colour),
            Key::Ring(colour) => self.ring(x + 11.0, y, colour),
            Key::Triangle(colour) => self.triangle((x + 11.0, y + 4.0), FRAC_PI_2, 8.0, colour),
        }
    }
}

fn pixel((x, y): &Point) -> (i32, i32) {
    (whole(*x), whole(*y))
}

/// A rectangle with two axes.
#[derive(Debug, Clone)]
pub(super) struct Frame {
    /// Start of the room for labels and title of the Y axis, pixels.
    pub(super) start: f64,
    /// Edges in pixels.
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) right: f64,
    pub(super) bottom: f64,
    pub(super) x: Axis,
    pub(super) y: Axis,
}

/// Room that tick labels and title of vertical axes need.
pub(super) fn gutter(axes: &[&Axis]) -> f64 {
    let labels = axes.iter().flat_map(|axis| &axis.ticks).map(|tick| text_width(&tick.1, SMALL));
    28.0 + labels.fold(20.0, f64::max)
}

impl Frame {
    /// A point of the data in pixels.
    pub(super) fn at(&self, point: &Point) -> Point {
        let x = self.left + self.x.place(point.0) * (self.right - self.left);
        let y = self.bottom - self.y.place(point.1) * (self.bottom - self.top);
        (x, y)
    }

    /// Grid, edges, tick labels and titles. `below` is false for a frame that shares the X axis with the next one.
    pub(super) fn axes(&self, canvas: &mut Canvas, below: bool) -> Result<()> {
        self.grid(canvas)?;
        let corners =
            [(self.left, self.top), (self.right, self.top), (self.right, self.bottom), (self.left, self.bottom)];
        canvas.line(&[corners[0], corners[1], corners[2], corners[3], corners[0]], Stroke(MARK, 0.75))?;
        for (value, label) in &self.y.ticks {
            let y = self.at(&(0.0, *value)).1;
            canvas.text(label, (self.left - 5.0, y), Anchor::End, INK)?;
        }
        canvas.upright(&self.y.title, (self.start + 9.0, 0.5 * (self.top + self.bottom)))?;
        if below { self.labels_below(canvas) } else { Ok(()) }
    }

    fn labels_below(&self, canvas: &mut Canvas) -> Result<()> {
        for (value, label) in &self.x.ticks {
            let x = self.at(&(*value, 0.0)).0;
            canvas.text(label, (x, self.bottom + 10.0), Anchor::Middle, INK)?;
        }
        canvas.text(&self.x.title, (0.5 * (self.left + self.right), self.bottom + 26.0), Anchor::Middle, INK)
    }

    fn grid(&self, canvas: &mut Canvas) -> Result<()> {
        for value in self.y.minor.iter().chain(self.y.ticks.iter().map(|tick| &tick.0)) {
            let y = self.at(&(0.0, *value)).1;
            let width = if self.y.minor.contains(value) { 0.25 } else { 0.75 };
            canvas.line(&[(self.left, y), (self.right, y)], Stroke(GRID, width))?;
        }
        for (value, _) in &self.x.ticks {
            let x = self.at(&(*value, 0.0)).0;
            canvas.line(&[(x, self.top), (x, self.bottom)], Stroke(GRID, 0.75))?;
        }
        Ok(())
    }

    /// A line of the data, broken where a value is missing.
    pub(super) fn curve(&self, canvas: &mut Canvas, points: &[Point], stroke: Stroke) -> Result<()> {
        for piece in pieces(points) {
            let pixels: Vec<Point> = piece.iter().map(|point| self.at(point)).collect();
            canvas.line(&pixels, stroke)?;
        }
        Ok(())
    }

    /// Writes "no data" in the middle of a frame without data.
    pub(super) fn note_if_empty(&self, canvas: &mut Canvas, curves: &[&[Point]]) -> Result<()> {
        if curves.iter().any(|curve| pieces(curve).next().is_some()) {
            return Ok(());
        }
        let middle = (0.5 * (self.left + self.right), 0.5 * (self.top + self.bottom));
        canvas.text("no data", middle, Anchor::Middle, MARK)
    }
}
