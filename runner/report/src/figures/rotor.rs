//! Drawing of the rotor from the side: shaft, disks, bearings, probes and unbalances over the stations of the scene, and the directions of
//! the probes seen along the axis.

use super::axis::{Axis, signed};
use super::canvas::{
    Anchor, BODY, BODY_DARK, Canvas, Colour, FAULT, INK, MARK, MEASURED, PAPER, SMALL, Stroke, WIDE, picture,
    text_width,
};
use super::line::Point;
use super::{Context, Figure, Picture};
use crate::number::{alone, fixed, shortened};
use ballrace_twin::replay::outcome::{DrawnDisk, DrawnSection, RotorDrawing};
use std::f64::consts::{FRAC_PI_2, PI};

/// Edges of the shaft at its longest.
const EDGES: [f64; 2] = [36.0, WIDE - 36.0];
/// Height of the shaft with its disks, at most.
const HEIGHT: f64 = 160.0;
/// Mean diameter of the shaft below which diameters are drawn larger than lengths.
const THIN: f64 = 22.0;
/// Diameter of the bar that represents a rigid rotor.
const BAR: f64 = 18.0;
/// Least drawn width of a disk, also used for a disk without a width in the scene.
const NARROW: f64 = 5.0;
/// Side of a bearing.
const BEARING: f64 = 13.0;
/// Size of a probe.
const PROBE: f64 = 10.0;
/// Height of a row of names.
const ROW: f64 = 15.0;
/// Characters of a name, and of several in one row.
const LONGEST: usize = 24;
const LINE: usize = 40;
/// Views along the axis in one row, their height and the radius of the shaft there.
const VIEWS: usize = 4;
const VIEW: f64 = 104.0;
const RADIUS: f64 = 22.0;

const EDGE: Stroke = Stroke(INK, 1.0);
const LEADER: Stroke = Stroke(MARK, 0.6);

/// Drawing of the rotor in the report of a replay.
pub(super) struct Rotor;

impl Figure for Rotor {
    fn heading(&self) -> &'static str {
        "Rotor"
    }

    fn draw(&self, context: &Context<'_>) -> Vec<Picture> {
        context.data.rotor.iter().map(rotor).collect()
    }
}

/// Draws a rotor.
pub(crate) fn rotor(rotor: &RotorDrawing) -> Picture {
    let side = SideView::new(rotor);
    let above = placed(&probe_names(rotor, &side));
    let below = placed(&names_below(rotor, &side));
    let rows = |names: &[Name]| names.iter().map(|name| name.row + 1).max().unwrap_or(0) as f64 * ROW;
    let views = views(rotor);
    let half = 0.5 * side.height() + BEARING + 4.0;
    let middle = rows(&above) + half + 6.0;
    let axis = middle + half + rows(&below) + 10.0;
    let first_view = axis + 44.0;
    let bottom = first_view + VIEW * views.len().div_ceil(VIEWS) as f64;
    let drawing = picture((WIDE, bottom), |canvas| {
        side.shaft(canvas, middle);
        side.disks(canvas, middle);
        canvas.line(&[(side.left - 12.0, middle), (side.right + 12.0, middle)], Stroke(MARK, 0.6));
        for name in &above {
            let y = middle - half - ROW * (name.row as f64 + 0.5);
            canvas.line(&[(name.x, middle - name.from), (name.x, y + 6.0)], LEADER);
        }
        for name in &below {
            let y = middle + half + ROW * (name.row as f64 + 0.5);
            canvas.line(&[(name.x, middle + name.from), (name.x, y - 6.0)], LEADER);
        }
        side.bearings(canvas, middle);
        side.probes(canvas, middle);
        for unbalance in &rotor.unbalances {
            let at = (side.x(unbalance.station_mm), middle + side.rim(unbalance.station_mm));
            canvas.dot(at.0, at.1, 4.2, FAULT);
        }
        centre_of_mass(canvas, (side.x(rotor.centre_of_mass_mm), middle));
        for (names, sign) in [(&above, -1.0), (&below, 1.0)] {
            for name in names {
                let y = middle + sign * (half + ROW * (name.row as f64 + 0.5));
                canvas.text(&name.text, (0.5 * (name.left + name.right), y), Anchor::Middle, INK);
            }
        }
        side.scale(canvas, axis);
        for (i, view) in views.iter().enumerate() {
            let across = (i % VIEWS) as f64 + 0.5;
            let x = across * WIDE / views.len().min(VIEWS) as f64;
            end_view(canvas, (x, first_view + VIEW * (i / VIEWS) as f64), view);
        }
    });
    Picture {
        title: "Rotor with bearings, probes and unbalances".to_owned(),
        note: note(rotor, &side),
        drawing,
        ..Picture::default()
    }
}

fn note(drawing: &RotorDrawing, side: &SideView) -> String {
    let mut note = match side.exaggeration {
        None => "Not to scale: the scene has the mass of a rigid rotor, not its shape. The bar ends at the outermost stations."
            .to_owned(),
        Some(factor) if factor > 1.05 => {
            format!("Sections to scale; diameters drawn {} times as large as lengths.", fixed(factor, 1))
        }
        Some(_) => "Sections to scale.".to_owned(),
    };
    if drawing.disks.iter().any(|disk| disk.width_mm.is_none()) {
        note.push_str(" A disk without a size has the diameter of a solid cylinder with its mass and polar inertia.");
    }
    note.push_str(" Crossed squares: bearings. ");
    if !drawing.probes.is_empty() {
        note.push_str("Triangles: probes, angles from +X towards +Y. ");
    }
    if drawing.probes.iter().any(|probe| probe.angle_deg.is_none()) {
        note.push_str("Axial probes are drawn at the right end. ");
    }
    if !drawing.unbalances.is_empty() {
        note.push_str("Dots: unbalances, angles from the keyphasor mark. ");
    }
    note.push_str("Quartered circle: centre of mass.");
    note
}

/// Scales of the view from the side.
struct SideView<'a> {
    drawing: &'a RotorDrawing,
    axis: Axis,
    left: f64,
    right: f64,
    /// Pixels per mm of a diameter.
    per_mm: f64,
    /// Scale of diameters over that of lengths; `None` for a rigid rotor.
    exaggeration: Option<f64>,
}

impl<'a> SideView<'a> {
    fn new(drawing: &'a RotorDrawing) -> Self {
        let [mut from, mut to] = drawing.ends_mm();
        if to - from < 1e-6 {
            (from, to) = (from - 50.0, to + 50.0);
        }
        let axis = Axis::exact(Some((from, to)), 7, "Station Z, mm");
        if drawing.sections.is_empty() {
            return Self { drawing, axis, left: EDGES[0], right: EDGES[1], per_mm: 1.0, exaggeration: None };
        }
        let length = to - from;
        let size = |s: &DrawnSection| s.outer_mm[0].max(s.outer_mm[1]);
        let largest = drawing.sections.iter().map(size).chain(drawing.disks.iter().map(|d| d.diameter_mm));
        let largest = largest.fold(0.0, f64::max);
        let area = |s: &DrawnSection| (s.ends_mm[1] - s.ends_mm[0]) * size(s);
        let mean = drawing.sections.iter().map(area).sum::<f64>() / length;
        let along = ((EDGES[1] - EDGES[0]) / length).min(HEIGHT / largest);
        let factor = (THIN / (along * mean)).min(HEIGHT / (along * largest)).max(1.0);
        let (middle, half) = (0.5 * WIDE, 0.5 * along * length);
        Self {
            drawing,
            axis,
            left: middle - half,
            right: middle + half,
            per_mm: along * factor,
            exaggeration: Some(factor),
        }
    }

    fn x(&self, station_mm: f64) -> f64 {
        self.left + self.axis.place(station_mm) * (self.right - self.left)
    }

    /// Returns the height of the shaft with its disks, pixels.
    fn height(&self) -> f64 {
        let sections = self.drawing.sections.iter().flat_map(|s| s.outer_mm);
        let all = sections.chain(self.drawing.disks.iter().map(|d| d.diameter_mm)).map(|d| d * self.per_mm);
        if self.exaggeration.is_none() { BAR } else { all.fold(0.0, f64::max) }
    }

    /// Returns the radius of the shaft at a station, pixels; where two sections meet, the larger radius.
    fn surface(&self, station_mm: f64) -> f64 {
        if self.exaggeration.is_none() {
            return 0.5 * BAR;
        }
        let within = self.drawing.sections.iter().filter(|s| {
            let slack = 1e-6 * (s.ends_mm[1] - s.ends_mm[0]);
            s.ends_mm[0] - slack <= station_mm && station_mm <= s.ends_mm[1] + slack
        });
        let radius = within.map(|s| {
            let share = (station_mm - s.ends_mm[0]) / (s.ends_mm[1] - s.ends_mm[0]);
            0.5 * self.per_mm * (s.outer_mm[0] + share * (s.outer_mm[1] - s.outer_mm[0]))
        });
        radius.fold(0.0, f64::max)
    }

    /// Returns the left and the right edge of a disk, pixels.
    fn disk(&self, disk: &DrawnDisk) -> [f64; 2] {
        let (x, per_mm) = (self.x(disk.station_mm), self.per_mm / self.exaggeration.unwrap_or(1.0));
        let half = 0.5 * (disk.width_mm.unwrap_or(0.0) * per_mm).max(NARROW);
        [x - half, x + half]
    }

    /// Returns the radius of the shaft or of a disk at a station, pixels.
    fn rim(&self, station_mm: f64) -> f64 {
        let x = self.x(station_mm);
        let here = self.drawing.disks.iter().filter(|d| {
            let [from, to] = self.disk(d);
            (from - 0.5 * BEARING..to + 0.5 * BEARING).contains(&x)
        });
        here.map(|d| 0.5 * d.diameter_mm * self.per_mm).fold(self.surface(station_mm), f64::max)
    }

    fn shaft(&self, canvas: &mut Canvas, middle: f64) {
        let outline = |canvas: &mut Canvas, [x0, x1]: [f64; 2], [r0, r1]: [f64; 2], fill: Colour| {
            let corners = [(x0, middle - r0), (x1, middle - r1), (x1, middle + r1), (x0, middle + r0)];
            canvas.polygon(&corners, fill);
            canvas.line(&[corners[0], corners[1], corners[2], corners[3], corners[0]], EDGE);
        };
        if self.drawing.sections.is_empty() {
            return outline(canvas, [self.left, self.right], [0.5 * BAR; 2], BODY);
        }
        for section in &self.drawing.sections {
            let ends = section.ends_mm.map(|z| self.x(z));
            outline(canvas, ends, section.outer_mm.map(|d| 0.5 * d * self.per_mm), BODY);
            if section.inner_mm > 0.0 {
                outline(canvas, ends, [0.5 * section.inner_mm * self.per_mm; 2], PAPER);
            }
        }
    }

    /// Draws the disks above and below the shaft.
    fn disks(&self, canvas: &mut Canvas, middle: f64) {
        for disk in &self.drawing.disks {
            let [from, to] = self.disk(disk);
            let (inner, outer) = (self.surface(disk.station_mm), 0.5 * disk.diameter_mm * self.per_mm);
            for sign in [-1.0, 1.0] {
                let (near, far) = (middle + sign * inner, middle + sign * outer.max(inner));
                let corners = [(from, near), (to, near), (to, far), (from, far)];
                canvas.polygon(&corners, BODY_DARK);
                canvas.line(&[corners[0], corners[1], corners[2], corners[3], corners[0]], EDGE);
            }
        }
    }

    /// Draws the bearings as squares with a cross on both sides of the shaft.
    fn bearings(&self, canvas: &mut Canvas, middle: f64) {
        let edge = Stroke(MEASURED, 1.3);
        for (_, station) in &self.drawing.bearings {
            let (x, surface) = (self.x(*station), self.surface(*station));
            let (from, to) = (x - 0.5 * BEARING, x + 0.5 * BEARING);
            for sign in [-1.0, 1.0] {
                let (near, far) = (middle + sign * surface, middle + sign * (surface + BEARING));
                let corners = [(from, near), (to, near), (to, far), (from, far)];
                canvas.polygon(&corners, PAPER);
                canvas.line(&[corners[0], corners[1], corners[2], corners[3], corners[0]], edge);
                canvas.line(&[corners[0], corners[2]], edge);
                canvas.line(&[corners[1], corners[3]], edge);
            }
        }
    }

    fn probes(&self, canvas: &mut Canvas, middle: f64) {
        for probe in &self.drawing.probes {
            match probe.angle_deg {
                Some(angle) => {
                    let side = if is_above(angle) { 1.0 } else { -1.0 };
                    let (x, rim) = (self.x(probe.station_mm), self.rim(probe.station_mm) + 2.0);
                    canvas.triangle((x, middle - side * rim), side * FRAC_PI_2, PROBE, MARK);
                }
                None => canvas.triangle((self.right + 2.0, middle), 0.0, PROBE, MARK),
            }
        }
    }

    /// Draws the axis with its stations.
    fn scale(&self, canvas: &mut Canvas, y: f64) {
        let tip = self.right + 20.0;
        canvas.line(&[(self.left - 8.0, y), (tip, y)], Stroke(INK, 0.9));
        canvas.triangle((tip, y), PI, 7.0, INK);
        for (value, label) in &self.axis.ticks {
            let x = self.x(*value);
            canvas.line(&[(x, y - 3.0), (x, y + 3.0)], Stroke(INK, 0.9));
            canvas.text(label, (x, y + 11.0), Anchor::Middle, INK);
        }
        canvas.text(&self.axis.title, (0.5 * WIDE, y + 27.0), Anchor::Middle, INK);
    }
}

fn is_above(angle_deg: f64) -> bool {
    angle_deg.to_radians().sin() > -1e-9
}

/// Draws the sign of a centre of mass.
fn centre_of_mass(canvas: &mut Canvas, (x, y): Point) {
    const RADIUS: f64 = 5.5;
    canvas.dot(x, y, RADIUS, PAPER);
    for start in [0.0, PI] {
        let arc = (0..=8).map(|i| (start + FRAC_PI_2 * f64::from(i) / 8.0).sin_cos());
        let sector: Vec<Point> = arc.map(|(s, c)| (x + RADIUS * c, y - RADIUS * s)).chain([(x, y)]).collect();
        canvas.polygon(&sector, INK);
    }
    canvas.circle(x, y, RADIUS, Stroke(INK, 1.0));
}

/// A name with its leader to the part that it names.
struct Name {
    /// End of the leader.
    x: f64,
    /// Start of the leader, from the axis of the shaft.
    from: f64,
    text: String,
    left: f64,
    right: f64,
    /// 0 is nearest to the shaft.
    row: usize,
}

impl Name {
    /// Creates a name in a row: in the middle of its leader, or to the left (`side` -1) or to the right (1) of it.
    fn new((x, from, text): &(f64, f64, String), row: usize, side: f64) -> Self {
        let half = 0.5 * text_width(text, SMALL) + 2.0;
        let middle = (x + side * (half - 6.0)).clamp(half, (WIDE - half).max(half));
        Self { x: *x, from: *from, text: text.clone(), left: middle - half, right: middle + half, row }
    }

    fn covers(&self, x: f64) -> bool {
        self.left - 3.0 < x && x < self.right + 3.0
    }

    /// Returns true where the leader of one of them passes behind the other.
    fn is_crossed(&self, other: &Self) -> bool {
        (other.row > self.row && self.covers(other.x)) || (other.row < self.row && other.covers(self.x))
    }

    fn overlaps(&self, other: &Self) -> bool {
        other.row == self.row && self.left < other.right + 6.0 && other.left < self.right + 6.0
    }
}

/// Sets row and side of each name: no two overlap, and as few leaders as possible pass behind a name.
fn placed(names: &[(f64, f64, String)]) -> Vec<Name> {
    let mut all: Vec<Name> = Vec::new();
    for (i, name) in names.iter().enumerate() {
        let is_other = |x: f64| (x - name.0).abs() >= 0.5;
        let cost = |new: &Name, side: f64| {
            let overlaps = all.iter().filter(|other| new.overlaps(other)).count();
            let crossed = all.iter().filter(|other| is_other(other.x) && new.is_crossed(other)).count();
            // The leaders of later names may pass behind this name.
            let later = names.iter().skip(i + 1).filter(|later| is_other(later.0) && new.covers(later.0)).count();
            2000 * overlaps + 6 * crossed + 3 * later + 2 * new.row + usize::from(side != 0.0)
        };
        let candidates =
            (0..=names.len()).flat_map(|row| [0.0, -1.0, 1.0].map(|side| (Name::new(name, row, side), side)));
        let best = candidates.min_by_key(|(new, side)| cost(new, *side));
        all.extend(best.map(|(new, _)| new));
    }
    all
}

/// Positions (pixels) or stations (mm) that are closer than this are the same.
const SAME: f64 = 1e-3;

/// Returns names and directions of the probes; those at one station share rows.
fn probe_names(drawing: &RotorDrawing, side: &SideView) -> Vec<(f64, f64, String)> {
    let mut groups: Vec<(f64, f64, Vec<String>)> = Vec::new();
    for probe in &drawing.probes {
        let name = shortened(&probe.name, LONGEST);
        let (x, from, name) = match probe.angle_deg {
            Some(angle) => {
                let from = if is_above(angle) { side.rim(probe.station_mm) + PROBE } else { 0.0 };
                (side.x(probe.station_mm), from, format!("{name} {}°", signed(&fixed(angle, 0))))
            }
            None => (side.right + 8.0, 4.0, name),
        };
        match groups.iter_mut().find(|group| (group.0 - x).abs() < SAME) {
            Some(group) => {
                group.1 = group.1.max(from);
                group.2.push(name);
            }
            None => groups.push((x, from, vec![name])),
        }
    }
    let rows = |(x, from, names): (f64, f64, Vec<String>)| {
        let mut lines: Vec<String> = Vec::new();
        for name in names {
            match lines.last_mut().filter(|line| line.chars().count() + name.chars().count() + 2 <= LINE) {
                Some(line) => *line = format!("{line}, {name}"),
                None => lines.push(name),
            }
        }
        lines.into_iter().map(move |line| (x, from, line))
    };
    groups.into_iter().flat_map(rows).collect()
}

/// Returns the names of bearings, unbalances and centre of mass.
fn names_below(drawing: &RotorDrawing, side: &SideView) -> Vec<(f64, f64, String)> {
    let bearings = drawing.bearings.iter().map(|(name, z)| {
        let name = shortened(name, LONGEST);
        (side.x(*z), side.surface(*z) + BEARING, format!("{name}, {} mm", signed(&fixed(*z, 1))))
    });
    let unbalances = drawing.unbalances.iter().map(|u| {
        let text = format!("{} g mm, {}°", alone(u.moment_g_mm), signed(&fixed(u.angle_deg, 0)));
        (side.x(u.station_mm), side.rim(u.station_mm) + 4.0, text)
    });
    let centre = drawing.centre_of_mass_mm;
    let centre = (side.x(centre), 5.0, format!("centre of mass, {} mm", signed(&fixed(centre, 1))));
    bearings.chain(unbalances).chain([centre]).collect()
}

/// Probes at one station: the station, mm, and their angles, rad.
type View = (f64, Vec<f64>);

fn views(drawing: &RotorDrawing) -> Vec<View> {
    let mut views: Vec<View> = Vec::new();
    for probe in &drawing.probes {
        let Some(angle) = probe.angle_deg.map(f64::to_radians) else { continue };
        match views.iter_mut().find(|view| (view.0 - probe.station_mm).abs() < SAME) {
            Some(view) => view.1.push(angle),
            None => views.push((probe.station_mm, vec![angle])),
        }
    }
    views
}

/// Draws the shaft along its axis with the probes of one station; `x` is its middle, `top` its upper edge.
fn end_view(canvas: &mut Canvas, (x, top): Point, (station, angles): &View) {
    let y = top + 16.0 + RADIUS + PROBE + 4.0;
    canvas.dot(x, y, RADIUS, BODY);
    canvas.circle(x, y, RADIUS, EDGE);
    let reach = RADIUS + PROBE + 4.0;
    canvas.line(&[(x, y), (x + reach, y)], LEADER);
    canvas.line(&[(x, y), (x, y - reach)], LEADER);
    for angle in angles {
        let (sin, cos) = angle.sin_cos();
        let rim = RADIUS + 1.5;
        canvas.triangle((x + rim * cos, y - rim * sin), *angle, PROBE, MARK);
    }
    canvas.text("X", (x + reach + 7.0, y), Anchor::Middle, INK);
    canvas.text("Y", (x, y - reach - 7.0), Anchor::Middle, INK);
    let below = y + RADIUS + PROBE + 10.0;
    canvas.text(&format!("at {} mm", signed(&fixed(*station, 1))), (x, below), Anchor::Middle, INK);
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use ballrace_twin::replay::outcome::DrawnProbe;

    #[test]
    fn names_do_not_overlap() {
        let names: Vec<(f64, f64, String)> =
            (0..12).map(|i| (45.0 * f64::from(i), 10.0, format!("name of part number {i}"))).collect();
        let all = placed(&names);
        assert_eq!(all.len(), names.len());
        for (i, a) in all.iter().enumerate() {
            assert!(a.left >= 0.0 && a.right <= WIDE);
            for b in all[i + 1..].iter().filter(|b| b.row == a.row) {
                assert!(a.right < b.left || b.right < a.left, "{} {}", a.text, b.text);
            }
        }
    }

    #[test]
    fn sections_are_to_scale() {
        let section =
            |from: f64, to: f64, d: f64| DrawnSection { ends_mm: [from, to], outer_mm: [d; 2], inner_mm: 0.0 };
        let thin = RotorDrawing {
            sections: vec![section(0.0, 1000.0, 20.0), section(1000.0, 2000.0, 20.0)],
            ..RotorDrawing::default()
        };
        let side = SideView::new(&thin);
        assert!(side.exaggeration.unwrap() > 1.5 && (side.height() - THIN).abs() < 1e-9);
        assert!((side.x(1000.0) - 0.5 * WIDE).abs() < 1e-9);
        let short = RotorDrawing { sections: vec![section(0.0, 100.0, 200.0)], ..RotorDrawing::default() };
        let side = SideView::new(&short);
        assert!((side.exaggeration.unwrap() - 1.0).abs() < 1e-12 && (side.height() - HEIGHT).abs() < 1e-9);
        assert!((side.right - side.left - 0.5 * HEIGHT).abs() < 1e-9, "as long as high for half the diameter");
    }

    #[test]
    fn a_rigid_rotor_is_marked_as_not_to_scale() {
        let rigid = RotorDrawing {
            bearings: vec![("DE".to_owned(), -100.0), ("NDE".to_owned(), 100.0)],
            probes: vec![DrawnProbe { name: "DE_X".to_owned(), station_mm: -120.0, angle_deg: Some(0.0) }],
            ..RotorDrawing::default()
        };
        let drawn = rotor(&rigid);
        assert!(drawn.note.starts_with("Not to scale") && drawn.drawing.svg.contains("DE_X 0°"));
        let point = RotorDrawing { bearings: vec![("DE".to_owned(), 0.0)], ..RotorDrawing::default() };
        assert!(!rotor(&point).drawing.svg.contains("NaN"));
    }
}
