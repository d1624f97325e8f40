//! Whirls of known size and sense.

#![expect(clippy::panic, reason = "a test fails by panicking")]

use super::*;
use crate::harness::probe;
use ballrace::Phase;
use ballrace_plant::probes::planes;
use ballrace_recording::Row;

/// Forward 5 um at 50 Hz, reverse 2 um at 120 Hz, for `seconds`.
fn spectra(probes: &[Probe], seconds: f64) -> Vec<Cascade> {
    let rate = 12_800.0;
    let planes = planes(probes);
    let mut spectra = Spectra::new(probes, &planes, rate, Speed::Constant(TAU * 50.0));
    for i in 0..(seconds * rate) as u64 {
        let time = i as f64 / rate;
        let (a, b) = (TAU * 50.0 * time, TAU * 120.0 * time);
        let at = [5e-6 * a.cos() + 2e-6 * b.cos() + 1e-3, 5e-6 * a.sin() - 2e-6 * b.sin()];
        spectra.add(&Sample {
            row: Row { index: i + 1, time, probes: at[..probes.len()].to_vec(), ..Row::default() },
            angle: Phase::ZERO,
            revolution: 0,
            speed: TAU * 50.0,
            acceleration: 0.0,
            status: Default::default(),
        });
    }
    spectra.finish()
}

/// Largest near a frequency.
fn at(cascade: &Cascade, slice: &Slice, hz: f64) -> f64 {
    let half = slice.amplitude_um.len() / 2;
    let middle = (half as f64 + hz / cascade.bin_hz).round() as usize;
    slice.amplitude_um[middle - 1..=middle + 1].iter().copied().fold(0.0, f64::max)
}

#[test]
fn sides_and_sizes_are_distinguished() {
    let plane = [probe("X", 0.0), probe("Y", 0.5 * std::f64::consts::PI)];
    for seconds in [2.0, 30.0] {
        let all = spectra(&plane, seconds);
        let [cascade] = &all[..] else { panic!("{}", all.len()) };
        assert!((20..=MOST).contains(&cascade.slices.len()), "{}", cascade.slices.len());
        for slice in &cascade.slices {
            // Scalloping of a Hann window: at most 15 %.
            assert!((4.2..5.01).contains(&at(cascade, slice, 50.0)) && at(cascade, slice, -50.0) < 0.05);
            assert!((1.7..2.01).contains(&at(cascade, slice, -120.0)) && at(cascade, slice, 120.0) < 0.05);
            assert!((slice.speed_rpm - 3000.0).abs() < 1e-6);
        }
    }
}

#[test]
fn a_lone_probe_has_its_whole_amplitude() {
    let all = spectra(&[probe("X", 0.0)], 1.0);
    let [cascade] = &all[..] else { panic!("{}", all.len()) };
    assert!(!cascade.two_sided);
    assert!(cascade.slices.iter().all(|slice| (4.2..5.01).contains(&at(cascade, slice, 50.0))));
}
