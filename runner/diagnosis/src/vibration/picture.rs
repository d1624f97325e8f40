//! Envelope spectrum of a sensor for the report: the band of the strongest diagnosis, or the band with the largest modulation.

use super::envelope::BandEnvelope;
use super::suspect::Suspect;
use ballrace_outcome::{EnvelopeSpectrum, MarkedLine};
use ballrace_scene::Sensor;

/// Returns the spectrum of one sensor from `bands`, up to `highest` (Hz); `suspects` are the bearings that it measures, `found`
/// is the band of the strongest diagnosis.
pub fn envelope(
    sensor: &Sensor,
    suspects: &[&Suspect],
    [turn_hz, highest]: [f64; 2],
    bands: &[BandEnvelope],
    found: Option<[f64; 2]>,
) -> Option<EnvelopeSpectrum> {
    let most = || bands.iter().max_by(|a, b| a.total_modulation().total_cmp(&b.total_modulation()));
    let envelope = match found {
        Some(band) => bands.iter().find(|e| e.band == band),
        None => most(),
    }?;
    let (bin_hz, modulation) = envelope.spectrum(highest);
    let mut lines = vec![MarkedLine { label: "1X".to_owned(), order: 1.0, hz: turn_hz }];
    lines.extend(suspects.iter().flat_map(|suspect| marked(suspect, turn_hz)));
    let reason = match found {
        Some(_) => "the band of the diagnosis",
        None => "the most impulsive band; no line of a bearing stands out of any",
    };
    Some(EnvelopeSpectrum {
        name: sensor.column.clone(),
        band_hz: envelope.band,
        reason: reason.to_owned(),
        bin_hz,
        modulation,
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
