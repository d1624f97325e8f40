//! Motions of known amplitude and phase.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use super::*;
use crate::harness::probe;
use crate::list;
use crate::outcome::{Orbit, Pictures, ProbeOutcome};
use ballrace::Phase;
use ballrace_plant::probes::planes;
use ballrace_recording::Row;
use ballrace_scene::Probe;

const RATE: f64 = 12_800.0;

fn probes() -> Vec<Probe> {
    vec![probe("X", 0.0), probe("Y", 0.5 * std::f64::consts::PI)]
}

/// The shaft at a speed (Hz) that may grow: its readings (m) by the turns that it has gone.
fn gone(trend: &mut Trend, seconds: f64, hz: impl Fn(f64) -> f64, reading: impl Fn(f64, f64) -> [f64; 2]) {
    let (mut turns, mut last) = (0.3, 0.3);
    for i in 0..(seconds * RATE) as u64 {
        let time = i as f64 / RATE;
        let sample = Sample {
            row: Row { index: i, time, probes: reading(turns, hz(time)).to_vec(), ..Row::default() },
            angle: Phase::from_radians(TAU * turns.rem_euclid(1.0)),
            revolution: turns.floor() as i64,
            speed: TAU * hz(time),
            acceleration: 0.0,
            status: Default::default(),
        };
        trend.add(&sample, &[0.0, 0.0], turns - last);
        last = turns;
        turns += hz(time + 0.5 / RATE) / RATE;
    }
}

/// Mean 500 um, 1X of 7 um at a lag of 40 degrees, 2X of 2 um, 0.5X of 1 um and the ball pass at 3.58X.
fn reading(turns: f64, _: f64) -> [f64; 2] {
    let part = |size: f64, order: f64, lag: f64| size * 1e-6 * (TAU * order * turns - lag.to_radians()).cos();
    let x = part(7.0, 1.0, 40.0) + part(2.0, 2.0, 0.0) + part(1.0, 0.5, 77.0) + part(0.5, 3.58, 0.0);
    [500e-6 + x, -3e-6 + part(7.0, 1.0, 130.0)]
}

#[test]
fn every_figure_of_a_known_motion() {
    let planes = planes(&probes());
    let mut trend = Trend::new(2, planes.clone());
    gone(&mut trend, 1.0, |_| 47.3, reading);
    let blocks = trend.finish();
    // 47.3 turns from 0.3 on: whole blocks from 4 to 44.
    assert_eq!(blocks.len(), 10);
    let mut rows = vec![ProbeOutcome::default(), ProbeOutcome::default()];
    list::fill(&mut rows, &blocks, false);
    let [x, y] = [0, 1].map(|i: usize| rows[i].list.unwrap());
    let near = |value: f64, true_value: f64, within: f64| {
        assert!((value - true_value).abs() < within, "{value} is not {true_value}");
    };
    near(x.one_x_um_pp, 14.0, 0.02);
    near(x.one_x_phase_lag_deg.unwrap(), 40.0, 0.1);
    near(y.one_x_phase_lag_deg.unwrap(), 130.0, 0.1);
    near(x.two_x_um_pp, 4.0, 0.02);
    near(x.half_x_um_pp, 2.0, 0.02);
    near(x.gap_um, 500.0, 0.05);
    near(y.direct_um_pp, 14.0, 0.02);
    near(y.not_one_x_um_pp, 0.0, 0.02);
    near(y.crest_factor, 2.0_f64.sqrt(), 0.01);
    near(y.kurtosis, 1.5, 0.01);
    let pictures = Pictures { blocks, orbits: vec![Orbit::default()], ..Pictures::default() };
    let plane = &list::planes(&planes, &pictures, 1.0)[0];
    near(plane.one_x_major_um_pp, 14.0, 0.02);
    near(plane.one_x_minor_um_pp, 14.0, 0.02);
    assert!(plane.one_x_forward);
    assert!(!list::planes(&planes, &pictures, -1.0)[0].one_x_forward);
}

/// A rotor on a spring: the 1X vector over the speed is that of the textbook, lag through 90 degrees at resonance.
#[test]
fn resonance_in_a_run_up() {
    let (natural, damping) = (60.0, 0.1);
    let vector = |hz: f64| {
        let r: f64 = hz / natural;
        let (re, im) = (1.0 - r * r, 2.0 * damping * r);
        (10.0 * r * r / re.hypot(im), im.atan2(re))
    };
    let mut trend = Trend::new(2, vec![]);
    gone(
        &mut trend,
        20.0,
        |t| 10.0 + 5.0 * t,
        |turns, hz| {
            let (size, lag) = vector(hz);
            [size * 1e-6 * (TAU * turns - lag).cos(), 0.0]
        },
    );
    let blocks = trend.finish();
    assert!(blocks.len() > 250, "{}", blocks.len());
    for block in &blocks {
        let (size, lag) = vector(block.speed_rpm / 60.0);
        let [cos, sin] = block.probes[0].one_x_um;
        assert!((cos - size * lag.cos()).hypot(sin - size * lag.sin()) < 0.03 * size + 0.02, "{}", block.speed_rpm);
    }
}

#[test]
fn long_recordings_stay_small_and_gaps_are_no_blocks() {
    let mut trend = Trend::new(2, vec![]);
    gone(&mut trend, 90.0, |_| 50.0, reading);
    let blocks = trend.finish();
    assert!((256..=512).contains(&blocks.len()), "{}", blocks.len());
    let last = blocks.last().unwrap();
    assert!(last.end_s > 89.0 && (last.probes[0].one_x_um[0].hypot(last.probes[0].one_x_um[1]) - 7.0).abs() < 0.02);
    let mut holes = Trend::new(2, vec![]);
    gone(
        &mut holes,
        1.0,
        |_| 50.0,
        |turns, hz| if turns.rem_euclid(4.0) < 0.5 { [f64::NAN; 2] } else { reading(turns, hz) },
    );
    assert!(holes.finish().is_empty());
}
