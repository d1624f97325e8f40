//! Vibration severity: the broad-band velocity of bearing housings and its zone (ISO 20816-1 and -3).

use super::envelope::{Transforms, averaged};
use ballrace_outcome::{SensorOutcome, VelocityZone};
use ballrace_scene::{MachineClass, Sensor};
use std::f64::consts::TAU;

/// Range of frequencies, Hz.
const BAND_HZ: [f64; 2] = [10.0, 1000.0];
/// Speed below which the range begins at a lower frequency, rev/s, and that frequency, Hz.
const SLOW_HZ: f64 = 10.0;
const LOWEST_SLOW_HZ: f64 = 2.0;
/// Speeds for which ISO 20816-3 holds, rev/s.
const SPEEDS_HZ: [f64; 2] = [2.0, 500.0];
/// Sampling rate over the highest frequency.
const RATE: f64 = 2.56;
/// Periods of the lowest frequency in a block, and the fewest.
const PERIODS: f64 = 20.0;
const LEAST_PERIODS: f64 = 5.0;
/// Equivalent noise bandwidth of the Hann window, bins.
const NOISE_BINS: f64 = 1.5;
/// Standard gravity, m/s^2.
const GRAVITY: f64 = 9.806_65;

/// Returns the velocity at a sensor, from its acceleration by division by `2 pi f`; none for a sensor of another quantity, too low a rate
/// or too short a signal. `turn_hz` is the shaft speed, rev/s.
pub(crate) fn velocity(
    (sensor, signal): (&Sensor, &[f64]),
    (rate, turn_hz): (f64, f64),
    machine: Option<MachineClass>,
    transforms: &mut Transforms,
) -> Option<SensorOutcome> {
    let (to_si, is_acceleration) = match sensor.unit.as_str() {
        "g" => (GRAVITY, true),
        "m/s^2" => (1.0, true),
        "m/s" => (1.0, false),
        "mm/s" => (1e-3, false),
        _ => return None,
    };
    let [lowest, highest] = BAND_HZ;
    let lowest = if turn_hz < SLOW_HZ { LOWEST_SLOW_HZ } else { lowest };
    if rate < RATE * highest || (signal.len() as f64) < LEAST_PERIODS / lowest * rate {
        return None;
    }
    let spectrum = averaged(signal, rate, (1.0, PERIODS / lowest, highest + 1.0), transforms)?;
    let power = |(i, amplitude_squared): (usize, &f64)| {
        let hz = i as f64 * spectrum.bin_hz;
        let divisor = if is_acceleration { (TAU * hz).powi(2) } else { 1.0 };
        if (lowest..=highest).contains(&hz) { 0.5 * amplitude_squared / divisor } else { 0.0 }
    };
    let velocity = to_si * (spectrum.power.iter().enumerate().map(power).sum::<f64>() / NOISE_BINS).sqrt();
    let [slowest, fastest] = SPEEDS_HZ;
    let applies =
        |class: &MachineClass| matches!(class, MachineClass::Own(_)) || (slowest..=fastest).contains(&turn_hz);
    Some(SensorOutcome {
        name: sensor.column.clone(),
        velocity_rms_mm_s: 1e3 * velocity,
        band_hz: [lowest, highest],
        zone: machine.filter(applies).map(|class| VelocityZone::of(velocity, class.velocity_limits())),
    })
}

/// Returns a note on the velocity at a sensor.
pub(crate) fn note(of: &SensorOutcome) -> String {
    let [lowest, highest] = of.band_hz;
    let zone = of.zone.map_or_else(String::new, |zone| format!(", zone {zone:?}"));
    format!("{}: velocity {:.3} mm/s rms from {lowest:.0} to {highest:.0} Hz{zone}.", of.name, of.velocity_rms_mm_s)
}

/// States the zone of the machine, which is that of the sensor with the greatest velocity; none without a class of machine.
pub fn statement(sensors: &[SensorOutcome], machine: Option<MachineClass>) -> Option<String> {
    let class = machine?;
    let greatest = sensors.iter().max_by(|a, b| a.velocity_rms_mm_s.total_cmp(&b.velocity_rms_mm_s));
    let Some((greatest, zone)) = greatest.and_then(|sensor| Some((sensor, sensor.zone?))) else {
        return Some(
            "No zone of the vibration velocity: it needs a sensor of acceleration or velocity, a rate of 2560 Hz or more, five periods \
             of the lowest frequency, and for ISO 20816-3 a speed from 120 to 30000 rpm."
                .to_owned(),
        );
    };
    let [a, b, c] = class.velocity_limits().map(|limit| 1e3 * limit);
    Some(format!(
        "Vibration velocity: {:.2} mm/s rms at {}, zone {zone:?}, {} ({}: {a} / {b} / {c} mm/s).",
        greatest.velocity_rms_mm_s,
        greatest.name,
        zone.meaning(),
        class.name()
    ))
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use ballrace_scene::{MachineGroup, MachineSupport};

    fn of(unit: &str, amplitude: f64, turn_hz: f64, machine: Option<MachineClass>) -> Option<SensorOutcome> {
        let sensor = Sensor { column: "a".to_owned(), unit: unit.to_owned(), bearing: None };
        // Lines below, in and above the band, on an offset.
        let wave = |i: i32, hz: f64| (TAU * hz * f64::from(i) / 12_000.0).sin();
        let signal: Vec<f64> =
            (0..60_000).map(|i| 1.0 + amplitude * (wave(i, 80.0) + wave(i, 4.0) + 5.0 * wave(i, 3000.0))).collect();
        velocity((&sensor, &signal), (12_000.0, turn_hz), machine, &mut Transforms::default())
    }

    #[test]
    fn velocity_is_that_of_the_line_in_the_band() {
        // 1 g zero to peak at 80 Hz is 13.80 mm/s rms.
        let expected = 1e3 * GRAVITY / (TAU * 80.0) / 2.0_f64.sqrt();
        let found = of("g", 1.0, 25.0, None).unwrap();
        assert!((found.velocity_rms_mm_s / expected - 1.0).abs() < 2e-3, "{found:?} {expected}");
        assert_eq!((found.zone, found.band_hz), (None, [10.0, 1000.0]));
        let found = of("mm/s", 1.0, 25.0, None).unwrap();
        assert!((found.velocity_rms_mm_s - 0.5_f64.sqrt()).abs() < 2e-3, "{found:?}");
        // Below 600 rpm the line at 4 Hz is in the band.
        let slow = of("mm/s", 1.0, 9.0, None).unwrap();
        assert!((slow.velocity_rms_mm_s - 1.0).abs() < 2e-3 && slow.band_hz == [2.0, 1000.0], "{slow:?}");
        assert_eq!(of("N", 1.0, 25.0, None), None);
    }

    #[test]
    fn zones_are_those_of_the_class() {
        let class = |group, support| Some(MachineClass::Iso20816 { group, support });
        let medium = class(MachineGroup::Medium, MachineSupport::Rigid);
        for (rms, zone, machine) in [
            (1.39, VelocityZone::A, medium),
            (2.7, VelocityZone::B, medium),
            (4.4, VelocityZone::C, medium),
            (4.6, VelocityZone::D, medium),
            (4.6, VelocityZone::B, class(MachineGroup::Large, MachineSupport::Flexible)),
            (4.6, VelocityZone::A, Some(MachineClass::Own([5e-3, 6e-3, 7e-3]))),
        ] {
            let found = of("mm/s", rms * 2.0_f64.sqrt(), 25.0, machine).unwrap();
            assert_eq!(found.zone, Some(zone), "{found:?}");
        }
        // The standard holds from 120 rpm.
        assert_eq!(of("mm/s", 1.0, 1.0, medium).unwrap().zone, None);
        let sensors = [of("mm/s", 5.0, 25.0, medium).unwrap()];
        let said = statement(&sensors, medium).unwrap();
        assert!(said.starts_with("Vibration velocity: 3.54 mm/s rms at a, zone C, unsatisfactory"), "{said}");
        assert!(said.ends_with("(ISO 20816-3, group 2, rigid support, indicative: 1.4 / 2.8 / 4.5 mm/s)."), "{said}");
        assert_eq!(statement(&sensors, None), None);
    }
}
