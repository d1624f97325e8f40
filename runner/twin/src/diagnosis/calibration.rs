//! Calibration: parameters of a scene fitted to a recording of the healthy machine.

use super::fit::{Prior, fit_whole};
use super::hypothesis::SLIPS;
use super::machine::{Machine, Unknown};
use super::{Prepared, Result, cage};
use crate::outcome::{CalibratedParameter, Calibration, ParameterName};
use crate::scene::Scene;
use nalgebra::{DMatrix, DVector};

/// Number of rounds of fit, weighting and search of the cages.
const ROUNDS: usize = 4;

impl ParameterName {
    const OF_ROTOR: [(Self, Unknown); 6] = [
        (Self::TranslationDamping, Unknown::Damping(0)),
        (Self::RotationDamping, Unknown::Damping(1)),
        (Self::UnbalanceX, Unknown::Unbalance(0)),
        (Self::UnbalanceY, Unknown::Unbalance(1)),
        (Self::CoupleX, Unknown::Unbalance(2)),
        (Self::CoupleY, Unknown::Unbalance(3)),
    ];

    /// Returns the relative standard deviation of a scene's value; `None` where the scene's value has no relation to the machine.
    ///
    /// Young's modulus of bearing steels differs by 2 %, with catalogue dimensions the stiffness by 5 %; a clearance class spans a
    /// factor of two; damping is seldom measured; rotors are rebalanced.
    fn deviation(self) -> Option<f64> {
        match self {
            Self::YoungsModulus => Some(0.05),
            Self::DiametralClearance => Some(0.3),
            Self::TranslationDamping | Self::RotationDamping => Some(0.5),
            Self::UnbalanceX | Self::UnbalanceY | Self::CoupleX | Self::CoupleY => None,
        }
    }

    fn of_bearing(b: usize) -> [(Self, Unknown); 2] {
        [(Self::DiametralClearance, Unknown::Clearance(b)), (Self::YoungsModulus, Unknown::Modulus(b))]
    }
}

/// Returns all parameters of a machine, with the bearing of each.
fn parameters(machine: &Machine) -> Vec<(ParameterName, Option<usize>, Unknown)> {
    let of_bearings =
        machine.bearings.iter().enumerate().filter(|(_, b)| b.scene.geometry.is_some()).flat_map(|(b, _)| {
            ParameterName::of_bearing(b).into_iter().map(move |(parameter, unknown)| (parameter, Some(b), unknown))
        });
    let of_rotor = ParameterName::OF_ROTOR.into_iter().map(|(parameter, unknown)| (parameter, None, unknown));
    // Damping that the scene does not have stays 0.
    let exists = |unknown: &Unknown| !matches!(unknown, Unknown::Damping(_)) || unknown.get(machine) > 0.0;
    of_bearings.chain(of_rotor).filter(|(.., unknown)| exists(unknown)).collect()
}

impl Calibration {
    /// Returns the scene with these parameters.
    #[must_use]
    pub fn scene(&self, scene: &Scene) -> Scene {
        let Some(mut machine) = Machine::new(scene) else { return scene.clone() };
        self.apply(&mut machine);
        machine.scene(scene)
    }

    /// Returns the parameters that a machine has, with their indices in the calibration.
    fn present(&self, machine: &Machine) -> Vec<(usize, Unknown)> {
        let place = |(parameter, b, unknown): (ParameterName, Option<usize>, Unknown)| {
            let name = b.map(|b| machine.bearings[b].scene.name.as_str());
            let at = self.parameters.iter().position(|p| p.name == parameter && p.bearing.as_deref() == name)?;
            Some((at, unknown))
        };
        parameters(machine).into_iter().filter_map(place).collect()
    }

    /// Returns the calibrated unknowns with their covariance.
    pub(super) fn covariance(&self, machine: &Machine) -> (Vec<Unknown>, DMatrix<f64>) {
        let present = self.present(machine);
        let of = |i: usize, j: usize| {
            let (i, j) = (present[i].0, present[j].0);
            let correlation = self.correlation.get(i).and_then(|row| row.get(j)).copied();
            let correlation = if i == j { 1.0 } else { correlation.unwrap_or(0.0) };
            correlation * self.parameters[i].deviation * self.parameters[j].deviation
        };
        let covariance = DMatrix::from_fn(present.len(), present.len(), of);
        (present.into_iter().map(|(_, unknown)| unknown).collect(), covariance)
    }

    fn prior(&self, machine: &Machine) -> Prior {
        let (unknowns, covariance) = self.covariance(machine);
        let n = unknowns.len();
        // Inverted with a unit diagonal: the units of the parameters differ by 20 orders of magnitude.
        let scale: Vec<f64> = (0..n).map(|i| covariance[(i, i)].max(f64::MIN_POSITIVE).sqrt()).collect();
        let scaled = DMatrix::from_fn(n, n, |i, j| covariance[(i, j)] / (scale[i] * scale[j]));
        let inverse = scaled.try_inverse().unwrap_or_else(|| DMatrix::identity(n, n));
        let mut known = machine.clone();
        self.apply(&mut known);
        let mean = DVector::from_iterator(unknowns.len(), unknowns.iter().map(|u| u.get(&known)));
        let precision = DMatrix::from_fn(n, n, |i, j| inverse[(i, j)] / (scale[i] * scale[j]));
        Prior { unknowns, mean, precision }
    }

    fn apply(&self, machine: &mut Machine) {
        for (at, unknown) in self.present(machine) {
            unknown.set(machine, self.parameters[at].value);
        }
    }
}

/// Returns the prior of the parameters of a machine from its scene.
fn of_scene(machine: &Machine) -> Prior {
    let known = parameters(machine).into_iter().filter_map(|(parameter, _, unknown)| {
        let mean = unknown.get(machine);
        let deviation = parameter.deviation()? * mean.abs();
        (deviation > 0.0).then_some((unknown, mean, deviation))
    });
    let known: Vec<(Unknown, f64, f64)> = known.collect();
    Prior {
        unknowns: known.iter().map(|k| k.0).collect(),
        mean: DVector::from_iterator(known.len(), known.iter().map(|k| k.1)),
        precision: DMatrix::from_diagonal(&DVector::from_iterator(known.len(), known.iter().map(|k| k.2.powi(-2)))),
    }
}

/// Fits the parameters of the healthy machine, with a prior from the scene or from an `earlier` calibration.
pub(super) fn calibrate(of: &mut Prepared, earlier: Option<&Calibration>) -> Result<Calibration> {
    let own = parameters(&of.healthy.machine);
    let prior = match earlier {
        Some(calibration) => calibration.prior(&of.healthy.machine),
        None => of_scene(&of.healthy.machine),
    };
    let all: Vec<Unknown> = own.iter().map(|(.., unknown)| *unknown).collect();
    // The modulus is fitted later: far from the recording, the other parameters explain it nearly as well.
    let mut first = all.clone();
    first.retain(|unknown| !matches!(unknown, Unknown::Modulus(_)));
    first.extend(cage::unknowns(&of.observable, &of.healthy.machine));
    let mut now = fit_whole(&of.evidence, &of.healthy, &first, &prior, 20)?;
    for _ in 0..ROUNDS {
        let unknowns = [all.clone(), cage::unknowns(&of.observable, &now.machine)].concat();
        now = fit_whole(&of.evidence, &now, &unknowns, &prior, 20)?;
        of.evidence.weight_for(&now.machine)?;
        let (settled, seen) = cage::fit_cages(&of.evidence, &of.band, &now.machine, SLIPS)?;
        of.observable = seen;
        now = settled;
    }
    let unknowns = [all, cage::unknowns(&of.observable, &now.machine)].concat();
    let now = fit_whole(&of.evidence, &now, &unknowns, &prior, 10)?;
    let chi_square_per_value = now.chi_square / now.residual.len().max(1) as f64;
    let inflation = chi_square_per_value.max(1.0).sqrt();
    let deviation = |i: usize| now.covariance[(i, i)].max(f64::MIN_POSITIVE).sqrt();
    let row = |i: usize| (0..own.len()).map(|j| now.covariance[(i, j)] / (deviation(i) * deviation(j))).collect();
    let parameters = own
        .iter()
        .enumerate()
        .map(|(i, (name, b, unknown))| CalibratedParameter {
            name: *name,
            bearing: b.map(|b| now.machine.bearings[b].scene.name.clone()),
            value: unknown.get(&now.machine),
            deviation: inflation * deviation(i),
        })
        .collect();
    Ok(Calibration { parameters, correlation: (0..own.len()).map(row).collect(), chi_square_per_value })
}
