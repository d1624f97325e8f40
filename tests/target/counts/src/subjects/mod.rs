//! Everything that is measured.

mod balls;
mod bearings;
mod blocks;
mod fixed_point;
mod flexible;
mod indicators;
mod rotor;

use crate::inputs::input;
use crate::measure::{Bench, Name};
use ballrace::{Exact, Fast, Math, Phase};

/// All subjects, cheapest first.
pub fn all(bench: &Bench) {
    sine_and_cosine(bench);
    bearings::all::<f32, Exact>(bench, "f32", "exact");
    bearings::all::<f32, Fast>(bench, "f32", "fast");
    bearings::all::<f64, Exact>(bench, "f64", "exact");
    bearings::all::<f64, Fast>(bench, "f64", "fast");
    balls::all(bench);
    blocks::all(bench);
    blocks::log(bench);
    blocks::blob(bench);
    indicators::all::<f32>(bench, "f32");
    indicators::all::<f64>(bench, "f64");
    indicators::damage(bench);
    rotor::all::<f32>(bench, "f32");
    rotor::all::<f64>(bench, "f64");
    flexible::all(bench);
}

/// The functions that firmware takes, in `f32`.
pub fn hot(bench: &Bench) {
    sine_and_cosine(bench);
    bearings::all::<f32, Exact>(bench, "f32", "exact");
    balls::all(bench);
    rotor::all::<f32>(bench, "f32");
    flexible::observers(bench);
}

/// Inputs of software floats, which take long under emulation.
const SOFTWARE_INPUTS: u32 = 140;

/// What a core without a floating-point unit takes: counts of a converter, and software floats for comparison.
pub fn without_fpu(bench: &Bench) {
    fixed_point::all(bench);
    let bench = bench.with_inputs(SOFTWARE_INPUTS);
    bearings::all::<f32, Exact>(&bench, "f32", "exact");
    balls::tables(&bench);
}

#[inline(never)]
fn sin_cos(angle: Phase) -> (f32, f32) {
    <Exact as Math<f32>>::sin_cos(angle)
}

fn sine_and_cosine(bench: &Bench) {
    let function = "sine and cosine";
    let name = Name { what: "cage angle", elements: 0, precision: "f32", math: "exact", function };
    bench.measure(name, sin_cos as *const (), |i| input::<f32>(i).1, |angle| sin_cos(*angle));
}
