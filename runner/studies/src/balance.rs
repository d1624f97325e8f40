//! Masses of a rotor from vibration vectors: influence coefficients from trial runs, and the moments that other runs carry.
//!
//! The once-per-turn vector of probe `p` at a speed is `y_p = B_p + sum_k C_pk u_k + d_p(t) + e`, with the moment `u_k` on each plane, the
//! influence coefficients `C`, the vector `B` of the rotor without added masses, and a drift that moves all probes and speeds
//! together. Trial runs give `B`, `C` and the drift; the moments of a blind run follow by least squares.
//!
//! Coefficients of planes that lie side by side are nearly in proportion, and single moments then known far less than their sum. What a
//! run carries is one of all choices of loaded planes, each as likely before as any other and with moments of the size of the trial
//! masses: an estimate and its interval are those of all choices together, weighted by their evidence. An empty plane so gets an interval
//! from 0.
//!
//! The twin of a machine has coefficients of its own, with the uncertainty of its parameters. They stand for trials that were not made,
//! and beside those that were: what is known of the coefficients before the trials.
//!
//! Source of influence coefficients: ISO 21940-12; of the evidence of choices: MacKay, Information Theory, Inference, and Learning
//! Algorithms, chapter 28.

mod agreement;
mod correction;
mod drift;
mod moments;
mod plane;
mod quality;
pub mod table;
mod twin;

pub use agreement::Agreement;
use ballrace_base::parallel;
pub use correction::{Correction, HoleMass, Holes, Placement, PlaneCorrection, Predicted};
use drift::{Drift, Observation, Solution};
pub use moments::MomentEstimate;
use nalgebra::{DMatrix, DVector};
pub use plane::{MassesError, Plane, masses};
pub use quality::{PlaneQuality, Quality, Requirement, TolerancePlane};
use serde::Serialize;
use table::{C, Record, VectorTable};
use twin::flat;
pub use twin::{TwinCoefficients, radial_probes};

/// Runs that differ by less in speed are of one speed.
pub const SAME_SPEED: f64 = 0.03;
/// Steps of the search of moments and coefficients together, and the change of a moment over the trial moments at which it ends.
const STEPS: (usize, f64) = (30, 1e-9);
/// Logarithm of the likelihood ratio from which the angles are taken to be counted the other way: odds of 1000.
const MIRRORED: f64 = 7.0;
/// Times of a drift that are tried, over the time from the first to the last run.
const DRIFT_TIMES: [f64; 7] = [0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0];

/// Error of an estimate from vectors.
#[derive(Debug, thiserror::Error)]
pub enum BalanceError {
    /// There are too few runs with known masses.
    #[error(
        "{found} conditions with known masses, expected at least {least}: a baseline and one trial for each of the {planes} planes"
    )]
    Few {
        /// Conditions found.
        found: usize,
        /// Least number.
        least: usize,
        /// Planes.
        planes: usize,
    },
    /// The trials do not tell the planes apart.
    #[error(
        "the trial masses do not tell the planes apart at {speed:.0} rpm, expected trials on each plane alone or in different proportions"
    )]
    Dependent {
        /// Speed, rpm.
        speed: f64,
    },
    /// No trial moves the probes by more than the errors of the vectors.
    #[error(
        "the trial masses change no probe by more than its scatter, expected larger masses, or planes and probes of this rotor"
    )]
    NoResponse,
    /// The response turns against the masses.
    #[error(
        "the vectors turn against the masses: with the angles of all masses counted the other way, the trials fit far better, expected angles of masses and vectors in one direction (a phase lag grows with the angle of the mass against rotation)"
    )]
    Mirrored,
    /// A blind run has a speed without trials.
    #[error("condition {condition}: no trial at {speed:.0} rpm, expected trials at the speeds of the blind runs")]
    Speed {
        /// Condition.
        condition: String,
        /// Speed, rpm.
        speed: f64,
    },
    /// Trials and twin do not agree, and there are too few trials without it.
    #[error(
        "the vectors are {misfit:.1} times as far from the coefficients of the twin as its errors and those of the vectors allow, expected a scene of \
         this machine, the right masses and angles, or a trial for each plane"
    )]
    Twin {
        /// Chi-squared over its largest value.
        misfit: f64,
    },
    /// Two planes are exchanged.
    #[error(
        "planes {first} and {second} look exchanged: with the masses of each in the other the vectors agree with the twin, expected the planes in which the masses were"
    )]
    Planes {
        /// A plane.
        first: String,
        /// The other.
        second: String,
    },
    /// A trial has the vectors of a run without masses.
    #[error(
        "{condition}: the vectors are those without added masses, expected the recording of the trial, or larger masses"
    )]
    Unmoved {
        /// Condition.
        condition: String,
    },
    /// Two probes are exchanged.
    #[error("{}: probes {first} and {second} look exchanged: with each in the place of the other the vectors agree with the twin, expected the columns of the scene", if condition.is_empty() { "all runs" } else { condition })]
    Exchanged {
        /// Condition; empty for all.
        condition: String,
        /// A probe.
        first: String,
        /// The other.
        second: String,
    },
}

/// A channel of the vectors: probe and speed.
#[derive(Debug, Clone, Serialize)]
pub struct Influence {
    /// Probe.
    pub probe: String,
    /// Mean speed of the runs, rpm.
    pub speed_rpm: f64,
    /// Vector without added masses: size and angle in degrees.
    pub baseline: [f64; 2],
    /// Influence coefficient of each plane per g mm: size, angle in degrees and standard deviation.
    pub coefficients: Vec<[f64; 3]>,
    /// Standard deviation of the drift, and of the error of a run.
    pub drift: f64,
    /// The same of the error of a run beside the drift.
    pub error: f64,
}

/// Moments that a condition carries.
#[derive(Debug, Clone, Serialize)]
pub struct Condition {
    /// Name.
    pub condition: String,
    /// Moment on each plane.
    pub planes: Vec<MomentEstimate>,
    /// Vectors of the runs that the moments leave, over the standard deviation expected of them: about 1 where all is as modelled.
    pub misfit: f64,
}

/// How well each known condition is estimated from the others.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Proof {
    /// Moments estimated.
    pub moments: usize,
    /// Mean error of their size, g mm.
    pub mean_error_g_mm: f64,
    /// Largest error of their size, g mm.
    pub largest_error_g_mm: f64,
    /// Mean error of the angle of the moments that are not 0, degrees.
    pub mean_angle_error_deg: f64,
    /// Intervals of the size that hold the true moment.
    pub inside: usize,
}

/// Result of an estimate.
#[derive(Debug, Clone, Serialize)]
pub struct Balance {
    /// Names of the planes.
    pub planes: Vec<String>,
    /// Unit of the vectors.
    pub unit: String,
    /// Influence coefficients, by speed and probe.
    pub influence: Vec<Influence>,
    /// Largest over least singular value of the coefficients in units of their errors: how far the planes lie apart.
    pub condition_number: f64,
    /// Time within which the drift is lost, s; `None` where the runs have no times.
    pub drift_time_s: Option<f64>,
    /// Moments of the blind conditions, in the order of the table.
    pub conditions: Vec<Condition>,
    /// Each known condition estimated from the others.
    pub proof: Proof,
    /// Correction of the rotor without added masses.
    pub correction: Correction,
    /// Agreement of the vectors with the coefficients of the twin; `None` without a twin.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub twin: Option<Agreement>,
    /// Balance quality before and after the correction; `None` where none is asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quality: Option<Quality>,
}

/// Coefficients with their covariance.
struct Vectors<'a> {
    runs: &'a Runs,
    planes: &'a [String],
    probes: &'a [String],
    drift: &'a Drift,
    solution: Solution,
    /// Usual moment: mean square of the trial moments; without trials, of the moment that moves the probes as the rotor does.
    usual: f64,
}

impl<'a> Vectors<'a> {
    fn new(runs: &'a Runs, table: &'a VectorTable, drift: &'a Drift, solution: Solution) -> Self {
        let mut vectors =
            Self { runs, planes: &table.planes, probes: &table.probes, drift, solution, usual: runs.usual };
        if vectors.usual == 0.0 {
            vectors.usual = 1.0;
            let of_baseline: f64 =
                (0..vectors.channels()).map(|c| vectors.baseline(c).norm_sqr() / vectors.noise(c)).sum();
            let largest = vectors.weighted().singular_values().max();
            vectors.usual = of_baseline / (largest * largest).max(f64::MIN_POSITIVE);
        }
        vectors
    }

    fn channels(&self) -> usize {
        self.runs.channels()
    }

    fn probe(&self, channel: usize) -> &str {
        &self.probes[channel % self.runs.probes]
    }

    fn speed(&self, channel: usize) -> f64 {
        self.runs.speeds[channel / self.runs.probes]
    }

    /// Returns the vector of a channel without added masses.
    fn baseline(&self, channel: usize) -> C {
        self.solution.theta[self.runs.column(channel, 0)]
    }

    /// Returns the influence coefficient of plane `k`, per g mm.
    fn coefficient(&self, channel: usize, k: usize) -> C {
        self.solution.theta[self.runs.column(channel, 1 + k)]
    }

    /// Returns the standard deviation of a coefficient.
    fn deviation(&self, channel: usize, k: usize) -> f64 {
        let at = self.runs.column(channel, 1 + k);
        self.solution.covariance[(at, at)].re.max(0.0).sqrt()
    }

    /// Returns the variance of the vector of a channel by drift and error.
    fn noise(&self, channel: usize) -> f64 {
        (self.drift.covariance[(channel, channel)].re + self.drift.variance[channel]).max(f64::MIN_POSITIVE)
    }

    /// Returns the coefficients with the usual moment in units of drift and error.
    fn weighted(&self) -> DMatrix<C> {
        DMatrix::from_fn(self.channels(), self.planes.len(), |channel, k| {
            self.coefficient(channel, k) * C::new((self.usual / self.noise(channel)).sqrt(), 0.0)
        })
    }

    /// Returns the squares that moments on the planes leave of the vectors without added masses, over their largest sum by errors alone;
    /// `None` where the planes explain any vectors.
    fn unexplained(&self, moments: &[C]) -> Option<f64> {
        let (channels, planes) = (self.channels(), self.planes.len());
        let spare = channels.checked_sub(planes).filter(|spare| *spare > 0)?;
        let factors = self.errors(moments).cholesky()?;
        let baseline = DVector::from_fn(channels, |channel, _| self.baseline(channel));
        let matrix = DMatrix::from_fn(channels, planes, |channel, k| self.coefficient(channel, k));
        let (weighted, of_baseline) = (factors.solve(&matrix), factors.solve(&baseline));
        let least = (matrix.adjoint() * weighted).cholesky()?.solve(&(matrix.adjoint() * &of_baseline));
        let left = baseline - matrix * least;
        Some(agreement::over_largest(left.dotc(&factors.solve(&left)).re, spare))
    }

    /// Returns the covariance of the vectors with these moments: by the coefficients, by the drift and by the error of a run.
    fn errors(&self, moments: &[C]) -> DMatrix<C> {
        let channels = self.channels();
        let mut design = DMatrix::<C>::zeros(channels, self.runs.coefficients());
        for channel in 0..channels {
            design[(channel, self.runs.column(channel, 0))] = C::new(1.0, 0.0);
            for (k, moment) in moments.iter().enumerate() {
                design[(channel, self.runs.column(channel, 1 + k))] = *moment;
            }
        }
        let mut sum = &design * &self.solution.covariance * design.adjoint() + &self.drift.covariance;
        for (channel, variance) in self.drift.variance.iter().enumerate() {
            sum[(channel, channel)] += C::new(*variance, 0.0);
        }
        sum
    }
}

/// Runs of one condition at one speed.
#[derive(Debug, Clone)]
struct Run {
    condition: usize,
    speed: usize,
    time: f64,
    count: usize,
    response: DVector<C>,
    moments: Option<Vec<C>>,
}

/// Runs of a table, in the order of time.
struct Runs {
    all: Vec<Run>,
    conditions: Vec<String>,
    /// Mean of each speed, rpm.
    speeds: Vec<f64>,
    probes: usize,
    planes: usize,
    /// Variance of one record about the mean of its run, by channel.
    repeat: Vec<f64>,
    has_times: bool,
    /// Mean square of the trial moments that are not 0.
    usual: f64,
    /// Squares by which the coefficients of a twin enter the estimate.
    prior: Option<DMatrix<C>>,
}

impl Runs {
    fn new(table: &VectorTable) -> Self {
        let (of_record, speeds) = table.speeds();
        let mut conditions: Vec<String> = vec![];
        let probes = table.probes.len();
        let mut groups: Vec<(Run, Vec<&Record>)> = vec![];
        for (record, &speed) in table.records.iter().zip(&of_record) {
            let condition = conditions.iter().position(|name| *name == record.condition).unwrap_or_else(|| {
                conditions.push(record.condition.clone());
                conditions.len() - 1
            });
            let of_run = |(run, _): &&mut (Run, Vec<&Record>)| run.condition == condition && run.speed == speed;
            if let Some((_, records)) = groups.iter_mut().find(of_run) {
                records.push(record);
            } else {
                let run = Run {
                    condition,
                    speed,
                    time: 0.0,
                    count: 0,
                    response: DVector::zeros(probes),
                    moments: record.moments.clone(),
                };
                groups.push((run, vec![record]));
            }
        }
        let has_times = table.has_times();
        let mut squares = vec![(0.0, 0usize); probes * speeds.len()];
        let finished = |(mut run, records): (Run, Vec<&Record>)| {
            run.count = records.len();
            let n = C::new(run.count as f64, 0.0);
            for record in &records {
                run.response += DVector::from_column_slice(&record.response) / n;
            }
            run.time = if has_times {
                records.iter().filter_map(|record| record.time).sum::<f64>() / run.count as f64
            } else {
                run.condition as f64
            };
            for p in 0..probes {
                let (sum, count) = &mut squares[run.speed * probes + p];
                *sum += records.iter().map(|record| (record.response[p] - run.response[p]).norm_sqr()).sum::<f64>();
                *count += run.count - 1;
            }
            run
        };
        let mut all: Vec<Run> = groups.into_iter().map(finished).collect();
        all.sort_by(|a, b| a.time.total_cmp(&b.time));
        let moments = all.iter().filter_map(|run| run.moments.as_ref()).flatten().filter(|u| u.norm_sqr() > 0.0);
        let (sum, count) = moments.fold((0.0, 0), |(sum, count), u| (sum + u.norm_sqr(), count + 1));
        Self {
            conditions,
            speeds,
            probes,
            planes: table.planes.len(),
            repeat: squares.into_iter().map(|(sum, count)| sum / count.max(1) as f64).collect(),
            has_times,
            usual: sum / f64::from(count.max(1)),
            prior: None,
            all,
        }
    }

    fn channels(&self) -> usize {
        self.probes * self.speeds.len()
    }

    /// Returns the number of known runs at the speed that has fewest.
    fn known(&self) -> usize {
        let at = |speed| self.all.iter().filter(|run| run.speed == speed && run.moments.is_some()).count();
        (0..self.speeds.len()).map(at).min().unwrap_or_default()
    }

    /// Columns of the coefficients: of each channel the baseline and each plane.
    fn coefficients(&self) -> usize {
        self.channels() * (1 + self.planes)
    }

    /// Column of a channel: 0 the baseline, then the planes.
    fn column(&self, channel: usize, of: usize) -> usize {
        channel * (1 + self.planes) + of
    }

    /// Returns a run as an observation of the coefficients, with `further` columns after them.
    fn observation(&self, run: &Run, moments: &[C], further: usize) -> Observation {
        let first = run.speed * self.probes;
        let mut design = DMatrix::zeros(self.probes, self.coefficients() + further);
        for p in 0..self.probes {
            design[(p, self.column(first + p, 0))] = C::new(1.0, 0.0);
            for (k, moment) in moments.iter().enumerate() {
                design[(p, self.column(first + p, 1 + k))] = *moment;
            }
        }
        Observation { time: run.time, first, response: run.response.clone(), count: run.count, design }
    }

    /// Returns the times of a drift that are tried, s. Without times each condition has a drift of its own.
    fn drift_times(&self) -> Vec<f64> {
        let span = match self.all.as_slice() {
            [first, .., last] if self.has_times => last.time - first.time,
            _ => 0.0,
        };
        if span > 0.0 { DRIFT_TIMES.iter().map(|share| share * span).collect() } else { vec![f64::MIN_POSITIVE] }
    }

    /// Finds drift and coefficients from the known conditions, with one of `times` for the drift. Where trials determine the coefficients,
    /// the drift comes from them alone: an error of the twin is no drift.
    fn learned(&self, times: &[f64]) -> Option<(Drift, Solution)> {
        let known = self.all.iter().filter_map(|run| Some(self.observation(run, run.moments.as_deref()?, 0)));
        let known: Vec<Observation> = known.collect();
        let Some(prior) = &self.prior else { return Drift::estimated(&known, &self.repeat, times) };
        if determined(self).is_err() {
            return Drift::usual(&known, &self.repeat, prior.clone());
        }
        let (drift, _) = Drift::estimated(&known, &self.repeat, times)?;
        let drift = Drift { prior: Some(prior.clone()), ..drift };
        let solution = drift.solve(&known)?;
        Some((drift, solution))
    }

    /// Returns the runs with what a twin knows of the coefficients; `None` if its covariance has no inverse.
    fn with_twin(&self, twin: &TwinCoefficients) -> Option<Self> {
        let precision = twin.covariance.clone().cholesky()?.inverse();
        let mean = flat(&twin.mean);
        let weighted = &precision * &mean;
        let size = 1 + self.coefficients();
        let mut squares = DMatrix::zeros(size, size);
        squares[(0, 0)] = mean.dotc(&weighted);
        let column = |i: usize| 1 + self.column(i / self.planes, 1 + i % self.planes);
        for i in 0..mean.len() {
            squares[(column(i), 0)] = weighted[i];
            squares[(0, column(i))] = weighted[i].conj();
            for j in 0..mean.len() {
                squares[(column(i), column(j))] = precision[(i, j)];
            }
        }
        Some(Self { prior: Some(squares), ..self.with(self.all.clone()) })
    }

    /// Returns the runs with the angles of all masses counted the other way.
    fn mirrored(&self) -> Self {
        self.with_moments(|_, moments| moments.iter_mut().for_each(|moment| *moment = moment.conj()))
    }

    /// Returns the runs with other masses: `change` has the condition and its moments.
    fn with_moments(&self, change: impl Fn(usize, &mut [C])) -> Self {
        let changed = |run: &Run| {
            let mut run = run.clone();
            run.moments.iter_mut().for_each(|moments| change(run.condition, moments));
            run
        };
        self.with(self.all.iter().map(changed).collect())
    }

    /// Returns other runs of the same machine.
    fn with(&self, all: Vec<Run>) -> Self {
        Self {
            all,
            conditions: self.conditions.clone(),
            speeds: self.speeds.clone(),
            repeat: self.repeat.clone(),
            prior: self.prior.clone(),
            ..*self
        }
    }

    /// Estimates the moments of a condition from the known ones and its own runs: one that no masses explain spoils no other.
    fn moments(&self, drift: &Drift, known: &DVector<C>, asked: usize) -> Option<Condition> {
        let used: Vec<&Run> = self.all.iter().filter(|run| run.condition == asked || run.moments.is_some()).collect();
        let mut moments = vec![C::new(0.0, 0.0); self.planes];
        let mut theta = known.clone();
        let mut solution = None;
        for _ in 0..STEPS.0 {
            // About the coefficients and moments of the step before: y = B + C u + u' dC + C' du.
            let observed = used.iter().map(|run| {
                if run.condition != asked {
                    return self.observation(run, run.moments.as_deref().unwrap_or_default(), self.planes);
                }
                let mut of = self.observation(run, &moments, self.planes);
                for p in 0..self.probes {
                    for (k, moment) in moments.iter().enumerate() {
                        let coefficient = theta[self.column(of.first + p, 1 + k)];
                        of.design[(p, self.coefficients() + k)] = coefficient;
                        of.response[p] += coefficient * moment;
                    }
                }
                of
            });
            let next = drift.solve(&observed.collect::<Vec<Observation>>())?;
            let mut change = 0.0_f64;
            for (moment, new) in moments.iter_mut().zip(next.theta.iter().skip(self.coefficients())) {
                change = change.max((new - *moment).norm());
                *moment = *new;
            }
            theta = next.theta.rows(0, self.coefficients()).into_owned();
            solution = Some(next);
            if change < STEPS.1 * self.usual.sqrt() {
                break;
            }
        }
        let solution = solution?;
        let wider = few_values(self.known(), self.planes);
        let at = self.coefficients();
        let covariance = solution.covariance.view((at, at), (self.planes, self.planes)) * C::new(wider * wider, 0.0);
        Some(Condition {
            condition: self.conditions[asked].clone(),
            planes: moments::estimates(&DVector::from_column_slice(&moments), &covariance, self.usual)?,
            misfit: self.misfit(drift, known, &moments, asked),
        })
    }

    /// Returns the rms of the vectors of a condition that moments leave, over that expected by drift and error.
    fn misfit(&self, drift: &Drift, theta: &DVector<C>, moments: &[C], condition: usize) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for run in self.all.iter().filter(|run| run.condition == condition) {
            let of = self.observation(run, moments, 0);
            let fitted = &of.design * theta;
            for p in 0..self.probes {
                let channel = of.first + p;
                let expected =
                    drift.covariance[(channel, channel)].re + drift.variance[channel] + drift.repeat[channel];
                sum += (of.response[p] - fitted[p]).norm_sqr() / expected.max(f64::MIN_POSITIVE);
                count += 1;
            }
        }
        (sum / f64::from(count.max(1))).sqrt()
    }

    /// Estimates each known condition from the others.
    fn proof(&self, time: f64) -> Proof {
        let known: Vec<(usize, Vec<C>)> = {
            let of = |condition: usize| {
                let run = self.all.iter().find(|run| run.condition == condition)?;
                Some((condition, run.moments.clone()?))
            };
            (0..self.conditions.len()).filter_map(of).collect()
        };
        let estimated = |(condition, truth): &(usize, Vec<C>)| {
            let asked = |run: &Run| {
                if run.condition == *condition { Run { moments: None, ..run.clone() } } else { run.clone() }
            };
            let others = self.with(self.all.iter().map(asked).collect());
            if others.known() < if self.prior.is_some() { 1 } else { self.planes + 2 } {
                return None;
            }
            let (drift, solution) = others.learned(&[time])?;
            let found = others.moments(&drift, &solution.theta, *condition)?;
            Some((truth.clone(), found))
        };
        let mut proof = Proof::default();
        let (mut errors, mut angles) = (vec![], vec![]);
        for (truth, found) in parallel::map(&known, estimated).into_iter().flatten() {
            for (truth, found) in truth.iter().zip(&found.planes) {
                errors.push((found.moment_g_mm - truth.norm()).abs());
                proof.inside += usize::from((found.moment_low..=found.moment_high).contains(&truth.norm()));
                if truth.norm_sqr() > 0.0 {
                    let turn = C::from_polar(1.0, found.angle_deg.to_radians()) / truth;
                    angles.push(turn.arg().to_degrees().abs());
                }
            }
        }
        let mean = |of: &[f64]| (of.iter().sum::<f64>() + 0.0) / of.len().max(1) as f64;
        proof.moments = errors.len();
        proof.mean_error_g_mm = mean(&errors);
        proof.largest_error_g_mm = errors.iter().copied().fold(0.0, f64::max);
        proof.mean_angle_error_deg = mean(&angles);
        proof
    }
}

/// Estimates influence coefficients, the moments of the blind conditions of a table, and the correction of the rotor without added masses.
/// `twin` has the coefficients of a scene for the planes, probes and speeds of the table.
///
/// # Errors
/// Returns an error if trials and twin do not determine the coefficients of every plane at every speed, or do not agree.
pub fn balance(
    table: &VectorTable,
    twin: Option<&TwinCoefficients>,
    placement: &Placement,
) -> Result<Balance, BalanceError> {
    let mut runs = Runs::new(table);
    let is_determined = determined(&runs);
    if twin.is_none() {
        is_determined?;
    } else if is_determined.is_ok() {
        agreement::response(&runs, table)?;
    }
    let agreement = twin.map(|twin| runs.agreement(table, twin)).transpose()?;
    if let (Some(twin), Some(Agreement { used: true, .. })) = (twin, agreement) {
        let singular = || BalanceError::Dependent { speed: runs.speeds.first().copied().unwrap_or_default() };
        runs = runs.with_twin(twin).ok_or_else(singular)?;
    }
    let dependent = || BalanceError::Dependent { speed: runs.speeds.first().copied().unwrap_or_default() };
    let (drift, solution) = runs.learned(&runs.drift_times()).ok_or_else(dependent)?;
    let theta = solution.theta.clone();
    let mirrored = runs.mirrored().learned(&[drift.time]);
    if mirrored.is_some_and(|(_, other)| other.log_likelihood > solution.log_likelihood + MIRRORED) {
        return Err(BalanceError::Mirrored);
    }
    let vectors = Vectors::new(&runs, table, &drift, solution);
    let singular = vectors.weighted().singular_values();
    if singular.max() < correction::OBSERVED {
        return Err(BalanceError::NoResponse);
    }
    let polar = |x: C| [x.norm(), x.arg().to_degrees().rem_euclid(360.0)];
    let influence = |channel: usize| Influence {
        probe: vectors.probe(channel).to_owned(),
        speed_rpm: vectors.speed(channel),
        baseline: polar(vectors.baseline(channel)),
        coefficients: (0..runs.planes)
            .map(|k| {
                let [size, angle] = polar(vectors.coefficient(channel, k));
                [size, angle, vectors.deviation(channel, k)]
            })
            .collect(),
        drift: drift.covariance[(channel, channel)].re.sqrt(),
        error: drift.variance[channel].sqrt(),
    };
    let is_blind = |condition: &usize| runs.all.iter().any(|run| run.condition == *condition && run.moments.is_none());
    let blind: Vec<usize> = (0..runs.conditions.len()).filter(is_blind).collect();
    let conditions = parallel::map(&blind, |condition| runs.moments(&drift, &theta, *condition));
    Ok(Balance {
        planes: table.planes.clone(),
        unit: table.unit.clone(),
        influence: (0..runs.channels()).map(influence).collect(),
        condition_number: singular.max() / singular.min().max(f64::MIN_POSITIVE),
        drift_time_s: runs.has_times.then_some(drift.time),
        conditions: conditions.into_iter().collect::<Option<_>>().ok_or_else(dependent)?,
        proof: runs.proof(drift.time),
        correction: correction::correction(&vectors, placement).ok_or_else(dependent)?,
        twin: agreement,
        quality: None,
    })
}

/// Returns how much wider an interval of 95 % is where its deviation comes from few runs: Student's t over the normal value, for two
/// degrees of freedom (real and imaginary part) a run beyond the coefficients.
///
/// Source: expansion of Fisher and Cornish, Abramowitz and Stegun 26.7.5.
fn few_values(known: usize, planes: usize) -> f64 {
    const Z: f64 = 1.959_964;
    let n = 2.0 * known.saturating_sub(1 + planes).max(1) as f64;
    let (z3, z5, z7) = (Z.powi(3), Z.powi(5), Z.powi(7));
    let t = Z
        + (z3 + Z) / (4.0 * n)
        + (5.0 * z5 + 16.0 * z3 + 3.0 * Z) / (96.0 * n * n)
        + (3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * Z) / (384.0 * n * n * n);
    t / Z
}

/// Checks that the known conditions determine every coefficient.
fn determined(runs: &Runs) -> Result<(), BalanceError> {
    let least = runs.planes + 1;
    for (speed, mean) in runs.speeds.iter().enumerate() {
        let known: Vec<&Vec<C>> =
            runs.all.iter().filter(|run| run.speed == speed).filter_map(|run| run.moments.as_ref()).collect();
        if known.is_empty() {
            let blind = runs.all.iter().find(|run| run.speed == speed);
            let condition = blind.map_or(String::new(), |run| runs.conditions[run.condition].clone());
            return Err(BalanceError::Speed { condition, speed: *mean });
        }
        if known.len() < least {
            return Err(BalanceError::Few { found: known.len(), least, planes: runs.planes });
        }
        let scale = runs.usual.sqrt().max(f64::MIN_POSITIVE);
        let design = DMatrix::from_fn(known.len(), 1 + runs.planes, |i, k| match k {
            0 => C::new(1.0, 0.0),
            _ => known[i][k - 1] / C::new(scale, 0.0),
        });
        let singular = design.singular_values();
        if singular.min() < 1e-3 * singular.max() {
            return Err(BalanceError::Dependent { speed: *mean });
        }
    }
    Ok(())
}
