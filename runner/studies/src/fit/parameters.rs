//! Parameters of a scene that can be fitted, with their start values and prior uncertainties.

use ballrace_base::least_squares::Bounds;
use ballrace_diagnosis::CageEstimate;
use ballrace_plant::{Plant, unbalance_planes};
use ballrace_scene::{FreeAngle, ModelInput, Preload, PreloadAmount, Scene, Unbalance};
use std::f64::consts::TAU;

/// Groups of parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Group {
    /// Unbalance: amount, angle and station.
    Unbalance,
    /// Clearance, radial play or preload of each bearing.
    Clearance,
    /// Damping of the rotor: radial, axial, tilt.
    Damping,
    /// Contact stiffness of each bearing.
    Stiffness,
    /// Offset of each probe.
    Offset,
}

/// All groups.
pub const ALL: [Group; 5] = [Group::Unbalance, Group::Clearance, Group::Damping, Group::Stiffness, Group::Offset];

impl Group {
    /// Returns the name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Unbalance => "unbalance",
            Self::Clearance => "clearance",
            Self::Damping => "damping",
            Self::Stiffness => "stiffness",
            Self::Offset => "offset",
        }
    }
}

/// A parameter of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ParameterKind {
    /// Sum of the unbalances, X or Y, kg m.
    Unbalance(usize),
    /// Sum of the unbalances times their stations, X or Y, kg m^2.
    Couple(usize),
    /// `diametral_clearance` of a bearing, m.
    Clearance(usize),
    /// `radial_play`, m.
    Play(usize),
    /// `preload`, m or N.
    Preload(usize),
    /// `youngs_modulus`, Pa.
    Modulus(usize),
    /// `stiffness`, N/m^n.
    Stiffness(usize),
    /// `damping` along X and Y, along Z, of the tilts.
    Damping(usize),
    /// `offset` of a probe, m.
    Offset(usize),
    /// `first_element_azimuth` of a bearing, rad.
    CageAngle(usize),
    /// `cage_ratio` of a bearing.
    CageRatio(usize),
}

/// One unknown.
#[derive(Debug, Clone)]
pub struct Parameter {
    /// The parameter of the scene.
    pub kind: ParameterKind,
    /// The scene's value, SI.
    pub given: f64,
    /// Mean of the prior, SI: the scene's value; for a cage, and for the offset of a probe with a gap, that of the diagnosis.
    pub start: f64,
    /// Prior standard deviation, SI: unit of the unknown.
    pub scale: f64,
    /// Smallest and largest value allowed, SI.
    pub bounds: [f64; 2],
}

/// No bounds.
pub(super) const OPEN: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];
/// Largest clearance of a search over the groove distance, at which the free contact angle reaches 60 degrees.
const LARGEST_CLEARANCE: f64 = 0.999;
/// Largest cage speed over shaft speed: a cage is slower than the shaft.
const LARGEST_CAGE_RATIO: f64 = 0.999;

impl Parameter {
    /// Returns the unknown at its start value: the mean of the prior, whose standard deviation is 1.
    #[must_use]
    pub(crate) fn prior_mean(&self) -> f64 {
        if self.spread().is_some() { 0.0 } else { self.start / self.scale }
    }

    /// Returns the value, SI, of an unknown, within its bounds.
    #[must_use]
    pub fn value(&self, unknown: f64) -> f64 {
        let of = |spread: f64| self.start.max(1e-2 * self.scale) * (spread * unknown).clamp(-12.0, 12.0).exp();
        self.spread().map_or(self.scale * unknown, of).clamp(self.bounds[0], self.bounds[1])
    }

    /// Returns the smallest and the largest unknown.
    #[must_use]
    pub(crate) fn unknown_bounds(&self) -> Bounds {
        if self.spread().is_some() { OPEN } else { self.bounds.map(|bound| bound / self.scale) }
    }

    /// Returns the prior standard deviation of the logarithm by which a positive parameter is fitted; `None` for other parameters.
    const fn spread(&self) -> Option<f64> {
        match self.kind {
            ParameterKind::Damping(_) => Some(1.0),
            ParameterKind::Modulus(_) | ParameterKind::Stiffness(_) => Some(0.2),
            ParameterKind::Preload(_) => Some(0.5),
            _ => None,
        }
    }
}

/// Returns the unknowns of the requested groups.
#[must_use]
pub fn parameters(scene: &Scene, plant: &Plant, groups: &[Group]) -> Vec<Parameter> {
    let mut all = Vec::new();
    let mut add = |kind, given, scale: f64| {
        all.push(Parameter { kind, given, start: given, scale, bounds: bounds(scene, kind) });
    };
    let Some(rotor) = &scene.rotor else { return all };
    if groups.contains(&Group::Unbalance) {
        // An eccentricity of 20 um.
        let scale = 20e-6 * rotor.mass;
        let (force, couple) = sums(&rotor.unbalance);
        let lever = lever(plant);
        (0..2).for_each(|i| add(ParameterKind::Unbalance(i), force[i], scale));
        (0..2).for_each(|i| add(ParameterKind::Couple(i), couple[i], scale * lever));
    }
    for (i, b) in scene.bearings.iter().enumerate() {
        let fit = b.geometry.map(|g| g.fit);
        if groups.contains(&Group::Clearance) {
            match (b.preload.map(|preload| preload.amount), fit, b.law.and_then(|l| l.radial_play)) {
                (Some(PreloadAmount::Force(force)), ..) => add(ParameterKind::Preload(i), force, 0.5 * force),
                (Some(PreloadAmount::Displacement(length)), ..) => add(ParameterKind::Preload(i), length, 5e-6),
                (None, _, Some(play)) => add(ParameterKind::Play(i), play, 5e-6),
                (None, Some(FreeAngle::DiametralClearance(clearance)), None) => {
                    add(ParameterKind::Clearance(i), clearance, 5e-6)
                }
                _ => {}
            }
        }
        if groups.contains(&Group::Stiffness) {
            match (b.law.and_then(|l| l.stiffness), b.geometry) {
                (Some(stiffness), _) => add(ParameterKind::Stiffness(i), stiffness, 0.2 * stiffness),
                (None, Some(geometry)) => {
                    add(ParameterKind::Modulus(i), geometry.youngs_modulus, 0.2 * geometry.youngs_modulus)
                }
                _ => {}
            }
        }
    }
    if groups.contains(&Group::Damping) {
        // At least a fiftieth of the critical damping for the stiffness at the static equilibrium.
        // A flexible rotor has its damping by the drawing: what the scene does not have stays 0.
        let exists = |entry: usize| rotor.flexible.is_none() || rotor.damping[entry] > 0.0;
        for (k, entry) in [(0, 0), (1, 2), (2, 3)].into_iter().filter(|(_, entry)| exists(*entry)) {
            let mass = if k == 2 { rotor.diametral_inertia } else { rotor.mass };
            let critical = 2.0 * (mass * plant.stiffness[(entry, entry)].abs()).sqrt();
            add(ParameterKind::Damping(k), rotor.damping[entry], (0.5 * rotor.damping[entry]).max(0.02 * critical));
        }
    }
    if groups.contains(&Group::Offset) {
        let probes = scene.recording.iter().flat_map(|r| &r.probes).enumerate();
        probes.for_each(|(i, probe)| add(ParameterKind::Offset(i), probe.offset, 5e-6));
    }
    all
}

/// Error of a cage angle from the diagnosis at either end of its samples, as a share of the element pitch.
const CAGE_ERROR: f64 = 0.05;

/// Returns the angle and the speed ratio of every observable cage; `turns` is the number of revolutions of the estimate.
#[must_use]
pub(crate) fn cage_parameters(scene: &Scene, plant: &Plant, cages: &[CageEstimate], turns: f64) -> Vec<Parameter> {
    let of = |(b, cage): (usize, &CageEstimate)| {
        let mounted = &plant.bearings[b];
        let error = CAGE_ERROR / mounted.elements as f64;
        let angle = Parameter {
            kind: ParameterKind::CageAngle(b),
            given: scene.bearings[b].first_element_azimuth,
            start: cage.first_element_azimuth,
            scale: error * TAU,
            bounds: OPEN,
        };
        let ratio = Parameter {
            kind: ParameterKind::CageRatio(b),
            given: mounted.kinematics.cage_ratio,
            start: cage.cage_ratio,
            scale: error / turns.max(1.0),
            bounds: [0.0, LARGEST_CAGE_RATIO],
        };
        [angle, ratio]
    };
    cages.iter().enumerate().filter(|(_, cage)| cage.observable).flat_map(of).collect()
}

/// Returns the bounds that the scene's checks allow: a clearance leaves a free contact angle of 0 to 60 degrees, or, with the `lumped`
/// model, may be an interference of the same size.
fn bounds(scene: &Scene, kind: ParameterKind) -> [f64; 2] {
    let ParameterKind::Clearance(b) = kind else { return OPEN };
    let Some((bearing, g)) = scene.bearings.get(b).and_then(|b| b.geometry.map(|g| (b, g))) else { return OPEN };
    let largest = LARGEST_CLEARANCE * (g.inner_conformity + g.outer_conformity - 1.0) * g.ball_diameter;
    let takes_interference = bearing.evaluated_model().properties().input == ModelInput::Law;
    [if takes_interference { -largest } else { 0.0 }, largest]
}

fn lever(plant: &Plant) -> f64 {
    plant.bearings.iter().map(|s| s.station.abs()).fold(0.02, f64::max)
}

/// Returns the sum of the unbalances, kg m, and the sum of each times its station, kg m^2, along X and Y.
pub(super) fn sums(unbalances: &[Unbalance]) -> ([f64; 2], [f64; 2]) {
    let (mut force, mut couple) = ([0.0; 2], [0.0; 2]);
    for one in unbalances {
        for (i, part) in [one.angle.cos(), one.angle.sin()].into_iter().enumerate() {
            force[i] += one.moment * part;
            couple[i] += one.moment * part * one.station;
        }
    }
    (force, couple)
}

/// Returns the unbalances in two planes, at the stations `planes` (m), with this sum (kg m) and couple (kg m^2).
#[must_use]
pub(crate) fn two_planes(force: [f64; 2], couple: [f64; 2], planes: [f64; 2]) -> [Unbalance; 2] {
    let [near, far] = planes;
    let second: [f64; 2] = std::array::from_fn(|i| (couple[i] - near * force[i]) / (far - near));
    let first: [f64; 2] = std::array::from_fn(|i| force[i] - second[i]);
    let at = |[x, y]: [f64; 2], station| Unbalance { moment: x.hypot(y), angle: y.atan2(x).rem_euclid(TAU), station };
    [at(first, near), at(second, far)]
}

/// Returns the stations of the two planes that carry the fitted unbalance, m: those of [`unbalance_planes`] on a flexible rotor, which bends
/// less under an unbalance near a bearing; on a rigid one, where all planes are equivalent, the outermost bearings or, if these coincide, two
/// stations 0.1 m apart.
#[must_use]
pub fn planes(scene: &Scene) -> [f64; 2] {
    let stations = || scene.bearings.iter().map(|b| b.station);
    let (near, far) = (stations().fold(f64::INFINITY, f64::min), stations().fold(f64::NEG_INFINITY, f64::max));
    let outermost = if far - near > 1e-3 { [near, far] } else { [near - 0.05, near + 0.05] };
    match &scene.rotor {
        Some(rotor) if rotor.flexible.is_some() => unbalance_planes(rotor, outermost),
        _ => outermost,
    }
}

/// Returns the scene with these values, SI, of `parameters`.
#[must_use]
pub fn with(scene: &Scene, parameters: &[Parameter], values: &[f64]) -> Scene {
    let mut scene = scene.clone();
    let planes = planes(&scene);
    let Some(rotor) = &mut scene.rotor else { return scene };
    let (mut force, mut couple) = sums(&rotor.unbalance);
    let mut turned = false;
    for (parameter, &value) in parameters.iter().zip(values) {
        match parameter.kind {
            ParameterKind::Unbalance(i) => (force[i], turned) = (value, true),
            ParameterKind::Couple(i) => (couple[i], turned) = (value, true),
            ParameterKind::Damping(k) => {
                let entries = [0..2, 2..3, 3..5][k].clone();
                rotor.damping[entries].fill(value.max(0.0));
            }
            ParameterKind::Clearance(b) => {
                if let Some(geometry) = &mut scene.bearings[b].geometry {
                    geometry.fit = FreeAngle::DiametralClearance(value);
                }
            }
            ParameterKind::Modulus(b) => {
                if let Some(geometry) = &mut scene.bearings[b].geometry {
                    geometry.youngs_modulus = value.max(1e6);
                }
            }
            ParameterKind::Play(b) | ParameterKind::Stiffness(b) => {
                if let Some(law) = &mut scene.bearings[b].law {
                    match parameter.kind {
                        ParameterKind::Play(_) => law.radial_play = Some(value),
                        _ => law.stiffness = Some(value.max(1e-3)),
                    }
                }
            }
            ParameterKind::Preload(b) => {
                scene.bearings[b].preload = scene.bearings[b].preload.map(|preload| Preload {
                    amount: match preload.amount {
                        PreloadAmount::Force(_) => PreloadAmount::Force(value.max(1e-6)),
                        PreloadAmount::Displacement(_) => PreloadAmount::Displacement(value.max(1e-12)),
                    },
                    ..preload
                });
            }
            ParameterKind::Offset(p) => {
                if let Some(probe) = scene.recording.as_mut().and_then(|r| r.probes.get_mut(p)) {
                    probe.offset = value;
                }
            }
            ParameterKind::CageAngle(b) => scene.bearings[b].first_element_azimuth = value,
            ParameterKind::CageRatio(b) => scene.bearings[b].cage_ratio = Some(value),
        }
    }
    if turned {
        rotor.unbalance = two_planes(force, couple, planes).to_vec();
    }
    scene
}

impl ParameterKind {
    /// Returns the name in the scene, the displayed unit, and the size of that unit in SI.
    #[must_use]
    pub fn name(self, scene: &Scene) -> (String, &'static str, f64) {
        let bearing = |b: usize| scene.bearings.get(b).map_or("", |b| b.name.as_str());
        let axis = |i: usize| ["X", "Y"][i % 2];
        match self {
            Self::Unbalance(i) => (format!("unbalance along {}", axis(i)), "g mm", 1e-6),
            Self::Couple(i) => (format!("unbalance couple along {}", axis(i)), "g mm^2", 1e-9),
            Self::Clearance(b) => (format!("{}: diametral_clearance", bearing(b)), "um", 1e-6),
            Self::Play(b) => (format!("{}: radial_play", bearing(b)), "um", 1e-6),
            Self::Preload(b) => match scene.bearings.get(b).and_then(|b| b.preload).map(|preload| preload.amount) {
                Some(PreloadAmount::Force(_)) => (format!("{}: preload", bearing(b)), "N", 1.0),
                _ => (format!("{}: preload", bearing(b)), "um", 1e-6),
            },
            Self::Modulus(b) => (format!("{}: youngs_modulus", bearing(b)), "GPa", 1e9),
            Self::Stiffness(b) => {
                let exponent = scene.bearings.get(b).and_then(|b| b.law).map_or(1.5, |l| l.exponent);
                let unit = if exponent == 1.5 { "N/m^1.5" } else { "N/m^n" };
                (format!("{}: stiffness", bearing(b)), unit, 1.0)
            }
            Self::Damping(0) => ("damping along X and Y".to_owned(), "N s/m", 1.0),
            Self::Damping(1) => ("damping along Z".to_owned(), "N s/m", 1.0),
            Self::Damping(_) => ("damping of tilt".to_owned(), "N m s/rad", 1.0),
            Self::Offset(p) => {
                let probe = scene.recording.as_ref().and_then(|r| r.probes.get(p));
                (format!("{}: offset", probe.map_or("", |p| p.column.as_str())), "um", 1e-6)
            }
            Self::CageAngle(b) => (format!("{}: first_element_azimuth", bearing(b)), "deg", TAU / 360.0),
            Self::CageRatio(b) => (format!("{}: cage_ratio", bearing(b)), "", 1.0),
        }
    }
}
