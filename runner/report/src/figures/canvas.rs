//! A drawing in pixels of the page, written as SVG: lines, text, frames with axes, legends.
//!
//! The content of a frame is drawn in a group that states how it follows the axes ([`Frame::inside`], [`Frame::along`]), and the
//! values of each curve are stored with the drawing ([`Plot`]), so that the script of a report can zoom and read them.

use super::axis::Axis;
use super::line::{Point, Thinning, pieces};
use std::f64::consts::FRAC_PI_2;
use std::fmt::{self, Write};

/// Width of a character over the font's size: an upper estimate for common sans-serif fonts.
const CHARACTER: f64 = 0.58;

/// Width of a figure across the page.
pub(super) const WIDE: f64 = 500.0;
/// Right edge of a frame in such a figure.
pub(super) const WIDE_RIGHT: f64 = WIDE - 14.0;
/// Height of a frame below which the title of the Y axis is above the frame, pixels.
const SHORT: f64 = 75.0;
/// Height of tick labels and title below a frame.
pub(super) const BELOW: f64 = 36.0;
/// Size of numbers at the ticks and of the legend.
pub(super) const SMALL: f64 = 11.0;

/// A colour by its role. The style of the page sets it for light and dark; lines of the twin and of the residual are dashed, so that
/// they also differ in grey print.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Colour {
    /// Name of the custom property.
    name: &'static str,
    /// Colour where the page does not set the property.
    hex: &'static str,
    /// Dashes of a line, empty for a solid one.
    dashes: &'static str,
}

const fn solid(name: &'static str, hex: &'static str) -> Colour {
    Colour { name, hex, dashes: "" }
}

/// Measured on the machine: solid.
pub(super) const MEASURED: Colour = solid("measured", "#0b3c6f");
/// The twin: dashed.
pub(super) const TWIN: Colour = Colour { name: "twin", hex: "#d55e00", dashes: "6 3" };
/// Measured less twin, and as measured beside compensated: dotted.
pub(super) const RESIDUAL: Colour = Colour { name: "residual", hex: "#6b6b6b", dashes: "1.6 1.8" };
/// Limits and damage: solid, in the colour of a fault.
pub(super) const FAULT: Colour = solid("fault", "#c4122f");
/// Noise of the probes, time beyond a limit.
pub(super) const BAND: Colour = solid("band", "#b9d2ea");
/// Reference lines: keyphasor, orders.
pub(super) const MARK: Colour = solid("mark", "#5a5a5a");
/// Text and edges.
pub(super) const INK: Colour = solid("ink", "#222222");
/// Marked lines inside a frame.
pub(super) const FAINT: Colour = solid("faint", "#b4b4b4");
/// Grid.
pub(super) const GRID: Colour = solid("grid", "#e2e2e2");
/// Bodies: the shaft.
pub(super) const BODY: Colour = solid("body", "#dfdfdf");
/// Bodies beside it: disks.
pub(super) const BODY_DARK: Colour = solid("body-dark", "#bdbdbd");
/// Extent of a damage.
pub(super) const SHADE: Colour = solid("shade", "#f6dfcc");
/// Paper.
pub(super) const PAPER: Colour = solid("paper", "#ffffff");
/// Colours of successive curves.
pub(super) const SERIES: [Colour; 6] = [
    MEASURED,
    Colour { name: "twin", hex: "#d55e00", dashes: "7 3" },
    Colour { name: "third", hex: "#007a5e", dashes: "2 2" },
    Colour { name: "fourth", hex: "#7a3e9d", dashes: "9 2 2 2" },
    Colour { name: "fifth", hex: "#8a6d00", dashes: "4 2" },
    Colour { name: "sixth", hex: "#b02a4c", dashes: "1 3" },
];

impl fmt::Display for Colour {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "var(--{},{})", self.name, self.hex)
    }
}

/// Colour and width in pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stroke(pub(super) Colour, pub(super) f64);

/// A curve of the machine in a frame.
pub(super) const MEASURED_LINE: Stroke = Stroke(MEASURED, 1.3);
/// A curve of the twin over that of the machine.
pub(super) const TWIN_LINE: Stroke = Stroke(TWIN, 1.5);
/// The residual.
pub(super) const RESIDUAL_LINE: Stroke = Stroke(RESIDUAL, 1.1);

impl fmt::Display for Stroke {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"", self.0, self.1)?;
        if self.0.dashes.is_empty() { Ok(()) } else { write!(f, " stroke-dasharray=\"{}\"", self.0.dashes) }
    }
}

/// Reference point of a text.
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
    Band(Colour),
    /// A filled dot.
    Dot(Colour),
    /// A small ring.
    Ring(Colour),
    /// A triangle that points down.
    Triangle(Colour),
}

/// Symbol of a separate point.
#[derive(Debug, Clone, Copy)]
pub(super) enum Marker {
    /// A dot of a radius.
    Dot(f64, Colour),
    /// A ring.
    Ring(Colour),
}

/// A frame with its curves as the script of a report reads them.
#[derive(Debug, Clone)]
pub(crate) struct Plot {
    pub(crate) frame: Frame,
    /// Tick labels and title of the X axis are below this frame.
    pub(crate) has_labels_below: bool,
    pub(crate) curves: Vec<Curve>,
}

/// Values of a curve.
#[derive(Debug, Clone)]
pub(crate) struct Curve {
    pub(crate) name: String,
    pub(crate) points: Vec<Point>,
    pub(crate) kind: CurveKind,
}

/// Relation of the values of a curve to its frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum CurveKind {
    /// Y over X.
    Function,
    /// A curve in the plane.
    Path,
    /// Separate points.
    Scatter,
    /// A spectrum drawn at this value of Y.
    Ridge(f64),
}

/// A picture while it is drawn.
pub(super) struct Canvas {
    body: String,
    width: f64,
    plots: Vec<Plot>,
}

/// A finished picture.
#[derive(Debug, Clone, Default)]
pub(crate) struct Drawing {
    /// An `svg` element, without a size.
    pub(crate) svg: String,
    /// Frames that the script can zoom and read.
    pub(crate) plots: Vec<Plot>,
}

impl Drawing {
    /// Returns the drawing as a file of its own, with the colours that a page would set.
    pub(crate) fn file(&self) -> String {
        let mut parts = self.svg.split("var(--");
        let mut out =
            parts.next().unwrap_or_default().replacen("<svg ", "<svg xmlns=\"http://www.w3.org/2000/svg\" ", 1);
        for part in parts {
            let (property, rest) = part.split_once(')').unwrap_or((part, ""));
            out.push_str(property.split_once(',').map_or("currentColor", |(_, colour)| colour));
            out.push_str(rest);
        }
        out + "\n"
    }
}

/// Draws one picture of a size in pixels.
pub(super) fn picture((width, height): (f64, f64), draw: impl FnOnce(&mut Canvas)) -> Drawing {
    let mut canvas = Canvas { body: String::new(), width, plots: Vec::new() };
    draw(&mut canvas);
    let svg = format!(
        "<svg viewBox=\"0 0 {} {}\" font-family=\"sans-serif\" font-size=\"{SMALL}\" aria-hidden=\"true\">\n{}</svg>",
        Pixels(width),
        Pixels(height),
        canvas.body
    );
    Drawing { svg, plots: canvas.plots }
}

/// Returns the estimated width of a text, pixels.
pub(super) fn text_width(text: &str, size: f64) -> f64 {
    CHARACTER * size * text.chars().count() as f64
}

/// A coordinate that is written with at most one decimal. A value that is not finite is placed far outside the picture.
struct Pixels(f64);

impl fmt::Display for Pixels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // An integer has neither -0 nor NaN.
        let tenths = if self.0.is_finite() { (self.0.clamp(-9999.0, 9999.0) * 10.0).round() as i32 } else { -99_990 };
        if tenths % 10 == 0 { write!(f, "{}", tenths / 10) } else { write!(f, "{}", f64::from(tenths) / 10.0) }
    }
}

/// Points as an attribute.
struct Points<'a>(&'a [Point]);

impl fmt::Display for Points<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, (x, y)) in self.0.iter().enumerate() {
            let space = if i > 0 { " " } else { "" };
            write!(f, "{space}{},{}", Pixels(*x), Pixels(*y))?;
        }
        Ok(())
    }
}

/// Text of an element.
struct Escaped<'a>(&'a str);

impl fmt::Display for Escaped<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.chars().try_for_each(|c| match c {
            '&' => f.write_str("&amp;"),
            '<' => f.write_str("&lt;"),
            '>' => f.write_str("&gt;"),
            '"' => f.write_str("&quot;"),
            c => f.write_char(c),
        })
    }
}

impl Canvas {
    fn element(&mut self, element: fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = self.body.write_fmt(element);
        self.body.push('\n');
    }

    /// Draws a group with these attributes.
    fn group(&mut self, attributes: fmt::Arguments<'_>, draw: impl FnOnce(&mut Self)) {
        self.element(format_args!("<g {attributes}>"));
        draw(self);
        self.element(format_args!("</g>"));
    }

    /// Draws a line through points in pixels; a single point becomes a dot.
    pub(super) fn line(&mut self, points: &[Point], stroke: Stroke) {
        match points {
            [] => {}
            [(x, y)] => self.dot(*x, *y, stroke.1.max(2.0), stroke.0),
            [(x1, y1), (x2, y2)] => {
                let [x1, y1, x2, y2] = [*x1, *y1, *x2, *y2].map(Pixels);
                self.element(format_args!("<line x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\" {stroke}/>"));
            }
            _ => self.element(format_args!("<polyline points=\"{}\" {stroke}/>", Points(points))),
        }
    }

    /// Draws a filled polygon.
    pub(super) fn polygon(&mut self, points: &[Point], colour: Colour) {
        self.element(format_args!("<polygon points=\"{}\" fill=\"{colour}\"/>", Points(points)));
    }

    /// Draws a filled circle.
    pub(super) fn dot(&mut self, x: f64, y: f64, radius: f64, colour: Colour) {
        let [x, y, radius] = [x, y, radius.max(0.1)].map(Pixels);
        self.element(format_args!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" fill=\"{colour}\"/>"));
    }

    /// Draws a small circle filled with the colour of the paper.
    pub(super) fn ring(&mut self, x: f64, y: f64, colour: Colour) {
        let [x, y] = [x, y].map(Pixels);
        let Stroke(colour, width) = Stroke(colour, 1.4);
        self.element(format_args!(
            "<circle cx=\"{x}\" cy=\"{y}\" r=\"2.4\" fill=\"{PAPER}\" stroke=\"{colour}\" stroke-width=\"{width}\"/>"
        ));
    }

    /// Draws the outline of a circle.
    pub(super) fn circle(&mut self, x: f64, y: f64, radius: f64, stroke: Stroke) {
        let [x, y, radius] = [x, y, radius.max(0.1)].map(Pixels);
        self.element(format_args!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" {stroke}/>"));
    }

    /// Draws a triangle with its tip at `tip`; `angle` is the direction from the tip to the body, rad (up is +90 degrees).
    pub(super) fn triangle(&mut self, tip: Point, angle: f64, size: f64, colour: Colour) {
        let corner = |turn: f64| {
            let (sine, cosine) = (angle + turn).sin_cos();
            (tip.0 + size * cosine, tip.1 - size * sine)
        };
        self.polygon(&[tip, corner(0.5), corner(-0.5)], colour);
    }

    /// Draws horizontal text.
    pub(super) fn text(&mut self, text: &str, at: Point, anchor: Anchor, colour: Colour) {
        self.write(text, at, anchor, colour, false);
    }

    /// Draws vertical text that runs upwards, with its middle at `at`.
    pub(super) fn upright(&mut self, text: &str, at: Point) {
        self.write(text, at, Anchor::Middle, INK, true);
    }

    fn write(&mut self, text: &str, (x, y): Point, anchor: Anchor, colour: Colour, is_upright: bool) {
        if text.is_empty() {
            return;
        }
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let [x, y] = [x, y].map(Pixels);
        let turn = if is_upright { format!(" transform=\"rotate(-90 {x} {y})\"") } else { String::new() };
        self.element(format_args!(
            "<text x=\"{x}\" y=\"{y}\" dy=\".35em\" fill=\"{colour}\"{anchor}{turn}>{}</text>",
            Escaped(text)
        ));
    }

    /// Draws a legend in rows from (`left`, `top`) to the right edge of the picture; returns its lower end.
    pub(super) fn legend(&mut self, left: f64, top: f64, entries: &[(Key, &str)]) -> f64 {
        let mut bottom = top;
        for (entry, (x, y)) in entries.iter().zip(legend_places(left, top, self.width, entries)) {
            self.key(entry.0, x, y);
            self.text(entry.1, (x + 27.0, y), Anchor::Start, INK);
            bottom = y + 8.0;
        }
        bottom
    }

    fn key(&mut self, key: Key, x: f64, y: f64) {
        match key {
            Key::Line(stroke) => self.line(&[(x, y), (x + 22.0, y)], stroke),
            Key::Band(colour) => {
                self.polygon(&[(x, y - 4.0), (x + 22.0, y - 4.0), (x + 22.0, y + 4.0), (x, y + 4.0)], colour);
            }
            Key::Dot(colour) => self.dot(x + 11.0, y, 3.5, colour),
            Key::Ring(colour) => self.ring(x + 11.0, y, colour),
            Key::Triangle(colour) => self.triangle((x + 11.0, y + 4.0), FRAC_PI_2, 8.0, colour),
        }
    }

    /// Returns the number of the plot of a frame.
    fn plot(&mut self, frame: &Frame, has_labels_below: bool) -> usize {
        let is_it = |plot: &Plot| plot.frame.left == frame.left && plot.frame.top == frame.top;
        self.plots.iter().position(is_it).unwrap_or_else(|| {
            self.plots.push(Plot { frame: frame.clone(), has_labels_below, curves: Vec::new() });
            self.plots.len() - 1
        })
    }
}

/// Returns the positions of the samples of a legend.
fn legend_places(left: f64, top: f64, width: f64, entries: &[(Key, &str)]) -> Vec<Point> {
    let (mut x, mut y) = (left, top + 8.0);
    let place = |(_, name): &(Key, &str)| {
        let wide = 30.0 + text_width(name, SMALL);
        if x > left && x + wide > width - 4.0 {
            (x, y) = (left, y + 15.0);
        }
        let at = (x, y);
        x += wide + 8.0;
        at
    };
    entries.iter().map(place).collect()
}

/// Returns the height of a legend from `left` in a picture across the page.
pub(super) fn legend_height(left: f64, entries: &[(Key, &str)]) -> f64 {
    legend_places(left, 0.0, WIDE, entries).last().map_or(0.0, |place| place.1 + 8.0)
}

/// A rectangle with two axes.
#[derive(Debug, Clone)]
pub(crate) struct Frame {
    /// Left end of the space for labels and title of the Y axis, pixels.
    pub(crate) start: f64,
    /// Edges in pixels.
    pub(crate) left: f64,
    pub(crate) top: f64,
    pub(crate) right: f64,
    pub(crate) bottom: f64,
    pub(crate) x: Axis,
    pub(crate) y: Axis,
}

/// Least distance of the labels of two ticks, pixels.
const TICK_GAP: f64 = 6.0;

/// Returns the width of tick labels and title of vertical axes, pixels.
pub(super) fn gutter(axes: &[&Axis]) -> f64 {
    let labels = axes.iter().flat_map(|axis| &axis.ticks).map(|tick| text_width(&tick.1, SMALL));
    28.0 + labels.fold(20.0, f64::max)
}

/// Stacks frames of a height across the page that share the X axis, from `top`, with a space between them.
pub(super) fn stacked(x: &Axis, axes: Vec<Axis>, (top, height, space): (f64, f64, f64)) -> Vec<Frame> {
    let left = gutter(&axes.iter().collect::<Vec<_>>());
    let frame = |(i, y): (usize, Axis)| {
        let top = top + i as f64 * (height + space);
        Frame { start: 0.0, left, top, right: WIDE_RIGHT, bottom: top + height, x: x.clone(), y }
    };
    axes.into_iter().enumerate().map(frame).collect()
}

/// Returns a square of the side `side` about the middle of both ranges, with one scale in both directions; `share` of it is filled.
pub(super) fn equal_scales(
    (x, y): ((f64, f64), (f64, f64)),
    (top, side, share): (f64, f64, f64),
    [across, up]: [&str; 2],
) -> Frame {
    let half = 0.5 * (x.1 - x.0).max(y.1 - y.0) / share;
    let about = |range: (f64, f64)| {
        let middle = 0.5 * (range.0 + range.1);
        Some((middle - half, middle + half))
    };
    let both = |most: usize| (Axis::exact(about(x), most, across), Axis::exact(about(y), most, up));
    let fits = |(x, _): &(Axis, Axis)| {
        let widest = x.ticks.iter().map(|tick| text_width(&tick.1, SMALL)).fold(0.0, f64::max);
        x.ticks.windows(2).all(|pair| widest + TICK_GAP < (pair[1].0 - pair[0].0) / (2.0 * half) * side)
    };
    let (x, y) = (4..=7).rev().map(both).find(fits).unwrap_or_else(|| both(3));
    let left = gutter(&[&y]);
    Frame { start: 0.0, left, top, right: left + side, bottom: top + side, x, y }
}

impl Frame {
    /// Returns a point of the data in pixels.
    pub(super) fn at(&self, point: &Point) -> Point {
        let x = self.left + self.x.place(point.0) * (self.right - self.left);
        let y = self.bottom - self.y.place(point.1) * (self.bottom - self.top);
        (x, y)
    }

    /// Draws grid, edges, tick labels and titles. `below` is false for a frame that shares the X axis with the next one.
    pub(super) fn axes(&self, canvas: &mut Canvas, below: bool) {
        let plot = canvas.plot(self, below);
        canvas.group(format_args!("data-axes=\"{plot}\""), |canvas| {
            self.grid(canvas);
            for (value, label) in &self.y.ticks {
                let y = self.at(&(0.0, *value)).1;
                canvas.text(label, (self.left - 5.0, y), Anchor::End, INK);
            }
            if below {
                for (value, label) in &self.x.ticks {
                    let x = self.at(&(*value, 0.0)).0;
                    canvas.text(label, (x, self.bottom + 10.0), Anchor::Middle, INK);
                }
            }
        });
        let corners =
            [(self.left, self.top), (self.right, self.top), (self.right, self.bottom), (self.left, self.bottom)];
        canvas.line(&[corners[0], corners[1], corners[2], corners[3], corners[0]], Stroke(MARK, 0.75));
        // A short axis has its title above it.
        if self.bottom - self.top < SHORT {
            canvas.text(&self.y.title, (self.left, self.top - 7.0), Anchor::Start, INK);
        } else {
            canvas.upright(&self.y.title, (self.start + 9.0, 0.5 * (self.top + self.bottom)));
        }
        if below {
            canvas.text(&self.x.title, (0.5 * (self.left + self.right), self.bottom + 26.0), Anchor::Middle, INK);
        }
    }

    fn grid(&self, canvas: &mut Canvas) {
        for (values, width) in
            [(&self.y.minor, 0.25), (&self.y.ticks.iter().map(|tick| tick.0).collect::<Vec<f64>>(), 0.75)]
        {
            for value in values {
                let y = self.at(&(0.0, *value)).1;
                canvas.line(&[(self.left, y), (self.right, y)], Stroke(GRID, width));
            }
        }
        for (values, width) in
            [(&self.x.minor, 0.25), (&self.x.ticks.iter().map(|tick| tick.0).collect::<Vec<f64>>(), 0.75)]
        {
            for value in values {
                let x = self.at(&(*value, 0.0)).0;
                canvas.line(&[(x, self.top), (x, self.bottom)], Stroke(GRID, width));
            }
        }
    }

    /// Draws elements that follow both axes when the script zooms.
    pub(super) fn inside(&self, canvas: &mut Canvas, draw: impl FnOnce(&mut Canvas)) {
        let plot = canvas.plot(self, true);
        canvas.group(format_args!("data-inside=\"{plot}\""), draw);
    }

    /// Draws elements that follow only the X axis when the script zooms, such as the name of a line above the frame.
    pub(super) fn along(&self, canvas: &mut Canvas, draw: impl FnOnce(&mut Canvas)) {
        let plot = canvas.plot(self, true);
        canvas.group(format_args!("data-along=\"{plot}\""), draw);
    }

    /// Draws lines from the lower to the upper edge.
    pub(super) fn uprights(&self, canvas: &mut Canvas, values: impl IntoIterator<Item = f64>, stroke: Stroke) {
        self.along(canvas, |canvas| {
            for value in values.into_iter().filter(|value| self.x.holds(*value)) {
                let x = self.at(&(value, 0.0)).0;
                canvas.line(&[(x, self.bottom), (x, self.top)], stroke);
            }
        });
    }

    /// Draws lines across the frame.
    pub(super) fn levels(&self, canvas: &mut Canvas, values: impl IntoIterator<Item = f64>, stroke: Stroke) {
        self.inside(canvas, |canvas| {
            for value in values.into_iter().filter(|value| value.is_finite()) {
                let y = self.at(&(0.0, value)).1;
                canvas.line(&[(self.left, y), (self.right, y)], stroke);
            }
        });
    }

    /// Shades ranges of X over the height of the frame.
    pub(super) fn shade(&self, canvas: &mut Canvas, ranges: impl IntoIterator<Item = [f64; 2]>, colour: Colour) {
        self.along(canvas, |canvas| {
            for range in ranges {
                let [from, to] = range.map(|x| self.at(&(x, 0.0)).0);
                let to = to.max(from + 1.0);
                canvas.polygon(&[(from, self.top), (to, self.top), (to, self.bottom), (from, self.bottom)], colour);
            }
        });
    }

    /// Draws a curve that is interrupted at missing values. The script does not read it.
    pub(super) fn curve(&self, canvas: &mut Canvas, points: &[Point], stroke: Stroke) {
        self.inside(canvas, |canvas| self.pieces(canvas, points, stroke));
    }

    fn pieces(&self, canvas: &mut Canvas, points: &[Point], stroke: Stroke) {
        for piece in pieces(points) {
            let pixels: Vec<Point> = piece.iter().map(|point| self.at(point)).collect();
            canvas.line(&pixels, stroke);
        }
    }

    /// Draws a named curve with few points, and stores it with more points for the script. Points outside the range of X are not drawn.
    pub(super) fn series(
        &self,
        canvas: &mut Canvas,
        (name, points): (&str, &[Point]),
        thinning: Thinning,
        stroke: Stroke,
    ) {
        let is_shown = |point: &Point| !(point.0 < self.x.low() || point.0 > self.x.high());
        let shown: Vec<Point> = points.iter().copied().filter(is_shown).collect();
        let drawn = self.standing_out(thinning.drawn(&shown));
        let kind = if matches!(thinning, Thinning::Path(_)) { CurveKind::Path } else { CurveKind::Function };
        let number = self.keep(canvas, Curve { name: name.to_owned(), points: thinning.kept(points), kind });
        canvas.group(format_args!("data-curve=\"{number}\" {stroke}"), |canvas| {
            for piece in pieces(&drawn) {
                let pixels: Vec<Point> = piece.iter().map(|point| self.at(point)).collect();
                match pixels.as_slice() {
                    [(x, y)] => canvas.dot(*x, *y, stroke.1.max(2.0), stroke.0),
                    pixels => canvas.element(format_args!("<polyline points=\"{}\"/>", Points(pixels))),
                }
            }
        });
    }

    /// Stores the values of a curve for the script; returns the numbers of plot and curve.
    fn keep(&self, canvas: &mut Canvas, curve: Curve) -> String {
        let plot = canvas.plot(self, true);
        let curves = &mut canvas.plots[plot].curves;
        curves.push(curve);
        format!("{plot}.{}", curves.len() - 1)
    }

    /// Draws separate points.
    pub(super) fn scatter(&self, canvas: &mut Canvas, (name, points): (&str, &[Point]), marker: Marker) {
        let finite = || points.iter().filter(|point| point.0.is_finite() && point.1.is_finite());
        let points: Vec<Point> = finite().copied().collect();
        self.inside(canvas, |canvas| {
            for (x, y) in finite().map(|point| self.at(point)) {
                match marker {
                    Marker::Dot(radius, colour) => canvas.dot(x, y, radius, colour),
                    Marker::Ring(colour) => canvas.ring(x, y, colour),
                }
            }
        });
        self.keep(canvas, Curve { name: name.to_owned(), points, kind: CurveKind::Scatter });
    }

    /// Draws a spectrum at a value of Y; it hides those behind it. Heights are proportional to the square root of the amplitude; the
    /// amplitude `highest` is `peak` pixels high.
    pub(super) fn ridge(
        &self,
        canvas: &mut Canvas,
        along: f64,
        (name, points): (&str, &[Point]),
        (highest, peak): (f64, f64),
    ) {
        let base = self.at(&(0.0, along)).1;
        let height = |amplitude: f64| peak * (amplitude / highest.max(f64::MIN_POSITIVE)).max(0.0).sqrt();
        let line: Vec<Point> = points.iter().map(|(x, a)| (self.at(&(*x, 0.0)).0, base - height(*a))).collect();
        let (Some(first), Some(last)) = (line.first(), line.last()) else { return };
        let body: Vec<Point> = line.iter().copied().chain([(last.0, base), (first.0, base)]).collect();
        self.inside(canvas, |canvas| {
            canvas.polygon(&body, PAPER);
            canvas.line(&[(self.left, base), (self.right, base)], Stroke(MARK, 0.25));
            canvas.line(&line, Stroke(MEASURED, 0.9));
        });
        let kind = CurveKind::Ridge(along);
        self.keep(canvas, Curve { name: name.to_owned(), points: points.to_vec(), kind });
    }

    /// Removes the parts below a logarithmic frame: they would be drawn along its lower edge.
    fn standing_out(&self, points: Vec<Point>) -> Vec<Point> {
        if !self.y.is_logarithmic() {
            return points;
        }
        let above: Vec<bool> = points.iter().map(|point| point.1 > self.y.low()).collect();
        let near = |i: usize| above[i] || (i > 0 && above[i - 1]) || above.get(i + 1) == Some(&true);
        points.into_iter().enumerate().map(|(i, point)| if near(i) { point } else { (point.0, f64::NAN) }).collect()
    }

    /// Writes "no data" in the middle of a frame without data.
    pub(super) fn note_if_empty(&self, canvas: &mut Canvas, curves: &[&[Point]]) {
        if curves.iter().any(|curve| pieces(curve).next().is_some()) {
            return;
        }
        let middle = (0.5 * (self.left + self.right), 0.5 * (self.top + self.bottom));
        canvas.text("no data", middle, Anchor::Middle, MARK);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_short_and_finite() {
        let shown = |x: f64| Pixels(x).to_string();
        assert_eq!([1.0, 1.04, -0.04, 12.34, -3.25].map(shown), ["1", "1", "0", "12.3", "-3.3"]);
        assert_eq!([f64::NAN, f64::INFINITY, 1e9].map(shown), ["-9999", "-9999", "9999"]);
    }

    #[test]
    fn text_is_escaped() {
        let drawn = picture((10.0, 10.0), |canvas| canvas.text("<b>&\"", (1.0, 2.0), Anchor::Start, INK));
        assert!(drawn.svg.contains(">&lt;b&gt;&amp;&quot;</text>"), "{}", drawn.svg);
    }

    #[test]
    fn a_file_has_colours_and_no_custom_properties() {
        let file = picture((10.0, 10.0), |canvas| canvas.dot(1.0, 2.0, 3.0, MEASURED)).file();
        assert!(
            file.starts_with("<svg xmlns=") && file.contains("fill=\"#0b3c6f\"") && !file.contains("var("),
            "{file}"
        );
    }

    #[test]
    fn a_curve_is_kept_whole_and_drawn_inside_its_frame() {
        let points: Vec<Point> = (0..100).map(|i| (f64::from(i), 1.0 + f64::from(i % 7))).collect();
        let x = Axis::exact(Some((0.0, 49.0)), 5, "Time, s");
        let y = Axis::from_zero(Some(8.0), 5, "Position, um");
        let frame = Frame { start: 0.0, left: 40.0, top: 10.0, right: 140.0, bottom: 60.0, x, y };
        let drawn = picture((150.0, 100.0), |canvas| {
            frame.axes(canvas, true);
            frame.series(canvas, ("measured", &points), Thinning::Extremes([1000, 1000]), MEASURED_LINE);
        });
        assert_eq!(drawn.plots[0].curves[0].points.len(), 100);
        let polyline = drawn.svg.split("<polyline points=\"").last().and_then(|rest| rest.split('"').next());
        assert_eq!(polyline.map(|points| points.split(' ').count()), Some(50));
    }
}
