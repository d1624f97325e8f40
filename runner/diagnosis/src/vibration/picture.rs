//! Envelope spectrum of a sensor for the report.

use super::envelope::SensorSpectra;
use super::suspect::Suspect;
use ballrace_outcome::{EnvelopeSpectrum, MarkedLine};
use ballrace_scene::Sensor;

/// Returns the spectrum of one sensor up to `highest` (Hz); `suspects` are the bearings that it measures, `found` is
/// the number of the band of the diagnosis.
pub(super) fn envelope(
    sensor: &Sensor,
    suspects: &[&Suspect],
    [turn_hz, highest]: [f64; 2],
    spectra: &SensorSpectra,
    found: Option<usize>,
) -> Option<EnvelopeSpectrum> {
    let envelope = spectra.bands.get(found.unwrap_or(0))?;
    let count = (highest / envelope.spectrum.bin_hz).ceil() as usize + 1;
    let mut lines = vec![MarkedLine { label: "1X".to_owned(), order: 1.0, hz: turn_hz }];
    lines.extend(suspects.iter().flat_map(|suspect| marked(suspect, turn_hz)));
    let reason = if found.is_some() { "with the lines of the diagnosis" } else { "no family of a bearing stands out" };
    Some(EnvelopeSpectrum {
        name: sensor.column.clone(),
        band_hz: envelope.band,
        reason: format!("pre-whitened, {reason}"),
        bin_hz: envelope.spectrum.bin_hz,
        modulation: envelope.spectrum.power.iter().take(count).map(|p| p.sqrt()).collect(),
        side_bands_hz: suspects.iter().flat_map(|suspect| side_bands(suspect, turn_hz)).collect(),
        lines,
    })
}

/// Returns the order of a ball defect, which strikes both races in one revolution of the ball.
fn ball(suspect: &Suspect) -> f64 {
    2.0 * suspect.orders.ball_spin
}

fn marked(suspect: &Suspect, turn_hz: f64) -> Vec<MarkedLine> {
    let o = suspect.orders;
    let kinds = [("cage", o.cage), ("outer", o.outer_race), ("inner", o.inner_race), ("2x spin", ball(suspect))];
    let mark = |(kind, order): (&str, f64)| MarkedLine {
        label: format!("{} {kind}", suspect.name),
        order,
        hz: order * turn_hz,
    };
    kinds.into_iter().map(mark).collect()
}

/// Returns the side bands: the inner race passes the load zone with the shaft, a ball with the cage.
fn side_bands(suspect: &Suspect, turn_hz: f64) -> Vec<f64> {
    let o = suspect.orders;
    let about = |order: f64, by: f64| [order - by, order + by];
    [about(o.inner_race, 1.0), about(ball(suspect), o.cage)].concat().into_iter().map(|order| order * turn_hz).collect()
}
