//! Table of all samples: readings, twin, residual, and the position and the force of every bearing.

use super::comparison::SampleReadings;
use super::follow::FollowedSample;
use super::force::{Displacements, EvaluatedForce};
use super::forces_file::status_of;
use ballrace::Phase;
use ballrace_outcome::Samples;
use ballrace_outcome::options::Source;
use ballrace_plant::MountedBearing;
use ballrace_recording::status::SampleStatus;
use ballrace_scene::Probe;
use std::f64::consts::TAU;

const UM: f64 = 1e6;

/// Collects the samples of a replay.
pub(super) struct SampleCollector {
    samples: Samples,
    source: Source,
}

impl SampleCollector {
    /// Creates the table; positions and forces are those of `source`.
    pub(super) fn new(probes: &[Probe], bearings: &[MountedBearing], source: Source) -> Self {
        let mut names: Vec<String> = ["time_s", "speed_rpm", "shaft_angle_rad"].map(str::to_owned).to_vec();
        for probe in probes {
            names.extend(["measured", "twin", "residual"].map(|kind| format!("{}_{kind}_um", probe.column)));
        }
        for bearing in bearings {
            let columns = [
                "element_1_azimuth_rad",
                "u_m",
                "v_m",
                "w_m",
                "thu_rad",
                "thv_rad",
                "FX_N",
                "FY_N",
                "FZ_N",
                "MX_Nm",
                "MY_Nm",
            ];
            names.extend(columns.map(|column| format!("{}_{column}", bearing.name)));
        }
        names.push("status".to_owned());
        Self { samples: Samples { names, values: vec![] }, source }
    }

    /// Adds the row of one sample.
    pub(super) fn add(
        &mut self,
        followed: &FollowedSample,
        readings: &SampleReadings,
        (bearings, displacements, forces): (&[MountedBearing], &[Displacements], &[EvaluatedForce]),
        status: SampleStatus,
    ) {
        let FollowedSample { sample, parts, .. } = followed;
        let values = &mut self.samples.values;
        values.extend([sample.row.time, sample.speed * 60.0 / TAU, sample.angle.radians()]);
        for (measured, twin) in sample.row.probes.iter().zip(&readings.twin) {
            values.extend([measured, twin, &(measured - twin)].map(|y| y * UM));
        }
        for (((bearing, parts), displacements), force) in bearings.iter().zip(parts).zip(displacements).zip(forces) {
            values.push(bearing.azimuths(parts.cage).next().map_or(f64::NAN, Phase::radians));
            values.extend(displacements.of(self.source).to_array());
            values.extend(force.of(self.source));
        }
        values.push(f64::from(status_of(status, self.source).bits()));
    }

    /// Returns the table.
    pub(super) fn finish(self) -> Samples {
        self.samples
    }
}
