//! Order tracking: amplitudes of lines whose phase follows the shaft, a cage and an outer ring.
//!
//! The phase of each line comes from the counted angles, not from time, so a run-up smears nothing. Blocks of
//! [`BLOCK_TURNS`] revolutions under a Hann window over the shaft angle separate neighbouring orders and allow a cage to slip
//! a little between blocks. Amplitudes are averaged over blocks by their squares.

use ballrace::math::Math;
use ballrace::rotor::ComponentAngles;
use ballrace::twin::{Accumulator, OrderVector, RevolutionBlock};
use ballrace::{Exact, Phase, Scalar};
use ballrace_models::simd::SimdDispatch;
use ballrace_plant::MountedBearing;

/// Revolutions of one block: lines 3/16 of an order apart are resolved.
pub const BLOCK_TURNS: f64 = 16.0;
/// Harmonics of the outer ball-pass line that are followed.
pub(crate) const OUTER_HARMONICS: i32 = 5;
/// Harmonics of the inner ball-pass line that are followed.
pub(crate) const INNER_HARMONICS: i32 = 3;

/// Angles of the shaft and of the parts of the bearings at one sample.
#[derive(Clone, Copy)]
pub struct Angles<'a> {
    /// Shaft.
    pub shaft: Phase,
    /// Parts of each bearing.
    pub parts: &'a [ComponentAngles],
    /// Revolutions of the shaft since the last sample.
    pub revolutions: f64,
}

/// Phase of a line: whole multiples of the angles of the shaft and of one bearing's cage and outer ring.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Line {
    shaft: i32,
    bearing: Option<BearingMultiples>,
}

/// Multiples of the angles of one bearing's parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct BearingMultiples {
    index: usize,
    cage: i32,
    outer: i32,
}

impl Line {
    /// Returns the `n`th harmonic of the shaft.
    #[must_use]
    pub const fn shaft(n: i32) -> Self {
        Self { shaft: n, bearing: None }
    }

    /// Returns the `k`th harmonic of the outer ball pass of a bearing, `k N (cage - outer ring)`.
    const fn outer_race(index: usize, elements: i32, k: i32) -> Self {
        Self { shaft: 0, bearing: Some(BearingMultiples { index, cage: k * elements, outer: -k * elements }) }
    }

    /// Returns the `k`th harmonic of the inner ball pass of a bearing, `k N (shaft - cage)`.
    const fn inner_race(index: usize, elements: i32, k: i32) -> Self {
        Self { shaft: k * elements, bearing: Some(BearingMultiples { index, cage: -k * elements, outer: 0 }) }
    }

    /// Returns the order per revolution of the shaft; negative where the phase runs against the shaft.
    #[must_use]
    pub fn order(&self, bearings: &[MountedBearing]) -> f64 {
        let of = |m: BearingMultiples| {
            let ratios =
                bearings.get(m.index).map_or((0.0, 0.0), |b| (b.kinematics.cage_ratio, b.kinematics.outer_ratio));
            f64::from(m.cage) * ratios.0 + f64::from(m.outer) * ratios.1
        };
        f64::from(self.shaft) + self.bearing.map_or(0.0, of)
    }

    /// Returns the line whose phase is that of this one and that of `other` together; none for lines of two bearings.
    fn plus(self, other: Self) -> Option<Self> {
        let bearing = match (self.bearing, other.bearing) {
            (Some(a), Some(b)) if a.index != b.index => return None,
            (Some(a), Some(b)) => {
                Some(BearingMultiples { index: a.index, cage: a.cage + b.cage, outer: a.outer + b.outer })
            }
            (a, b) => a.or(b),
        };
        Some(Self { shaft: self.shaft + other.shaft, bearing })
    }

    fn phase(&self, angles: &Angles) -> Phase {
        let times = |angle: Phase, n: i32| angle.wrapping_mul(i64::from(n) as u64);
        let bearing = self.bearing.map_or(Phase::ZERO, |m| {
            let parts = angles.parts.get(m.index).copied().unwrap_or_default();
            times(parts.cage, m.cage).wrapping_add(times(parts.outer, m.outer))
        });
        times(angles.shaft, self.shaft).wrapping_add(bearing)
    }
}

/// Returns the followed lines: 1X, 2X, then for each bearing the harmonics of the outer and of the inner ball pass.
#[must_use]
pub fn followed(bearings: &[MountedBearing]) -> Vec<Line> {
    let mut lines = vec![Line::shaft(1), Line::shaft(2)];
    for (i, bearing) in bearings.iter().enumerate() {
        let n = bearing.elements as i32;
        lines.extend((1..=OUTER_HARMONICS).map(|k| Line::outer_race(i, n, k)));
        lines.extend((1..=INNER_HARMONICS).map(|k| Line::inner_race(i, n, k)));
    }
    lines
}

/// Returns the orders of the followed lines.
#[must_use]
pub(crate) fn followed_orders(bearings: &[MountedBearing]) -> Vec<f64> {
    followed(bearings).iter().map(|line| line.order(bearings)).collect()
}

/// Returns the index in [`followed`] of harmonic `k` (1 is the fundamental) of a bearing's outer ball pass.
#[must_use]
pub(crate) fn outer_line(bearing: usize, k: i32) -> usize {
    2 + bearing * (OUTER_HARMONICS + INNER_HARMONICS) as usize + (k - 1) as usize
}

/// Returns the index in [`followed`] of harmonic `k` of a bearing's inner ball pass.
#[must_use]
pub(crate) fn inner_line(bearing: usize, k: i32) -> usize {
    outer_line(bearing, OUTER_HARMONICS + k)
}

/// Returns the last two of the lines before `line` whose phases add up to that of `line`.
fn summands(lines: &[Line], line: usize) -> Option<[usize; 2]> {
    let earlier = || (0..line).rev();
    let pairs = earlier().flat_map(|a| earlier().filter(move |b| *b <= a).map(move |b| [a, b]));
    pairs.into_iter().find(|&[a, b]| lines[a].plus(lines[b]) == Some(lines[line]))
}

/// Number of signals that are demodulated side by side, as many as a vector register of AVX2 takes.
const GROUP_SIZE: usize = 4;

/// Demodulator of several signals at several lines: the kernel's [`OrderTracker`](ballrace::twin::OrderTracker) for any number
/// of both.
///
/// `T` is the precision and `S` the accumulator of the sums. In `f32` with compensated sums the amplitudes are those of firmware to
/// the bit, except of harmonics of other lines; in `f64` a plain sum has digits to spare.
#[derive(Debug, Clone)]
pub struct Demodulator<T: Scalar = f64, S: Accumulator<T> = f64> {
    lines: Vec<Line>,
    /// Two earlier lines whose phases add up to that of each line, where there are such.
    summands: Vec<Option<[usize; 2]>>,
    /// Sine and cosine of each line at the current sample.
    basis: Vec<(T, T)>,
    signals: usize,
    /// Number of signals of the first half less those of the second, which are demodulated too: from the amplitudes, which are linear in
    /// the signals.
    differences: usize,
    block: RevolutionBlock<T, S>,
    /// Sums over the current block with cosine and sine, line-major, in groups of signals.
    sums: Vec<[[S; GROUP_SIZE]; 2]>,
    /// Signals of the current sample about their means, times the window, in the same groups; the last one is filled with zeros.
    windowed: Vec<[T; GROUP_SIZE]>,
    registers: SimdDispatch,
    /// Amplitudes of cosine and sine in the last finished block, line-major: of the signals, then of the differences.
    last: Vec<OrderVector<T>>,
    /// Squared amplitudes of the same, summed over finished blocks.
    power: Vec<f64>,
    blocks: f64,
    /// Running means, subtracted before demodulation so that a large mean does not leak.
    means: Vec<f64>,
    samples: f64,
}

impl<T: Scalar, S: Accumulator<T>> Demodulator<T, S>
where
    Exact: Math<T>,
{
    /// Creates a demodulator of `signals` signals.
    #[must_use]
    pub fn new(lines: Vec<Line>, signals: usize) -> Self {
        Self::of(lines, signals, 0)
    }

    /// Creates a demodulator of `pairs` signals, of as many others, and of the first less the others.
    #[must_use]
    pub(crate) fn with_differences(lines: Vec<Line>, pairs: usize) -> Self {
        Self::of(lines, 2 * pairs, pairs)
    }

    fn of(lines: Vec<Line>, signals: usize, differences: usize) -> Self {
        let (results, groups) = (lines.len() * (signals + differences), signals.div_ceil(GROUP_SIZE));
        Self {
            summands: (0..lines.len()).map(|line| summands(&lines, line)).collect(),
            basis: vec![(T::ZERO, T::ONE); lines.len()],
            block: RevolutionBlock::new(),
            sums: vec![[[S::ZERO; GROUP_SIZE]; 2]; lines.len() * groups],
            windowed: vec![[T::ZERO; GROUP_SIZE]; groups],
            registers: SimdDispatch::detect(),
            last: vec![[T::ZERO; 2]; results],
            power: vec![0.0; results],
            blocks: 0.0,
            means: vec![0.0; signals],
            samples: 0.0,
            lines,
            signals,
            differences,
        }
    }

    /// Returns the number of results of a line.
    const fn results(&self) -> usize {
        self.signals + self.differences
    }

    /// Adds one sample of all signals; returns true where a block ends before it.
    pub fn add(&mut self, values: &[f64], angles: Angles) -> bool {
        self.samples += 1.0;
        // A slow average: fixed within rounding over a block, whatever the recording's length.
        let rate = 1.0 / self.samples.min(20_000.0);
        let centred = self.windowed.as_flattened_mut();
        for ((mean, value), to) in self.means.iter_mut().zip(values).zip(centred) {
            *mean += (value - *mean) * rate;
            *to = T::from_f64(value - *mean);
        }
        // The first sample begins a block.
        let revolutions = if self.samples > 1.0 { angles.revolutions.abs() } else { 0.0 };
        self.demodulate(angles, revolutions)
    }

    /// Adds the centred signals in `windowed`, after `revolutions` since the last sample.
    fn demodulate(&mut self, angles: Angles, revolutions: f64) -> bool {
        let share = revolutions / BLOCK_TURNS;
        let is_complete = self.block.advance(Phase::from_revolutions(share)) || share >= 1.0;
        if is_complete {
            self.close();
        }
        let window = self.block.window::<Exact>();
        self.windowed.as_flattened_mut().iter_mut().for_each(|signal| *signal = window * *signal);
        for (i, summands) in self.summands.iter().enumerate() {
            // A harmonic costs four multiplications instead of a sine and cosine.
            self.basis[i] = match *summands {
                Some([a, b]) => {
                    let ((sin_a, cos_a), (sin_b, cos_b)) = (self.basis[a], self.basis[b]);
                    (sin_a * cos_b + cos_a * sin_b, cos_a * cos_b - sin_a * sin_b)
                }
                None => Exact::sin_cos(self.lines[i].phase(&angles)),
            };
        }
        self.registers.run(
            #[inline(always)]
            || {
                let lines = self.sums.chunks_exact_mut(self.windowed.len().max(1));
                for (sums, &(sin, cos)) in lines.zip(&self.basis) {
                    for ([with_cosine, with_sine], &windowed) in sums.iter_mut().zip(&self.windowed) {
                        for i in 0..GROUP_SIZE {
                            with_cosine[i].accumulate(windowed[i] * cos);
                            with_sine[i].accumulate(windowed[i] * sin);
                        }
                    }
                }
            },
        );
        is_complete
    }

    fn close(&mut self) {
        let scale = self.block.close();
        if scale > T::ZERO {
            self.evaluate(scale);
        }
        self.sums.fill([[S::ZERO; GROUP_SIZE]; 2]);
    }

    /// Evaluates the sums of a block with the factor from sums to amplitudes.
    fn evaluate(&mut self, scale: T) {
        let sums = self.sums.chunks_exact(self.windowed.len().max(1));
        for (last, sums) in self.last.chunks_exact_mut(self.signals.max(1) + self.differences).zip(sums) {
            let (signals, differences) = last.split_at_mut(self.signals);
            for (i, amplitudes) in signals.iter_mut().enumerate() {
                *amplitudes = sums[i / GROUP_SIZE].map(|sums| scale * sums[i % GROUP_SIZE].total());
            }
            let (first, second) = signals.split_at(self.differences);
            for (difference, ([c, s], [other_c, other_s])) in differences.iter_mut().zip(first.iter().zip(second)) {
                *difference = [*c - *other_c, *s - *other_s];
            }
        }
        for (power, vector) in self.power.iter_mut().zip(&self.last) {
            let [cosine, sine] = vector.map(T::to_f64);
            *power += cosine * cosine + sine * sine;
        }
        self.blocks += 1.0;
    }

    /// Drops the unfinished block, because the shaft angle is interrupted.
    pub fn interrupt(&mut self) {
        self.block = RevolutionBlock::new();
        self.sums.fill([[S::ZERO; GROUP_SIZE]; 2]);
    }

    /// Ends the recording: an incomplete block counts only where there is no complete one.
    pub fn finish(&mut self) {
        if self.blocks == 0.0 {
            self.close();
        }
    }

    /// Returns the amplitudes of cosine and sine of a line in every signal, then in every difference, of the last finished block.
    #[must_use]
    pub fn block(&self, line: usize) -> &[[T; 2]] {
        self.last.get(line * self.results()..(line + 1) * self.results()).unwrap_or_default()
    }

    /// Returns the amplitude (zero to peak) of a line in a signal; differences follow the signals.
    #[must_use]
    pub fn amplitude(&self, line: usize, signal: usize) -> f64 {
        let power = self.power.get(line * self.results() + signal).copied().unwrap_or(0.0);
        if self.blocks > 0.0 { (power / self.blocks).sqrt() } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ballrace::phase::{PhaseDelta, SpeedRatio};
    use ballrace::rotor::SpeedRatios;
    use ballrace::twin::{CompensatedSum, OrderLine, OrderTracker};
    /// Counts of a phase in one revolution.
    const COUNTS: f64 = 18_446_744_073_709_551_616.0;

    const LINES: [OrderLine; 3] = [
        OrderLine { shaft: 1, cage: 0, ball: 0 },
        OrderLine { shaft: 0, cage: 9, ball: 0 },
        OrderLine { shaft: 9, cage: -9, ball: 0 },
    ];

    fn same_lines() -> Vec<Line> {
        vec![Line::shaft(1), Line::outer_race(0, 9, 1), Line::inner_race(0, 9, 1)]
    }

    /// Feeds a run-up to the kernel's tracker and to the demodulator of the desktop, and calls `compare` at the end of each block.
    /// `increment` is the rotation between two samples, in revolutions.
    fn run<T: Scalar, S: Accumulator<T>>(
        increment: impl Fn(i32) -> f64,
        compare: impl Fn(OrderVector<T>, OrderVector<T>),
    ) where
        Exact: Math<T>,
    {
        let speed_ratios = SpeedRatios::<f64>::new(0.398_31);
        let (mut shaft, mut parts) = (Phase::from_revolutions(0.3), ComponentAngles::default());
        let mut kernel = OrderTracker::<T, 3>::new(LINES, BLOCK_TURNS as u32, shaft);
        let mut desktop = Demodulator::<T, S>::new(same_lines(), 1);
        let (mut revolutions, mut blocks) = (0.0, 0);
        for i in 0..20_000 {
            let signal = LINES.iter().map(|line| line.angle(shaft, &parts).radians().cos()).sum::<f64>();
            let is_complete = kernel.add::<Exact>(T::from_f64(signal), shaft, &parts);
            desktop.windowed.fill([T::from_f64(signal); GROUP_SIZE]);
            let angles = Angles { shaft, parts: &[parts], revolutions };
            assert_eq!(desktop.demodulate(angles, revolutions), is_complete, "{i}");
            if is_complete {
                blocks += 1;
                for (line, of_kernel) in kernel.vectors().iter().enumerate() {
                    let [of_desktop] = desktop.block(line) else { unreachable!("one signal") };
                    compare(*of_kernel, *of_desktop);
                }
            }
            revolutions = increment(i);
            let arc = PhaseDelta((revolutions * COUNTS) as i64);
            (shaft, parts) = (shaft.advanced(arc), speed_ratios.advance(parts, arc));
        }
        assert!(blocks >= 5, "{blocks}");
    }

    /// The demodulator and the kernel's tracker report the same amplitudes of a signal.
    #[test]
    fn amplitudes_are_those_of_the_kernel() {
        run::<f64, f64>(
            |i| 0.004 + 1e-7 * f64::from(i),
            |[c, s], [x, y]| assert!((c - x).abs() < 1e-9 && (s - y).abs() < 1e-9, "{c} {s}, {x} {y}"),
        );
    }

    /// In single precision the demodulator reports the amplitudes of firmware to the bit.
    #[test]
    fn amplitudes_in_single_precision_are_those_of_firmware_to_the_bit() {
        // Increments that the angle and the share of a block represent exactly: rounding of the angles does not count here.
        let exact = |i: i32| f64::from(512 + i % 64) / 131_072.0;
        assert_eq!(SpeedRatio::new(1.0 / BLOCK_TURNS).apply(PhaseDelta(1 << 40)), PhaseDelta(1 << 36));
        run::<f32, CompensatedSum<f32>>(exact, |of_kernel, of_desktop| {
            assert_eq!(of_kernel.map(f32::to_bits), of_desktop.map(f32::to_bits), "{of_kernel:?} {of_desktop:?}");
        });
    }

    /// Harmonics and differences are those that a demodulator of each line and of the difference itself would find.
    #[test]
    fn harmonics_and_differences_are_those_of_their_own_demodulators() {
        let lines: Vec<Line> =
            (1..=5).map(|k| Line::outer_race(0, 9, k)).chain([Line::shaft(1), Line::shaft(2)]).collect();
        let speed_ratios = SpeedRatios::<f64>::new(0.398_31);
        let arc = PhaseDelta((0.004 * COUNTS) as i64);
        let (mut shaft, mut parts) = (Phase::from_revolutions(0.3), ComponentAngles::default());
        let mut together = Demodulator::<f64>::with_differences(lines.clone(), 2);
        let mut alone: Vec<_> = lines.iter().map(|line| Demodulator::<f64>::new(vec![*line], 6)).collect();
        for _ in 0..9000 {
            let angles = Angles { shaft, parts: &[parts], revolutions: 0.004 };
            let value = |k: f64| {
                let each = lines.iter().enumerate();
                each.map(|(i, line)| (1.0 + i as f64) * (k * line.phase(&angles).radians()).sin()).sum::<f64>()
            };
            let signals = [value(1.0), 3.0 + value(2.0), 0.7 * value(1.0), 1.0 - value(1.0)];
            let all = [signals.as_slice(), &[signals[0] - signals[2], signals[1] - signals[3]]].concat();
            together.add(&signals, angles);
            alone.iter_mut().for_each(|one| {
                one.add(&all, angles);
            });
            (shaft, parts) = (shaft.advanced(arc), speed_ratios.advance(parts, arc));
        }
        for (line, one) in alone.iter().enumerate() {
            for signal in 0..6 {
                let (found, expected) = (together.amplitude(line, signal), one.amplitude(0, signal));
                assert!((found - expected).abs() < 1e-12, "line {line}, signal {signal}: {found}, {expected}");
            }
            assert_eq!(together.block(line).len(), 6);
        }
        assert!(together.amplitude(2, 4) > 0.5);
    }
}
