use ballrace::bearing::Bearing;
use ballrace::{BearingKinematicState, Displacement, Phase};

#[path = "../target/baked/src/bearings.rs"]
#[rustfmt::skip]
pub mod bearings;
#[path = "../target/baked/src/flexible.rs"]
#[rustfmt::skip]
mod flexible;
#[path = "../target/baked/src/motion.rs"]
mod motion;

/// The same as in the image.
fn displacement(i: u16) -> Displacement<f32> {
    let part = f32::from(i) / 64.0;
    let half = if i < 32 { part } else { 1.0 - part };
    Displacement { u: 6e-6 * half, v: 4e-6 * (0.25 - half), w: 5e-6 + 4e-6 * part, thu: 1e-4 * half, thv: -5e-5 * part }
}

fn line(name: &str, i: u16, bearing: &impl Bearing<f32>, u: &Displacement<f32>) -> String {
    let turn = Phase(u64::from(i) << 57);
    let at = BearingKinematicState {
        cage: turn,
        inner: turn.wrapping_mul(3),
        inner_speed: 1256.0,
        ..BearingKinematicState::default()
    };
    let reaction = bearing.reaction(u, &at);
    let bits: Vec<String> = reaction.wrench.to_array().iter().map(|f| format!("{:08x}", f.to_bits())).collect();
    format!("{name},{i},{},{}\n", bits.join(","), reaction.status.bits())
}

/// Firmware with a baked scene prints the bits that the desktop computes from the same constants.
#[test]
#[ignore = "needs qemu-system-arm and the target thumbv7em-none-eabihf; tests/run runs it"]
fn a_baked_scene_gives_the_same_bits() {
    let (de, nde) = (bearings::bearing_de::bearing(), bearings::bearing_nde::bearing());
    let mut expected = String::new();
    for i in 0..64 {
        let u = displacement(i);
        expected += &line("DE", i, &de, &u);
        expected += &line("NDE", i, &nde, &u.mirrored());
    }
    assert!(expected.lines().all(|l| l.ends_with(",0")), "inside both tables:\n{expected}");
    let mut lines = String::new();
    motion::run(|i, moved, observed| {
        assert!(moved.iter().chain(observed).all(|x| x.abs() < 1e-3), "{moved:?} {observed:?}");
        let bits: String = moved.iter().chain(observed).map(|x| format!(",{:08x}", x.to_bits())).collect();
        lines += &format!("rotor,{i}{bits}\n");
    })
    .expect("symmetric matrices");
    assert_eq!(super::run("baked"), expected + &lines);
}
