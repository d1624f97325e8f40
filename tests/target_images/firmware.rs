use ballrace::bearing::Bearing;
use ballrace::phase::SpeedRatio;
use ballrace::{Displacement, Exact, Math, Phase, Status};
use ballrace_tests::bearings::deep_groove;

/// The example gives the forces that the desktop gives, holds the bad sample, and reports it.
#[test]
#[ignore = "needs qemu-system-arm and the target thumbv7em-none-eabihf; tests/run runs it"]
fn the_worked_example_runs() {
    let printed = super::run("firmware");
    let rows: Vec<Vec<f64>> = printed
        .lines()
        .filter(|l| !l.starts_with("held"))
        .map(|l| l.split(',').map(|cell| cell.parse().expect("a number")).collect())
        .collect();
    assert_eq!(rows.len(), 32);
    assert!(printed.ends_with("held,1\n"), "{printed}");
    let bearing = deep_groove::<9>(10e-6);
    let mut last = vec![0.0; 3];
    for (i, row) in rows.iter().enumerate() {
        let shaft = Phase::from_revolutions(i as f64 / 16.0);
        let (sin, cos): (f64, f64) = Exact::sin_cos(shaft);
        let u = Displacement { u: 8e-6 * cos, v: 8e-6 * sin, w: 20e-6, ..Displacement::default() };
        let cage = Phase::from_revolutions(SpeedRatio::new(0.4).value() * i as f64 / 16.0);
        let bad = i == 10;
        let expected =
            if bad { last.clone() } else { bearing.reaction(&u, &cage.into()).wrench.to_array()[..3].to_vec() };
        assert_eq!(row[4] == f64::from(Status::INPUT_NOT_FINITE.bits()), bad, "sample {i}");
        for (found, expected) in row[1..4].iter().zip(&expected) {
            // Single precision, three decimals printed.
            assert!((found - expected).abs() < 2e-3, "sample {i}: {found} {expected}");
        }
        last = expected;
    }
}

/// With the feature `defmt` the same samples come as frames, which decode to the same words.
#[test]
#[ignore = "needs qemu-system-arm and the target thumbv7em-none-eabihf; tests/run runs it"]
fn the_worked_example_logs_by_defmt() {
    let image = super::images_with_defmt().join("firmware");
    let elf = std::fs::read(&image).expect("an image");
    let table = defmt_decoder::Table::parse(&elf).expect("a readable table").expect("a table of defmt");
    let mut decoder = table.new_stream_decoder();
    decoder.received(&super::emulated_bytes(&image, super::COUNTING));
    let mut lines = Vec::new();
    while let Ok(frame) = decoder.decode() {
        lines.push(frame.display_message().to_string());
    }
    assert_eq!(lines.len(), 33, "{lines:?}");
    assert!(lines[0].starts_with("0 Wrench { fx: "), "{}", lines[0]);
    assert_eq!(lines[10].split("Status").nth(1), Some("(1)"), "the bad sample is flagged");
    assert_eq!(lines[32], "held 1");
}
