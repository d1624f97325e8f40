//! Trim runs: the vectors with the masses that are mounted, against what the other runs expect of them, and the probable error where they
//! are not those of the stated masses.

use super::correction::degrees;
use super::error::BalanceError;
use super::runs::{Run, Runs, determined};
use super::table::{C, VectorTable};
use super::vectors::{Vectors, over_largest};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

/// Vector of a trim run at a probe.
#[derive(Debug, Clone, Serialize)]
pub struct TrimVector {
    /// Probe.
    pub probe: String,
    /// Speed, rpm.
    pub speed_rpm: f64,
    /// Measured vector: size and angle in degrees.
    pub measured: [f64; 2],
    /// Vector that the other runs expect with the mounted masses: size, angle in degrees and standard deviation; `None` where they do not determine
    /// it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected: Option<[f64; 3]>,
}

/// Last trim run.
#[derive(Debug, Clone, Serialize)]
pub struct Trim {
    /// Condition.
    pub condition: String,
    /// Mounted moment of each plane: size in g mm and angle in degrees.
    pub mounted: Vec<[f64; 2]>,
    /// Its vectors.
    pub vectors: Vec<TrimVector>,
    /// Chi-squared of the vectors less the expected ones over its largest value by errors alone: above 1 they disagree; `None` where the other
    /// runs do not tell.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub misfit: Option<f64>,
}

/// Runs of one condition as one vector of their channels.
struct Measured {
    channels: Vec<usize>,
    response: Vec<C>,
    /// Variance by the records of each mean.
    repeat: Vec<f64>,
}

impl Measured {
    fn new(runs: &Runs, condition: usize) -> Self {
        let mut of = Self { channels: vec![], response: vec![], repeat: vec![] };
        for run in runs.all.iter().filter(|run| run.condition == condition) {
            for probe in 0..runs.probes {
                let channel = run.speed * runs.probes + probe;
                of.channels.push(channel);
                of.response.push(run.response[probe]);
                of.repeat.push(runs.repeat[channel] / run.count as f64);
            }
        }
        of
    }

    /// Returns the vectors that are expected with moments, and chi-squared of the measured ones over its largest value by errors alone.
    fn expected(&self, of: &Vectors, moments: &[C]) -> (Vec<(C, f64)>, Option<f64>) {
        let all = of.errors(moments) + of.errors_of_masses(moments);
        let n = self.channels.len();
        let errors = DMatrix::from_fn(n, n, |i, j| {
            let repeat = if i == j { self.repeat[i] } else { 0.0 };
            all[(self.channels[i], self.channels[j])] + C::new(repeat, 0.0)
        });
        let vector = |i: usize| {
            let by_masses = moments.iter().enumerate().map(|(k, u)| of.coefficient(self.channels[i], k) * u);
            (of.baseline(self.channels[i]) + by_masses.sum::<C>(), errors[(i, i)].re.max(0.0).sqrt())
        };
        let expected: Vec<(C, f64)> = (0..n).map(vector).collect();
        let apart = DVector::from_fn(n, |i, _| self.response[i] - expected[i].0);
        let squares = errors.cholesky().map(|factors| apart.dotc(&factors.solve(&apart)).re);
        (expected, squares.map(|squares| over_largest(squares, n)))
    }
}

impl Runs {
    /// Compares the last trim run with what the other runs expect of it; `None` without a trim run.
    ///
    /// # Errors
    /// Returns an error where other masses than the stated ones explain its vectors.
    pub(super) fn trim(&self, table: &VectorTable) -> Result<Option<Trim>, BalanceError> {
        let Some(&condition) = self.trims.last() else { return Ok(None) };
        let mounted = self.mounted();
        let measured = Measured::new(self, condition);
        let others: Vec<Run> = self.all.iter().filter(|run| run.condition != condition).cloned().collect();
        let others = self.with(others);
        let is_determined = determined(&others).is_ok() || self.prior.is_some();
        let learned = if is_determined { others.learned(&others.drift_times()) } else { None };
        let (mut expected, mut misfit) = (None, None);
        if let Some((drift, solution)) = &learned {
            let of = Vectors::new(&others, table, drift, solution.clone());
            let (vectors, of_stated) = measured.expected(&of, &mounted);
            if of_stated.is_some_and(|misfit| misfit > 1.0) {
                let misfit =
                    |(moments, _): &(Vec<C>, String)| measured.expected(&of, moments).1.unwrap_or(f64::INFINITY);
                let likely = self.likely(table, condition, &mounted).into_iter().map(|one| (misfit(&one), one.1));
                let best = likely.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(misfit, _)| *misfit <= 1.0);
                if let Some((_, likely)) = best {
                    return Err(BalanceError::Mounted { condition: self.conditions[condition].clone(), likely });
                }
            }
            (expected, misfit) = (Some(vectors), of_stated);
        }
        let vector = |i: usize| TrimVector {
            probe: table.probes[measured.channels[i] % self.probes].clone(),
            speed_rpm: self.speeds[measured.channels[i] / self.probes],
            measured: [measured.response[i].norm(), degrees(measured.response[i])],
            expected: expected.as_ref().map(|of: &Vec<(C, f64)>| [of[i].0.norm(), degrees(of[i].0), of[i].1]),
        };
        Ok(Some(Trim {
            condition: self.conditions[condition].clone(),
            mounted: mounted.iter().map(|moment| [moment.norm(), degrees(*moment)]).collect(),
            vectors: (0..measured.channels.len()).map(vector).collect(),
            misfit,
        }))
    }

    /// Returns masses that may be mounted instead of the stated ones, each in words.
    fn likely(&self, table: &VectorTable, condition: usize, mounted: &[C]) -> Vec<(Vec<C>, String)> {
        let changed = |change: fn(&C) -> C| mounted.iter().map(change).collect::<Vec<C>>();
        let mut all = vec![
            (changed(|_| C::new(0.0, 0.0)), "none mounted".to_owned()),
            (changed(|u| -u), "these half a turn from the stated angles".to_owned()),
            (changed(C::conj), "the angles of these counted the other way".to_owned()),
        ];
        for plane in 0..self.planes {
            let name = &table.planes[plane];
            let mut without = mounted.to_vec();
            without[plane] = C::new(0.0, 0.0);
            all.push((without, format!("none in plane {name}")));
            let mut turned = mounted.to_vec();
            turned[plane] = -turned[plane];
            all.push((turned, format!("that in plane {name} half a turn from the stated angle")));
            for other in plane + 1..self.planes {
                let mut swapped = mounted.to_vec();
                swapped.swap(plane, other);
                all.push((swapped, format!("those of planes {name} and {} exchanged", table.planes[other])));
            }
        }
        for run in self.all.iter().filter(|run| run.condition != condition) {
            let Some(moments) = run.moments.as_ref().filter(|of| of.iter().any(|u| u.norm_sqr() > 0.0)) else {
                continue;
            };
            let name = &self.conditions[run.condition];
            let both = mounted.iter().zip(moments).map(|(a, b)| a + b).collect();
            all.push((both, format!("those of {name} mounted besides")));
        }
        all
    }
}
