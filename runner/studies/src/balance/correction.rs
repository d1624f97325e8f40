//! Correction masses: the moments that leave the least vibration, and the holes and weights that come nearest to them.

use super::error::BalanceError;
use super::holes::{HoleMass, PlaneHoles};
use super::placement::Placement;
use super::stock::StockChoice;
use super::table::C;
use super::vectors::{Mounted, Vectors};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

/// Correction of one plane.
#[derive(Debug, Clone, Serialize)]
pub struct PlaneCorrection {
    /// Plane.
    pub plane: String,
    /// Moment to add, beside the mounted one or instead of it, g mm.
    pub moment_g_mm: f64,
    /// Its angle, degrees.
    pub angle_deg: f64,
    /// Standard deviation of the moment in any direction, g mm.
    pub deviation_g_mm: f64,
    /// The probes show a mass of the size of the trial masses on this plane above drift and errors.
    pub observed: bool,
    /// Holes of the plane; `None` for masses at any angle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub circle: Option<PlaneHoles>,
    /// Masses in holes that come nearest to it; empty without holes.
    pub holes: Vec<HoleMass>,
    /// Moment that these masses leave, g mm.
    pub left_g_mm: f64,
}

/// Vibration of a probe before and after the correction.
#[derive(Debug, Clone, Serialize)]
pub struct Predicted {
    /// Probe.
    pub probe: String,
    /// Speed, rpm.
    pub speed_rpm: f64,
    /// Size of the vector before the correction.
    pub before: f64,
    /// Its angle, degrees.
    pub before_deg: f64,
    /// Standard deviation of that vector: by the coefficients and the drift.
    pub before_deviation: f64,
    /// Size with the correction.
    pub after: f64,
    /// Its angle, degrees.
    pub after_deg: f64,
    /// Standard deviation of the vector after the correction: by the coefficients, the drift and the masses.
    pub deviation: f64,
}

/// Correction of the rotor: with the masses of the last trim run, else without added masses.
#[derive(Debug, Clone, Serialize)]
pub struct Correction {
    /// Moment and masses of each plane.
    pub planes: Vec<PlaneCorrection>,
    /// Masses are removed at the holes, opposite to the moments to add.
    pub removes: bool,
    /// The mounted masses are taken off first.
    pub replaces: bool,
    /// What a choice of weights of the stock leaves; `None` without a stock.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stock: Option<StockChoice>,
    /// Combinations of the planes that the probes do not show above their errors, and that therefore stay 0.
    pub not_observed: usize,
    /// Vibration before and after.
    pub predicted: Vec<Predicted>,
    /// Moments that balance the rotor without added masses, g mm.
    #[serde(skip)]
    pub(super) moments: Vec<C>,
    /// Moments that are mounted before, g mm.
    #[serde(skip)]
    pub(super) mounted: Vec<C>,
    /// Moments that are mounted after, g mm.
    #[serde(skip)]
    pub(super) added: Vec<C>,
    /// Covariance of the moments.
    #[serde(skip)]
    pub(super) covariance: DMatrix<C>,
}

/// Least size of a combination of planes at the probes, with the trial moments, in units of the errors of the vectors.
pub(super) const OBSERVED: f64 = 3.0;

/// Moments that leave the least sum of squares.
pub(super) struct Optimum {
    /// Moments of the planes from the rotor without added masses, g mm.
    pub(super) moments: DVector<C>,
    /// Moments by the vectors of all channels: minus the inverse of the coefficients.
    inverse: DMatrix<C>,
    /// Combinations of the planes that stay 0.
    not_observed: usize,
}

/// Finds the moments that leave the least sum of squares of all vectors; combinations of planes that the probes do not show stay 0.
pub(super) fn optimum(of: &Vectors) -> Option<Optimum> {
    let (channels, planes) = (of.channels(), of.planes.len());
    let matrix = DMatrix::from_fn(channels, planes, |channel, k| of.coefficient(channel, k));
    let baseline = DVector::from_fn(channels, |channel, _| of.baseline(channel));
    let factors = of.weighted().svd(false, true);
    let seen: Vec<usize> = (0..planes.min(channels)).filter(|&i| factors.singular_values[i] >= OBSERVED).collect();
    let directions = factors.v_t?.adjoint();
    let inverse = if seen.is_empty() {
        DMatrix::zeros(planes, channels)
    } else {
        let seen_directions = directions.select_columns(&seen);
        &seen_directions * (&matrix * &seen_directions).pseudo_inverse(f64::EPSILON).ok()?
    };
    Some(Optimum { moments: -(&inverse * &baseline), inverse, not_observed: planes - seen.len() })
}

/// Returns the correction of the rotor as it is: the moments that are wanted beside the mounted ones, and the masses that come nearest.
pub(super) fn correction(of: &Vectors, placement: &Placement) -> Result<Correction, BalanceError> {
    let dependent = || BalanceError::Dependent { speed: of.speed(0) };
    let Optimum { moments, inverse, not_observed } = optimum(of).ok_or_else(dependent)?;
    let Mounted { moments: mounted, covariance: of_mounted } = of.mounted();
    let (kept, of_kept) = if placement.replaces {
        (vec![C::new(0.0, 0.0); mounted.len()], of_mounted.map(|_| C::new(0.0, 0.0)))
    } else {
        (mounted.clone(), of_mounted.clone())
    };
    let wanted: Vec<C> = moments.iter().zip(&kept).map(|(moment, kept)| moment - kept).collect();
    let placed = placement.place(&wanted, &of.metric(), of.channels())?;
    // What is put in is what acts.
    let added: Vec<C> = kept.iter().zip(&placed.moments).map(|(kept, moment)| kept + moment).collect();
    let by_channel = of.errors(&added) + of.errors_of_masses(&placed.moments) + of.carried(&of_kept);
    let of_before = of.errors(&mounted) + of.carried(&of_mounted);
    // Errors of the coefficients change the moments by what they leave of the vectors as well.
    let left: Vec<C> = (0..of.channels()).map(|channel| vector(of, channel, moments.as_slice())).collect();
    let normal = &inverse * inverse.adjoint();
    let of_moments = &inverse * of.errors(moments.as_slice()) * inverse.adjoint()
        + &normal * of.errors_of_left(&left) * &normal
        + of_kept;
    let shown = of.weighted();
    let plane = |(k, holes): (usize, Vec<HoleMass>)| PlaneCorrection {
        plane: of.planes[k].clone(),
        moment_g_mm: wanted[k].norm(),
        angle_deg: degrees(wanted[k]),
        deviation_g_mm: of_moments[(k, k)].re.max(0.0).sqrt(),
        observed: shown.column(k).norm() >= OBSERVED,
        circle: placement.holes.as_ref().map(|holes| PlaneHoles::from(&holes.circles[k])),
        holes,
        left_g_mm: (wanted[k] - placed.moments[k]).norm(),
    };
    let predicted = |channel: usize| {
        let (before, after) = (vector(of, channel, &mounted), vector(of, channel, &added));
        Predicted {
            probe: of.probe(channel).to_owned(),
            speed_rpm: of.speed(channel),
            before: before.norm(),
            before_deg: degrees(before),
            before_deviation: of_before[(channel, channel)].re.max(0.0).sqrt(),
            after: after.norm(),
            after_deg: degrees(after),
            deviation: by_channel[(channel, channel)].re.max(0.0).sqrt(),
        }
    };
    Ok(Correction {
        planes: placed.masses.into_iter().enumerate().map(plane).collect(),
        removes: placement.removes,
        replaces: placement.replaces,
        stock: placed.choice,
        not_observed,
        predicted: (0..of.channels()).map(predicted).collect(),
        moments: moments.iter().copied().collect(),
        mounted,
        covariance: of_moments,
        added,
    })
}

/// Returns the vector of a channel with moments on the planes.
fn vector(of: &Vectors, channel: usize, moments: &[C]) -> C {
    let by_masses = moments.iter().enumerate().map(|(k, u)| of.coefficient(channel, k) * u);
    of.baseline(channel) + by_masses.sum::<C>()
}

/// Returns the angle of a complex number, 0 to 360 degrees.
pub(super) fn degrees(of: C) -> f64 {
    of.arg().to_degrees().rem_euclid(360.0)
}
