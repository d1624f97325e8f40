//! Blocks of samples of two channels: every model, readings of every kind.

use crate::inputs::{counts, input};
use crate::measure::{Bench, Name};
use baked::bearings::bearing_de;
use ballrace::bearing::angular::{Angular, DisplacementDatum};
use ballrace::bearing::linear::Linear;
use ballrace::bearing::lumped::{Axial, Combined, Radial};
use ballrace::bearing::tabulated::{Node, Tabulated};
use ballrace::bearing::{ElementPosition, LastValidWrench, evenly_spaced};
use ballrace::blob::{Blob, BlobCheck};
use ballrace::block::{Channel, Metres, ProbedBearing};
use ballrace::contact::law::{LineContactLaw, PointContactLaw, PowerLaw};
use ballrace::phase::{PhaseDelta, SpeedRatio};
use ballrace::probe::{Probe, ProbeParams};
use ballrace::{Bearing, Displacement, Exact, Phase, Status, Stiffness, Wrench};

/// Samples in a block.
const SAMPLES: usize = 16;
/// Blocks of balls in equilibrium, which take long under emulation.
const SOLVED_INPUTS: u32 = 60;
const STILL: Displacement<f32> = Displacement { u: 0.0, v: 0.0, w: 0.0, thu: 0.0, thv: 0.0 };
const PROBE: Probe<f32> = Probe::from_constants(ProbeParams {
    at_zero: -32.768e-3,
    per_count: 1e-6,
    linear_range: [400, 65_000],
    stuck_after: 2,
});

/// Every model by counts, one by readings of the other kinds.
pub fn all(bench: &Bench) {
    let (point, elements) = (PointContactLaw { stiffness: 8e9 }, evenly_spaced::<f32, 9>(Phase::ZERO));
    of_counts(bench, "linear", 0, Linear::new(Stiffness::from_element(1e7)));
    if let Ok(bearing) = Radial::<f32, Exact, _, _>::try_new(elements, point, 5e-6) {
        of_counts(bench, "radial 3/2", 9, bearing);
        if let Ok(axial) = Axial::<f32, Exact, _, _>::try_new(elements, point, 5e-6, 0.02) {
            of_counts(bench, "radial and axial 3/2", 9, Combined(bearing, axial));
        }
    }
    if let Ok(bearing) = Radial::<f32, Exact, _, _>::try_new(elements, LineContactLaw { stiffness: 3e8 }, 5e-6) {
        of_counts(bench, "radial 10/9", 9, bearing);
    }
    let power = PowerLaw { stiffness: 2e9, exponent: 1.4 };
    if let Ok(bearing) = Radial::<f32, Exact, _, _>::try_new(elements, power, 5e-6) {
        of_counts(bench, "radial, any power", 9, bearing);
    }
    let Ok(geometry) = rig::geometry() else { return };
    if let Ok(bearing) = Angular::<f32, Exact, _>::try_new(geometry, elements, DisplacementDatum::Centred) {
        of_counts(bench, "angular", 9, bearing);
        let signed = |i, k| counts(i, k).wrapping_sub(0x8000).cast_signed();
        measure(bench, name("angular", 9, "block of 16 samples, signed counts"), bearing, [PROBE; 2], signed);
        let metres = |i: u32, k: u32| {
            let (u, _) = input::<f32>(i.wrapping_mul(16).wrapping_add(k));
            if k.is_multiple_of(2) { u.u } else { u.v }
        };
        measure(bench, name("angular", 9, "block of 16 samples, metres"), bearing, [Metres; 2], metres);
    }
    of_counts(bench, "tabulated", 8, bearing_de::bearing());
    if let Some(bearing) = super::balls::massive() {
        of_counts(&bench.with_inputs(SOLVED_INPUTS), "quasi-static, gyroscopic", 8, bearing);
    }
}

/// A frame of a log.
pub fn log(bench: &Bench) {
    let ready = |i: u32| {
        let (u, cage) = input::<f32>(i);
        (cage.0 as u32, [u.u, u.v, u.w, u.thu])
    };
    bench.measure(name("log", 0, "frame of 4 readings"), frame as *const (), ready, |(number, readings)| {
        frame(*number, readings)
    });
}

#[inline(never)]
fn frame(number: u32, readings: &[f32; 4]) -> [u8; 24] {
    ballrace::log::frame(number, readings)
}

/// The check of a blob in parts, and a bearing from it.
pub fn blob(bench: &Bench) {
    let bytes = &baked::blob::BLOB.0;
    let begin = |_| BlobCheck::default();
    bench.measure(name("blob", 0, "check of 1000 bytes"), check as *const (), begin, |state| check(state, bytes));
    if let Ok(blob) = Blob::try_new(bytes) {
        let function = name("blob", 11, "bearing by name, tabulated");
        bench.measure(function, from_blob as *const (), |_| (), |()| from_blob(&blob));
    }
}

type FromBlobs = Tabulated<f32, Exact, &'static [ElementPosition<f32>], &'static [Node<f32, 2>], 2>;

#[inline(never)]
fn check(state: &mut BlobCheck, bytes: &'static [u8]) -> bool {
    state.advance(bytes, 1000).is_none()
}

#[inline(never)]
fn from_blob(blob: &Blob<'static>) -> Option<FromBlobs> {
    blob.bearing("balls").ok()?.bearing().ok()
}

fn name(what: &'static str, elements: usize, function: &'static str) -> Name {
    Name { what, elements, precision: "f32", math: "exact", function }
}

fn of_counts<B: Bearing<f32> + Copy>(bench: &Bench, what: &'static str, n: usize, bearing: B) {
    measure(bench, name(what, n, "block of 16 samples, counts"), bearing, [PROBE; 2], counts);
}

#[inline(never)]
fn samples<B: Bearing<f32>, C: Channel<f32, R>, R: Copy>(
    end: &mut ProbedBearing<f32, B, C, 2>,
    buffer: &[R],
    results: &mut [(Wrench<f32>, Status)],
) -> usize {
    end.samples(buffer, PhaseDelta(0x0123_4567_89ab_cdef), 1256.0, results)
}

/// Measures a block whose channel `k % 2` has the reading `k` of `reading`.
fn measure<B: Bearing<f32> + Copy, C: Channel<f32, R> + Copy, R: Copy>(
    bench: &Bench,
    name: Name,
    bearing: B,
    channels: [C; 2],
    reading: impl Fn(u32, u32) -> R,
) {
    let prepare = |i: u32| {
        let end = ProbedBearing {
            bearing,
            channels,
            directions: [Displacement { u: 1.0, ..STILL }, Displacement { v: 1.0, ..STILL }],
            offset: Displacement { w: 20e-6, ..STILL },
            cage_ratio: SpeedRatio::new(0.3983),
            shaft: Phase(u64::from(i) << 48),
            cage: Phase(u64::from(i) << 40),
            last_valid: LastValidWrench::new(),
        };
        let buffer: [R; 2 * SAMPLES] = core::array::from_fn(|k| reading(i, k as u32));
        (end, buffer, [(Wrench::ZERO, Status::OK); SAMPLES])
    };
    bench.measure(name, samples::<B, C, R> as *const (), prepare, |(end, buffer, results)| {
        samples(end, buffer, results)
    });
}
