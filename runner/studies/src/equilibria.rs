//! Static equilibria over ranges of keys of a scene: stiffness, loads, life, friction and temperatures at each point.

use crate::equilibrium::{BearingEquilibrium, StaticEquilibrium, settled};
use crate::sweep::{Axis, check_units, named, scene_at, values_at};
use crate::thermal::thermal_equilibrium;
use ballrace_base::parallel;
use ballrace_plant::error::{Error, Result, SweepError, with_causes};
use serde::Serialize;
use std::path::Path;

/// Largest number of points.
const MOST: usize = 100_000;

/// A figure of one bearing in equilibrium.
pub struct BearingFigure {
    /// Name, with its unit as columns have it.
    pub name: &'static str,
    /// Name in words.
    pub words: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Value; `None` where the bearing does not have it.
    pub value: fn(&BearingEquilibrium, &StaticEquilibrium) -> Option<f64>,
}

fn largest(values: impl Iterator<Item = f64>) -> Option<f64> {
    values.reduce(f64::max)
}

/// Figures of each bearing.
pub const FIGURES: [BearingFigure; 13] = [
    figure("axial_force_N", "axial force", "N", |b, _| Some(b.force[2])),
    figure("radial_force_N", "radial force", "N", |b, _| Some(b.force[0].hypot(b.force[1]))),
    figure("largest_load_N", "largest load on an element", "N", |b, all| {
        largest(all.of(&b.name).map(|e| e.inner_load.max(e.outer_load)))
    }),
    figure("largest_pressure_MPa", "largest contact pressure", "MPa", |b, all| {
        largest(all.of(&b.name).flat_map(|e| [e.inner_pressure, e.outer_pressure]).flatten()).map(|p| p / 1e6)
    }),
    figure("stiffness_x_N_um", "stiffness along X", "N/um", |b, _| Some(b.stiffness[0][0] / 1e6)),
    figure("stiffness_z_N_um", "stiffness along Z", "N/um", |b, _| Some(b.stiffness[2][2] / 1e6)),
    figure("L10r_h", "reference life L10r", "h", |b, _| b.life.and_then(|life| life.hours(life.reference_life?))),
    figure("L10mr_h", "modified life L10mr", "h", |b, _| b.life.and_then(|life| life.hours(life.modified?.life?))),
    figure("friction_Nmm", "moment of friction", "N mm", |b, _| b.friction.map(|lost| 1e3 * lost.moment)),
    figure("power_W", "power of friction", "W", |b, _| b.friction.map(|lost| lost.power)),
    figure("inner_ring_degC", "temperature of the inner ring", "degC", |b, _| b.temperatures.map(|t| t.inner - 273.15)),
    figure("outer_ring_degC", "temperature of the outer ring", "degC", |b, _| b.temperatures.map(|t| t.outer - 273.15)),
    figure("clearance_um", "operating clearance", "um", |b, _| b.operating_clearance.as_ref().map(|s| s.operating_um)),
];

const fn figure(
    name: &'static str,
    words: &'static str,
    unit: &'static str,
    value: fn(&BearingEquilibrium, &StaticEquilibrium) -> Option<f64>,
) -> BearingFigure {
    BearingFigure { name, words, unit, value }
}

/// One point: the figures of each bearing, or why there are none.
#[derive(Debug, Clone, Serialize)]
pub struct EquilibriumPoint {
    /// Value of each axis in its unit.
    pub values: Vec<f64>,
    /// Name of each bearing with its figures in the order of [`FIGURES`]; empty without an equilibrium.
    pub bearings: Vec<(String, Vec<Option<f64>>)>,
    /// Why there is no equilibrium.
    pub failure: Option<String>,
}

/// Computes the equilibria of the scene in `text`, whose file is `path`, at all combinations of the axes, of which the first runs fastest: of the rotor or of
/// one `bearing` under a `load`, at the temperatures that friction and cooling keep where `is_thermal`. A point without an equilibrium states why.
/// `progress` is called with the number of points, and with 0 after each.
///
/// # Errors
/// Too many points, axes that the scene does not have, values that it rejects, no load.
pub fn equilibria(
    (text, path): (&str, &Path),
    axes: &[Axis],
    (bearing, load, is_thermal): (Option<&str>, Option<[f64; 5]>, bool),
    progress: &(dyn Fn(usize) + Sync),
) -> Result<Vec<EquilibriumPoint>> {
    let points = axes.iter().try_fold(1_usize, |product, axis| product.checked_mul(axis.values.len()));
    let Some(points) = points.filter(|points| *points <= MOST) else {
        let counts: Vec<String> = axes.iter().map(|axis| axis.values.len().to_string()).collect();
        return Err(SweepError::Equilibria { found: counts.join(" x "), most: MOST }.into());
    };
    check_units(text, path, axes)?;
    progress(points);
    let solve = if is_thermal { thermal_equilibrium } else { settled };
    let point = |point: &usize| -> Result<EquilibriumPoint> {
        let values = values_at(axes, *point);
        let at_point = |error| Error::Point { point: named(axes, &values), source: Box::new(error) };
        let scene = scene_at(text, path, axes, &values).map_err(at_point)?;
        let (found, failure) = match solve(&scene, bearing, load) {
            Ok(found) if found.is_in_equilibrium() => (Some(found), None),
            Ok(found) => (None, Some(format!("no equilibrium: {:.1e} of the load is not balanced", found.residual))),
            Err(error) if error.is_usage_error() => return Err(at_point(error)),
            Err(error) => (None, Some(with_causes(&error))),
        };
        let of = |all: &StaticEquilibrium| {
            let one = |b: &BearingEquilibrium| FIGURES.iter().map(|figure| (figure.value)(b, all)).collect();
            all.bearings.iter().map(|b| (b.name.clone(), one(b))).collect()
        };
        progress(0);
        Ok(EquilibriumPoint { bearings: found.as_ref().map(of).unwrap_or_default(), values, failure })
    };
    parallel::map(&(0..points).collect::<Vec<_>>(), point).into_iter().collect()
}
