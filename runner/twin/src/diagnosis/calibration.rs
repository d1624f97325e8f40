//! The machine in good order: parameters of a scene fitted to a recording of it.

use super::Prepared;
use super::Result;
use super::cage;
use super::fit::fit;
use super::hypothesis::SLIPS;
use super::machine::{Machine, Unknown};
use crate::scene::Scene;
use serde::{Deserialize, Serialize};

/// Rounds of fit, weighing and search of the cages.
const ROUNDS: usize = 4;

/// Parameters of a machine in good order, which a recording of it determined.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// Parameters with their standard deviations.
    pub parameters: Vec<CalibratedParameter>,
    /// Sum of squares of the residual per value, in units of the noise: about 1 where the calibrated scene describes the recording.
    pub chi_square_per_value: f64,
}

/// One parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CalibratedParameter {
    /// Which one.
    pub name: Parameter,
    /// Bearing, where it is one of a bearing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bearing: Option<String>,
    /// Value, SI.
    pub value: f64,
    /// Standard deviation, SI.
    pub deviation: f64,
}

/// A parameter that a calibration determines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Parameter {
    /// Diametral clearance, m.
    DiametralClearance,
    /// Young's modulus of a bearing, Pa.
    YoungsModulus,
    /// Damping of translations, N s/m.
    TranslationDamping,
    /// Damping of rotations, N m s/rad.
    RotationDamping,
    /// Static unbalance along the keyphasor mark, kg m.
    UnbalanceX,
    /// Static unbalance a quarter of a revolution ahead, kg m.
    UnbalanceY,
    /// Couple unbalance along the keyphasor mark, kg m^2.
    CoupleX,
    /// Couple unbalance a quarter of a revolution ahead, kg m^2.
    CoupleY,
}

impl Parameter {
    const OF_ROTOR: [(Self, Unknown); 6] = [
        (Self::TranslationDamping, Unknown::Damping(0)),
        (Self::RotationDamping, Unknown::Damping(1)),
        (Self::UnbalanceX, Unknown::Unbalance(0)),
        (Self::UnbalanceY, Unknown::Unbalance(1)),
        (Self::CoupleX, Unknown::Unbalance(2)),
        (Self::CoupleY, Unknown::Unbalance(3)),
    ];

    fn of_bearing(b: usize) -> [(Self, Unknown); 2] {
        [(Self::DiametralClearance, Unknown::Clearance(b)), (Self::YoungsModulus, Unknown::Modulus(b))]
    }
}

/// Returns all parameters of a machine, with the bearing of each.
fn parameters(machine: &Machine) -> Vec<(Parameter, Option<usize>, Unknown)> {
    let of_bearings =
        machine.bearings.iter().enumerate().filter(|(_, b)| b.scene.geometry.is_some()).flat_map(|(b, _)| {
            Parameter::of_bearing(b).into_iter().map(move |(parameter, unknown)| (parameter, Some(b), unknown))
        });
    let of_rotor = Parameter::OF_ROTOR.into_iter().map(|(parameter, unknown)| (parameter, None, unknown));
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

    fn apply(&self, machine: &mut Machine) {
        for (parameter, b, unknown) in parameters(machine) {
            let name = b.map(|b| machine.bearings[b].scene.name.as_str());
            let own = self.parameters.iter().find(|p| p.name == parameter && p.bearing.as_deref() == name);
            if let Some(own) = own {
                unknown.set(machine, own.value);
            }
        }
    }
}

/// Fits the parameters of the machine in good order.
pub(super) fn calibrate(of: &mut Prepared) -> Result<Calibration> {
    let own = parameters(&of.healthy.machine);
    let mut now = of.healthy.clone();
    for _ in 0..ROUNDS {
        let mut unknowns = cage::unknowns(&of.observable);
        unknowns.extend(own.iter().map(|(.., unknown)| *unknown));
        now = fit(&of.evidence, &now, &unknowns, 10)?;
        of.evidence.weigh(&now.machine)?;
        let (settled, seen) = cage::settle(&of.evidence, &of.band, &now.machine, SLIPS)?;
        of.observable = seen;
        now = settled;
    }
    let mut unknowns: Vec<Unknown> = own.iter().map(|(.., unknown)| *unknown).collect();
    unknowns.extend(cage::unknowns(&of.observable));
    let now = fit(&of.evidence, &now, &unknowns, 10)?;
    let chi_square_per_value = now.chi_square / now.residual.len().max(1) as f64;
    let inflation = chi_square_per_value.max(1.0).sqrt();
    let parameters = own
        .iter()
        .enumerate()
        .map(|(i, (name, b, unknown))| CalibratedParameter {
            name: *name,
            bearing: b.map(|b| now.machine.bearings[b].scene.name.clone()),
            value: unknown.get(&now.machine),
            deviation: inflation * now.covariance[(i, i)].max(0.0).sqrt(),
        })
        .collect();
    Ok(Calibration { parameters, chi_square_per_value })
}
