//! Runs of a table as observations of the influence coefficients, and what the known ones determine.

use super::drift::{Drift, Observation, Solution};
use super::error::BalanceError;
use super::moments::MASS_ERROR;
use super::table::{C, Record, Set, VectorTable};
use super::twin::{TwinCoefficients, flat};
use nalgebra::{DMatrix, DVector};

/// Times of a drift that are tried, over the time from the first to the last run.
const DRIFT_TIMES: [f64; 7] = [0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0];

/// Runs of one condition at one speed.
#[derive(Debug, Clone)]
pub(super) struct Run {
    pub(super) condition: usize,
    pub(super) speed: usize,
    pub(super) time: f64,
    pub(super) count: usize,
    pub(super) response: DVector<C>,
    pub(super) moments: Option<Vec<C>>,
    /// Covariance of its vectors by the errors of masses that stay mounted.
    pub(super) by_masses: Option<DMatrix<C>>,
}

/// Runs of a table, in the order of time.
pub(super) struct Runs {
    pub(super) all: Vec<Run>,
    pub(super) conditions: Vec<String>,
    /// Mean of each speed, rpm.
    pub(super) speeds: Vec<f64>,
    pub(super) probes: usize,
    pub(super) planes: usize,
    /// Variance of one record about the mean of its run, by channel.
    pub(super) repeat: Vec<f64>,
    pub(super) has_times: bool,
    /// Mean square of the trial moments that are not 0.
    pub(super) usual: f64,
    /// Conditions of the trim runs in the order of time: the masses of the last one stay mounted.
    pub(super) trims: Vec<usize>,
    /// Squares by which the coefficients of a twin enter the estimate.
    pub(super) prior: Option<DMatrix<C>>,
}

impl Runs {
    pub(super) fn new(table: &VectorTable) -> Self {
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
                    by_masses: None,
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
        let is_trim = |condition: usize| {
            let mut records = table.records.iter().filter(|record| record.condition == conditions[condition]);
            records.any(|record| record.set == Set::Trim)
        };
        // Without times conditions are in the order of the table.
        let mut trims: Vec<usize> = all.iter().map(|run| run.condition).filter(|of| is_trim(*of)).collect();
        trims.dedup();
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
            trims,
            prior: None,
            all,
        }
    }

    pub(super) fn channels(&self) -> usize {
        self.probes * self.speeds.len()
    }

    /// Returns the number of known runs at the speed that has fewest.
    pub(super) fn known(&self) -> usize {
        let at = |speed| self.all.iter().filter(|run| run.speed == speed && run.moments.is_some()).count();
        (0..self.speeds.len()).map(at).min().unwrap_or_default()
    }

    /// Returns the moments that stay mounted: those of the last trim run, else none.
    pub(super) fn mounted(&self) -> Vec<C> {
        let moments = self.last_trim().next().and_then(|run| run.moments.clone());
        moments.unwrap_or_else(|| vec![C::new(0.0, 0.0); self.planes])
    }

    /// Returns the runs of the last trim condition.
    pub(super) fn last_trim(&self) -> impl Iterator<Item = &Run> {
        self.all.iter().filter(|run| Some(&run.condition) == self.trims.last())
    }

    /// Returns the runs, with the errors of mounted masses as errors of the vectors of each trim run: coefficients from `theta`.
    pub(super) fn with_errors_of_masses(&self, theta: &DVector<C>) -> Self {
        let changed = |run: &Run| {
            let mut run = run.clone();
            if let Some(moments) = run.moments.as_ref().filter(|_| self.trims.contains(&run.condition)) {
                let of = |p: usize, k: usize| {
                    theta[self.column(run.speed * self.probes + p, 1 + k)] * (MASS_ERROR * moments[k].norm())
                };
                let moved = DMatrix::from_fn(self.probes, self.planes, of);
                run.by_masses = Some(&moved * moved.adjoint());
            }
            run
        };
        self.with(self.all.iter().map(changed).collect())
    }

    /// Columns of the coefficients: of each channel the baseline and each plane.
    pub(super) fn coefficients(&self) -> usize {
        self.channels() * (1 + self.planes)
    }

    /// Column of a channel: 0 the baseline, then the planes.
    pub(super) fn column(&self, channel: usize, of: usize) -> usize {
        channel * (1 + self.planes) + of
    }

    /// Returns a run as an observation of the coefficients, with `further` columns after them.
    pub(super) fn observation(&self, run: &Run, moments: &[C], further: usize) -> Observation {
        let first = run.speed * self.probes;
        let mut design = DMatrix::zeros(self.probes, self.coefficients() + further);
        for p in 0..self.probes {
            design[(p, self.column(first + p, 0))] = C::new(1.0, 0.0);
            for (k, moment) in moments.iter().enumerate() {
                design[(p, self.column(first + p, 1 + k))] = *moment;
            }
        }
        Observation {
            time: run.time,
            first,
            response: run.response.clone(),
            count: run.count,
            design,
            by_masses: run.by_masses.clone(),
        }
    }

    /// Returns the times of a drift that are tried, s. Without times each condition has a drift of its own.
    pub(super) fn drift_times(&self) -> Vec<f64> {
        let span = match self.all.as_slice() {
            [first, .., last] if self.has_times => last.time - first.time,
            _ => 0.0,
        };
        if span > 0.0 { DRIFT_TIMES.iter().map(|share| share * span).collect() } else { vec![f64::MIN_POSITIVE] }
    }

    /// Finds drift and coefficients from the known conditions, with one of `times` for the drift. Where trials determine the coefficients,
    /// the drift comes from them alone: an error of the twin is no drift.
    pub(super) fn learned(&self, times: &[f64]) -> Option<(Drift, Solution)> {
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
    pub(super) fn with_twin(&self, twin: &TwinCoefficients) -> Option<Self> {
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
    pub(super) fn mirrored(&self) -> Self {
        self.with_moments(|_, moments| moments.iter_mut().for_each(|moment| *moment = moment.conj()))
    }

    /// Returns the runs with other masses: `change` has the condition and its moments.
    pub(super) fn with_moments(&self, change: impl Fn(usize, &mut [C])) -> Self {
        let changed = |run: &Run| {
            let mut run = run.clone();
            run.moments.iter_mut().for_each(|moments| change(run.condition, moments));
            run
        };
        self.with(self.all.iter().map(changed).collect())
    }

    /// Returns other runs of the same machine.
    pub(super) fn with(&self, all: Vec<Run>) -> Self {
        Self {
            all,
            conditions: self.conditions.clone(),
            speeds: self.speeds.clone(),
            repeat: self.repeat.clone(),
            trims: self.trims.clone(),
            prior: self.prior.clone(),
            ..*self
        }
    }
}

/// Checks that the known conditions determine every coefficient.
pub(super) fn determined(runs: &Runs) -> Result<(), BalanceError> {
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
