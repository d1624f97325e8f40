//! Figures of a running monitor: of its newest samples, and of the history of its indicators.

use super::figures::{Picture, present_loads, sections, trends};
use ballrace_twin::outcome::{Block, HalfSpectrum, LimitLine, Orbit, Outcome, Pictures, ProbeOutcome, Record, Trace};
use ballrace_twin::replay::Snapshot;
use ballrace_twin::scene::{Direction, Probe, Scene};
use ballrace_twin::spectrum::amplitudes;
use serde::Serialize;

/// Micrometres per metre.
const UM: f64 = 1e6;
/// Revolutions in traces and orbits.
const REVOLUTIONS: usize = 4;
/// Samples in traces and orbits without keyphasor pulses.
const SAMPLES: usize = 1024;
/// Points of all lines of the figures together.
const POINTS: usize = 20_000;

/// A figure for the live page.
#[derive(Debug, Clone, Serialize)]
pub struct LiveFigure {
    /// Heading of its section.
    pub heading: &'static str,
    /// Caption.
    pub title: String,
    /// Explanation; may be empty.
    pub note: String,
    /// An `svg` element.
    pub svg: String,
}

impl LiveFigure {
    fn new(heading: &'static str, Picture { title, note, drawing, .. }: Picture) -> Self {
        Self { heading, title, note, svg: drawing.svg }
    }
}

/// Draws the figures of the newest samples: orbits, traces, spectra and the loads on the elements.
#[must_use]
pub fn figures(scene: &Scene, snapshot: &Snapshot) -> Vec<LiveFigure> {
    let mut figures = vec![];
    for section in sections(&outcome(scene, snapshot), POINTS) {
        figures.extend(section.pictures.into_iter().map(|picture| LiveFigure::new(section.heading, picture)));
    }
    for (name, loads) in snapshot.loads.iter().filter(|(_, loads)| !loads.is_empty()) {
        figures.push(LiveFigure::new("Load on the rolling elements", present_loads(name, loads)));
    }
    figures
}

/// Draws the trends of the probes over `blocks`, whose times count from the present, with the limits of the scene.
#[must_use]
pub fn history(scene: &Scene, blocks: Vec<Block>, limits: Vec<LimitLine>, note: &str) -> Vec<LiveFigure> {
    let probes = probes(scene);
    let traces = probes.iter().map(|probe| Trace { name: probe.name.clone(), ..Trace::default() }).collect();
    let outcome =
        Outcome { probes, pictures: Pictures { blocks, limits, traces, ..Pictures::default() }, ..Outcome::default() };
    let drawn = trends(&outcome, POINTS);
    let noted = drawn.into_iter().map(|picture| Picture { note: note.to_owned(), ..picture });
    noted.map(|picture| LiveFigure::new("History", picture)).collect()
}

fn scene_probes(scene: &Scene) -> &[Probe] {
    scene.recording.as_ref().map_or(&[], |recording| &recording.probes)
}

fn probes(scene: &Scene) -> Vec<ProbeOutcome> {
    let probe = |probe: &Probe| ProbeOutcome {
        name: probe.column.clone(),
        angle_deg: probe.direction.angle().map(f64::to_degrees),
        ..ProbeOutcome::default()
    };
    scene_probes(scene).iter().map(probe).collect()
}

/// Returns an outcome that has the snapshot's samples in place of the first ones of a recording.
fn outcome(scene: &Scene, snapshot: &Snapshot) -> Outcome {
    let samples = &snapshot.samples;
    let pulses: Vec<usize> = (0..samples.len()).filter(|&i| samples[i].passed).collect();
    let first = match pulses.len().checked_sub(REVOLUTIONS + 1) {
        Some(pulse) => pulses[pulse],
        None => samples.len().saturating_sub(SAMPLES),
    };
    let time = |i: usize| snapshot.time_s - (samples.len() - 1 - i) as f64 / snapshot.rate_hz.max(1.0);
    let shown = || first..samples.len();
    let shown_pulses = || pulses.iter().copied().filter(|pulse| *pulse >= first);
    let column = |values: fn(&ballrace_twin::replay::snapshot::SnapshotSample) -> &[f64], i: usize| {
        move |sample: &ballrace_twin::replay::snapshot::SnapshotSample| {
            values(sample).get(i).map_or(f64::NAN, |value| value * UM)
        }
    };
    let probes = scene_probes(scene);
    let trace = |(i, probe): (usize, &Probe)| Trace {
        name: probe.column.clone(),
        time: shown().map(time).collect(),
        measured: samples[first..].iter().map(column(|s| &s.measured, i)).collect(),
        twin: samples[first..].iter().map(column(|s| &s.twin, i)).collect(),
        keyphasor: shown_pulses().map(time).collect(),
    };
    let orbit = |(name, plane): &(String, ballrace_twin::probes::Plane)| {
        let um = |readings: &[f64]| {
            let (x, y) = plane.xy(readings);
            (x * UM, y * UM)
        };
        let direction = |i: usize| match probes.get(i).map(|probe| (&probe.column, probe.direction)) {
            Some((column, Direction::Radial(angle))) => (column.clone(), angle),
            _ => (String::new(), f64::NAN),
        };
        Orbit {
            name: name.clone(),
            station_mm: plane.station * 1e3,
            measured: samples[first..].iter().map(|s| um(&s.measured)).collect(),
            twin: samples[first..].iter().map(|s| um(&s.twin)).collect(),
            keyphasor: shown_pulses().map(|pulse| pulse - first).collect(),
            probes: plane.probes.map(direction).to_vec(),
            one_x: None,
        }
    };
    let length = samples.len().checked_ilog2().map_or(0, |power| 1 << power);
    let latest = &samples[samples.len() - length..];
    let spectrum = |(i, probe): (usize, &Probe)| {
        let measured: Vec<f64> = latest.iter().map(column(|s| &s.measured, i)).collect();
        let twin: Vec<f64> = latest.iter().map(column(|s| &s.twin, i)).collect();
        let residual: Vec<f64> = measured.iter().zip(&twin).map(|(y, x)| y - x).collect();
        let is_complete = length >= 64 && measured.iter().chain(&twin).all(|value| value.is_finite());
        let of = |values: &[f64]| if is_complete { amplitudes(values) } else { vec![] };
        HalfSpectrum {
            name: probe.column.clone(),
            bin_hz: snapshot.rate_hz / length.max(1) as f64,
            measured: of(&measured),
            twin: of(&twin),
            residual: of(&residual),
        }
    };
    let mut pictures = Pictures { lines: snapshot.lines.clone(), ..Pictures::default() };
    if !samples.is_empty() {
        pictures.traces = probes.iter().enumerate().map(trace).collect();
        pictures.orbits = snapshot.planes.iter().map(orbit).collect();
        pictures.half_spectra = probes.iter().enumerate().map(spectrum).collect();
    }
    let record = Record { mean_speed_rpm: snapshot.speed_rpm, ..Record::default() };
    Outcome { probes: self::probes(scene), record, pictures, ..Outcome::default() }.with_stations_as_drawn(scene)
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use ballrace_twin::outcome::BlockFigures;
    use ballrace_twin::probes::planes;
    use ballrace_twin::replay::snapshot::SnapshotSample;
    use ballrace_twin::scene::read::read_str;
    use std::f64::consts::TAU;
    use std::path::Path;

    fn scene() -> Scene {
        read_str(include_str!("../demo/healthy.toml"), Path::new("demo")).unwrap()
    }

    fn snapshot(scene: &Scene, samples: usize) -> Snapshot {
        let sample = |i: usize| {
            let (sin, cos) = (TAU * i as f64 / 256.0).sin_cos();
            let readings = vec![8e-6 * cos, 5e-6 * sin, 3e-6 * cos, 3e-6 * sin, 0.0];
            SnapshotSample { measured: readings.clone(), twin: readings, passed: i.is_multiple_of(256) }
        };
        Snapshot {
            time_s: 12.5,
            speed_rpm: 3000.0,
            rate_hz: 12_800.0,
            samples: (0..samples).map(sample).collect(),
            planes: planes(scene_probes(scene)).into_iter().map(|p| ("<b>".to_owned(), p)).collect(),
            loads: vec![("DE".to_owned(), vec![(0.0, 10.0), (2.0, 0.0), (4.0, f64::NAN)])],
            ..Snapshot::default()
        }
    }

    #[test]
    fn newest_samples_are_drawn() {
        let scene = scene();
        let figures = figures(&scene, &snapshot(&scene, 4096));
        for heading in ["Orbits", "Spectra", "Load on the rolling elements"] {
            assert!(figures.iter().any(|figure| figure.heading == heading), "{heading}");
        }
        let all: String = figures.iter().map(|figure| figure.svg.as_str()).collect();
        assert!(!all.contains("NaN") && !all.contains("<b>"), "{all}");
        let outcome = outcome(&scene, &snapshot(&scene, 4096));
        let (orbit, spectrum) = (&outcome.pictures.orbits[0], &outcome.pictures.half_spectra[0]);
        assert!((orbit.keyphasor.len(), orbit.keyphasor[0]) == (REVOLUTIONS + 1, 0));
        let peak = spectrum.measured.iter().copied().fold(0.0, f64::max);
        assert!((peak - 8.0).abs() < 0.01, "{peak}");
    }

    #[test]
    fn few_or_no_samples_draw_what_there_is() {
        let scene = scene();
        for samples in [0, 1, 63, 300] {
            assert!(!figures(&scene, &snapshot(&scene, samples)).is_empty());
        }
        assert!(figures(&scene, &Snapshot::default()).is_empty());
    }

    #[test]
    fn a_history_is_drawn_in_time_before_the_present() {
        let scene = scene();
        let probes = vec![BlockFigures { greatest_um_pp: 3.0, ..BlockFigures::default() }; 5];
        let block = |i: i32| Block {
            start_s: f64::from(i),
            end_s: f64::from(i + 1),
            probes: probes.clone(),
            ..Block::default()
        };
        let drawn = history(&scene, (-7200..0).step_by(60).map(block).collect(), vec![], "a note");
        assert_eq!((drawn.len(), drawn[0].note.as_str()), (5, "a note"));
        assert!(drawn[0].svg.contains("Time, min"), "{}", drawn[0].svg);
    }
}
