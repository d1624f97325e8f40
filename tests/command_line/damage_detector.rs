//! The damage detector of the kernel has the verdict of the program, on recordings that a microcontroller takes.

use crate::support::Sandbox;
use crate::vibration::scene;
use ballrace::bearing::kinematics::orders;
use ballrace::twin::{DamageDetector, DamagedComponent};
use ballrace::{Exact, Phase};
use serde_json::Value;
use std::io::Read;

/// Greatest rate, Hz.
const FASTEST: f64 = 12_000.0;

/// Returns the first column of a compressed array of NumPy of integers of 16 bits.
fn first_column(file: &str) -> Vec<f32> {
    let mut bytes = vec![];
    flate2::read::GzDecoder::new(std::fs::File::open(file).unwrap()).read_to_end(&mut bytes).unwrap();
    let head = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let (head, data) = bytes.split_at(head);
    let head = String::from_utf8_lossy(head);
    assert!(head.contains("'<i2'") && head.contains(", 1)"), "{file}: {head}");
    data.as_chunks().0.iter().map(|number| f32::from(i16::from_le_bytes(*number))).collect()
}

fn named(file: &str, [elements, ball, pitch]: [f64; 3], turns_per_sample: f64) -> Option<DamagedComponent> {
    let orders = orders(elements as usize, ball / pitch, ball / pitch);
    let (mut detector, mut named) = (DamageDetector::<f32>::new(), None);
    for (i, x) in (0_u32..).zip(first_column(file)) {
        if detector.add(x, Phase::from_revolutions(turns_per_sample * f64::from(i))) {
            named = detector.close::<Exact>(&orders).named;
        }
    }
    named
}

/// Recordings with `labels.csv`, where they are at hand: file, fault, elements, diameters, speed and rate.
#[test]
fn the_kernel_has_the_verdict_of_the_program() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/recordings/vibration");
    let Ok(labels) = std::fs::read_to_string(format!("{folder}/labels.csv")) else {
        println!("{folder} is not here: not tried");
        return;
    };
    let (mut same, mut all) = (0, 0);
    for line in labels.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |i: usize| cells[i].parse::<f64>().ok();
        let Some((rate, rpm)) = number(11).zip(number(9)).filter(|(rate, _)| *rate <= FASTEST) else { continue };
        let bearing = [5, 6, 7].map(|i| number(i).unwrap());
        let file = format!("{folder}/{}", cells[0]);
        let sandbox = Sandbox::empty();
        sandbox.put("scene.toml", scene(rpm, bearing, &file, &format!("{rate} Hz"), "c0", "g"));
        let outcome = sandbox.replay("scene.toml", &[]);
        let program = outcome.pointer("/findings/0/kind").and_then(Value::as_str);
        let kernel = named(&file, bearing, rpm / 60.0 / rate).map(|component| match component {
            DamagedComponent::OuterRace => "outer-race",
            DamagedComponent::InnerRace => "inner-race",
            DamagedComponent::Element => "element",
            DamagedComponent::Cage => "cage",
        });
        println!("{} {}: program {program:?}, kernel {kernel:?}", cells[0], cells[2]);
        // What the kernel names is the damage.
        let fault = ["outer-race", "inner-race", "element"].iter().zip(["outer", "inner", "ball"]);
        let damage = fault.filter(|(_, label)| *label == cells[2]).map(|(kind, _)| *kind).next();
        assert!(kernel.is_none() || kernel == damage, "{line}");
        same += usize::from(program == kernel);
        all += 1;
    }
    assert_eq!(same, all, "recordings with the same verdict");
}
