use ballrace::phase::{PhaseDelta, SpeedRatio};
use ballrace::twin::Statistics;
use ballrace::{Bearing, Displacement, Exact, Math, Phase};
use ballrace_tests::bearings::deep_groove;

/// The interrupt-driven example prints the statistics that the desktop computes from the same samples.
#[test]
#[ignore = "needs qemu-system-arm and the target thumbv7em-none-eabihf; tests/run runs it"]
fn the_interrupt_driven_example_runs() {
    let printed = super::run("isr");
    let bearing = deep_groove::<9>(10e-6);
    let (step, ratio) = (PhaseDelta(1 << 60), SpeedRatio::new(0.4));
    let (mut shaft, mut cage, mut statistics) = (Phase::ZERO, Phase::ZERO, Statistics::<f64>::new(64));
    let mut expected = Vec::new();
    for _ in 0..3 * 64 {
        let (sin, cos): (f64, f64) = Exact::sin_cos(shaft);
        let u = Displacement { u: 8e-6 * cos, v: 8e-6 * sin, w: 20e-6, ..Displacement::default() };
        expected.extend(statistics.add::<Exact>(bearing.reaction(&u, &cage.into()).wrench.fx));
        (shaft, cage) = (shaft.advanced(step), cage.advanced(ratio.apply(step)));
    }
    let rows: Vec<Vec<f64>> =
        printed.lines().map(|line| line.split(',').map(|cell| cell.parse().expect("a number")).collect()).collect();
    assert_eq!(rows.len(), expected.len(), "{printed}");
    for (row, block) in rows.iter().zip(&expected) {
        assert!(block.peak_to_peak > 1.0, "{block:?}");
        for (found, expected) in row.iter().zip([block.mean, block.rms, block.peak_to_peak]) {
            assert!((found - expected).abs() < 1e-4 * block.peak_to_peak, "{row:?} {block:?}");
        }
    }
}
