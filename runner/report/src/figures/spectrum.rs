//! Half spectra (one per probe, logarithmic) and full spectra (one per plane, linear).

use super::axis::{Axis, extent};
use super::canvas::{
    BELOW, Canvas, Frame, Key, MARK, MEASURED_LINE, RESIDUAL, RESIDUAL_LINE, Stroke, TWIN, WIDE, gutter, legend_height,
    picture,
};
use super::line::Point;
use super::mark::{self, Mark};
use super::{Context, Figure, Picture, PointBudget, Source};
use ballrace_twin::replay::outcome::{FullSpectrum, HalfSpectrum, MarkedLine, Pictures};

/// Height of a frame; the rows of names come on top.
const HEIGHT: f64 = 170.0;
/// The close view ends at this many times the highest marked line.
const BEYOND_LINES: f64 = 3.0;
/// The same factor for a full spectrum, whose sides have half the width.
const BEYOND_LINES_FULL: f64 = 1.6;
/// Highest harmonic of a marked line that gets a mark.
const HARMONICS: u32 = 10;
/// Share of the largest residual above which a harmonic gets a mark, and the number of these.
const STRONG: f64 = 0.3;
/// Least amplitude of a marked harmonic over the median of the residual: the amplitude of noise in a bin, which has a Rayleigh distribution, exceeds
/// it with a probability of 2^-16.
const ABOVE_NOISE: f64 = 4.0;
const MARKED_HARMONICS: usize = 6;
/// The close view ends at least at this many times the lowest natural frequency, and the largest residual.
const BEYOND_NATURAL: f64 = 1.15;
/// Largest ratio of the highest peak to the lower end of the amplitude axis.
const DYNAMIC_RANGE: f64 = 1e6;
/// Stroke of the twin. It is drawn under the measured curve and is wider, so that it is visible beside a peak.
const TWIN_WIDE: Stroke = Stroke(TWIN, 2.4);
const RESIDUAL_FINE: Stroke = Stroke(RESIDUAL, 0.9);
/// Largest number of lowest bins that are omitted because they contain the mean, spread by the window.
const MEAN_BINS: usize = 3;

/// Spectra, one per probe.
pub(super) struct HalfSpectra;

impl Figure for HalfSpectra {
    fn heading(&self) -> &'static str {
        "Spectra"
    }

    fn lines(&self, data: &Pictures) -> usize {
        6 * data.half_spectra.len()
    }

    fn draw(&self, context: &Context<'_>) -> Vec<Picture> {
        let data = context.data;
        let one = |(i, spectrum): (usize, &HalfSpectrum)| Picture {
            source: Some(Source::Spectrum(i)),
            ..half(spectrum, data, context.budget)
        };
        data.half_spectra.iter().enumerate().map(one).collect()
    }
}

/// Draws the spectrum of one probe: the range of the bearing lines, and beside it the whole range.
pub(super) fn half(spectrum: &HalfSpectrum, data: &Pictures, budget: PointBudget) -> Picture {
    let whole = whole_range(spectrum.bin_hz, longest(spectrum).saturating_sub(1));
    let close = close_view(data, whole, BEYOND_LINES);
    let curves = Curves::new(spectrum, mean_bins(&data.lines, spectrum.bin_hz));
    let y = curves.amplitude_axis();
    let lines = [data.lines.as_slice(), &harmonics(spectrum, &data.lines)].concat();
    let mut marks = mark::marks(&lines, &data.natural_frequencies, close);
    let split = whole > 1.5 * close;
    let width = if split { 0.72 * WIDE } else { WIDE };
    let x = Axis::exact(Some((0.0, close)), if split { 5 } else { 7 }, "Frequency, Hz");
    let left = gutter(&[&y]);
    let right = mark::right_edge(&marks, left, width, |hz| x.place(hz));
    let rows = mark::stack(&mut marks, |hz| left + x.place(hz) * (right - left));
    let legend = [
        (Key::Line(MEASURED_LINE), "measured"),
        (Key::Line(TWIN_WIDE), "twin"),
        (Key::Line(RESIDUAL_LINE), "residual"),
        (Key::Ring(MARK), "residual at a marked line"),
    ];
    let top = legend_height(left, &legend) + 8.0 + mark::height(rows);
    let frame = Frame { start: 0.0, left, top, right, bottom: top + HEIGHT, x, y };
    let drawing = picture((WIDE, frame.bottom + BELOW), |canvas| {
        canvas.legend(left, 0.0, &legend);
        frame.axes(canvas, true);
        mark::lines(canvas, &frame, &marks);
        mark::names(canvas, &frame, &marks);
        curves.draw(canvas, &frame, budget);
        residual_at(canvas, &frame, spectrum, &marks);
        if split {
            overview(canvas, &frame, &curves, whole, budget);
        }
    });
    let beside = if split { ", with the whole range beside it" } else { "" };
    Picture {
        title: format!("Spectrum of {}", spectrum.name),
        note: format!(
            "Amplitude zero to peak, logarithmic scale. Mean position omitted; 0 to {close:.0} Hz{beside}.{}",
            natural_note(data)
        ),
        drawing,
        ..Picture::default()
    }
}

/// Returns an explanation of the names of natural frequencies; empty without natural frequencies.
fn natural_note(data: &Pictures) -> &'static str {
    if data.natural_frequencies.is_empty() {
        ""
    } else {
        " Grey dotted lines N1, N2, ...: natural frequencies of the twin at the mean speed."
    }
}

/// Draws the three curves from 0 to the highest frequency in a narrow frame.
fn overview(canvas: &mut Canvas, close: &Frame, curves: &Curves, whole: f64, budget: PointBudget) {
    let x = Axis::exact(Some((0.0, whole)), 2, "Frequency, Hz");
    let mut y = close.y.clone();
    y.title = String::new();
    y.ticks.iter_mut().for_each(|tick| tick.1.clear());
    let frame = Frame { left: 0.76 * WIDE, right: WIDE - 18.0, x, y, ..close.clone() };
    frame.axes(canvas, true);
    curves.draw(canvas, &frame, budget);
}

/// The three curves of a half spectrum, without the mean.
struct Curves {
    measured: Vec<Point>,
    twin: Vec<Point>,
    residual: Vec<Point>,
}

impl Curves {
    fn new(spectrum: &HalfSpectrum, mean_bins: usize) -> Self {
        let points = |amplitudes: &[f64]| {
            let bins = amplitudes.iter().enumerate().skip(mean_bins).filter(|(_, amplitude)| amplitude.is_finite());
            bins.map(|(i, amplitude)| (i as f64 * spectrum.bin_hz, *amplitude)).collect()
        };
        Self {
            measured: points(&spectrum.measured),
            twin: points(&spectrum.twin),
            residual: points(&spectrum.residual),
        }
    }

    /// Returns the amplitude axis from just below the noise to just above the highest peak.
    fn amplitude_axis(&self) -> Axis {
        let noisy = self.measured.iter().chain(&self.residual).map(|point| point.1);
        let mut noisy: Vec<f64> = noisy.filter(|amplitude| *amplitude > 0.0).collect();
        noisy.sort_by(f64::total_cmp);
        let high = noisy.iter().copied().chain(self.twin.iter().map(|point| point.1)).fold(0.0, f64::max);
        let floor = noisy.get(noisy.len() / 20).copied().unwrap_or(high / 1000.0);
        Axis::decades((0.5 * floor).max(high / DYNAMIC_RANGE), 1.6 * high, "Amplitude, um peak")
    }

    fn draw(&self, canvas: &mut Canvas, frame: &Frame, budget: PointBudget) {
        let curves = [
            ("twin", &self.twin, TWIN_WIDE),
            ("measured", &self.measured, MEASURED_LINE),
            ("residual", &self.residual, RESIDUAL_FINE),
        ];
        for (name, points, stroke) in curves {
            frame.series(canvas, (name, points), budget.spectrum(), stroke);
        }
        frame.note_if_empty(canvas, &[&self.measured, &self.twin, &self.residual]);
    }
}

/// Returns the number of lowest bins that are omitted because they contain the mean; fewer where the lowest marked line is close.
fn mean_bins(lines: &[MarkedLine], bin_hz: f64) -> usize {
    let lowest = lines.iter().map(|line| line.hz).filter(|hz| *hz > 0.0).fold(f64::INFINITY, f64::min);
    ((0.5 * lowest / bin_hz) as usize).clamp(1, MEAN_BINS)
}

/// Draws rings at the peaks of the residual on the marked lines, where the measured peak covers its curve.
fn residual_at(canvas: &mut Canvas, frame: &Frame, spectrum: &HalfSpectrum, marks: &[Mark]) {
    frame.inside(canvas, |canvas| {
        for mark in marks.iter().filter(|mark| !mark.is_natural) {
            let near = |i: usize| (i as f64 * spectrum.bin_hz - mark.hz).abs() <= 1.5 * spectrum.bin_hz;
            let peak = spectrum.residual.iter().enumerate().filter(|(i, a)| near(*i) && a.is_finite()).map(|(_, a)| *a);
            let peak = peak.fold(0.0, f64::max);
            if peak > frame.y.low() {
                let (x, y) = frame.at(&(mark.hz, peak));
                canvas.ring(x, y, MARK);
            }
        }
    });
}

/// Returns the highest frequency, Hz; 0 where the bin width is not finite.
fn whole_range(bin_hz: f64, bins: usize) -> f64 {
    let highest = bin_hz * bins as f64;
    if highest.is_finite() { highest.max(0.0) } else { 0.0 }
}

fn longest(spectrum: &HalfSpectrum) -> usize {
    spectrum.measured.len().max(spectrum.twin.len()).max(spectrum.residual.len())
}

/// Returns the strongest harmonics of the marked lines in the residual, which have no mark of their own.
fn harmonics(spectrum: &HalfSpectrum, lines: &[MarkedLine]) -> Vec<MarkedLine> {
    let near = |hz: f64| {
        let within = |i: &usize| (*i as f64 * spectrum.bin_hz - hz).abs() <= 1.5 * spectrum.bin_hz;
        let bins = spectrum.residual.iter().enumerate().filter(|(i, a)| within(i) && a.is_finite());
        bins.map(|(_, amplitude)| *amplitude).fold(0.0, f64::max)
    };
    let mut sorted: Vec<f64> = spectrum.residual.iter().skip(MEAN_BINS).copied().filter(|a| a.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let largest = sorted.last().copied().unwrap_or(0.0);
    let least = f64::max(STRONG * largest, ABOVE_NOISE * sorted.get(sorted.len() / 2).copied().unwrap_or(0.0));
    let apart = |hz: f64| lines.iter().all(|line| (line.hz - hz).abs() > 3.0 * spectrum.bin_hz);
    let all = lines.iter().filter(|line| line.hz > 3.0 * spectrum.bin_hz).flat_map(|line| {
        (2..=HARMONICS).map(move |k| {
            let times = f64::from(k);
            let label = if line.label == "1X" { format!("{k}X") } else { format!("{} x{k}", line.label) };
            MarkedLine { label, order: times * line.order, hz: times * line.hz }
        })
    });
    let mut strong: Vec<(f64, MarkedLine)> = all.map(|line| (near(line.hz), line)).collect();
    strong.retain(|(amplitude, line)| *amplitude > least && apart(line.hz));
    strong.sort_by(|a, b| b.0.total_cmp(&a.0));
    strong.truncate(MARKED_HARMONICS);
    strong.into_iter().map(|(_, line)| line).collect()
}

/// Returns the frequency of the largest residual of all probes, Hz; 0 where there is none.
fn strongest_residual(data: &Pictures) -> f64 {
    let peaks = data.half_spectra.iter().flat_map(|spectrum| {
        let bins = spectrum.residual.iter().enumerate().skip(MEAN_BINS).filter(|(_, amplitude)| amplitude.is_finite());
        bins.max_by(|a, b| a.1.total_cmp(b.1)).map(|(i, amplitude)| (*amplitude, i as f64 * spectrum.bin_hz))
    });
    peaks.filter(|(_, hz)| hz.is_finite()).max_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |(_, hz)| hz)
}

/// Returns the end of the range that contains the bearing lines, the largest residual and the lowest natural frequency, Hz; the whole range
/// without lines.
fn close_view(data: &Pictures, whole: f64, beyond: f64) -> f64 {
    let highest = data.lines.iter().map(|line| line.hz).filter(|hz| hz.is_finite()).fold(0.0, f64::max);
    let natural = data.natural_frequencies.iter().map(|line| line.hz).fold(f64::INFINITY, f64::min);
    let natural = if natural < 2.0 * beyond * highest { BEYOND_NATURAL * natural } else { 0.0 };
    let shown = (beyond * highest).max(natural).max(BEYOND_NATURAL * strongest_residual(data));
    if highest > 0.0 { whole.min(shown) } else { whole }
}

/// Draws the full spectrum of one plane: forward to the right, reverse to the left; below it, magnified, all but 1X.
pub(super) fn full(spectrum: &FullSpectrum, data: &Pictures, budget: PointBudget) -> Picture {
    let sides = Sides::new(spectrum, data);
    let mut marks = mark::marks(&data.lines, &data.natural_frequencies, sides.close);
    let frames = sides.frames(&mut marks);
    let bottom = frames.last().map_or(0.0, |frame| frame.bottom);
    let drawing = picture((WIDE, bottom + BELOW), |canvas| {
        let legend = [(Key::Line(MEASURED_LINE), "measured"), (Key::Line(TWIN_WIDE), "twin")];
        canvas.legend(frames[0].left, 0.0, &legend);
        for (i, frame) in frames.iter().enumerate() {
            frame.axes(canvas, i + 1 == frames.len());
            mark::lines(canvas, frame, &marks);
            sides.draw(canvas, frame, budget);
        }
        mark::names(canvas, &frames[0], &marks);
        mark::name_sides(canvas, &frames[frames.len() - 1]);
    });
    let magnified = if frames.len() > 1 { "; below, magnified, with 1X cut off" } else { "" };
    let (close, whole) = (sides.close, sides.whole);
    Picture {
        title: format!("Full spectrum of {}", spectrum.name),
        note: format!(
            "Amplitude zero to peak, linear scale{magnified}. Mean position omitted; \u{b1}{close:.0} Hz of \
             \u{b1}{whole:.0} Hz.{}",
            natural_note(data)
        ),
        drawing,
        ..Picture::default()
    }
}

/// Both curves of a full spectrum, and the ranges of the axes.
struct Sides {
    measured: Vec<Point>,
    twin: Vec<Point>,
    close: f64,
    whole: f64,
    highest: Option<f64>,
    highest_but_one_x: Option<f64>,
}

impl Sides {
    fn new(spectrum: &FullSpectrum, data: &Pictures) -> Self {
        let lines = &data.lines;
        let half = spectrum.measured.len().max(spectrum.twin.len()) / 2;
        let whole = whole_range(spectrum.bin_hz, half);
        let close = close_view(data, whole, BEYOND_LINES_FULL);
        let mean_bins = mean_bins(lines, spectrum.bin_hz);
        let measured = two_sided(&spectrum.measured, spectrum.bin_hz, mean_bins);
        let twin = two_sided(&spectrum.twin, spectrum.bin_hz, mean_bins);
        let one_x = lines.iter().find(|line| line.label == "1X").map(|line| line.hz);
        let near_one_x = |hz: f64| one_x.is_some_and(|one_x| (hz.abs() - one_x).abs() < 3.5 * spectrum.bin_hz);
        let highest = |shown: &dyn Fn(f64) -> bool| {
            let points = measured.iter().chain(&twin).filter(|point| shown(point.0));
            extent(points.map(|point| point.1)).map(|range| range.1)
        };
        let all = highest(&|hz| hz.abs() <= close);
        let others = highest(&|hz| hz.abs() <= close && !near_one_x(hz));
        Self { close, whole, highest: all, highest_but_one_x: others, measured, twin }
    }

    /// Returns the frames, one above the other: two where 1X is more than three times as high as the rest, else one.
    fn frames(&self, marks: &mut [Mark]) -> Vec<Frame> {
        let magnified = match (self.highest, self.highest_but_one_x) {
            (Some(all), Some(others)) => others > 0.0 && all > 3.0 * others,
            _ => false,
        };
        let highs = if magnified { vec![self.highest, self.highest_but_one_x] } else { vec![self.highest] };
        let height = if magnified { 0.6 * HEIGHT } else { HEIGHT };
        let axes: Vec<Axis> = highs.into_iter().map(|high| Axis::from_zero(high, 5, "Ampl., um peak")).collect();
        let x = Axis::exact(Some((-self.close, self.close)), 7, "Frequency, Hz");
        let left = gutter(&axes.iter().collect::<Vec<_>>());
        let right = mark::right_edge(marks, left, WIDE, |hz| x.place(hz));
        let rows = mark::stack(marks, |hz| left + x.place(hz) * (right - left));
        let first = 24.0 + mark::height(rows);
        let frame = |(i, y): (usize, Axis)| {
            let top = first + i as f64 * (height + 14.0);
            Frame { start: 0.0, left, top, right, bottom: top + height, x: x.clone(), y }
        };
        axes.into_iter().enumerate().map(frame).collect()
    }

    fn draw(&self, canvas: &mut Canvas, frame: &Frame, budget: PointBudget) {
        for (name, points, stroke) in [("twin", &self.twin, TWIN_WIDE), ("measured", &self.measured, MEASURED_LINE)] {
            frame.series(canvas, (name, points), budget.spectrum(), stroke);
        }
        frame.uprights(canvas, [0.0], Stroke(MARK, 1.0));
        frame.note_if_empty(canvas, &[&self.measured, &self.twin]);
    }
}

/// Returns amplitudes with their frequencies, without the bins about 0 Hz, which contain the mean.
fn two_sided(amplitudes: &[f64], bin_hz: f64, mean_bins: usize) -> Vec<Point> {
    let half = amplitudes.len() / 2;
    let bin = |i: usize| i as f64 - half as f64;
    let kept = amplitudes.iter().enumerate().filter(|(i, _)| i.abs_diff(half) >= mean_bins);
    kept.map(|(i, amplitude)| (bin(i) * bin_hz, *amplitude)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(label: &str, hz: f64) -> MarkedLine {
        MarkedLine { label: label.to_owned(), order: hz / 50.0, hz }
    }

    /// Returns the labels of the harmonics in a residual of noise with these peaks, bin and amplitude.
    fn labels(peaks: &[(usize, f64)], lines: &[MarkedLine]) -> Vec<String> {
        let mut residual = vec![0.01; 1024];
        peaks.iter().for_each(|(bin, amplitude)| residual[*bin] = *amplitude);
        let spectrum = HalfSpectrum { bin_hz: 1.0, residual, ..HalfSpectrum::default() };
        harmonics(&spectrum, lines).into_iter().map(|line| line.label).collect()
    }

    #[test]
    fn strong_harmonics_of_the_marked_lines_are_marked_strongest_first() {
        let lines = [line("1X", 50.0), line("DE outer", 180.0)];
        // 150 Hz is too weak, 700 Hz no harmonic, 361 Hz within the width of a line.
        let peaks = [(100, 0.5), (150, 0.2), (361, 0.9), (704, 1.0), (720, 0.8)];
        assert_eq!(labels(&peaks, &lines), ["DE outer x2", "DE outer x4", "2X"]);
        assert!(labels(&[], &[]).is_empty() && labels(&[(704, 1.0)], &lines).is_empty());
    }

    #[test]
    fn a_harmonic_on_another_marked_line_has_its_mark_already() {
        let lines = [line("DE cage", 20.0), line("DE outer", 180.0)];
        assert!(labels(&[(180, 1.0)], &lines).is_empty());
        assert_eq!(labels(&[(180, 1.0), (360, 0.9)], &lines), ["DE outer x2"]);
    }

    #[test]
    fn noise_has_no_harmonics() {
        // Amplitudes with a Rayleigh distribution at quantiles in an order without period.
        let quantile = |i: usize| (i as f64 * 0.618_034).fract().max(1e-3);
        let noise: Vec<(usize, f64)> = (3..1024).map(|i| (i, (-2.0 * quantile(i).ln()).sqrt())).collect();
        assert!(labels(&noise, &[line("1X", 50.0), line("DE cage", 20.0)]).is_empty());
    }

    #[test]
    fn the_marks_of_harmonics_are_few() {
        let peaks: Vec<(usize, f64)> = (2..=10).map(|k| (100 * k, 1.0 + k as f64)).collect();
        let found = labels(&peaks, &[line("1X", 100.0)]);
        assert_eq!(found, ["10X", "9X", "8X", "7X", "6X", "5X"]);
        // Values that are not finite count nowhere.
        assert!(labels(&[(200, f64::NAN), (300, f64::INFINITY)], &[line("1X", 100.0)]).len() <= MARKED_HARMONICS);
    }
}
