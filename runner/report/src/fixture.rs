//! Outcomes for the tests: a usual one, an empty one, and one with many long names; `broken` has invalid numbers.

mod broken;
mod pictures;
mod signal;
mod snapshots;

pub(crate) use broken::{broken, with_data};
pub(crate) use snapshots::with_snapshots;

use ballrace_twin::recording::flaws::{Flaw, FlawLedger, FlawSummary, Position};
use ballrace_twin::replay::outcome::*;
use pictures::{blocks, half_spectrum, pictures, trace};
use signal::{OUTER, RATE_HZ, SPEED_HZ, motion};

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
        life: Some(life()),
    }
}

fn life() -> LifeOutcome {
    LifeOutcome {
        dynamic_rating_n: 4356.0,
        static_rating_n: 2210.0,
        reference_load_n: 61.4,
        reference_life_h: Some(2.1e6),
        viscosity_ratio: Some(1.62),
        modification_factor: None,
        modified_life_h: Some(187_400.0),
        equivalent_load_n: Some(48.2),
        basic_life_h: Some(743_210.0),
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
    Outcome::default()
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
