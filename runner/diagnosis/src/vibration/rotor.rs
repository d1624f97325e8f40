//! Lines of the shaft in the vibration: what a bad rotor shows while its bearings are good.

use super::envelope::SensorSpectra;
use ballrace_outcome::baseline::{Baseline, BaselineSensor};
use ballrace_scene::Sensor;

/// Multiples of the shaft speed that are compared.
const MULTIPLES: usize = 3;
/// Growth from which a line of the vibration, or the motion of the shaft, has changed, dB: 2.5 is the ratio of two balance grades (ISO 21940-11).
pub(crate) const GROWTH_DB: f64 = 8.0;

/// Level below the baseline from which a machine stands still, dB.
const STANDSTILL_DB: f64 = 40.0;

/// Returns the reason why a machine whose level is far below its baseline at every sensor is not judged.
pub(crate) fn standstill(now: &[BaselineSensor], baseline: Option<&Baseline>) -> Option<String> {
    let below = |(now, before): (&BaselineSensor, &BaselineSensor)| {
        20.0 * (before.rms / now.rms.max(f64::MIN_POSITIVE)).log10()
    };
    let least_db = now.iter().zip(&baseline?.sensors).map(below).fold(f64::INFINITY, f64::min);
    (least_db.is_finite() && least_db >= STANDSTILL_DB).then(|| {
        format!("the level of every sensor is {least_db:.0} dB or more below the baseline: the machine stands still")
    })
}

/// Returns the amplitudes at the first multiples of the shaft speed, in the unit of the sensor.
pub(crate) fn amplitudes(spectra: &SensorSpectra, turn_hz: f64) -> Vec<f64> {
    let background = spectra.raw.background();
    (1..=MULTIPLES).map(|k| spectra.raw.line(k as f64 * turn_hz, 1, &background)[0].sqrt()).collect()
}

/// States which multiples of the shaft speed have grown against the baseline, and the conditions of the rotor that have these lines (ISO
/// 13373-3): 1X is of unbalance and of a bent shaft, 2X and 3X of misalignment, looseness and a bent shaft.
pub(crate) fn growth(
    sensors: &[(&Sensor, Option<SensorSpectra>)],
    now: &[BaselineSensor],
    baseline: Option<&Baseline>,
) -> Option<String> {
    let (mut grown, mut is_one_x, mut is_multiple) = (vec![], false, false);
    for (((sensor, _), now), before) in sensors.iter().zip(now).zip(&baseline?.sensors) {
        for (k, (now, before)) in now.shaft_lines.iter().zip(&before.shaft_lines).enumerate() {
            let growth_db = 20.0 * (now / before.max(f64::MIN_POSITIVE)).log10();
            if growth_db >= GROWTH_DB && growth_db.is_finite() {
                (is_one_x, is_multiple) = (is_one_x || k == 0, is_multiple || k > 0);
                grown.push(format!("{}X at {} by {growth_db:.0} dB to {now:.4} {}", k + 1, sensor.column, sensor.unit));
            }
        }
    }
    let cause = match (is_one_x, is_multiple) {
        (false, false) => return None,
        (true, false) => "unbalance or a bent shaft",
        (false, true) => "misalignment, a bent shaft or looseness",
        (true, true) => "unbalance, a bent shaft, misalignment or looseness",
    };
    Some(format!(
        "Grown against the baseline: {}. These lines turn with the shaft: {cause} is the cause, not a bearing.",
        grown.join(", ")
    ))
}
