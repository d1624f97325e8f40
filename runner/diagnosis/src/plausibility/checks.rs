//! Checks of readings, shaft angle, speed and rate, each with its probable cause and the remedy.

use super::{Evidence, Implausibility, ReadingSummary};
use ballrace_models::build::kinematics;
use ballrace_plant::probes;
use ballrace_recording::rotation::RotationError;
use ballrace_scene::{Probe, Recording, RotationSource, Scene};
use std::f64::consts::TAU;

/// Ratio of measured and given speed beyond which they differ.
pub(super) const SPEED_FACTOR: f64 = 1.5;
/// Least share of the samples at a speed within that factor: a recording may hold a start or a stop.
const MIN_AT_SPEED: f64 = 0.1;
/// Largest relative distance of a speed ratio from a known mistake.
const NEAR: f64 = 0.05;
/// Largest share of readings out of range: spikes of a sound probe are rarer.
const MAX_OUT_OF_RANGE: f64 = 0.1;
/// Radial readings smaller than this share of the range that the bearings allow have another unit.
const TOO_SMALL: f64 = 1e-4;
/// Ratio of the motion at two probes of a plane beyond which one of them has another unit or sensitivity.
const PROBE_RATIO: f64 = 50.0;
/// The same for probes of different planes of a rigid rotor: its end in a worn bearing moves many times as much as the other, and
/// a plane in millimetres instead of micrometres is off by 1000.
const PLANE_RATIO: f64 = 200.0;
/// Ratio of backward and forward 1X from which an orbit counts as backward.
const BACKWARD: f64 = 3.0;
/// The same for one of several planes where no slow roll has been recorded: a run-out of random phases has it once in 100 times.
const BACKWARD_UNCOMPENSATED: f64 = 10.0;
/// Ratio of the 1X amplitude to its standard deviation by noise above which its direction is significant; noise exceeds it once in
/// 1e6 times.
const CLEAR: f64 = 5.0;
/// Samples per period of the inner ball pass that a spectrum needs.
const SAMPLES_PER_PASS: f64 = 2.56;
/// Units of length that a column may be in by mistake: name and metres.
const UNITS: [(&str, f64); 5] = [("nm", 1e-9), ("um", 1e-6), ("mil", 25.4e-6), ("mm", 1e-3), ("m", 1.0)];

/// Limits of the readings of each probe, and how often they were exceeded.
pub struct ReadingLimits {
    /// Largest magnitude of each reading that the bearings allow, m.
    pub largest: Vec<f64>,
    /// Share of the readings of each probe beyond it.
    pub outside: Vec<f64>,
}

/// Statistics of a recording, with its scene.
struct Checked<'a> {
    scene: &'a Scene,
    recording: &'a Recording,
    readings: Vec<ReadingSummary>,
    evidence: &'a Evidence<'a>,
}

/// Returns the implausibilities of readings, speed and rate.
pub(super) fn of_readings(evidence: &Evidence) -> Vec<Implausibility> {
    let Some(recording) = &evidence.scene.recording else { return vec![] };
    let readings = evidence.collected.summary(recording);
    let checked = Checked { scene: evidence.scene, recording, readings, evidence };
    let mut all: Vec<Implausibility> = directions(evidence.scene).into_iter().collect();
    all.extend(rotation(&checked));
    all.extend(speed(&checked));
    all.extend(rate(&checked));
    all.extend(monotonic(&checked));
    all.extend(out_of_range(&checked));
    all.extend(too_small(&checked));
    let planes = planes(&checked);
    all.extend(backward(&planes, if recording.run_out.is_some() { BACKWARD } else { BACKWARD_UNCOMPENSATED }));
    all.extend(unequal(&checked));
    all
}

/// Returns an implausibility if all radial probes measure one direction.
pub(super) fn directions(scene: &Scene) -> Option<Implausibility> {
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

fn rotation(checked: &Checked) -> Option<Implausibility> {
    let error = checked.evidence.rotation?;
    let unit = match error {
        RotationError::ImplausibleSpeed { found, .. } => {
            let (low, high) = checked.scene.shaft.speed.range();
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

fn speed(checked: &Checked) -> Option<Implausibility> {
    let (scene, speeds) = (checked.scene, checked.evidence.collected.speeds());
    let (low, high) = scene.shaft.speed.range();
    let is_measured = !matches!(checked.recording.rotation, RotationSource::Scene);
    let [_, mean, _] = speeds.rpm().filter(|_| is_measured && (low != 0.0 || high != 0.0))?;
    if speeds.share_at_speed() >= MIN_AT_SPEED {
        return None;
    }
    let [low, high] = [low, high].map(|speed| speed * 60.0 / TAU);
    let ratio = mean.abs() / (0.5 * (low + high)).abs();
    let is_count = |pulses: f64| pulses > 0.5 && (pulses / pulses.round() - 1.0).abs() < NEAR;
    let (cause, remedy) = match &checked.recording.rotation {
        RotationSource::Keyphasor { pulses_per_turn, .. } if is_count(ratio * f64::from(*pulses_per_turn)) => {
            let pulses = (ratio * f64::from(*pulses_per_turn)).round();
            let marks = if pulses == 1.0 { "mark" } else { "marks" };
            (
                format!("{pulses} {marks} on the shaft, or a recording at another speed or rate"),
                format!("pulses_per_turn = {pulses}, [shaft] speed or [recording] rate"),
            )
        }
        RotationSource::SpeedColumn { .. } if speed_unit(ratio).is_some() => {
            (speed_unit(ratio).unwrap_or_default().to_owned(), "unit of the speed".to_owned())
        }
        _ => (
            "a recording at another speed, of another machine or with another rate".to_owned(),
            "[shaft] speed or [recording] rate".to_owned(),
        ),
    };
    let of_scene = if low == high { format!("{low:.0} rpm") } else { format!("{low:.0} to {high:.0} rpm") };
    Some(Implausibility {
        subject: "shaft speed".to_owned(),
        found: format!("{mean:.0} rpm measured, {of_scene} in the scene; expected within a factor of {SPEED_FACTOR}"),
        cause,
        remedy,
    })
}

/// Returns an implausibility if the sampling rate is too low for the inner-race ball pass of a bearing.
fn rate(checked: &Checked) -> Option<Implausibility> {
    let [_, mean, _] = checked.evidence.collected.speeds().rpm()?;
    let bearings = checked.scene.bearings.iter().filter_map(|bearing| {
        let inner = kinematics(checked.scene, bearing).ok()?.orders.inner_race;
        Some((bearing.name.as_str(), inner.abs() * mean.abs() / 60.0))
    });
    let (name, fastest) = bearings.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let (rate_hz, needed) = (checked.evidence.rate_hz, SAMPLES_PER_PASS * fastest);
    (rate_hz < needed).then(|| Implausibility {
        subject: "recording.rate".to_owned(),
        found: format!("{rate_hz:.0} Hz, while the balls of {name} pass its inner race {fastest:.0} times a second"),
        cause: "a rate in kHz without its unit, or a recording that is too slow for the bearings".to_owned(),
        remedy: format!("rate = \"... kHz\", or a recording with {needed:.0} Hz or more"),
    })
}

/// Returns an implausibility if a column only rises or only falls.
fn monotonic(checked: &Checked) -> Option<Implausibility> {
    let column = checked.evidence.collected.monotonic()?;
    let reading = checked.readings.get(column)?;
    Some(Implausibility {
        subject: reading.column.clone(),
        found: format!("each of its {} readings is farther in one direction than the one before", reading.samples),
        cause: "a column of time or of a count".to_owned(),
        remedy: "the column of the probe".to_owned(),
    })
}

/// Returns the remedy for readings of an improbable size; `is_possible` returns true for a unit in metres that brings them into range.
fn unit_remedy(reading: &ReadingSummary, probe: &Probe, range: f64, is_possible: impl Fn(f64) -> bool) -> String {
    if let Some(voltage) = reading.voltage {
        return format!("check unit, offset and sensitivity of the probe, {:.4} mV/um", voltage.sensitivity_mv_per_um);
    }
    let metres_per_unit = probe.metres_per_unit;
    let fits = |(_, metres): &&(&str, f64)| {
        let size = reading.peak_to_peak * 1e-6 / metres_per_unit * metres;
        let is_another = (metres / metres_per_unit - 1.0).abs() > 1e-6;
        is_another && size < 2.0 * range && size > 2.0 * TOO_SMALL * range && is_possible(*metres)
    };
    let units: Vec<&str> = UNITS.iter().filter(fits).map(|(name, _)| *name).collect();
    if units.is_empty() {
        "check unit, offset and sensitivity of the probe".to_owned()
    } else {
        format!("check the unit: the readings would be possible in {}", units.join(" or "))
    }
}

fn out_of_range(checked: &Checked) -> Vec<Implausibility> {
    let Some(limits) = &checked.evidence.limits else { return vec![] };
    let each = checked.readings.iter().zip(&checked.recording.probes).zip(limits.largest.iter().zip(&limits.outside));
    let mostly = each.filter(|(_, (_, outside))| **outside > MAX_OUT_OF_RANGE);
    let describe = |((reading, probe), (largest, outside)): ((&ReadingSummary, &Probe), (&f64, &f64))| {
        let [largest_um, mean] = [largest * 1e6, reading.mean];
        // An offset is much larger than the motion; readings in another unit are larger by one factor.
        let is_offset = mean.abs() > largest_um && reading.peak_to_peak < 2.0 * largest_um;
        let size = reading.peak_to_peak.max(mean.abs()) * 1e-6;
        let is_smaller = |metres: f64| size * metres / probe.metres_per_unit < 2.0 * largest;
        let units = unit_remedy(reading, probe, *largest, is_smaller);
        let offset = match reading.voltage {
            Some(voltage) => {
                format!("offset = the voltage with the shaft in the middle, near the mean of {:.4} V", voltage.mean_v)
            }
            None => format!("offset = \"{:.1} um\"", mean + probe.offset * 1e6),
        };
        let (cause, remedy) = if is_offset {
            ("the gap of the probe is in the readings, or another unit", format!("{units}; or {offset}"))
        } else {
            ("another unit or sensitivity", units)
        };
        Implausibility {
            subject: reading.column.clone(),
            found: format!(
                "{:.0} % of the readings are farther from zero than {largest_um:.0} um, which the bearings allow; mean {mean:.1} um, peak to peak {:.1} um",
                100.0 * outside,
                reading.peak_to_peak
            ),
            cause: cause.to_owned(),
            remedy,
        }
    };
    mostly.map(describe).collect()
}

fn too_small(checked: &Checked) -> Option<Implausibility> {
    let limits = checked.evidence.limits.as_ref()?;
    let radial = || {
        let each = checked.readings.iter().zip(&checked.recording.probes).zip(&limits.largest);
        each.filter(|((reading, _), _)| reading.radial.is_some())
    };
    let is_small = |reading: &ReadingSummary, largest: f64| {
        largest.is_finite()
            && reading.peak_to_peak * 1e-6 < TOO_SMALL * largest
            && reading.mean.abs() * 1e-6 < TOO_SMALL * largest
    };
    let ((first, probe), range) = radial().next()?;
    radial().all(|((reading, _), largest)| is_small(reading, *largest)).then(|| Implausibility {
        subject: first.column.clone(),
        found: format!(
            "{} um peak to peak, and likewise at every radial probe; the bearings allow {:.0} um",
            micrometres(first.peak_to_peak),
            range * 1e6
        ),
        cause: if first.peak_to_peak > 0.0 { "another unit or sensitivity" } else { "dead probes or other columns" }
            .to_owned(),
        remedy: if first.peak_to_peak > 0.0 {
            unit_remedy(first, probe, *range, |_| true)
        } else {
            "check columns and cables of the probes".to_owned()
        },
    })
}

/// Formats a length, um.
fn micrometres(length: f64) -> String {
    if length == 0.0 { "0".to_owned() } else { format!("{length:.2e}") }
}

/// 1X of the two probes of one plane.
struct Plane {
    name: String,
    /// Amplitudes of the orbit's forward and backward circle, um.
    forward: f64,
    backward: f64,
    /// Standard deviation of both by noise, um.
    noise: f64,
}

/// Returns the planes of two probes.
fn planes(checked: &Checked) -> Vec<Plane> {
    let noise = checked.evidence.collected.one_x_noise();
    let plane = |plane: probes::Plane| {
        let [a, b] = plane.probes.map(|i| checked.readings.get(i));
        let (a, b) = (a?, b?);
        let ([_, angle_a], [_, angle_b]) = (a.radial?, b.radial?);
        let (forward, backward) = circles([angle_a, angle_b], [a.one_x?, b.one_x?]);
        let noise = plane.probes.iter().filter_map(|i| noise.get(*i)).fold(0.0, |a: f64, b| a.max(*b));
        Some(Plane { name: format!("{} and {}", a.column, b.column), forward, backward, noise: noise * 1e6 })
    };
    probes::planes(&checked.recording.probes).into_iter().filter_map(plane).collect()
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

fn backward(planes: &[Plane], ratio_of_one: f64) -> Option<Implausibility> {
    let is_clear = |plane: &&Plane| plane.backward.max(plane.forward) > CLEAR * plane.noise;
    let is_backward = |plane: &&Plane| is_clear(plane) && plane.backward > BACKWARD * plane.forward;
    let is_forward = |plane: &&Plane| is_clear(plane) && plane.forward > BACKWARD * plane.backward;
    let first = planes.iter().find(is_backward)?;
    // Backward whirl of one plane alone is possible between the critical speeds of two directions; there no plane is
    // clearly forward.
    let in_all = planes.iter().all(|plane| is_backward(&plane));
    let in_one = first.backward > ratio_of_one * first.forward && planes.iter().any(|plane| is_forward(&plane));
    (in_all || in_one).then(|| Implausibility {
        subject: first.name.clone(),
        found: format!(
            "the orbit of 1X is backward{}: {:.2} um against {:.2} um forward",
            if in_all { " in every plane" } else { ", and forward in another plane" },
            first.backward,
            first.forward
        ),
        cause:
            "columns of X and Y exchanged, an angle from +X in the other direction, or a shaft that turns the other way"
                .to_owned(),
        remedy: "check the angles of the probes and the sign of [shaft] speed".to_owned(),
    })
}

/// Returns an implausibility if the motion at a radial probe is far larger or smaller than at the others: within a plane, and
/// between planes where the rotor is rigid.
fn unequal(checked: &Checked) -> Option<Implausibility> {
    let is_rigid = checked.scene.rotor.as_ref().is_some_and(|rotor| rotor.flexible.is_none());
    let radial: Vec<usize> = (0..checked.readings.len()).filter(|i| checked.readings[*i].radial.is_some()).collect();
    let planes = probes::planes(&checked.recording.probes).into_iter().map(|plane| plane.probes.to_vec());
    let groups = planes.map(|plane| (plane, PROBE_RATIO)).chain(is_rigid.then_some((radial, PLANE_RATIO)));
    let rms = checked.evidence.collected.rms_in_range();
    let motion =
        |i: &usize| Some(ProbeMotion { column: &checked.readings.get(*i)?.column, rms: (*rms.get(*i)?)? * 1e6 });
    groups.filter_map(|(group, ratio)| odd_one(group.iter().filter_map(motion).collect(), ratio)).next()
}

/// Motion at a probe.
struct ProbeMotion<'a> {
    column: &'a str,
    /// Root of the mean square about the mean, um.
    rms: f64,
}

fn odd_one(mut group: Vec<ProbeMotion>, ratio: f64) -> Option<Implausibility> {
    group.sort_by(|a, b| a.rms.total_cmp(&b.rms));
    let (small, large, middle) = (group.first()?, group.last()?, group.get(group.len() / 2)?);
    (large.rms > ratio * small.rms).then(|| {
        // The outlier has the larger ratio to the median.
        let is_large = large.rms * small.rms > middle.rms * middle.rms;
        let (odd, other) = if is_large { (large, small) } else { (small, large) };
        Implausibility {
            subject: odd.column.to_owned(),
            found: format!(
                "{} um rms about the mean, while {} has {} um; expected within a factor of {ratio}",
                micrometres(odd.rms),
                other.column,
                micrometres(other.rms)
            ),
            cause: "another unit or sensitivity, a dead probe or another column".to_owned(),
            remedy: "check column, unit and cable of the probe".to_owned(),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One end of a rotor in a worn bearing may move 150 times as much as the other; a plane in another unit, 1000 times.
    #[test]
    fn planes_may_differ_by_less_than_another_unit() {
        let planes = |other: f64| {
            let motions = [("A_X", 0.1), ("A_Y", 0.11), ("B_X", other)];
            odd_one(motions.map(|(column, rms)| ProbeMotion { column, rms }).into(), PLANE_RATIO)
        };
        assert!(planes(15.0).is_none());
        assert_eq!(planes(100.0).map(|found| found.subject), Some("B_X".to_owned()));
    }
}
