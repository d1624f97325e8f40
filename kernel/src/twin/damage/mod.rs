//! Detector of bearing damage in an acceleration.

mod component;
mod lines;
mod spectrum;
mod whitener;

pub use component::DamagedComponent;

use crate::bearing::kinematics::Orders;
use crate::choice::Choice;
use crate::math::Math;
use crate::phase::Phase;
use crate::scalar::Scalar;
use component::Pattern;
use lines::Lines;
use spectrum::{BINS, Block, Power, TURN_BITS};
use whitener::Whitener;

/// Blocks of the average: longer ago they are forgotten.
const AVERAGED: u32 = 8;
/// Share of the first block that the predictor does not see: an eighth, 8 revolutions, is enough to learn it.
const UNSEEN: Phase = Phase(7 << 61);
/// Standard deviation of the slip.
const SLIP_DEVIATION: f64 = 0.01;
/// Least evidence. The cells of slip of all components are some hundreds, `ln` of which is 6.
const LEAST_EVIDENCE: f64 = 6.0;
/// Share of the evidence of the strongest family of any order that a hypothesis must have.
const OF_STRONGEST_FAMILY: f64 = 0.75;
/// Amplitude over that of the strongest line that a carrier has at least: side bands are weaker.
const OF_STRONGEST_LINE: f64 = 0.5;
/// Least modulation of the squared envelope by the harmonics of a carrier: good bearings modulate it by up to 0.26, damaged
/// ones by 0.4 to 2.7.
const LEAST_MODULATION: f64 = 0.3;
/// Modulation over that of another hypothesis from which the other is made of side bands: those of a full modulation are as
/// strong as the carrier.
const STRONGER: f64 = 1.5;

/// Components and nothing, in the order of the hypotheses: a table, because a comparison would be a branch.
const NAMED: [Option<DamagedComponent>; NOTHING + 1] = [
    Some(DamagedComponent::OuterRace),
    Some(DamagedComponent::InnerRace),
    Some(DamagedComponent::Element),
    Some(DamagedComponent::Cage),
    None,
];
const NOTHING: usize = DamagedComponent::ALL.len();

/// Damage of one component as the cause of the lines of the envelope, at the slip that fits best.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DamageHypothesis<T> {
    /// Logarithm of its likelihood over that of noise.
    pub evidence: T,
    /// Order of the carrier, per revolution of the shaft.
    pub order: T,
    /// Modulation of the squared envelope by the harmonics of the carrier: amplitude over the mean, root of the sum of
    /// squares. Firmware that stores it for a machine in good order has a baseline: damage doubles it.
    pub modulation: T,
}

/// Verdict on a bearing.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DamageVerdict<T> {
    /// The damaged component, if one is named.
    pub named: Option<DamagedComponent>,
    /// Probability of the component with the most evidence, against the others and against no damage, 0 to 1; below 0.5 none
    /// is named.
    pub confidence: T,
    /// Hypotheses, in the order of [`DamagedComponent::ALL`].
    pub hypotheses: [DamageHypothesis<T>; 4],
    /// Blocks in the average, at most 8; 0 before the first verdict.
    pub blocks: u32,
}

/// Detector of bearing damage in an acceleration, by families of lines in the envelope of the pre-whitened signal.
///
/// | part | method |
/// | --- | --- |
/// | pre-whitening | error of a linear prediction by 16 samples, learned in the last block |
/// | envelope | its square, averaged over 1/64 revolution |
/// | spectrum | blocks of 64 revolutions under a Hann window: orders to 32 in steps of 1/64; mean of the last 8 blocks |
/// | line | a maximum of 3 times the mean of the noise within 0.75 orders |
/// | hypothesis | 5 harmonics of one carrier with one slip, and side bands, with the logarithms of line over noise |
///
/// One component is named at most: the one with the most evidence, 6 or more, if no family of lines at any other order
/// explains a third more, if its carrier is not made of side bands of a stronger line, and if it modulates the envelope by
/// 25 % or more. Its slip is at most 1.5 %, that of outer race and cage 2.5 %.
///
/// Valid for 128 samples or more in a revolution, at a rate of 10 times the ball-pass frequency of the inner race or more. The
/// shaft angle has to be true within 1 % over a block: that of a keyphasor, an encoder or a synchronous drive, not that of
/// the name plate of an asynchronous motor. While the shaft stands still there is no verdict.
///
/// Cost per sample: 16 times 4 multiplications and additions, and one division. [`close`](Self::close) takes 1.9 million
/// instructions on a Cortex-M4F, once in 64 revolutions; samples that arrive meanwhile may be dropped. Both take a constant
/// number of instructions in `f32`. RAM: 25 kB in `f32`.
///
/// ```
/// use ballrace::bearing::kinematics::orders;
/// use ballrace::twin::DamageDetector;
/// use ballrace::{Exact, Phase};
///
/// let (orders, mut detector) = (orders(9, 0.2, 0.2), DamageDetector::<f32>::new());
/// for i in 0..40_000_u32 {
///     // A machine whose load changes with the shaft, and nothing else.
///     let shaft = Phase::from_revolutions(f64::from(i) / 400.0);
///     if detector.add(shaft.radians().cos() as f32, shaft) {
///         assert_eq!(detector.close::<Exact>(&orders).named, None);
///     }
/// }
/// ```
///
/// Equations: `docs/src/models.md#damage-in-an-acceleration`. Source: Randall and Antoni 2011, Rolling element bearing
/// diagnostics: a tutorial, Mechanical Systems and Signal Processing 25.
#[derive(Debug, Clone, Copy)]
pub struct DamageDetector<T> {
    whitener: Whitener<T>,
    has_learned: bool,
    /// Shaft angle at the last sample.
    shaft: Phase,
    /// Completed share of the block.
    progress: Phase,
    /// Mean of the values of the present step of the angle, and their number.
    mean: T,
    count: T,
    block: Block<T>,
    power: Power<T>,
    blocks: u32,
}

impl<T: Scalar> DamageDetector<T> {
    /// Creates the detector. A `static` of it has nothing but zeros.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            whitener: Whitener::new(),
            has_learned: false,
            shaft: Phase::ZERO,
            progress: Phase::ZERO,
            mean: T::ZERO,
            count: T::ZERO,
            block: Block::new(),
            power: [T::ZERO; BINS],
            blocks: 0,
        }
    }

    /// Adds an acceleration, in any unit, at a shaft angle; returns true where [`close`](Self::close) has a new verdict.
    ///
    /// A reading that is no number spoils its block, not the next one.
    #[inline]
    pub fn add(&mut self, acceleration: T, shaft: Phase) -> bool {
        let (error, is_settled) = self.whitener.add(acceleration);
        let has_begun = Choice::new(is_settled);
        let turned = Phase(shaft.since(self.shaft).0.unsigned_abs() >> TURN_BITS);
        let start = Choice::new(self.has_learned).select_phase(Phase::ZERO, UNSEEN);
        let progress = has_begun.select_phase(self.progress.wrapping_add(turned), start);
        let is_complete = progress.0 < self.progress.0;
        let (number, last) = (Block::<T>::number(progress), Block::<T>::number(self.progress));
        let is_same = Choice::new((number == last) & is_settled);
        self.count = T::ONE + is_same.select(self.count, T::ZERO);
        self.mean = is_same.select(self.mean, T::ZERO);
        self.mean += (error * error - self.mean) / self.count;
        self.block.set(number, self.mean);
        (self.shaft, self.progress) = (shaft, progress);
        is_complete
    }

    /// Ends the block: returns the verdict on it and the blocks before, for a bearing whose outer ring stands still. The first
    /// block only learns.
    pub fn close<M: Math<T>>(&mut self, orders: &Orders) -> DamageVerdict<T> {
        self.whitener.close();
        let mean = self.block.mean();
        let is_valid = self.has_learned & (mean > T::ZERO) & mean.is_finite();
        let counts = Choice::new(is_valid);
        self.blocks = (self.blocks + u32::from(is_valid)).min(AVERAGED);
        let weight = counts.select(T::ONE / T::from_u32(self.blocks.max(1)), T::ZERO);
        for pair in &mut self.block.0 {
            *pair = pair.map(|value| counts.select(value, T::ZERO));
        }
        self.block.transform::<M>(counts.select(T::ONE / counts.select(mean, T::ONE), T::ZERO));
        self.block.average::<M>(&mut self.power, weight);
        let lines = Lines::new::<M>(&self.power, self.blocks, &mut self.block);
        let verdict = verdict::<T, M>(&lines, &Pattern::all(orders), self.blocks);
        // In place: a new block would be made on the stack.
        self.block.0.iter_mut().for_each(|pair| *pair = [T::ZERO; 2]);
        (self.has_learned, self.progress) = (true, Phase::ZERO);
        (self.mean, self.count) = (T::ZERO, T::ZERO);
        verdict
    }
}

impl<T: Scalar> Default for DamageDetector<T> {
    fn default() -> Self {
        Self::new()
    }
}

/// A hypothesis at the slip that fits best.
#[derive(Clone, Copy, Default)]
struct Fit<T> {
    hypothesis: DamageHypothesis<T>,
    /// What the slip takes from the evidence.
    unlikely_slip: T,
    /// Power of the strongest harmonic.
    strongest: T,
}

/// Fits the slip of a pattern.
fn fit<T: Scalar, M: Math<T>>(lines: &Lines<'_, T>, pattern: &Pattern<T>) -> Fit<T> {
    let mut best = DamageHypothesis { evidence: T::from_f64(-1e6), ..DamageHypothesis::default() };
    let mut unlikely_slip = T::ZERO;
    for slip in pattern.slips() {
        let deviations = slip * T::from_f64(1.0 / SLIP_DEVIATION);
        let unlikely = T::HALF * deviations * deviations;
        let order = pattern.order * (T::ONE + slip);
        let evidence = lines.evidence(order, pattern.side_bands()) - unlikely;
        let is_better = Choice::new(evidence > best.evidence);
        best.evidence = is_better.select(evidence, best.evidence);
        best.order = is_better.select(order, best.order);
        unlikely_slip = is_better.select(unlikely, unlikely_slip);
    }
    let [power, strongest] = lines.harmonics(best.order);
    best.modulation = M::sqrt(power);
    Fit { hypothesis: best, unlikely_slip, strongest }
}

/// Compares the hypotheses.
fn verdict<T: Scalar, M: Math<T>>(lines: &Lines<'_, T>, patterns: &[Pattern<T>; 4], blocks: u32) -> DamageVerdict<T> {
    let family = lines.strongest_family() * T::from_f64(OF_STRONGEST_FAMILY);
    let strongest = lines.strongest_pass() * T::from_f64(OF_STRONGEST_LINE * OF_STRONGEST_LINE);
    let least = T::from_f64(LEAST_EVIDENCE);
    let fits = patterns.each_ref().map(|pattern| fit::<T, M>(lines, pattern));
    let hypotheses = fits.map(|fit| fit.hypothesis);
    let is_significant = fits.map(|fit| {
        (fit.hypothesis.evidence >= least)
            & (fit.hypothesis.evidence + fit.unlikely_slip >= family)
            & (fit.strongest >= strongest)
            & (fit.hypothesis.modulation >= T::from_f64(LEAST_MODULATION))
    });
    // Side bands of a strong carrier, taken for a family of their own, are weaker than the carrier.
    let significant = || hypotheses.iter().zip(is_significant);
    let greatest = significant().map(|(h, is)| Choice::new(is).select(h.modulation, T::ZERO)).fold(T::ZERO, T::larger);
    let mut best = DamageHypothesis { evidence: T::ZERO, ..DamageHypothesis::default() };
    let mut number = NOTHING as u32;
    for (i, (h, is_significant)) in (0_u32..).zip(significant()) {
        let is_carrier = greatest <= T::from_f64(STRONGER) * h.modulation;
        let is_better = is_significant & is_carrier & (h.evidence > best.evidence);
        let choice = Choice::new(is_better);
        best.evidence = choice.select(h.evidence, best.evidence);
        best.modulation = choice.select(h.modulation, best.modulation);
        let mask = u32::from(is_better).wrapping_neg();
        number = (i & mask) | (number & !mask);
    }
    // Another component, or nothing of these, as likely as the least evidence.
    let odds = |difference: T| T::ONE / M::powf(T::from_f64(core::f64::consts::E), difference.larger(T::ZERO));
    let mut against = odds(best.evidence - least);
    for (i, h) in (0_u32..).zip(&hypotheses) {
        let rivals = (i != number) & (T::from_f64(STRONGER) * h.modulation >= best.modulation);
        against += Choice::new(rivals).select(odds(best.evidence - h.evidence), T::ZERO);
    }
    // More likely than all others together.
    let is_unlikely = u32::from(against >= T::ONE).wrapping_neg();
    let named = NAMED[((number | is_unlikely) as usize).min(NOTHING)];
    DamageVerdict { named, confidence: T::ONE / (T::ONE + against), hypotheses, blocks }
}
