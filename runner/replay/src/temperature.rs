//! Measured temperatures of bearing rings: the clearance of the model before a replay, and its range over the recording.

use ballrace_outcome::ClearanceOutcome;
use ballrace_plant::error::{ReplayError, Result};
use ballrace_recording::{Reader, Row};
use ballrace_scene::{Bearing, Recording, Scene, TemperatureChannel, Temperatures};
use std::collections::VecDeque;

/// Time over which the first temperatures are averaged, s.
const FIRST_SECONDS: f64 = 1.0;
/// 0 degrees Celsius, K.
const CELSIUS: f64 = 273.15;
/// Change of the clearance over the recording that is reported as one which the model does not follow, m.
const SMALL_CHANGE: f64 = 0.5e-6;

/// Least, mean and greatest temperature of each channel, K.
#[derive(Debug, Clone)]
struct Range {
    least: f64,
    sum: f64,
    count: f64,
    greatest: f64,
}

impl Default for Range {
    fn default() -> Self {
        Self { least: f64::INFINITY, sum: 0.0, count: 0.0, greatest: f64::NEG_INFINITY }
    }
}

impl Range {
    fn add(&mut self, temperature: f64) {
        if temperature.is_finite() {
            self.least = self.least.min(temperature);
            self.greatest = self.greatest.max(temperature);
            self.sum += temperature;
            self.count += 1.0;
        }
    }

    fn mean(&self) -> Option<f64> {
        (self.count > 0.0).then(|| self.sum / self.count)
    }
}

/// Reads the rows of the first second and returns them with the scene, whose clearances are those at their mean temperatures.
///
/// # Errors
/// A recording that cannot be read, a channel without a reading in the first second.
pub(super) fn corrected(
    scene: &Scene,
    recording: &Recording,
    reader: &mut Reader,
    name: &str,
) -> Result<(Scene, VecDeque<Row>)> {
    let (mut scene, mut rows) = (scene.clone(), VecDeque::new());
    if recording.temperatures.is_empty() {
        return Ok((scene, rows));
    }
    let mut ranges = vec![Range::default(); recording.temperatures.len()];
    let mut row = Row::default();
    while rows.front().is_none_or(|first: &Row| row.time - first.time < FIRST_SECONDS) && reader.next_row(&mut row)? {
        for (range, &temperature) in ranges.iter_mut().zip(&row.temperatures) {
            range.add(temperature);
        }
        rows.push_back(row.clone());
    }
    let means: Vec<Option<f64>> = ranges.iter().map(Range::mean).collect();
    if let Some((channel, _)) = recording.temperatures.iter().zip(&means).find(|(_, mean)| mean.is_none()) {
        let (recording, column) = (name.to_owned(), channel.column.clone());
        return Err(ReplayError::NoTemperature { recording, column }.into());
    }
    for bearing in &mut scene.bearings {
        let Some(measured) = measured(bearing, &recording.temperatures, &means) else { continue };
        bearing.set_temperatures(measured);
    }
    Ok((scene, rows))
}

/// Returns the temperatures of a bearing with those of its channels; none without a channel.
fn measured(bearing: &Bearing, channels: &[TemperatureChannel], readings: &[Option<f64>]) -> Option<Temperatures> {
    let given = bearing.mounting?.temperatures?;
    let own: Vec<(&TemperatureChannel, f64)> = channels
        .iter()
        .zip(readings)
        .filter(|(channel, _)| channel.bearing == bearing.name)
        .filter_map(|(channel, reading)| Some((channel, (*reading)?)))
        .collect();
    match own[..] {
        [] => None,
        [(one, reading)] => Some(given.measured(one.ring, reading)),
        _ => Some(own.iter().fold(given, |all, (channel, reading)| match channel.ring {
            ballrace_scene::Ring::Inner => Temperatures { inner: *reading, ..all },
            ballrace_scene::Ring::Outer => Temperatures { outer: *reading, ..all },
        })),
    }
}

/// Temperatures over a recording.
#[derive(Debug, Clone)]
pub(super) struct TemperatureMonitor {
    ranges: Vec<Range>,
    /// Least and greatest operating clearance of each bearing with a channel, m.
    clearances: Vec<Range>,
    readings: Vec<Option<f64>>,
}

impl TemperatureMonitor {
    /// Creates the monitor; none without temperatures.
    pub fn new(scene: &Scene) -> Option<Self> {
        let channels = &scene.recording.as_ref()?.temperatures;
        let clearances = vec![Range::default(); scene.bearings.len()];
        let readings = vec![None; channels.len()];
        (!channels.is_empty()).then(|| Self { ranges: vec![Range::default(); channels.len()], clearances, readings })
    }

    /// Adds the temperatures of a row.
    pub fn add(&mut self, scene: &Scene, row: &Row) {
        let Some(recording) = &scene.recording else { return };
        let mut has_changed = false;
        for ((range, reading), &temperature) in self.ranges.iter_mut().zip(&mut self.readings).zip(&row.temperatures) {
            range.add(temperature);
            if temperature.is_finite() && *reading != Some(temperature) {
                *reading = Some(temperature);
                has_changed = true;
            }
        }
        if !has_changed || self.readings.iter().any(Option::is_none) {
            return;
        }
        for (range, bearing) in self.clearances.iter_mut().zip(&scene.bearings) {
            if let (Some(mounting), Some(temperatures)) =
                (bearing.mounting, measured(bearing, &recording.temperatures, &self.readings))
            {
                range.add(mounting.at(Some(temperatures)).value());
            }
        }
    }

    /// Returns the notes of the outcome.
    pub fn notes(&self, scene: &Scene) -> Vec<String> {
        let channels = scene.recording.iter().flat_map(|recording| &recording.temperatures);
        let temperature = |(channel, range): (&TemperatureChannel, &Range)| {
            let [least, mean, greatest] = [range.least, range.mean()?, range.greatest].map(|kelvin| kelvin - CELSIUS);
            Some(format!("{}: {mean:.1} degC in the mean, {least:.1} to {greatest:.1} degC.", channel.column))
        };
        let clearance = |(bearing, range): (&Bearing, &Range)| {
            let (model, _) = (bearing.mounting?.operating(), range.mean()?);
            let [least, greatest] = [range.least, range.greatest].map(|x| x * 1e6);
            let is_large = range.greatest - range.least > SMALL_CHANGE;
            is_large.then(|| {
                format!(
                    "Bearing {}: the temperature changes the operating clearance from {least:.2} to {greatest:.2} um; the model keeps {:.2} um.",
                    bearing.name,
                    ClearanceOutcome::from(model).operating_um
                )
            })
        };
        let all = channels.zip(&self.ranges).filter_map(temperature);
        all.chain(scene.bearings.iter().zip(&self.clearances).filter_map(clearance)).collect()
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use ballrace_scene::read::read_str;
    use std::path::Path;

    const SCENE: &str = "[shaft]\nspeed = 100\n[[bearing]]\nname = \"A\"\nstation = 0\nmodel = \"angular\"\nelements = 8\n\
        ball_diameter = \"10 mm\"\npitch_diameter = \"50 mm\"\ninner_conformity = 0.52\nouter_conformity = 0.53\n\
        diametral_clearance = \"20 um\"\ntemperatures = { inner = \"50 degC\", outer = \"40 degC\" }\n[recording]\n\
        file = \"a.csv\"\nrate = 1000\nprobes = [{ column = \"x\", unit = \"um\", station = 0, angle = 0 }]\n\
        temperature = [\n{ column = \"To\", unit = \"degC\", bearing = \"A\", ring = \"outer\" },\n\
        { column = \"Ti\", unit = \"K\", bearing = \"A\", ring = \"inner\" },\n]\n";

    fn reader<'a>(scene: &Scene, inner: &'a [f64], outer: &'a [f64]) -> Reader<'a> {
        let columns = vec![("x".to_owned(), inner), ("Ti".to_owned(), inner), ("To".to_owned(), outer)];
        Reader::from_columns(columns, Path::new("r"), scene.recording.as_ref().unwrap()).unwrap()
    }

    /// The first second has 60 and 45 degrees; then the inner ring warms by 10 K, which takes 6 um.
    #[test]
    fn the_first_second_corrects_the_clearance() {
        let scene = read_str(SCENE, Path::new("s.toml")).unwrap();
        assert!((scene.bearings[0].clearance().unwrap() - 14e-6).abs() < 1e-12);
        let outer = vec![45.0; 3000];
        let inner: Vec<f64> = (0..3000).map(|i| CELSIUS + 60.0 + if i < 1000 { 0.0 } else { 10.0 }).collect();
        let mut reader = reader(&scene, &inner, &outer);
        let recording = scene.recording.as_ref().unwrap();
        let (corrected, rows) = corrected(&scene, recording, &mut reader, "r").unwrap();
        assert!((rows.len() as i64 - 1001).abs() <= 1, "{}", rows.len());
        // 12e-6 1/K, pitch diameter of 50 mm, 15 K.
        assert!((corrected.bearings[0].clearance().unwrap() - 11e-6).abs() < 1e-8);
        let mut monitor = TemperatureMonitor::new(&corrected).unwrap();
        let mut row = Row::default();
        rows.iter().for_each(|row| monitor.add(&corrected, row));
        while reader.next_row(&mut row).unwrap() {
            monitor.add(&corrected, &row);
        }
        let notes = monitor.notes(&corrected);
        assert_eq!(notes[0], "To: 45.0 degC in the mean, 45.0 to 45.0 degC.");
        assert_eq!(notes[1], "Ti: 66.7 degC in the mean, 60.0 to 70.0 degC.");
        assert!(
            notes[2].starts_with("Bearing A: the temperature changes the operating clearance from 5.00 to 11.00 um"),
            "{notes:?}"
        );
    }

    /// With one channel the other ring keeps its difference of the scene.
    #[test]
    fn one_channel_moves_both_rings() {
        let scene = read_str(SCENE, Path::new("s.toml")).unwrap();
        let bearing = &scene.bearings[0];
        let channels = &scene.recording.as_ref().unwrap().temperatures[..1];
        let found = measured(bearing, channels, &[Some(353.15)]).unwrap();
        assert!((found.inner - 363.15).abs() < 1e-9 && (found.outer - 353.15).abs() < 1e-9);
    }

    #[test]
    fn a_channel_without_a_reading_is_refused() {
        let scene = read_str(SCENE, Path::new("s.toml")).unwrap();
        let (inner, outer) = (vec![330.0; 2000], vec![f64::NAN; 2000]);
        let mut reader = reader(&scene, &inner, &outer);
        let error = corrected(&scene, scene.recording.as_ref().unwrap(), &mut reader, "r").unwrap_err();
        let expected = "r: To: no temperature in the first second, expected a reading for the clearance";
        assert_eq!(error.to_string(), expected);
    }
}
