//! Revolutions of the shaft over the samples of vibration signals.

use ballrace_recording::Sample;
use ballrace_recording::status::SampleStatus;
use std::ops::Range;

/// Smallest distance of two knots, samples. A vibration recording has many more samples per revolution.
const KNOT_SAMPLES: f64 = 16.0;
/// Largest deviation from uniform rotation, in periods of the highest line, at which the speed counts as constant.
const CONSTANT: f64 = 1.0 / 16.0;

/// Number of revolutions at a position in samples.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Knot {
    position: f64,
    revolutions: f64,
}

/// A stretch in which the shaft angle is measured without interruption.
#[derive(Debug, Clone, Default)]
pub struct Stretch {
    knots: Vec<Knot>,
    last: Option<Knot>,
}

/// Shaft angle over a recording.
#[derive(Debug, Default)]
pub(crate) struct ShaftAngle {
    stretches: Vec<Stretch>,
    is_open: bool,
}

impl ShaftAngle {
    /// Adds a sample with its angle, the mean of `average` samples of the recording; positions count from sample
    /// `first_index`.
    pub fn add(&mut self, sample: &Sample, average: u32, first_index: u64) {
        if sample.status.has(SampleStatus::ANGLE_NOT_MEASURED) {
            return;
        }
        if !std::mem::replace(&mut self.is_open, true) {
            self.stretches.push(Stretch::default());
        }
        let size = f64::from(average);
        let position = sample.row.index as f64 * size + 0.5 * (size - 1.0) - first_index as f64;
        let knot = Knot { position, revolutions: sample.total_revolutions() };
        if let Some(stretch) = self.stretches.last_mut() {
            stretch.add(knot);
        }
    }

    /// Ends the stretch: the next angle has another origin.
    pub const fn interrupt(&mut self) {
        self.is_open = false;
    }

    /// Returns the revolutions of the last stretch.
    pub fn revolutions(&self) -> f64 {
        self.stretches.last().map_or(0.0, Stretch::revolutions)
    }

    /// Returns true where the angle is interrupted.
    pub(crate) const fn is_interrupted(&self) -> bool {
        self.stretches.len() > 1
    }

    /// Returns the stretch with the most revolutions.
    pub fn longest(self) -> Option<Stretch> {
        self.stretches.into_iter().max_by(|a, b| a.revolutions().total_cmp(&b.revolutions())).map(Stretch::closed)
    }
}

impl Stretch {
    fn add(&mut self, knot: Knot) {
        if self.knots.last().is_none_or(|last| knot.position - last.position >= KNOT_SAMPLES) {
            self.knots.push(knot);
        }
        self.last = Some(knot);
    }

    fn closed(mut self) -> Self {
        let end = self.knots.last().map(|knot| knot.position);
        self.knots.extend(self.last.filter(|last| Some(last.position) != end));
        self
    }

    fn ends(&self) -> Option<[Knot; 2]> {
        Some([*self.knots.first()?, self.last?])
    }

    /// Returns the magnitude of the revolutions in the stretch.
    pub fn revolutions(&self) -> f64 {
        self.ends().map_or(0.0, |[first, last]| (last.revolutions - first.revolutions).abs())
    }

    /// Returns the samples of the stretch.
    pub fn samples(&self) -> Range<usize> {
        self.ends().map_or(0..0, |[first, last]| first.position.ceil() as usize..last.position as usize + 1)
    }

    /// Returns the mean speed, revolutions per sample.
    pub fn mean(&self) -> f64 {
        let samples = self.ends().map_or(0.0, |[first, last]| last.position - first.position);
        if samples > 0.0 { self.revolutions() / samples } else { 0.0 }
    }

    /// Returns the least and the greatest speed over one revolution, revolutions per sample: a wrong reading of a
    /// speed column is shorter.
    pub(crate) fn extreme_speeds(&self) -> [f64; 2] {
        let (mut least, mut greatest) = (f64::INFINITY, 0.0_f64);
        let mut starts = self.knots.iter().peekable();
        for end in &self.knots {
            let turned = |start: &Knot| (end.revolutions - start.revolutions).abs();
            while let Some(start) = starts.next_if(|start| turned(start) >= 1.0) {
                // The window that begins at the last knot from which a whole revolution has passed.
                if starts.peek().is_none_or(|next| turned(next) < 1.0) {
                    let speed = turned(start) / (end.position - start.position);
                    (least, greatest) = (least.min(speed), greatest.max(speed));
                }
            }
        }
        if greatest > 0.0 { [least, greatest] } else { [self.mean(); 2] }
    }

    /// Returns the revolutions from the first sample of [`samples`](Self::samples), for signals with lines up to
    /// `highest_order`; none where the speed is constant.
    pub fn varying(&self, highest_order: f64) -> Option<Revolutions> {
        let ([first, _], mean) = (self.ends()?, self.mean());
        let sign = if self.knots.last()?.revolutions < first.revolutions { -1.0 } else { 1.0 };
        let turned = |knot: &Knot| sign * (knot.revolutions - first.revolutions);
        let deviation = |knot: &Knot| (turned(knot) - mean * (knot.position - first.position)).abs();
        let largest = self.knots.iter().map(deviation).fold(0.0, f64::max);
        if largest * highest_order <= CONSTANT {
            return None;
        }
        let start = first.position.ceil();
        let knots = self.knots.iter().map(|knot| (knot.position - start, turned(knot))).collect();
        Some(Revolutions { knots })
    }
}

/// Revolutions over the positions of a signal in samples. Both rise.
#[derive(Debug, Clone)]
pub struct Revolutions {
    knots: Vec<(f64, f64)>,
}

impl Revolutions {
    /// Returns the positions at which the shaft has turned by multiples of `step` revolutions, up to the position
    /// `end`.
    pub fn positions(&self, step: f64, end: f64) -> impl Iterator<Item = f64> {
        let start = self.knots.first().map_or(0.0, |knot| knot.1);
        let mut pieces = self.knots.windows(2);
        let mut piece = pieces.next();
        let mut number = 0.0;
        std::iter::from_fn(move || {
            let target = start + number * step;
            number += 1.0;
            loop {
                let &[(from, low), (to, high)] = piece? else { return None };
                // A shaft that stands still or turns back for a moment has no position of its own there.
                if target <= high && high > low {
                    return Some(from + (to - from) * ((target - low) / (high - low)).max(0.0));
                }
                piece = pieces.next();
            }
        })
        .take_while(move |position| *position <= end)
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use ballrace::Phase;
    use ballrace_recording::Row;
    use std::f64::consts::TAU;

    const RATE: f64 = 10_000.0;

    fn angle(turned: impl Fn(f64) -> f64, average: u32) -> ShaftAngle {
        let mut angle = ShaftAngle::default();
        for index in 0..20_000 / u64::from(average) {
            let position = index as f64 * f64::from(average) + 0.5 * f64::from(average - 1);
            let [now, next] = [position, position + 1.0].map(|p| turned(p / RATE));
            let row = Row { index, ..Row::default() };
            let (revolution, speed) = (now.floor() as i64, TAU * (next - now) * RATE);
            angle.add(
                &Sample { row, angle: Phase::from_revolutions(now), revolution, speed, ..Sample::default() },
                average,
                0,
            );
        }
        angle
    }

    #[test]
    fn a_constant_speed_has_no_revolutions() {
        for (average, sign) in [(1, 1.0), (4, -1.0)] {
            let stretch = angle(|t| sign * 50.0 * t, average).longest().unwrap();
            assert!((stretch.mean() * RATE - 50.0).abs() < 1e-6, "{}", stretch.mean());
            assert!(stretch.varying(20.0).is_none());
            assert!(stretch.samples().len() > 19_990);
        }
    }

    #[test]
    fn positions_of_equal_angles() {
        for (average, sign) in [(1, 1.0), (8, -1.0)] {
            let turned = |t: f64| 40.0 * t + 5.0 * t * t;
            let stretch = angle(|t| sign * turned(t), average).longest().unwrap();
            let revolutions = stretch.varying(20.0).unwrap();
            let first = turned((stretch.samples().start as f64 - revolutions.knots[0].0.abs()) / RATE);
            for (i, position) in revolutions.positions(0.1, 19_000.0).enumerate() {
                let t = (position + stretch.samples().start as f64) / RATE;
                assert!((turned(t) - first - 0.1 * i as f64).abs() < 1e-5, "{i}");
            }
            assert!(revolutions.positions(0.1, 19_000.0).count() > 900);
        }
    }

    /// A wrong speed for a hundredth of a revolution changes the extremes by a hundredth.
    #[test]
    fn extreme_speeds_are_those_of_a_revolution() {
        let jump = |t: f64| 50.0 * t + if t > 1.0 { 0.01 } else { 0.0 };
        let [least, greatest] = angle(jump, 1).longest().unwrap().extreme_speeds().map(|speed| speed * RATE);
        assert!((least - 50.0).abs() < 1e-6 && greatest > 50.0 && greatest < 50.6, "{least} {greatest}");
    }

    #[test]
    fn the_longest_stretch_counts() {
        let mut both = angle(|t| 10.0 * t, 1);
        both.interrupt();
        both.stretches.extend(angle(|t| 30.0 * t, 1).stretches);
        assert!(both.is_interrupted());
        assert!((both.longest().unwrap().mean() * RATE - 30.0).abs() < 1e-6);
    }
}
