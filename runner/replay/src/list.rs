//! Tabular list: overall and order-related figures of each probe and plane, from the blocks of the trend.

use super::pictures::filtered;
use super::trend::merged;
use ballrace_outcome::{Block, BlockFigures, Clearance, Pictures, PlaneOutcome, ProbeOutcome, TabularList};
use ballrace_plant::probes::Plane;
use ballrace_scene::{Bearing, FreeAngle, Scene};

const MM: f64 = 1e3;
const UM: f64 = 1e6;

/// Sets the row of each probe. Where the speed changes, a mean phase has no meaning and is omitted.
pub fn fill(probes: &mut [ProbeOutcome], blocks: &[Block], speed_changes: bool) {
    for (i, probe) in probes.iter_mut().enumerate() {
        let figures: Vec<&BlockFigures> = blocks.iter().filter_map(|block| block.probes.get(i)).collect();
        probe.list = (!figures.is_empty()).then(|| row(&figures, speed_changes));
    }
}

fn row(figures: &[&BlockFigures], speed_changes: bool) -> TabularList {
    let mean = |of: fn(&BlockFigures) -> f64| figures.iter().map(|f| of(f)).sum::<f64>() / figures.len() as f64;
    let (cos, sin) = (mean(|f| f.one_x_um[0]), mean(|f| f.one_x_um[1]));
    TabularList {
        direct_um_pp: mean(|f| f.peak_to_peak_um),
        greatest_um_pp: figures.iter().map(|f| f.greatest_um_pp).fold(0.0, f64::max),
        gap_um: mean(|f| f.mean_um),
        one_x_um_pp: 2.0 * mean(|f| f.one_x_um[0].hypot(f.one_x_um[1])),
        one_x_phase_lag_deg: (!speed_changes).then(|| sin.atan2(cos).to_degrees().rem_euclid(360.0)),
        two_x_um_pp: 2.0 * mean(|f| f.two_x_um),
        not_one_x_um_pp: mean(|f| f.not_one_x_um_pp),
        half_x_um_pp: 2.0 * mean(|f| f.half_x_um),
        crest_factor: mean(|f| f.crest_factor),
        kurtosis: mean(|f| f.kurtosis),
    }
}

/// Returns the figures of each plane; `sense` is +1 where the shaft turns from +X towards +Y.
#[must_use]
pub fn planes(planes: &[Plane], pictures: &Pictures, sense: f64) -> Vec<PlaneOutcome> {
    let Some(all) = merged(&pictures.blocks) else { return vec![] };
    let of = |(i, (plane, orbit)): (usize, (&Plane, &ballrace_outcome::Orbit))| {
        let [(xc, yc), (xs, ys)] = filtered(plane, &all).measured;
        // Decomposition of the orbit into a forward and a reverse circle.
        let forward = 0.5 * (xc + ys).hypot(yc - xs);
        let reverse = 0.5 * (xc - ys).hypot(yc + xs);
        PlaneOutcome {
            name: orbit.name.clone(),
            station_mm: plane.station * MM,
            smax_um_peak: all.smax_um.get(i).copied().unwrap_or(f64::NAN),
            one_x_major_um_pp: 2.0 * (forward + reverse),
            one_x_minor_um_pp: 2.0 * (forward - reverse).abs(),
            one_x_forward: sense * (forward - reverse) > 0.0,
        }
    };
    planes.iter().zip(&pictures.orbits).enumerate().map(of).collect()
}

/// Returns the clearance of the bearing nearest to each plane, where the scene gives it and has stations.
#[must_use]
pub fn clearances(scene: &Scene, planes: &[Plane]) -> Vec<Option<Clearance>> {
    let nearest = |plane: &Plane| match scene.system {
        Some(_) => None,
        None => clearance(&scene.bearings, plane.station),
    };
    planes.iter().map(nearest).collect()
}

fn clearance(bearings: &[Bearing], station: f64) -> Option<Clearance> {
    let away = |b: &Bearing| (b.station - station).abs();
    let bearing = bearings.iter().min_by(|a, b| away(a).total_cmp(&away(b)))?;
    let play = match (bearing.law.and_then(|law| law.radial_play), bearing.geometry.map(|g| g.fit)) {
        (Some(play), _) => play,
        (None, Some(FreeAngle::DiametralClearance(clearance))) => 0.5 * clearance,
        _ => return None,
    };
    let radius_um = play * UM;
    (radius_um > 0.0).then(|| Clearance { bearing: bearing.name.clone(), distance_mm: away(bearing) * MM, radius_um })
}
