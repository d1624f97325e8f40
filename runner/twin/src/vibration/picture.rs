//! The envelope spectrum that the report shows of a sensor: the band of the strongest finding, or the one that swells most.

use super::envelope::Envelope;
use super::judge::{Judge, Suspect};
use crate::outcome::{EnvelopeSpectrum, MarkedLine};
use crate::scene::Sensor;

/// Of one sensor, among the `bands` of which `found` is the one that the strongest finding rests on.
pub fn envelope(
    judge: &Judge,
    sensor: &Sensor,
    bands: &[Envelope],
    found: Option<[f64; 2]>,
) -> Option<EnvelopeSpectrum> {
    let most = || bands.iter().max_by(|a, b| a.swell().total_cmp(&b.swell()));
    let envelope = match found {
        Some(band) => bands.iter().find(|e| e.band == band),
        None => most(),
    }?;
    let (bin_hz, modulation) = envelope.spectrum(judge.range());
    let mut lines = vec![MarkedLine { label: "1X".to_owned(), order: 1.0, hz: judge.turn_hz }];
    lines.extend(judge.heard_by(sensor).flat_map(|suspect| marked(suspect, judge.turn_hz)));
    let reason = match found {
        Some(_) => "the band on which the finding rests",
        None => "the most impulsive band; no line of a bearing stands out of any",
    };
    Some(EnvelopeSpectrum {
        name: sensor.column.clone(),
        band_hz: envelope.band,
        reason: reason.to_owned(),
        bin_hz,
        modulation,
        side_bands_hz: judge.heard_by(sensor).flat_map(|suspect| side_bands(suspect, judge.turn_hz)).collect(),
        lines,
    })
}

/// A spot on a ball strikes both races in a turn of the ball.
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

/// The inner race turns through the load with the shaft, a ball with the cage.
fn side_bands(suspect: &Suspect, turn_hz: f64) -> Vec<f64> {
    let o = suspect.orders;
    let about = |order: f64, by: f64| [order - by, order + by];
    [about(o.inner_race, 1.0), about(ball(suspect), o.cage)].concat().into_iter().map(|order| order * turn_hz).collect()
}
