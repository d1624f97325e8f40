//! Spectra one behind the other: a waterfall over time, or a cascade over speed where that changes.

use super::axis::{Axis, extent};
use super::canvas::{Anchor, BELOW, Canvas, FAINT, Frame, INK, Stroke, WIDE, gutter, picture};
use super::line::{Point, Thinning};
use super::mark::{self, Mark};
use super::{Context, Figure, Picture};
use ballrace_twin::replay::outcome::{Cascade, MarkedLine, Slice};

const HEIGHT: f64 = 300.0;
/// Height of the highest peak.
const PEAK: f64 = 52.0;
/// Largest number of points of one spectrum.
const POINTS: usize = 170;
/// The view ends at this many times the highest marked line.
const BEYOND_LINES: f64 = 1.3;
/// Bins closer to 0 Hz than this number of bins contain the mean, spread by the window.
const MEAN_BINS: usize = 2;

/// Waterfalls over time or cascades over speed, one per plane or probe.
pub(super) struct Cascades;

impl Figure for Cascades {
    fn heading(&self) -> &'static str {
        "Cascade and waterfall spectra"
    }

    fn draw(&self, context: &Context<'_>) -> Vec<Picture> {
        let data = context.data;
        let several = data.cascades.iter().filter(|one| one.slices.len() > 1);
        several.map(|one| cascade(one, &data.lines, context.over_speed)).collect()
    }
}

/// Draws the spectra of one plane or probe, over the speed if `over_speed` is true, else over time.
pub(super) fn cascade(cascade: &Cascade, lines: &[MarkedLine], over_speed: bool) -> Picture {
    let view = View::new(cascade, lines, over_speed);
    let mut marks = mark::marks(&view.lines, &[], view.highest);
    let frame = view.frame(&mut marks);
    let largest = view.slices.iter().flat_map(|s| view.points(s)).map(|p| p.1).fold(0.0, f64::max);
    let drawing = picture((WIDE, frame.bottom + BELOW), |canvas| {
        frame.axes(canvas, true);
        // Spectra further up lie behind: they are drawn first.
        for slice in view.slices.iter().rev() {
            let spectrum = ("amplitude, um peak", &view.points(slice)[..]);
            frame.ridge(canvas, view.along(slice), spectrum, (largest, PEAK));
        }
        view.order_lines(canvas, &frame, &marks);
        mark::names(canvas, &frame, &marks);
        canvas.text(
            &format!("height: root of the amplitude, highest {largest:.3} um peak"),
            (frame.left, 8.0),
            Anchor::Start,
            INK,
        );
    });
    let (kind, over) = if over_speed { ("Cascade", "speed") } else { ("Waterfall", "time") };
    Picture {
        title: format!("{kind} of {} over {over}", cascade.name),
        note: if cascade.two_sided {
            "Full spectra: forward precession to the right, reverse to the left."
        } else {
            ""
        }
        .to_owned(),
        drawing,
        ..Picture::default()
    }
}

/// Part of a cascade that is drawn.
struct View<'a> {
    cascade: &'a Cascade,
    over_speed: bool,
    /// Spectra in their order from the front to the back.
    slices: Vec<&'a Slice>,
    /// Marked lines with their frequencies at the top of the frame.
    lines: Vec<MarkedLine>,
    highest: f64,
    low: f64,
    /// Speed (rpm) or time (s) at the top of the frame.
    high: f64,
}

impl<'a> View<'a> {
    fn new(cascade: &'a Cascade, lines: &[MarkedLine], over_speed: bool) -> Self {
        let along = |slice: &Slice| if over_speed { slice.speed_rpm.abs() } else { slice.time_s };
        let finite = |slice: &&Slice| along(slice).is_finite() && along(slice).abs() < 1e12;
        let mut slices: Vec<&Slice> = cascade.slices.iter().filter(finite).collect();
        slices.sort_by(|a, b| along(a).total_cmp(&along(b)));
        let (low, last) = extent(slices.iter().map(|slice| along(slice))).unwrap_or((0.0, 1.0));
        // The last spectrum fits inside the frame.
        let high = last + (last - low).max(1e-3 * last.abs()).max(1e-6) * PEAK / (HEIGHT - PEAK);
        let at_top = |line: &MarkedLine| if over_speed { line.order * high / 60.0 } else { line.hz };
        let lines = lines.iter().map(|line| MarkedLine { hz: at_top(line), ..line.clone() }).collect::<Vec<_>>();
        let bins = slices.iter().map(|slice| slice.amplitude_um.len() / 2).max().unwrap_or(0);
        let whole = Some(cascade.bin_hz * bins as f64).filter(|hz| *hz > 0.0 && *hz < 1e12).unwrap_or(1.0);
        let marked = lines.iter().map(|line| line.hz).filter(|hz| hz.is_finite()).fold(0.0, f64::max);
        let highest = if marked > 0.0 { whole.min(BEYOND_LINES * marked) } else { whole };
        Self { cascade, over_speed, slices, lines, highest, low, high }
    }

    fn along(&self, slice: &Slice) -> f64 {
        if self.over_speed { slice.speed_rpm.abs() } else { slice.time_s }
    }

    fn frame(&self, marks: &mut [Mark]) -> Frame {
        let lowest = if self.cascade.two_sided { -self.highest } else { 0.0 };
        let x = Axis::exact(Some((lowest, self.highest)), 7, "Frequency, Hz");
        let y = Axis::exact(Some((self.low, self.high)), 8, if self.over_speed { "Speed, rpm" } else { "Time, s" });
        let left = gutter(&[&y]);
        let right = mark::right_edge(marks, left, WIDE, |hz| x.place(hz));
        let rows = mark::stack(marks, |hz| left + x.place(hz) * (right - left));
        let top = 24.0 + mark::height(rows);
        Frame { start: 0.0, left, top, right, bottom: top + HEIGHT, x, y }
    }

    /// Returns frequencies and amplitudes of a spectrum, without the mean.
    fn points(&self, slice: &Slice) -> Vec<Point> {
        let half = slice.amplitude_um.len() / 2;
        let hz = |i: usize| (i as f64 - half as f64) * self.cascade.bin_hz;
        let lowest = if self.cascade.two_sided { -self.highest } else { 0.0 };
        let bins = slice.amplitude_um.iter().enumerate();
        let kept = bins.filter(|(i, a)| a.is_finite() && hz(*i) >= lowest && hz(*i) <= self.highest);
        let size = |i: usize, a: f64| if i.abs_diff(half) < MEAN_BINS { 0.0 } else { a.min(1e12) };
        Thinning::Peaks([POINTS, POINTS]).drawn(&kept.map(|(i, a)| (hz(i), size(i, *a))).collect::<Vec<_>>())
    }

    /// Draws the marked lines: vertical over time, rays through the origin over speed.
    fn order_lines(&self, canvas: &mut Canvas, frame: &Frame, marks: &[Mark]) {
        if !self.over_speed {
            return mark::lines(canvas, frame, marks);
        }
        frame.inside(canvas, |canvas| self.rays(canvas, frame, marks));
    }

    fn rays(&self, canvas: &mut Canvas, frame: &Frame, marks: &[Mark]) {
        for mark in marks {
            let foot = mark.hz * self.low / self.high;
            for side in [1.0, -1.0] {
                let (from, to) = ((side * foot, self.low), (side * mark.hz, self.high));
                if frame.x.holds(from.0) && frame.x.holds(to.0) {
                    canvas.line(&[frame.at(&from), frame.at(&to)], Stroke(FAINT, 0.75));
                }
            }
        }
    }
}
