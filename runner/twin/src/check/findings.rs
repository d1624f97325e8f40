//! Checks: what the recording shows, its probable cause and the remedy.

use super::{BearingSummary, ReadingSummary, RecordingSummary};
use crate::recording::rotation::RotationError;
use crate::scene::{Probe, RotationSource, Scene};
use serde::Serialize;
use std::f64::consts::TAU;

/// Ratio of measured and given speed beyond which they differ.
const SPEED_FACTOR: f64 = 1.5;
/// Largest relative distance of a speed ratio from a known mistake.
const NEAR: f64 = 0.05;
/// Largest share of readings out of range: spikes of a sound probe are rarer.
const MOST_OUT_OF_RANGE: f64 = 0.1;
/// Radial readings smaller than this share of the range that the bearings allow have another unit.
const TOO_SMALL: f64 = 1e-4;
/// Ratio of the 1X amplitudes of two planes beyond which one of them has another unit or sensitivity.
const PLANE_RATIO: f64 = 50.0;
/// Ratio of backward and forward 1X from which an orbit counts as backward.
const BACKWARD: f64 = 3.0;
/// Amplitude of 1X over its standard deviation by noise from which its direction is known: one in 1e6 by chance.
const CLEAR: f64 = 5.0;
/// Samples per period of the inner ball pass that a spectrum needs.
const SAMPLES_PER_PASS: f64 = 2.56;
/// Units of length that a column may be in by mistake: name and metres.
const UNITS: [(&str, f64); 5] = [("nm", 1e-9), ("um", 1e-6), ("mil", 25.4e-6), ("mm", 1e-3), ("m", 1.0)];

/// Something that is not plausible.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Implausibility {
    /// Key or column that it concerns.
    pub subject: String,
    /// Observation, with numbers.
    pub found: String,
    /// Probable cause.
    pub cause: String,
    /// Change that would remove it.
    pub remedy: String,
}

/// Data of the checks beside the summary of the recording.
#[derive(Default)]
pub(super) struct Evidence {
    /// Largest reading of each probe that the bearings allow, m.
    pub largest: Option<Vec<f64>>,
    /// Share of the readings of each probe beyond it.
    pub outside: Option<Vec<f64>>,
    /// Reason why the shaft angle is not known up to the end.
    pub rotation: Option<RotationError>,
    /// Standard deviation of the amplitude of 1X by noise, m.
    pub noise: Vec<f64>,
}

/// Returns all implausibilities.
pub(super) fn implausible(
    scene: &Scene,
    bearings: &[BearingSummary],
    recording: Option<&RecordingSummary>,
    evidence: &Evidence,
) -> Vec<Implausibility> {
    let mut all: Vec<Implausibility> = directions(scene).into_iter().collect();
    let Some(recording) = recording else { return all };
    all.extend(rotation(scene, evidence));
    all.extend(speed(scene, recording));
    all.extend(rate(bearings, recording));
    all.extend(out_of_range(scene, recording, evidence));
    all.extend(too_small(scene, recording, evidence));
    let planes = planes(recording, evidence);
    all.extend(backward(&planes));
    all.extend(unequal(&planes));
    all
}

/// Radial probes that all measure one direction.
fn directions(scene: &Scene) -> Option<Implausibility> {
    let probes = &scene.recording.as_ref()?.probes;
    let angles: Vec<f64> = probes.iter().filter_map(|probe| probe.direction.angle()).collect();
    let first = angles.first()?;
    let is_parallel = |angle: &f64| (angle - first).sin().abs() < 0.1;
    (angles.len() > 1 && angles.iter().all(is_parallel)).then(|| Implausibility {
        subject: "recording.probes".to_owned(),
        found: "all radial probes measure the same direction".to_owned(),
        cause: "an angle that was copied from another probe".to_owned(),
        remedy: "give each probe its angle, from +X towards +Y, such as \"0 deg\" and \"90 deg\"".to_owned(),
    })
}

fn rotation(scene: &Scene, evidence: &Evidence) -> Option<Implausibility> {
    let error = evidence.rotation.as_ref()?;
    let unit = match error {
        RotationError::ImplausibleSpeed { found, .. } => {
            let (low, high) = scene.shaft.speed.range();
            speed_unit(found.abs() / low.abs().max(high.abs()))
        }
        _ => None,
    };
    let other = || "another column, a dead keyphasor or a shaft at standstill".to_owned();
    Some(Implausibility {
        subject: "shaft angle".to_owned(),
        found: error.to_string(),
        cause: unit.map_or_else(other, str::to_owned),
        remedy: "check column and unit of keyphasor or speed".to_owned(),
    })
}

/// Returns the units that were taken for each other where a speed is `ratio` times the scene's.
fn speed_unit(ratio: f64) -> Option<&'static str> {
    let mistakes = [
        (60.0, "rev/s and rpm taken for each other"),
        (TAU, "rad/s and rev/s taken for each other"),
        (60.0 / TAU, "rad/s and rpm taken for each other"),
    ];
    let near = |factor: f64| [factor, 1.0 / factor].iter().any(|value| (ratio / value - 1.0).abs() < NEAR);
    mistakes.iter().find(|(factor, _)| near(*factor)).map(|(_, mistake)| *mistake)
}

fn speed(scene: &Scene, recording: &RecordingSummary) -> Option<Implausibility> {
    let [_, mean, _] = recording.speed_rpm.filter(|_| recording.speed_is_measured)?;
    let (low, high) = scene.shaft.speed.range();
    let [slow, fast] = [low.abs().min(high.abs()), low.abs().max(high.abs())].map(|speed| speed * 60.0 / TAU);
    if fast == 0.0 || (slow / SPEED_FACTOR..=fast * SPEED_FACTOR).contains(&mean.abs()) {
        return None;
    }
    let ratio = mean.abs() / (0.5 * (slow + fast));
    let is_count = |pulses: f64| pulses > 0.5 && (pulses / pulses.round() - 1.0).abs() < NEAR;
    let (cause, remedy) = match &scene.recording.as_ref()?.rotation {
        RotationSource::Keyphasor { pulses_per_turn, .. } if is_count(ratio * f64::from(*pulses_per_turn)) => {
            let pulses = (ratio * f64::from(*pulses_per_turn)).round();
            let marks = if pulses == 1.0 { "mark" } else { "marks" };
            (format!("{pulses} {marks} on the shaft"), format!("pulses_per_turn = {pulses}"))
        }
        RotationSource::SpeedColumn { .. } if speed_unit(ratio).is_some() => {
            (speed_unit(ratio).unwrap_or_default().to_owned(), "unit of the speed".to_owned())
        }
        _ => ("a recording at another speed, or of another machine".to_owned(), "[shaft] speed".to_owned()),
    };
    Some(Implausibility {
        subject: "shaft speed".to_owned(),
        found: format!("{mean:.0} rpm measured, {:.0} rpm in the scene", 0.5 * (slow + fast)),
        cause,
        remedy,
    })
}

/// A rate at which the ball pass of a bearing cannot be seen.
fn rate(bearings: &[BearingSummary], recording: &RecordingSummary) -> Option<Implausibility> {
    let [_, mean, _] = recording.speed_rpm?;
    let of = |bearing: &BearingSummary| bearing.orders[1].abs() * mean.abs() / 60.0;
    let fastest = bearings.iter().max_by(|a, b| of(a).total_cmp(&of(b)))?;
    let needed = SAMPLES_PER_PASS * of(fastest);
    (recording.rate_hz < needed).then(|| Implausibility {
        subject: "recording.rate".to_owned(),
        found: format!(
            "{:.0} Hz, while the balls of {} pass its inner race {:.0} times a second",
            recording.rate_hz,
            fastest.name,
            of(fastest)
        ),
        cause: "a rate in kHz without its unit, or a recording that is too slow for the bearings".to_owned(),
        remedy: format!("rate = \"... kHz\", or a recording with {needed:.0} Hz or more"),
    })
}

/// Returns the names of the units in which the readings would be in range, by the unit that the scene has.
fn fitting_units(peak_to_peak: f64, metres_per_unit: f64, range: f64) -> Vec<&'static str> {
    let fits = |(_, metres): &&(&str, f64)| {
        let size = peak_to_peak / metres_per_unit * metres;
        (metres / metres_per_unit - 1.0).abs() > 1e-6 && size < 2.0 * range && size > 2.0 * TOO_SMALL * range
    };
    UNITS.iter().filter(fits).map(|(name, _)| *name).collect()
}

/// Returns the remedy for readings of an improbable size.
fn unit_remedy(reading: &ReadingSummary, probe: &Probe, range: f64) -> String {
    if let Some(voltage) = reading.voltage {
        return format!("check unit, offset and sensitivity of the probe, {:.4} mV/um", voltage.sensitivity_mv_per_um);
    }
    let units = fitting_units(reading.peak_to_peak * 1e-6, probe.metres_per_unit, range);
    if units.is_empty() {
        "check unit, offset and sensitivity of the probe".to_owned()
    } else {
        format!("check the unit: the readings would be possible in {}", units.join(" or "))
    }
}

fn out_of_range(scene: &Scene, recording: &RecordingSummary, evidence: &Evidence) -> Vec<Implausibility> {
    let (Some(largest), Some(outside), Some(given)) = (&evidence.largest, &evidence.outside, &scene.recording) else {
        return vec![];
    };
    let each = recording.readings.iter().zip(&given.probes).zip(largest.iter().zip(outside));
    let mostly = each.filter(|(_, (_, outside))| **outside > MOST_OUT_OF_RANGE);
    let describe = |((reading, probe), (largest, outside)): ((&ReadingSummary, &Probe), (&f64, &f64))| {
        let [largest_um, mean] = [largest * 1e6, reading.mean];
        // An offset is much larger than the motion; readings in another unit are larger by one factor.
        let is_offset = mean.abs() > largest_um && reading.peak_to_peak < 2.0 * largest_um;
        let has_unit = reading.voltage.is_none()
            && !fitting_units(reading.peak_to_peak * 1e-6, probe.metres_per_unit, *largest).is_empty();
        let offset = match reading.voltage {
            Some(voltage) => format!("offset = \"{:.4} V\"", voltage.mean_v),
            None => format!("offset = \"{:.1} um\"", mean + probe.offset * 1e6),
        };
        let (gap, unit) = ("the gap of the probe is in the readings", "another unit or sensitivity");
        let (cause, remedy) = match (is_offset, has_unit) {
            (true, false) => (gap.to_owned(), offset),
            (true, true) => {
                (format!("{unit}, or {gap}"), format!("{}; or {offset}", unit_remedy(reading, probe, *largest)))
            }
            (false, _) => (unit.to_owned(), unit_remedy(reading, probe, *largest)),
        };
        Implausibility {
            subject: reading.column.clone(),
            found: format!(
                "{:.0} % of the readings are farther from zero than {largest_um:.0} um, which the bearings allow; mean {mean:.1} um, peak to peak {:.1} um",
                100.0 * outside,
                reading.peak_to_peak
            ),
            cause,
            remedy,
        }
    };
    mostly.map(describe).collect()
}

fn too_small(scene: &Scene, recording: &RecordingSummary, evidence: &Evidence) -> Option<Implausibility> {
    let (largest, given) = (evidence.largest.as_ref()?, scene.recording.as_ref()?);
    let radial = || {
        let each = recording.readings.iter().zip(&given.probes).zip(largest);
        each.filter(|((reading, _), _)| reading.radial.is_some())
    };
    let is_small = |reading: &ReadingSummary, largest: f64| {
        reading.peak_to_peak * 1e-6 < TOO_SMALL * largest && reading.mean.abs() * 1e-6 < TOO_SMALL * largest
    };
    let ((first, probe), range) = radial().next()?;
    radial().all(|((reading, _), largest)| is_small(reading, *largest)).then(|| Implausibility {
        subject: first.column.clone(),
        found: format!(
            "{:.2e} um peak to peak, and likewise at every radial probe; the bearings allow {:.0} um",
            first.peak_to_peak,
            range * 1e6
        ),
        cause: "another unit or sensitivity".to_owned(),
        remedy: unit_remedy(first, probe, *range),
    })
}

/// 1X of the two probes of one plane.
struct Plane {
    name: String,
    station: f64,
    /// Amplitudes of the orbit's forward and backward circle, um.
    forward: f64,
    backward: f64,
    /// Standard deviation of both by noise, um.
    noise: f64,
}

/// Returns the planes with two probes that are not parallel.
fn planes(recording: &RecordingSummary, evidence: &Evidence) -> Vec<Plane> {
    let probes: Vec<(&ReadingSummary, [f64; 2], f64)> = recording
        .readings
        .iter()
        .zip(&evidence.noise)
        .filter_map(|(reading, noise)| Some((reading, reading.radial?, noise * 1e6)))
        .collect();
    let mut planes: Vec<Plane> = Vec::new();
    for (i, (a, [station, angle_a], noise_a)) in probes.iter().enumerate() {
        let partner = probes.iter().skip(i + 1).find(|(_, [other, angle], _)| {
            (other - station).abs() < 1e-6 && (angle - angle_a).to_radians().sin().abs() > 0.3
        });
        if let Some((b, [_, angle_b], noise_b)) = partner
            && let (Some(one_a), Some(one_b)) = (a.one_x, b.one_x)
            && planes.iter().all(|plane| (plane.station - station).abs() > 1e-6)
        {
            let (forward, backward) = circles([*angle_a, *angle_b], [one_a, one_b]);
            let noise = noise_a.max(*noise_b);
            planes.push(Plane {
                name: format!("{} and {}", a.column, b.column),
                station: *station,
                forward,
                backward,
                noise,
            });
        }
    }
    planes
}

/// Returns the amplitudes of the forward and backward circle of an orbit from 1X (amplitude, phase lag) of two probes: a probe at
/// the angle `p` reads `F cos(wt - p + f) + B cos(wt + p + b)`.
fn circles(angles: [f64; 2], one_x: [[f64; 2]; 2]) -> (f64, f64) {
    let polar = |size: f64, degrees: f64| [size * degrees.to_radians().cos(), size * degrees.to_radians().sin()];
    let [a, b] = one_x.map(|[size, lag]| polar(size, -lag));
    let product = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a * c - b * d, a * d + b * c];
    let [p, q] = angles;
    // a = F e^(-ip) + B e^(ip), b = F e^(-iq) + B e^(iq)
    let denominator = 2.0 * (p - q).to_radians().sin().abs();
    let difference = |s: f64| {
        let ([ax, ay], [bx, by]) = (product(a, polar(1.0, s * q)), product(b, polar(1.0, s * p)));
        (ax - bx).hypot(ay - by) / denominator
    };
    (difference(1.0), difference(-1.0))
}

fn backward(planes: &[Plane]) -> Option<Implausibility> {
    let is_backward = |plane: &Plane| plane.backward > BACKWARD * plane.forward && plane.backward > CLEAR * plane.noise;
    let first = planes.first()?;
    planes.iter().all(is_backward).then(|| Implausibility {
        subject: first.name.clone(),
        found: format!(
            "the orbit of 1X is backward in every plane: {:.2} um against {:.2} um forward",
            first.backward, first.forward
        ),
        cause:
            "columns of X and Y exchanged, an angle from +X in the other direction, or a shaft that turns the other way"
                .to_owned(),
        remedy: "check the angles of the probes and the sign of [shaft] speed".to_owned(),
    })
}

fn unequal(planes: &[Plane]) -> Option<Implausibility> {
    let size = |plane: &Plane| plane.forward.hypot(plane.backward);
    let large = planes.iter().max_by(|a, b| size(a).total_cmp(&size(b)))?;
    let small = planes.iter().min_by(|a, b| size(a).total_cmp(&size(b)))?;
    let is_clear = size(large) > CLEAR * large.noise.max(small.noise);
    (is_clear && size(large) > PLANE_RATIO * size(small)).then(|| Implausibility {
        subject: format!("{}; {}", large.name, small.name),
        found: format!("1X of {:.3} um in one plane and {:.5} um in the other", size(large), size(small)),
        cause: "another unit or sensitivity of one plane".to_owned(),
        remedy: "check the units of the probes".to_owned(),
    })
}
