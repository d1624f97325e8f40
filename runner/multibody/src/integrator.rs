//! Integration with error control: the pair of Dormand and Prince of orders 5 and 4.

/// A system of first-order equations with contacts.
pub trait Motion {
    /// Writes the rates of the state at a time (s), and the approach of each contact, negative with a gap.
    fn rates(&mut self, time: f64, state: &[f64], rates: &mut [f64], approaches: &mut [f64]);

    /// Restores properties of the state that a step changes by its error, such as the length of an orientation.
    fn normalise(&self, state: &mut [f64]);
}

/// Numbers of steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Steps {
    /// Steps taken.
    pub taken: u64,
    /// Steps repeated with a smaller length because of their error.
    pub rejected: u64,
    /// Steps shortened to end where a contact opens or closes.
    pub events: u64,
}

/// Integrator of an adaptive step.
///
/// A step in which a contact opens or closes is repeated once with the interpolated length to the first of these times, unless that is near one
/// of its ends, because the error estimate of a step holds for smooth rates.
/// Source: Dormand and Prince 1980; control of the step by the last two errors after Gustafsson 1991.
#[derive(Debug, Clone)]
pub struct Integrator {
    /// Error that a step may have in each number of the state.
    tolerances: Vec<f64>,
    /// Length of the next step, s.
    step: f64,
    /// Error of the last step over its tolerance.
    last_error: f64,
    /// Rates at the points of a step; the first are those at its start, the last those at its end.
    rates: [Vec<f64>; STAGES],
    /// Approaches at the start, at the end and within a step; the last are not used.
    approaches: [Vec<f64>; 3],
    trial: Vec<f64>,
    steps: Steps,
}

/// Points of a step, of which the last is the first of the next step.
const STAGES: usize = 7;
/// Points after the first, over the step.
const NODES: [f64; STAGES - 1] = [0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];
/// Weights of the earlier rates at these points.
const WEIGHTS: [[f64; STAGES - 1]; STAGES - 1] = [
    [0.2, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19_372.0 / 6_561.0, -25_360.0 / 2_187.0, 64_448.0 / 6_561.0, -212.0 / 729.0, 0.0, 0.0],
    [9_017.0 / 3_168.0, -355.0 / 33.0, 46_732.0 / 5_247.0, 49.0 / 176.0, -5_103.0 / 18_656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1_113.0, 125.0 / 192.0, -2_187.0 / 6_784.0, 11.0 / 84.0],
];
/// Weights of order 5 less those of order 4.
const ERROR_WEIGHTS: [f64; STAGES] =
    [71.0 / 57_600.0, 0.0, -71.0 / 16_695.0, 71.0 / 1_920.0, -17_253.0 / 339_200.0, 22.0 / 525.0, -1.0 / 40.0];

/// First step, s.
const FIRST_STEP: f64 = 1e-8;
/// Shortest step, s: below it the error is that of rounding, and the motion has no result.
const SHORTEST_STEP: f64 = 1e-14;
/// Share of the step, at the start and at the end, in which an event is not located.
const NEAR_END: f64 = 0.05;

impl Integrator {
    /// Creates the integrator for a state with these tolerances and a number of contacts.
    #[must_use]
    pub fn new(tolerances: Vec<f64>, contacts: usize) -> Self {
        let order = tolerances.len();
        Self {
            tolerances,
            step: FIRST_STEP,
            last_error: 1.0,
            rates: std::array::from_fn(|_| vec![0.0; order]),
            approaches: std::array::from_fn(|_| vec![0.0; contacts]),
            trial: vec![0.0; order],
            steps: Steps::default(),
        }
    }

    /// Returns the numbers of steps since the start.
    #[must_use]
    pub const fn steps(&self) -> Steps {
        self.steps
    }

    /// Advances the state from time 0 to `duration`, s. Returns false where no step has a result; the state is then the last one.
    pub fn advance(&mut self, motion: &mut impl Motion, state: &mut [f64], duration: f64) -> bool {
        let mut time = 0.0;
        let [first, ..] = &mut self.rates;
        motion.rates(time, state, first, &mut self.approaches[0]);
        let mut is_located = false;
        while time < duration {
            let left = duration - time;
            let (step, is_last) = if self.step >= left { (left, true) } else { (self.step, false) };
            if step < SHORTEST_STEP && !is_last {
                return false;
            }
            let error = self.attempt(motion, state, time, step);
            if error.is_nan() || error > 1.0 {
                self.steps.rejected += 1;
                let factor = if error.is_finite() { (0.9 * error.powf(-1.0 / 5.0)).max(0.2) } else { 0.1 };
                self.step = step * factor;
                continue;
            }
            if let Some(share) = self.event().filter(|_| !is_located) {
                self.steps.events += 1;
                self.step = step * share;
                is_located = true;
                continue;
            }
            self.accept(motion, state);
            time = if is_last { duration } else { time + step };
            is_located = false;
            let factor = 0.9 * error.max(1e-8).powf(-0.7 / 5.0) * self.last_error.powf(0.4 / 5.0);
            // The last step of a sample is short for no reason of the motion.
            if !is_last || factor < 1.0 {
                self.step = step * factor.clamp(0.2, 4.0);
            }
            self.last_error = error.max(1e-4);
        }
        true
    }

    /// Computes a step into `trial`. Returns its largest error over the tolerance.
    fn attempt(&mut self, motion: &mut impl Motion, state: &[f64], time: f64, step: f64) -> f64 {
        let Self { rates, trial, approaches: [_, end, unread], tolerances, .. } = self;
        for (i, (node, weights)) in NODES.iter().zip(&WEIGHTS).enumerate() {
            let (done, next) = rates.split_at_mut(i + 1);
            trial.copy_from_slice(state);
            for (weight, rates) in weights.iter().zip(done.iter()).filter(|(weight, _)| **weight != 0.0) {
                trial.iter_mut().zip(rates).for_each(|(entry, rate)| *entry += step * weight * rate);
            }
            let approaches = if i + 2 == STAGES { &mut *end } else { &mut *unread };
            motion.rates(time + node * step, trial, &mut next[0], approaches);
        }
        let mut most = 0.0_f64;
        let mut is_finite = true;
        for (i, tolerance) in tolerances.iter().enumerate() {
            let error: f64 = ERROR_WEIGHTS.iter().zip(rates.iter()).map(|(weight, rates)| weight * rates[i]).sum();
            let share = step * error.abs() / tolerance;
            is_finite &= !share.is_nan();
            most = most.max(share);
        }
        if is_finite { most } else { f64::NAN }
    }

    fn accept(&mut self, motion: &impl Motion, state: &mut [f64]) {
        state.copy_from_slice(&self.trial);
        motion.normalise(state);
        self.rates.swap(0, STAGES - 1);
        self.approaches.swap(0, 1);
        self.steps.taken += 1;
    }

    /// Returns the share of the step after which the first contact opens or closes, where that is not near one of its ends.
    fn event(&self) -> Option<f64> {
        let [start, end, _] = &self.approaches;
        let crossing = start.iter().zip(end).filter(|(a, b)| (**a > 0.0) != (**b > 0.0)).map(|(a, b)| a / (a - b));
        crossing.filter(|share| (NEAR_END..=1.0 - NEAR_END).contains(share)).min_by(f64::total_cmp)
    }
}
