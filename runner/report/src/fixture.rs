//! Outcomes for the tests: a usual one, an empty one, and one with many long names; `broken` has invalid numbers.

mod broken;
mod snapshots;

pub(crate) use broken::{broken, with_data};
pub(crate) use snapshots::with_snapshots;

use ballrace_twin::recording::flaws::{Flaw, FlawLedger, FlawSummary, Position};
use ballrace_twin::replay::Source;
use ballrace_twin::replay::outcome::*;
use std::f64::consts::{FRAC_PI_2, TAU};

const SPEED_HZ: f64 = 50.0;
const RATE_HZ: f64 = 12_800.0;
const OUTER: f64 = 3.584;
const SAMPLES: usize = 2048;

/// Repeatable noise of about one standard deviation.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        let uniform = || {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1u64 << 53) as f64
        };
        std::iter::repeat_with(uniform).take(12).sum::<f64>() - 6.0
    }
}

/// Returns the position at one probe without noise, um; gain and phase of the twin differ slightly.
fn position(time: f64, angle: f64, size: f64, twin: bool) -> f64 {
    let (gain, lag) = if twin { (1.04, 0.05) } else { (1.0, 0.0) };
    let turn = TAU * SPEED_HZ * time;
    let pass = 0.12 * gain * (OUTER * turn + 0.4).cos() + 0.05 * (2.0 * OUTER * turn).cos();
    let (cosine, sine) = (angle.cos(), angle.sin());
    let static_part = -6.8 * sine + 0.3 * cosine;
    static_part
        + gain * size * (turn - angle - 0.6 - lag).cos()
        + 0.35 * (turn + angle).cos()
        + pass * sine.abs().max(0.3)
}

fn times() -> Vec<f64> {
    (0..SAMPLES).map(|i| i as f64 / RATE_HZ).collect()
}

fn motion(angle: f64, size: f64, twin: bool) -> Motion {
    let values: Vec<f64> = times().iter().map(|t| position(*t, angle, size, twin)).collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let range = values.iter().fold((f64::MAX, f64::MIN), |r, v| (r.0.min(*v), r.1.max(*v)));
    Motion {
        mean_um: mean,
        peak_to_peak_um: range.1 - range.0,
        rms_um: (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt(),
        one_x_um: size * if twin { 1.04 } else { 1.0 },
        one_x_phase_lag_deg: (angle.to_degrees() + 34.4 + if twin { 2.9 } else { 0.0 }).rem_euclid(360.0),
    }
}

fn probe(name: &str, station: f64, angle: Option<f64>, size: f64) -> ProbeOutcome {
    let direction = angle.unwrap_or(0.0).to_radians();
    let line = |bearing: &str, size: f64| BallPassLine {
        bearing: bearing.to_owned(),
        order: OUTER,
        frequency_hz: OUTER * SPEED_HZ,
        measured_um: size,
        twin_um: 1.04 * size,
        residual_um: 0.011,
    };
    ProbeOutcome {
        name: name.to_owned(),
        station_mm: station,
        angle_deg: angle,
        measured: motion(direction, size, false),
        twin: motion(direction, size, true),
        one_x_error_um: 0.064 * size,
        ball_pass: vec![line("DE", 0.121), line("NDE", 0.118)],
        residual_bias_um: -0.0123,
        residual_rms_um: 0.0571 * size.max(0.5),
        nrmse_percent: 1.62,
        nrmse_normaliser: "the peak-to-peak value of the measured signal".to_owned(),
        noise_um: Some(0.03),
        baselines: SimplePredictors {
            mean: SimplePredictor::new(0.71 * size, 0.034 * size, 0.71 * size),
            persistence: SimplePredictor::new(0.045 * size, 0.034 * size, 0.71 * size),
            one_x: SimplePredictor::new(0.098, 0.034 * size, 0.71 * size),
            linear: SimplePredictor::new(0.1834, 0.034 * size, 0.71 * size),
        },
        list: Some(TabularList {
            direct_um_pp: 2.3 * size,
            greatest_um_pp: 2.4 * size,
            gap_um: -6.8,
            one_x_um_pp: 2.0 * size,
            one_x_phase_lag_deg: Some(34.4),
            two_x_um_pp: 0.08,
            not_one_x_um_pp: 0.4,
            half_x_um_pp: 0.02,
            crest_factor: 1.5,
            kurtosis: 1.6,
        }),
    }
}

/// Returns successive blocks; `rpm` returns the speed at a share of their duration.
pub(crate) fn blocks(probes: usize, rpm: impl Fn(f64) -> f64) -> Vec<Block> {
    let figures = |probe: usize, share: f64| {
        let (sin, cos) = (0.4 + probe as f64 + 2.6 * share).sin_cos();
        let size = 0.5 + 5.0 * share;
        BlockFigures {
            mean_um: -6.8 + share,
            peak_to_peak_um: 2.1 * size,
            greatest_um_pp: 2.2 * size,
            not_one_x_um_pp: 0.3,
            rms_um: 0.7 * size,
            crest_factor: 1.5,
            kurtosis: 1.6 + share,
            residual_rms_um: 0.05,
            one_x_um: [size * cos, size * sin],
            twin_one_x_um: [1.04 * size * cos, 1.04 * size * sin],
            two_x_um: 0.04,
            half_x_um: 0.01,
        }
    };
    let block = |i: u32| {
        let share = f64::from(i) / 50.0;
        Block {
            start_s: 0.08 * f64::from(i),
            end_s: 0.08 * f64::from(i + 1),
            speed_rpm: rpm(share),
            probes: (0..probes).map(|probe| figures(probe, share)).collect(),
            smax_um: vec![3.0; 2],
        }
    };
    (0..50).map(block).collect()
}

fn cascade(name: &str) -> Cascade {
    let mut noise = Noise(4);
    let slice = |i: u32| {
        let at = |k: i32| amplitude(6.25 * f64::from(k), &spectrum_peaks(5.7, 1.0), 0.001, &mut noise);
        Slice { time_s: 0.16 * f64::from(i), speed_rpm: 3000.0, amplitude_um: (-400..=400).map(at).collect() }
    };
    Cascade { name: name.to_owned(), two_sided: true, bin_hz: 6.25, slices: (0..24).map(slice).collect() }
}

fn envelope_spectrum(name: &str) -> EnvelopeSpectrum {
    let mut noise = Noise(8);
    let at = |i: i32| amplitude(1.5625 * f64::from(i), &spectrum_peaks(0.3, 1.0)[1..], 0.01, &mut noise);
    EnvelopeSpectrum {
        name: name.to_owned(),
        band_hz: [2000.0, 3200.0],
        reason: "the band of the diagnosis".to_owned(),
        bin_hz: 1.5625,
        modulation: (0..700).map(at).collect(),
        lines: lines(),
        side_bands_hz: vec![220.0, 320.0],
    }
}

/// Returns [`usual`] for a run-up, with limits and an event.
pub(crate) fn run_up() -> Outcome {
    let mut outcome = usual();
    outcome.record.min_speed_rpm = 600.0;
    outcome.record.max_speed_rpm = 6000.0;
    let pictures = &mut outcome.pictures;
    pictures.blocks = blocks(5, |share| 600.0 + 5400.0 * share);
    for slice in pictures.cascades.iter_mut().flat_map(|cascade| &mut cascade.slices) {
        slice.speed_rpm = 600.0 + 1400.0 * slice.time_s;
    }
    let limit = |indicator, max| LimitLine { indicator, probe: "DE_X".to_owned(), max, ..LimitLine::default() };
    pictures.limits = vec![limit("peak-to-peak", 9.0), limit("1X", 4.0), limit("kurtosis", 3.0)];
    outcome.events = vec![Event {
        indicator: "peak-to-peak",
        probe: "DE_X".to_owned(),
        bearing: None,
        start_s: 3.0,
        end_s: None,
        worst: 12.0,
        worst_s: 4.0,
        limit: 9.0,
        unit: "um",
        sentence: "Limit crossed: peak-to-peak at DE_X up to 12.000 um.".to_owned(),
    }];
    outcome
}

fn bearing(name: &str, station: f64) -> BearingOutcome {
    let figures =
        |mean: f64, swing: f64| ForceFigures { mean, min: mean - swing, max: mean + swing, noise_sigma: Some(0.9) };
    let force =
        [figures(-0.2, 24.0), figures(29.6, 31.0), figures(-30.1, 4.2), figures(0.02, 0.11), figures(-0.01, 0.12)];
    BearingOutcome {
        name: name.to_owned(),
        model: "angular, 9 balls".to_owned(),
        station_mm: station,
        orders: BearingOrders { cage: 0.398, outer_race: OUTER, inner_race: 5.416, ball_spin: Some(2.357) },
        force_measured: force,
        force_estimated: force,
        force_twin: force.map(|f| ForceFigures { min: 0.97 * f.min, noise_sigma: None, ..f }),
        straight_line_error: None,
        largest_element_load_n: 31.4,
        contact_lost_samples: 0,
        held_samples: 12,
    }
}

fn trace(name: &str, angle: f64, size: f64) -> Trace {
    let mut noise = Noise(name.len() as u64 + 7);
    let time = times();
    let mut measured: Vec<f64> = time.iter().map(|t| position(*t, angle, size, false) + 0.03 * noise.next()).collect();
    measured[700..712].fill(f64::NAN);
    Trace {
        name: name.to_owned(),
        measured,
        twin: time.iter().map(|t| position(*t, angle, size, true)).collect(),
        keyphasor: (0..8).map(|turn| f64::from(turn) / SPEED_HZ + 0.001).collect(),
        time,
    }
}

fn orbit(x: (&str, f64), y: (&str, f64), station: f64, size: f64) -> Orbit {
    let mut noise = Noise(99);
    let mut at = |t: &f64, twin: bool, grain: f64| {
        let mut read = |angle: f64| position(*t, angle, size, twin) + grain * noise.next();
        (read(0.0), read(FRAC_PI_2))
    };
    Orbit {
        name: format!("{} and {}", x.0, y.0),
        station_mm: station,
        measured: times().iter().map(|t| at(t, false, 0.03)).collect(),
        twin: times().iter().map(|t| at(t, true, 0.0)).collect(),
        keyphasor: (0..8).map(|turn| 13 + 256 * turn).collect(),
        probes: [x, y].map(|probe| (probe.0.to_owned(), probe.1.to_radians())).to_vec(),
        one_x: Some(FilteredOrbit {
            speed_rpm: 3000.0,
            measured: [(size, 0.3), (-0.2, 0.8 * size)],
            twin: [(1.04 * size, 0.3), (-0.2, 0.83 * size)],
        }),
    }
}

/// Returns the amplitude of windowed sines on a noise floor at a frequency.
fn amplitude(hz: f64, peaks: &[(f64, f64)], floor: f64, noise: &mut Noise) -> f64 {
    let peak = |(at, size): &(f64, f64)| {
        let bins = (hz - at).abs() / 1.5625;
        size * if bins < 2.0 { (0.25 * TAU * bins / 2.0).cos().powi(2) } else { 0.0 }
    };
    floor * (0.3 + noise.next().hypot(noise.next())) + peaks.iter().map(peak).sum::<f64>()
}

fn spectrum_peaks(size: f64, gain: f64) -> Vec<(f64, f64)> {
    let pass = OUTER * SPEED_HZ;
    vec![
        (0.0, 6.0),
        (SPEED_HZ, gain * size),
        (2.0 * SPEED_HZ, 0.04),
        (pass, 0.12 * gain),
        (2.0 * pass, 0.05),
        (pass - 50.0, 0.01),
        (pass + 50.0, 0.012),
        (3.0 * pass, 0.008),
    ]
}

fn half_spectrum(name: &str, size: f64) -> HalfSpectrum {
    let mut noise = Noise(5);
    let mut curve = |peaks: &[(f64, f64)], floor: f64| {
        (0..4097).map(|i| amplitude(1.5625 * f64::from(i), peaks, floor, &mut noise)).collect()
    };
    let residual = [(SPEED_HZ, 0.06 * size), (OUTER * SPEED_HZ, 0.011), (0.0, 0.01)];
    HalfSpectrum {
        name: name.to_owned(),
        bin_hz: 1.5625,
        measured: curve(&spectrum_peaks(size, 1.0), 0.0008),
        twin: curve(&spectrum_peaks(size, 1.04), 1e-6),
        residual: curve(&residual, 0.0008),
    }
}

fn full_spectrum(name: &str, size: f64) -> FullSpectrum {
    let mut noise = Noise(6);
    let mut curve = |gain: f64| {
        let mut peaks = spectrum_peaks(size, gain);
        peaks.extend([(-SPEED_HZ, 0.35), (-OUTER * SPEED_HZ, 0.05)]);
        (-2048..=2048).map(|i| amplitude(3.125 * f64::from(i), &peaks, 0.001, &mut noise)).collect()
    };
    FullSpectrum { name: name.to_owned(), bin_hz: 3.125, measured: curve(1.0), twin: curve(1.04) }
}

fn lines() -> Vec<MarkedLine> {
    let line = |label: &str, order: f64| MarkedLine { label: label.to_owned(), order, hz: order * SPEED_HZ };
    let mut lines = vec![line("1X", 1.0), line("2X", 2.0)];
    for bearing in ["DE", "NDE"] {
        let kinds = [("cage", 0.398), ("outer", OUTER), ("inner", 5.416), ("spin", 2.357)];
        lines.extend(kinds.map(|(kind, order)| line(&format!("{bearing} {kind}"), order)));
    }
    lines
}

fn force_trace(name: &str) -> ForceTrace {
    let mut noise = Noise(3);
    let means = [0.0, 29.6, -30.1];
    let swing = [19.0, 21.0, 1.5];
    let mut curve = |axis: usize, grain: f64| -> Vec<f64> {
        let at = |t: &f64| {
            let turn = TAU * SPEED_HZ * t - axis as f64 * FRAC_PI_2;
            means[axis] + swing[axis] * turn.cos() + 4.0 * (OUTER * turn).cos() + grain * noise.next()
        };
        times().iter().map(at).collect()
    };
    let measured = [0, 1, 2].map(|axis| curve(axis, 0.9));
    let twin = [0, 1, 2].map(|axis| curve(axis, 0.0));
    ForceTrace {
        name: name.to_owned(),
        source: Source::Displacement,
        time: times(),
        measured,
        twin,
        sigma: [0.9, 1.1, 0.6].map(|s| vec![s; SAMPLES]),
    }
}

fn element_loads(name: &str) -> ElementLoads {
    let azimuth: Vec<f64> = (0..72).map(|i| (f64::from(i) + 0.5) * TAU / 72.0).collect();
    let zone = |at: f64, size: f64| 4.0 + size * (at + FRAC_PI_2).cos().max(0.0).powf(1.5);
    let loads = |size: f64| azimuth.iter().map(|at| zone(*at, size)).collect::<Vec<f64>>();
    let load = |i: u32| {
        let at = 0.398 * TAU * f64::from(i) / 256.0;
        (at, zone(at, 14.0) + 3.0 * (TAU * f64::from(i) / 256.0).cos())
    };
    ElementLoads {
        name: name.to_owned(),
        source: Source::Displacement,
        mean: loads(14.0),
        largest: loads(26.0),
        twin_mean: loads(14.8),
        first_element: (0..256 * 12).map(load).collect(),
        azimuth,
    }
}

/// A shaft with a disk, a cone and a bore.
fn rotor_drawing() -> RotorDrawing {
    let section = |from: f64, to: f64, outer_mm: [f64; 2], inner_mm: f64| DrawnSection {
        ends_mm: [from, to],
        outer_mm,
        inner_mm,
    };
    let probe = |name: &str, station_mm: f64, angle_deg| DrawnProbe { name: name.to_owned(), station_mm, angle_deg };
    RotorDrawing {
        sections: vec![section(-140.0, 0.0, [25.0, 40.0], 0.0), section(0.0, 140.0, [40.0, 40.0], 20.0)],
        disks: vec![
            DrawnDisk { station_mm: -20.0, diameter_mm: 150.0, width_mm: Some(20.0) },
            DrawnDisk { station_mm: 40.0, diameter_mm: 120.0, width_mm: None },
        ],
        bearings: vec![("DE".to_owned(), -100.0), ("NDE".to_owned(), 100.0)],
        probes: vec![
            probe("DE_X", -120.0, Some(0.0)),
            probe("DE_Y", -120.0, Some(90.0)),
            probe("NDE_X", 120.0, Some(45.0)),
            probe("NDE_Y", 120.0, Some(-45.0)),
            probe("AXIAL", 0.0, None),
        ],
        unbalances: vec![DrawnUnbalance { moment_g_mm: 120.0, angle_deg: 17.0, station_mm: -20.0 }],
        centre_of_mass_mm: 3.0,
    }
}

fn deflected_line() -> DeflectedLine {
    let point = |z: f64| [z, 0.3, -7.0 - 1.5 * (FRAC_PI_2 * z / 140.0).cos()];
    DeflectedLine {
        twin: (-14..=14).map(|i| point(10.0 * f64::from(i))).collect(),
        measured: vec![point(-120.0), point(120.0)],
        bearings: vec![("DE".to_owned(), -100.0), ("NDE".to_owned(), 100.0)],
    }
}

fn pictures() -> Pictures {
    let probes = [
        ("DE_X", 0.0, 5.7),
        ("DE_Y", FRAC_PI_2, 5.7),
        ("NDE_X", 0.0, 3.9),
        ("NDE_Y", FRAC_PI_2, 3.9),
        ("AXIAL", 0.2, 0.4),
    ];
    Pictures {
        rotor: Some(rotor_drawing()),
        deflected_line: Some(deflected_line()),
        traces: probes.iter().map(|(name, angle, size)| trace(name, *angle, *size)).collect(),
        orbits: vec![
            orbit(("DE_X", 0.0), ("DE_Y", 90.0), -120.0, 5.7),
            orbit(("NDE_X", 45.0), ("NDE_Y", 135.0), 120.0, 3.9),
        ],
        half_spectra: probes.iter().map(|(name, _, size)| half_spectrum(name, *size)).collect(),
        full_spectra: vec![full_spectrum("DE_X and DE_Y", 5.7), full_spectrum("NDE_X and NDE_Y", 3.9)],
        lines: lines(),
        natural_frequencies: vec![MarkedLine { label: "N1".to_owned(), order: f64::NAN, hz: 231.0 }],
        excerpt: Excerpt::default(),
        forces: vec![force_trace("DE"), force_trace("NDE")],
        element_loads: vec![element_loads("DE"), element_loads("NDE")],
        blocks: blocks(5, |_| 3000.0),
        cascades: vec![cascade("DE_X and DE_Y"), cascade("NDE_X and NDE_Y")],
        clearances: vec![Some(Clearance { bearing: "DE".to_owned(), distance_mm: 20.0, radius_um: 5.0 }), None],
        limits: vec![],
        envelopes: vec![envelope_spectrum("acceleration_DE")],
    }
}

fn flaws() -> Vec<FlawSummary> {
    let mut ledger = FlawLedger::default();
    ledger.record(Flaw::MissingValue, Some("DE_X"), Position { index: 700, line: 702, time: 0.0547 }, 12);
    ledger.record(Flaw::Gap, None, Position { index: 30_000, line: 30_002, time: 2.343_75 }, 640);
    ledger.summary()
}

fn observer() -> ObserverOutcome {
    ObserverOutcome {
        gate: 53.3,
        rejected_samples: 0,
        restarts: 0,
        distrusted_samples: 0,
        nis_mean: 5.02,
        nis_expected: 5.0,
        nis_bounds: [4.93, 5.07],
        consistent: true,
        process_noise_n_per_root_s: 5.9,
        noise_um: vec![0.03; 5],
        unknown_load_mean: [0.1, -0.2, 0.0, 1e-3, 0.0],
        unknown_load_rms: [0.4, 0.5, 0.1, 2e-3, 3e-3],
    }
}

fn timing() -> Timing {
    Timing {
        paced: true,
        samples: 51_200,
        compute: Quantiles { p50_ns: 1_210, p99_ns: 1_870, p999_ns: 3_440, max_ns: 41_300 },
        stages: Some(StageTimes { twin_ns: 420.0, observer_ns: 510.0, forces_ns: 330.0, comparison_ns: 610.0 }),
        pacing: Some(Pacing {
            block_ns: 5_000_000,
            blocks: 800,
            compute: Quantiles { p50_ns: 91_000, p99_ns: 130_000, p999_ns: 410_000, max_ns: 5_300_000 },
            lateness: Quantiles { p50_ns: 8_200, p99_ns: 31_000, p999_ns: 74_000, max_ns: 212_000 },
            deadline_misses: 1,
            starting_s: 0.31,
            idle_percent: Some(97.2),
            scheduling: "ordinary scheduling".to_owned(),
        }),
        source: Some(SourceFigures {
            rows: 51_200,
            lost_frames: 12,
            ring_capacity: 262_144,
            ..SourceFigures::default()
        }),
        outputs: None,
        sample_period_ns: 78_125,
        wall_s: 4.003,
        diagnosis_s: 2.5,
        times_real_time: 0.9993,
        peak_memory_bytes: Some(18_400_000),
    }
}

/// A spall at 290 deg.
fn spall() -> FaultParameters {
    let around = |value: f64, half: f64| Some(Estimate { value, low: value - half, high: value + half });
    FaultParameters {
        form: Some(FaultForm::Spall),
        azimuth_deg: around(290.0, 2.0),
        half_width_deg: around(2.5, 0.3),
        depth_um: around(3.0, 0.4),
        odds_to_next: Some(1e12),
        ..FaultParameters::default()
    }
}

/// Returns figures of a diagnosis with these values, which may be any numbers.
fn fault_figures(values: &[f64]) -> FaultFigures {
    let pairs: Vec<(f64, f64)> = values.iter().enumerate().map(|(i, x)| (i as f64 - 2.0, *x)).collect();
    let spectrum = |frame, is_of_component| ForceSpectrum {
        frame,
        is_of_component,
        unexplained: pairs.clone(),
        explained: pairs.iter().copied().take(3).collect(),
        lines: values.to_vec(),
    };
    FaultFigures {
        rose: Some(ForceRose {
            frame: ReferenceFrame::Fixed,
            energy: values.to_vec(),
            direction_deg: values.first().copied().unwrap_or(0.0),
            peak_n: values.last().copied().unwrap_or(0.0),
            passes: 240.0,
            pass: values.iter().map(|x| [*x, *x, -*x]).collect(),
            element_azimuths: values.to_vec(),
            ball_over_pitch: 0.2,
        }),
        spectra: vec![
            spectrum(ReferenceFrame::Fixed, true),
            spectrum(ReferenceFrame::Shaft, false),
            spectrum(ReferenceFrame::Cage, false),
        ],
        motion: Some(FaultMotion {
            probe: "DE_X".to_owned(),
            revolutions: values.to_vec(),
            measured: values.to_vec(),
            without: values.to_vec(),
            with: values.iter().take(2).copied().collect(),
            unexplained: UnexplainedMotion::new("DE_X", [0.348, 0.018, 0.017]),
        }),
    }
}

/// Two bearings, four radial probes and an axial one, 3000 rpm.
pub(crate) fn usual() -> Outcome {
    let record = Record {
        samples: 51_200,
        average: 1,
        compared: 51_188,
        rate_hz: RATE_HZ,
        duration_s: 4.0,
        turns: 200.0,
        mean_speed_rpm: 3000.0,
        min_speed_rpm: 2997.2,
        max_speed_rpm: 3002.9,
        angle_source: "keyphasor in column KEY, 200 pulses, 1 per revolution".to_owned(),
        is_run_out_subtracted: false,
        load: [0.0, 0.0, 60.0, 0.0, 0.0],
        spectra: SpectraSettings { lines: 2048, bin_hz: 3.125, averages: 24 },
    };
    let diagnosis = Diagnosis {
        kind: FaultKind::OuterRace,
        parameters: spall(),
        figures: fault_figures(&[0.0, 2.0, -1.0, 0.5, 3.0]),
        bearing: Some("DE".to_owned()),
        failure_modes: FailureMode::of(FaultKind::OuterRace, Some(FaultForm::Spall)).to_vec(),
        line_hz: 179.2,
        order: OUTER,
        level_db: 17.4,
        confidence: 0.91,
        evidence: vec![EvidenceSource::ShaftMotion],
        vibration: None,
        lines: vec![],
        sentence: "The outer race of bearing DE is damaged: its ball-pass line and two harmonics stand 17 dB above \
                   what the twin explains. Plan a replacement and repeat the measurement within a week."
            .to_owned(),
    };
    Outcome {
        file: Some(RecordingFile {
            sha256: "27ca0587c537a3ead0a97132ad2452e3f402dd242d2b8c6c0a71ede89289c175".to_owned(),
            bytes: 588_866,
            modified: "2026-11-27T11:03:22Z".to_owned(),
        }),
        snapshots: vec![],
        snapshot_trends: vec![],
        implausible: vec![],
        not_judged: vec![],
        scene: "Test rig with two 6205 bearings".to_owned(),
        recording: "outer-spall.csv".to_owned(),
        version: "0.1.0".to_owned(),
        verdict: "The twin follows the machine to within 0.33 um rms (NRMSE 1.6 %) and beats every simple predictor \
                  at 1 of 5 probes; bearing DE shows damage of its outer race."
            .to_owned(),
        record,
        twin: ComparedTwin::default(),
        observation: Observation { condition_number: 1.41, noise_gain: 1.07, supplied_by_twin: Vec::new() },
        probes: vec![
            probe("DE_X", -120.0, Some(0.0), 5.7),
            probe("DE_Y", -120.0, Some(90.0), 5.7),
            probe("NDE_X", 120.0, Some(0.0), 3.9),
            probe("NDE_Y", 120.0, Some(90.0), 3.9),
            probe("AXIAL", 0.0, None, 0.4),
        ],
        planes: [("DE_X / DE_Y", -120.0), ("NDE_X / NDE_Y", 120.0)]
            .map(|(name, station_mm)| PlaneOutcome {
                name: name.to_owned(),
                station_mm,
                smax_um_peak: 5.9,
                one_x_major_um_pp: 11.4,
                one_x_minor_um_pp: 10.1,
                one_x_forward: true,
            })
            .to_vec(),
        rotor: Some(RotorOutcome {
            mass_kg: 10.098,
            centre_of_mass_mm: 266.71,
            diametral_inertia_kg_m2: 0.081,
            polar_inertia_kg_m2: 0.0234,
            coordinates: 13,
            finite_element_coordinates: 130,
            highest_line_hz: 1133.3,
            frequency_error_percent: 0.09,
            accurate_to_hz: 1080.0,
            deflection_error_percent: 0.004,
            response_error_percent: 0.12,
        }),
        bearings: vec![bearing("DE", -100.0), bearing("NDE", 100.0)],
        sensors: vec![],
        timing: timing(),
        observer: Some(observer()),
        events: vec![],
        diagnoses: vec![diagnosis],
        diagnosis: None,
        flaws: flaws(),
        notes: vec![
            "The scene gives no rotor temperature; 20 degrees are assumed.".to_owned(),
            "Runout was not removed: part of 1X may be runout.".to_owned(),
        ],
        learning: None,
        learned: baseline::Baseline::default(),
        pictures: pictures(),
        samples: None,
    }
}

/// Returns an empty outcome.
pub(crate) fn bare() -> Outcome {
    Outcome {
        file: None,
        snapshots: vec![],
        snapshot_trends: vec![],
        implausible: vec![],
        not_judged: vec![],
        scene: String::new(),
        recording: String::new(),
        version: String::new(),
        verdict: String::new(),
        record: Record::default(),
        twin: ComparedTwin::default(),
        observation: Observation::default(),
        probes: Vec::new(),
        planes: Vec::new(),
        rotor: None,
        bearings: Vec::new(),
        sensors: vec![],
        timing: Timing::default(),
        observer: None,
        events: vec![],
        diagnoses: Vec::new(),
        diagnosis: None,
        flaws: Vec::new(),
        notes: Vec::new(),
        learning: None,
        learned: baseline::Baseline::default(),
        pictures: Pictures::default(),
        samples: None,
    }
}

/// Returns an outcome with many probes that have long names, some with HTML markup.
pub(crate) fn crowded() -> Outcome {
    let mut outcome = usual();
    outcome.scene =
        "Cooling-water pump 3B, <motor & pump> \"as found\" on the test bed of the works, before overhaul".to_owned();
    let name = |i: usize| format!("Channel {i:02} <b>proximity</b> radial 45 degrees left of vertical");
    outcome.probes = (0..16)
        .map(|i| probe(&name(i), 55.5 * i as f64 - 400.0, Some(22.5 * i as f64), 1234.5 * (i + 1) as f64))
        .collect();
    outcome.bearings = (0..4)
        .map(|i| bearing(&format!("Bearing {i} of the intermediate speed_ratios shaft"), 300.0 * f64::from(i)))
        .collect();
    let pictures = &mut outcome.pictures;
    pictures.traces = (0..16).map(|i| trace(&name(i), 0.1 * i as f64, 1e4)).collect();
    pictures.half_spectra = (0..16).map(|i| half_spectrum(&name(i), 1e4)).collect();
    for orbit in &mut pictures.orbits {
        orbit.probes =
            (0..8).map(|i| (format!("Channel {i} left"), std::f64::consts::FRAC_PI_4 * f64::from(i))).collect();
    }
    pictures.lines.push(MarkedLine {
        label: "Bearing 0 of the intermediate speed_ratios shaft outer".into(),
        order: 7.99,
        hz: 399.5,
    });
    pictures.lines.extend((2..7).map(|i| MarkedLine {
        label: format!("Bearing {i} inner"),
        order: f64::from(i) + 0.1,
        hz: 50.0 * f64::from(i) + 5.0,
    }));
    outcome.flaws = outcome.flaws.iter().cycle().take(12).cloned().collect();
    outcome
}
