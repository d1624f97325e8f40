use super::*;
use crate::harness::probe;
use ballrace::Phase;
use ballrace_scene::{Clock, FileLayout, RotationSource};
use std::path::Path;

const RATE: f64 = 6400.0;

fn recording() -> Recording {
    Recording {
        layout: FileLayout::default(),
        temperatures: vec![],
        average: 1,
        file: "slow.csv".into(),
        clock: Clock::Rate(RATE),
        probes: vec![probe("x", 1.0), probe("y", 1.0)],
        sensors: vec![],
        rotation: RotationSource::keyphasor("key", 1),
        run_out: None,
        further_files: vec![],
        sequence: None,
    }
}

/// A bow of 12 um, an oval and a scratch of 40 degrees.
fn true_run_out(turns: f64) -> f64 {
    let angle = TAU * turns;
    let scratch = (1.0 + (angle - 2.0).cos()) / 2.0;
    12e-6 * (angle - 0.4).cos() + 3e-6 * (2.0 * angle).sin() - 8e-6 * scratch.powi(16)
}

fn noise(seed: &mut u64) -> f64 {
    let mut uniform = || {
        *seed ^= *seed << 13;
        *seed ^= *seed >> 7;
        *seed ^= *seed << 17;
        (*seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..12).map(|_| uniform()).sum::<f64>() - 6.0
}

/// Readings of two probes and of a keyphasor: run-out, a gap that drifts, noise.
fn slow_roll(count: usize, turns_per_second: f64, deviation: f64) -> [Vec<f64>; 3] {
    let (mut seed, mut last) = (0x9e37_79b9_7f4a_7c15, -1.0);
    let mut columns = [vec![], vec![], vec![]];
    for i in 0..count {
        let time = i as f64 / RATE;
        let turns = turns_per_second * time - 0.3;
        columns[0].push(true_run_out(turns) + 50e-6 + 1e-6 * time + deviation * noise(&mut seed));
        columns[1].push(2.0 * true_run_out(turns + 0.25) - 20e-6 + deviation * noise(&mut seed));
        columns[2].push(f64::from(u8::from(turns.floor() > last)));
        last = turns.floor();
    }
    columns
}

fn measured(columns: &[Vec<f64>; 3], speed: f64) -> Result<RunOut, RunOutError> {
    let names = ["x", "y", "key"].map(str::to_owned);
    let columns = names.into_iter().zip(columns.iter().map(Vec::as_slice)).collect();
    let recording = recording();
    let reader = Reader::from_columns(columns, Path::new("slow.csv"), &recording).map_err(RunOutError::Recording)?;
    RunOut::measure(reader, &recording, Speed::Constant(speed))
}

#[test]
fn a_known_run_out_is_removed() {
    // A keyphasor of steps is late by half a sample, 0.1 degrees: of 24 um that is 0.05 um, more on the scratch.
    for (deviation, most) in [(0.0, 0.2e-6), (0.5e-6, 0.6e-6)] {
        let run_out = measured(&slow_roll(64_000, 4.0, deviation), 314.0).unwrap();
        let mut largest = 0.0_f64;
        for i in 0..1000 {
            let turns = f64::from(i) / 1000.0;
            let mut readings = [true_run_out(turns), 2.0 * true_run_out(turns + 0.25)];
            run_out.subtract(Phase::from_revolutions(turns), &mut readings);
            // The mean is not touched: that of the scratch stays.
            let mean = -8e-6
                * (0..1000).map(|k| ((1.0 + (TAU * f64::from(k) / 1000.0).cos()) / 2.0).powi(16)).sum::<f64>()
                / 1000.0;
            largest = largest.max((readings[0] - mean).abs()).max((readings[1] - 2.0 * mean).abs());
        }
        println!("noise {deviation}: largest error {largest:.3e} m; {}", run_out.notes()[0]);
        assert!(largest < most, "{largest}");
        let [x, y] = run_out.probes() else { unreachable!("two probes") };
        assert!((y.rms() / x.rms() - 2.0).abs() < 0.01 && (x.rms() - 9e-6).abs() < 1e-6, "{}", x.rms());
        assert!(run_out.notes()[0].contains("39 revolutions at 240.0 rpm"), "{}", run_out.notes()[0]);
    }
}

/// Errors of a baseline, with a gap and fewer or more multiples than the slow roll, beside it and alone.
#[test]
fn errors_of_a_baseline_are_removed_too() {
    let slow_roll = measured(&slow_roll(64_000, 4.0, 0.0), 314.0).unwrap();
    let harmonics = [[0.0, 0.0], [2e-6, -1e-6]];
    let errors = [("x", 5e-6, &harmonics[..]), ("y", -3e-6, &[])];
    for known in [Some(&slow_roll), None] {
        let both = RunOut::with_errors(known, errors.into_iter(), "of the baseline");
        for turns in [0.0, 0.1, 0.7] {
            let (s, c) = (TAU * 2.0 * turns).sin_cos();
            let mut readings = [0.0; 2];
            known.iter().for_each(|known| known.subtract(Phase::from_revolutions(turns), &mut readings));
            let expected = [readings[0] - 5e-6 - 2e-6 * c + 1e-6 * s, readings[1] + 3e-6];
            let mut found = [0.0; 2];
            both.subtract(Phase::from_revolutions(turns), &mut found);
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{found:?} {expected:?}");
        }
        let last = both.notes().last().unwrap();
        assert!(
            last.contains("of the baseline are subtracted from the readings: x 5.00 um and 1.581 um, y -3.00"),
            "{last}"
        );
        assert_eq!(both.notes().len(), 1 + usize::from(known.is_some()));
    }
}

#[test]
fn noise_alone_is_no_run_out() {
    let mut columns = slow_roll(64_000, 4.0, 1e-6);
    let mut seed = 7;
    columns[0].iter_mut().for_each(|reading| *reading = 1e-6 * noise(&mut seed));
    let run_out = measured(&columns, 314.0).unwrap();
    let rms = run_out.probes()[0].rms();
    assert!(rms < 0.02e-6, "{rms}");
}

#[test]
fn recordings_that_cannot_be_used() {
    let error =
        |count: usize, turns: f64, speed: f64| measured(&slow_roll(count, turns, 0.0), speed).unwrap_err().to_string();
    let fast = error(32_000, 10.0, 314.159_265);
    assert!(fast.starts_with("recording.run_out: slow.csv: shaft too fast: 60"), "{fast}");
    assert!(fast.ends_with("rpm, expected at most 300.0 rpm, 10 % of the scene's fastest speed"), "{fast}");
    assert_eq!(
        error(6_000, 4.0, 314.0),
        "recording.run_out: slow.csv: too short: 3 whole revolutions with a reading of every probe, expected at least 4"
    );
    assert!(error(3_200, 0.5, 314.0).starts_with("recording.run_out: slow.csv: column key: "));
    let coarse = error(32_000, 110.0, 10_000.0);
    assert!(
        coarse.contains("too few samples: 5") && coarse.ends_with("in a revolution, expected at least 64"),
        "{coarse}"
    );
}

/// A tracker subtracts the run-out at the angle of each sample, before samples are averaged.
#[test]
fn the_tracker_subtracts_it() {
    let run_out = Arc::new(measured(&slow_roll(64_000, 4.0, 0.1e-6), 314.0).unwrap());
    let columns = slow_roll(12_800, 50.0, 0.0);
    for average in [1, 4] {
        let recording = Recording { average, ..recording() };
        let mut tracker = Tracker::of(&recording, RATE, Speed::Constant(314.0)).with_run_out(Some(run_out.clone()));
        let (mut errors, mut count) = (0.0, 0);
        let mut take = |tracker: &mut Tracker| {
            while let Some(sample) = tracker.pop() {
                // The gap and its drift are left.
                let rest = sample.row.probes[0] - 50e-6 - 1e-6 * sample.row.time;
                errors += (rest + 1.17e-6).powi(2);
                count += 1;
            }
        };
        for (i, ((x, y), key)) in columns[0].iter().zip(&columns[1]).zip(&columns[2]).enumerate() {
            let (index, time) = (i as u64, i as f64 / RATE);
            let probes = vec![*x, *y];
            tracker.push(Row { index, line: index, time, probes, rotation: *key, ..Row::default() }).unwrap();
            take(&mut tracker);
        }
        tracker.finish().unwrap();
        take(&mut tracker);
        let rms = (errors / f64::from(count)).sqrt();
        println!("average {average}: {rms:.3e} m left of 9e-6 m rms");
        assert!(rms < 0.25e-6, "{rms}");
    }
}
