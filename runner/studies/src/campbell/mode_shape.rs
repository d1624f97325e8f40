//! Mode shapes of a flexible rotor on linearised bearings.

use super::{Mode, eigenvector, modes_of, state_matrix};
use ballrace_plant::{Plant, Result};
use ballrace_scene::Scene;
use ballrace_scene::flexible_rotor::ReducedRotor;
use nalgebra::{Complex, DVector};
use std::f64::consts::TAU;

/// Largest number of mode shapes.
const MOST: usize = 8;
/// Number of mode shapes that are computed even above the highest line of interest.
const FEWEST: usize = 4;

/// Shape of one mode along the shaft.
///
/// The largest component is 1. In each direction the shape is that at the instant of its largest displacement.
#[derive(Debug, Clone, PartialEq)]
pub struct ModeShape {
    /// Frequency, damping and whirl.
    pub mode: Mode,
    /// Shaft speed.
    pub speed_rpm: f64,
    /// Points in the order of their stations.
    pub points: Vec<ModeShapePoint>,
}

/// Displacement at one station.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ModeShapePoint {
    /// Station as drawn, mm.
    pub station_mm: f64,
    /// Along X.
    pub x: f64,
    /// Along Y.
    pub y: f64,
    /// Along Z.
    pub z: f64,
}

impl ModeShape {
    /// Returns the largest displacement along X, Y and Z.
    #[must_use]
    pub fn largest(&self) -> [f64; 3] {
        let all = self.points.iter().map(|p| [p.x.abs(), p.y.abs(), p.z.abs()]);
        all.fold([0.0; 3], |a, b| std::array::from_fn(|i| f64::max(a[i], b[i])))
    }

    /// Returns true where the shapes along X and Y differ by less than `share` of the largest displacement.
    #[must_use]
    pub fn is_alike_in_both_planes(&self, share: f64) -> bool {
        self.points.iter().all(|p| (p.x - p.y).abs() < share)
    }
}

/// Computes the shapes of the lowest damped modes at `speed` (rad/s), up to the highest line of interest; empty without a flexible rotor.
///
/// # Errors
/// Returns the errors of [`super::modes`].
pub fn mode_shapes(scene: &Scene, plant: &Plant, speed: f64) -> Result<Vec<ModeShape>> {
    let Some(rotor) = plant.layout.flexible() else { return Ok(vec![]) };
    let highest = plant.reduction.map_or(0.0, |reduction| reduction.highest_line);
    let system = state_matrix(plant, speed, true)?;
    let modes = modes_of(&system, plant)?;
    let shown = modes.into_iter().enumerate().take(MOST);
    let shown = shown.take_while(|(i, (_, value))| *i < FEWEST || value.im <= TAU * highest);
    let shapes = shown.filter_map(|(_, (mode, value))| {
        let vector = eigenvector(&system, value)?;
        Some(ModeShape { mode, speed_rpm: speed * 60.0 / TAU, points: points(scene, plant, rotor, &vector) })
    });
    Ok(shapes.collect())
}

/// Computes the shapes of the lowest damped modes at the scene's nominal speed; empty without a flexible rotor.
///
/// # Errors
/// Returns the errors of [`super::campbell`].
pub fn nominal_mode_shapes(scene: &Scene) -> Result<Vec<ModeShape>> {
    if scene.rotor.as_ref().is_none_or(|rotor| rotor.flexible.is_none()) {
        return Ok(vec![]);
    }
    mode_shapes(scene, &Plant::try_new(scene)?, scene.shaft.speed.nominal())
}

fn points(scene: &Scene, plant: &Plant, rotor: &ReducedRotor, vector: &DVector<Complex<f64>>) -> Vec<ModeShapePoint> {
    let stations = &rotor.free.mesh.stations;
    let at = |station: &f64| {
        let rows = plant.layout.rows(*station);
        let part = |i: usize| -> Complex<f64> { rows[i].iter().zip(vector.iter()).map(|(row, q)| q * *row).sum() };
        [part(0), part(1), part(2)]
    };
    let all: Vec<[Complex<f64>; 3]> = stations.iter().map(at).collect();
    // The point with the largest displacement in a direction defines the phase of that direction.
    let largest: [Complex<f64>; 3] = std::array::from_fn(|i| {
        all.iter().map(|point| point[i]).fold(Complex::default(), |a, b| if b.norm() > a.norm() { b } else { a })
    });
    let size = largest.iter().map(|z| z.norm()).fold(f64::MIN_POSITIVE, f64::max);
    let signed = |point: &[Complex<f64>; 3], i: usize| {
        let phase = largest[i].unscale(largest[i].norm().max(f64::MIN_POSITIVE));
        (point[i] * phase.conj()).re / size
    };
    let point = |(station, of): (&f64, &[Complex<f64>; 3])| ModeShapePoint {
        station_mm: scene.drawn_station(*station) * 1e3,
        x: signed(of, 0),
        y: signed(of, 1),
        z: signed(of, 2),
    };
    stations.iter().zip(&all).map(point).collect()
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use ballrace_scene::read::read_str;
    use std::f64::consts::PI;
    use std::path::Path;

    /// A uniform shaft on two stiff bearings at its ends, slow enough for no gyroscopic effect.
    const SCENE: &str = r#"
        [shaft]
        speed = "3000 rpm"
        [rotor]
        sections = [{ from = "100 mm", to = "1100 mm", outer_diameter = "20 mm" }]
        coordinates = 17
        proportional_damping = { mass = "20 1/s", stiffness = "0 s" }
        [[bearing]]
        name = "DE"
        station = "100 mm"
        facing = "both"
        model = "linear"
        elements = 8
        cage_ratio = 0.4
        stiffness_matrix = [[1e9, 0, 0, 0, 0], [0, 3e8, 0, 0, 0], [0, 0, 1e7, 0, 0], [0, 0, 0, 0, 0], [0, 0, 0, 0, 0]]
        [[bearing]]
        name = "NDE"
        station = "1100 mm"
        facing = "both"
        model = "linear"
        elements = 8
        cage_ratio = 0.4
        stiffness_matrix = [[1e9, 0, 0, 0, 0], [0, 3e8, 0, 0, 0], [0, 0, 0, 0, 0], [0, 0, 0, 0, 0], [0, 0, 0, 0, 0]]
    "#;

    /// The shapes of a pinned shaft are sines, the frequencies of Euler and Bernoulli `(n pi / L)^2 sqrt(E I / rho A) / 2 pi`.
    #[test]
    fn shapes_of_a_pinned_shaft_are_sines() {
        let scene = read_str(SCENE, Path::new("scene.toml")).unwrap();
        let shapes = nominal_mode_shapes(&scene).unwrap();
        assert!(shapes.len() >= 4, "{}", shapes.len());
        let drawn = scene.rotor.as_ref().unwrap().flexible.as_ref().unwrap();
        let wave = (drawn.youngs_modulus / drawn.density).sqrt() * 0.02 / 4.0;
        for (i, shape) in shapes.iter().take(4).enumerate() {
            let half_waves = f64::from(1 + u32::try_from(i).unwrap() / 2);
            let expected = (half_waves * PI).powi(2) * wave / TAU;
            assert!((shape.mode.frequency_hz / expected - 1.0).abs() < 0.01, "{} {expected}", shape.mode.frequency_hz);
            let [x, y, _] = shape.largest();
            assert!((x.max(y) - 1.0).abs() < 1e-9);
            for point in &shape.points {
                let sine = (half_waves * PI * (point.station_mm - 100.0) / 1000.0).sin();
                // The phase is that of one of the points that move most.
                let found = if x > y { point.x } else { point.y };
                assert!((found.abs() - sine.abs()).abs() < 0.02, "mode {i} at {}: {found} {sine}", point.station_mm);
            }
        }
        let first = &shapes[0].points;
        assert!(
            (first[0].station_mm - 100.0).abs() < 1e-9 && (first[first.len() - 1].station_mm - 1100.0).abs() < 1e-9
        );
    }

    #[test]
    fn a_rigid_rotor_has_no_mode_shapes() {
        let text = SCENE
            .replace("sections = [{ from = \"100 mm\", to = \"1100 mm\", outer_diameter = \"20 mm\" }]", "mass = 5")
            .replace("coordinates = 17", "diametral_inertia = 0.01\npolar_inertia = 0.01")
            .replace("proportional_damping = { mass = \"20 1/s\", stiffness = \"0 s\" }", "");
        let scene = read_str(&text, Path::new("scene.toml")).unwrap();
        let plant = Plant::try_new(&scene).unwrap();
        assert!(mode_shapes(&scene, &plant, 0.0).unwrap().is_empty());
    }
}
