//! Significance of bending: bearing forces and 1X response of a flexible rotor against those of the same rotor without bending.

use super::{EffectSignificance, share, size};
use ballrace::Phase;
use ballrace::bearing::Bearing as _;
use ballrace_plant::{Plant, PlantError, Result, response};
use ballrace_scene::flexible_rotor::Modes;
use ballrace_scene::{Direction, Scene};
use nalgebra::{Complex, DVector};
use std::f64::consts::TAU;

/// Name of the effect.
pub(crate) const BENDING: &str = "bending";
/// Share of the strain energy in the shaft from which a mode is a bending mode.
const BENT: f64 = 0.5;

/// Predicted change by the bending of the shaft.
pub struct Bending {
    /// One entry per bearing, in the order of the scene.
    entries: Vec<EffectSignificance>,
}

impl Bending {
    /// Compares a flexible rotor with the rigid one, both on bearings linearised at their static equilibrium; there are no entries if
    /// the rotor is not flexible.
    ///
    /// The change of force is that of the static force plus that of the 1X amplitude, over the sum of both.
    ///
    /// # Errors
    /// Returns an error if the kernel rejects a parameter or the modes cannot be computed.
    pub fn new(scene: &Scene, plant: &Plant) -> Result<Self> {
        let Some(rigid) = plant.without_bending(scene)? else { return Ok(Self { entries: vec![] }) };
        let (flexible, rigid) = (Loads::new(scene, plant)?, Loads::new(scene, &rigid)?);
        let changes: Vec<f64> = flexible.bearings.iter().zip(&rigid.bearings).map(|(a, b)| a.change(b)).collect();
        let largest = changes.iter().copied().fold(0.0, f64::max);
        let mut because = first_bending(plant)?;
        because.push_str(&format!("; a rigid rotor changes the bearing forces by up to {}", share(largest)));
        if let Some(change) = response_change(&flexible.probes, &rigid.probes) {
            because.push_str(&format!(" and the 1X response at the probes by up to {}", share(change)));
        }
        let entry = |(bearing, change): (&ballrace_scene::Bearing, f64)| EffectSignificance {
            bearing: bearing.name.clone(),
            effect: BENDING,
            change,
            modelled: true,
            because: because.clone(),
            at: None,
        };
        let entries = scene.bearings.iter().zip(changes).map(entry).filter(|entry| entry.change.is_finite());
        Ok(Self { entries: entries.collect() })
    }

    /// Returns the entry of a bearing.
    pub fn of(&self, bearing: &str) -> Option<EffectSignificance> {
        self.entries.iter().find(|entry| entry.bearing == bearing).cloned()
    }
}

/// Forces at the bearings and response at the probes.
struct Loads {
    bearings: Vec<BearingLoad>,
    /// 1X amplitude at each radial probe, m.
    probes: Vec<Complex<f64>>,
}

/// Force on the inner ring of a bearing along X, Y and Z, N.
struct BearingLoad {
    at_rest: [f64; 3],
    /// 1X amplitude.
    one_x: [Complex<f64>; 3],
}

impl BearingLoad {
    /// Returns the change of the force from `self` to `other`, over the force of `self`.
    fn change(&self, other: &Self) -> f64 {
        let amplitude = |of: [Complex<f64>; 3]| size(of.map(|z| z.norm()));
        let at_rest = size(std::array::from_fn(|i| other.at_rest[i] - self.at_rest[i]));
        let one_x = amplitude(std::array::from_fn(|i| other.one_x[i] - self.one_x[i]));
        (at_rest + one_x) / (size(self.at_rest) + amplitude(self.one_x))
    }
}

impl Loads {
    fn new(scene: &Scene, plant: &Plant) -> Result<Self> {
        let scales = plant.scales()?;
        let matrices = [&scales.mass, &scales.damping, &scales.gyroscopic, &plant.stiffness];
        let q = response(matrices, &scales.unbalance, plant.speed());
        let bearings = plant.bearings.iter().enumerate().map(|(i, mounted)| {
            let displacement = plant.displacement(i, &plant.rest);
            let at = plant.resting(mounted, Phase::ZERO);
            let (reaction, tangent) = mounted.bearing.reaction_and_stiffness(&displacement, &at);
            let [x, y, z, ..] = reaction.wrench.to_array();
            let moved: [Complex<f64>; 5] = std::array::from_fn(|row| {
                plant.layout.attached(i).map_or(Complex::default(), |rows| product(&rows[row], &q))
            });
            let force = |row: usize| moved.iter().enumerate().map(|(j, u)| u * tangent[(row, j)]).sum();
            BearingLoad { at_rest: [x, y, z], one_x: std::array::from_fn(force) }
        });
        let radial = scene.recording.iter().flat_map(|recording| &recording.probes);
        let radial = radial.filter(|probe| matches!(probe.direction, Direction::Radial(_)));
        Ok(Self {
            bearings: bearings.collect(),
            probes: radial.map(|p| product(&plant.layout.probe_row(p), &q)).collect(),
        })
    }
}

fn product(row: &[f64], q: &DVector<Complex<f64>>) -> Complex<f64> {
    row.iter().zip(q.iter()).map(|(a, x)| x * *a).sum()
}

/// Returns the largest change of the response over the largest response; `None` without a response.
fn response_change(flexible: &[Complex<f64>], rigid: &[Complex<f64>]) -> Option<f64> {
    let largest = flexible.iter().map(|z| z.norm()).fold(0.0, f64::max);
    let change = flexible.iter().zip(rigid).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    (largest > 0.0).then(|| change / largest)
}

/// Describes the lowest mode on the bearings, without damping and gyroscopic effect, in which the shaft has at least half of the strain
/// energy; where there is none, the mode with the largest share.
fn first_bending(plant: &Plant) -> Result<String> {
    let scales = plant.scales()?;
    let symmetric = 0.5 * (&plant.stiffness + plant.stiffness.transpose());
    let modes = Modes::try_new(&scales.mass, &symmetric).map_err(PlantError::from)?;
    let Some(rotor) = plant.layout.flexible() else { return Ok(String::new()) };
    let in_shaft = |j: usize| {
        let shape = modes.shapes.column(j);
        let elastic = 5..5 + 2 * rotor.elastic();
        let energy: f64 = elastic.map(|i| rotor.stiffness[(i - 5) / 2] * shape[i] * shape[i]).sum();
        if modes.squares[j] > 0.0 { energy / modes.squares[j] } else { 0.0 }
    };
    let shares: Vec<f64> = (0..modes.squares.len()).map(in_shaft).collect();
    let most = || (0..shares.len()).max_by(|a, b| shares[*a].total_cmp(&shares[*b]));
    let Some(first) = shares.iter().position(|share| *share >= BENT).or_else(most) else { return Ok(String::new()) };
    let hz = modes.squares[first].sqrt() / TAU;
    let speed_hz = plant.speed().abs() / TAU;
    let over_speed = if speed_hz > 0.0 {
        format!("{:.2} times the shaft speed", hz / speed_hz)
    } else {
        "the shaft is at rest".to_owned()
    };
    let highest = plant.reduction.map_or(0.0, |reduction| reduction.highest_line);
    let over_line = if highest > 0.0 {
        format!(", {:.2} of the highest line of interest, {highest:.0} Hz", hz / highest)
    } else {
        String::new()
    };
    Ok(format!("first bending frequency on the bearings {hz:.1} Hz, {over_speed}{over_line}"))
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use ballrace_scene::read::read_str;
    use std::path::Path;

    /// A shaft with a disk between stiff bearings.
    fn scene(diameter: f64, rpm: f64) -> Scene {
        let bearing = |name: &str, station: f64, axial: f64| {
            format!(
                "[[bearing]]\nname = \"{name}\"\nstation = \"{station} mm\"\nfacing = \"both\"\nmodel = \"linear\"\nelements = 8\n\
                 stiffness_matrix = [[5e7, 0, 0, 0, 0], [0, 5e7, 0, 0, 0], [0, 0, {axial:e}, 0, 0], [0, 0, 0, 0, 0], [0, 0, 0, 0, 0]]\n"
            )
        };
        let text = format!(
            "[shaft]\nspeed = \"{rpm} rpm\"\n[rotor]\n\
             sections = [{{ from = \"0 mm\", to = \"500 mm\", outer_diameter = \"{diameter} mm\" }}]\n\
             disks = [{{ station = \"150 mm\", mass = \"5 kg\", diametral_inertia = 0.008, polar_inertia = 0.014 }}]\n\
             proportional_damping = {{ mass = \"60 1/s\", stiffness = \"0 s\" }}\n\
             unbalance = [{{ moment = \"2000 g mm\", angle = \"30 deg\", station = \"150 mm\" }}]\n{}{}",
            bearing("DE", 20.0, 1e7),
            bearing("NDE", 480.0, 0.0)
        );
        read_str(&text, Path::new("scene.toml")).unwrap()
    }

    fn change(diameter: f64, rpm: f64) -> f64 {
        let scene = scene(diameter, rpm);
        let found = Bending::new(&scene, &Plant::try_new(&scene).unwrap()).unwrap();
        let entry = found.of("DE").unwrap();
        assert!(entry.modelled && entry.because.starts_with("first bending frequency on the bearings"), "{entry:?}");
        entry.change
    }

    /// The static forces of a statically determinate rotor do not depend on its bending: only the 1X forces change, by about
    /// `r^2 / (1 - r^2)` at `r` times the first bending frequency.
    #[test]
    fn bending_matters_near_the_critical_speed_of_a_thin_shaft() {
        let (slow, fast) = (change(30.0, 60.0), change(30.0, 3000.0));
        assert!(slow < 1e-3, "{slow}");
        assert!(fast > 0.05, "{fast}");
        assert!(change(100.0, 3000.0) < 0.2 * fast);
    }
}
