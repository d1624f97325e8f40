//! Mean deflection of a flexible rotor: the static line of the shaft.

use super::statistics::Running;
use ballrace_outcome::{DeflectedLine, ProbeOutcome};
use ballrace_plant::Plant;
use ballrace_plant::probes::Plane;
use ballrace_scene::Scene;

const MM: f64 = 1e3;
const UM: f64 = 1e6;

/// Mean of the twin's coordinates.
pub(super) struct MeanDeflection {
    coordinates: Vec<Running>,
}

impl MeanDeflection {
    /// Creates the mean for a flexible rotor; none for another one.
    pub(super) fn new(plant: &Plant) -> Option<Self> {
        plant.layout.flexible().map(|_| Self { coordinates: vec![Running::default(); plant.layout.order] })
    }

    /// Adds the coordinates at a sample.
    pub(super) fn add(&mut self, coordinates: &[f64]) {
        for (sum, q) in self.coordinates.iter_mut().zip(coordinates) {
            sum.add(*q);
        }
    }

    /// Returns the mean line of the twin with the means of the probes at each plane; none without a sample.
    pub(super) fn line(
        &self,
        scene: &Scene,
        plant: &Plant,
        planes: &[Plane],
        probes: &[ProbeOutcome],
    ) -> Option<DeflectedLine> {
        let rotor = plant.layout.flexible()?;
        self.coordinates.first().filter(|sum| sum.count() > 0.0)?;
        let mean: Vec<f64> = self.coordinates.iter().map(Running::mean).collect();
        let station_mm = |z: f64| scene.drawn_station(z) * MM;
        let at = |z: &f64| {
            let rows = plant.layout.rows(*z);
            let [x, y] = [0, 1].map(|i| rows[i].iter().zip(&mean).map(|(row, q)| row * q).sum::<f64>() * UM);
            [station_mm(*z), x, y]
        };
        let measured: Vec<f64> = probes.iter().map(|probe| probe.measured.mean_um).collect();
        let plane = |plane: &Plane| {
            let (x, y) = plane.xy(&measured);
            [station_mm(plane.station), x, y]
        };
        Some(DeflectedLine {
            twin: rotor.free.mesh.stations.iter().map(at).collect(),
            measured: planes.iter().map(plane).collect(),
            bearings: scene.bearings.iter().map(|b| (b.name.clone(), station_mm(b.station))).collect(),
        })
    }
}
