//! The worked example: an interrupt brings displacements, the main loop turns them into forces.
//!
//! On a real board the interrupt reads the probes' converter; here the system timer stands in and makes an orbit of
//! 8 um with one bad sample in it, so that the image runs in an emulator.
#![no_std]
#![no_main]

mod log;

use ballrace::bearing::angular::{Angular, DisplacementDatum};
use ballrace::bearing::geometry::{BEARING_STEEL, BallBearingGeometry};
use ballrace::bearing::{Bearing, ElementPositions, LastValidWrench, evenly_spaced};
use ballrace::phase::{PhaseDelta, SpeedRatio};
use ballrace::{Displacement, Exact, Math, Phase};
use core::cell::RefCell;
use cortex_m::interrupt::{Mutex, free};
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::{Peripherals, singleton};
use cortex_m_rt::{entry, exception};
use cortex_m_semihosting::debug;
use heapless::spsc::{Producer, Queue};
use panic_semihosting as _;

/// What the interrupt hands over: a displacement and the shaft angle at which it was taken.
#[derive(Clone, Copy)]
struct Sample {
    displacement: Displacement<f32>,
    shaft: Phase,
}

/// The sampler's own state: where the shaft is and where samples go.
struct Sampler {
    queue: Producer<'static, Sample>,
    shaft: Phase,
    count: u32,
}

static SAMPLER: Mutex<RefCell<Option<Sampler>>> = Mutex::new(RefCell::new(None));

/// A sixteenth of a turn from sample to sample.
const STEP: PhaseDelta = PhaseDelta(1 << 60);
const SAMPLES: u32 = 32;
const BAD_SAMPLE: u32 = 10;

#[exception]
fn SysTick() {
    free(|token| {
        if let Some(sampler) = SAMPLER.borrow(token).borrow_mut().as_mut() {
            sampler.sample();
        }
    });
}

impl Sampler {
    fn sample(&mut self) {
        let (sin, cos): (f32, f32) = Exact::sin_cos(self.shaft);
        let u = if self.count == BAD_SAMPLE { f32::NAN } else { 8e-6 * cos };
        let displacement = Displacement { u, v: 8e-6 * sin, w: 20e-6, thu: 0.0, thv: 0.0 };
        // A full queue means that the main loop is late: the sample is lost here and nowhere else.
        let _ = self.queue.enqueue(Sample { displacement, shaft: self.shaft });
        self.shaft = self.shaft.advanced(STEP);
        self.count += 1;
    }
}

/// Set-up may fail; it runs once.
fn bearing() -> Option<Angular<f32, Exact, ElementPositions<f32, 9>>> {
    let geometry = BallBearingGeometry {
        ball_diameter: 7.94e-3,
        pitch_diameter: 39.04e-3,
        inner_conformity: 0.52,
        outer_conformity: 0.52,
        contact_angle: 0.0,
        ball: BEARING_STEEL,
        race: BEARING_STEEL,
    };
    let geometry = geometry.with_clearance(10e-6).ok()?;
    Angular::try_new(geometry, evenly_spaced(Phase::ZERO), DisplacementDatum::Centred).ok()
}

#[entry]
fn main() -> ! {
    let (Some(bearing), Some(peripherals)) = (bearing(), Peripherals::take()) else { done() };
    let Some(queue) = singleton!(: Queue<Sample, 8> = Queue::new()) else { done() };
    let (producer, mut samples) = queue.split();
    free(|token| {
        let sampler = Sampler { queue: producer, shaft: Phase::ZERO, count: 0 };
        *SAMPLER.borrow(token).borrow_mut() = Some(sampler);
    });
    let mut timer = peripherals.SYST;
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(50_000);
    timer.clear_current();
    timer.enable_counter();
    timer.enable_interrupt();

    let mut held = LastValidWrench::new();
    let ratio = SpeedRatio::new(0.4);
    let (mut cage, mut shaft, mut seen) = (Phase::ZERO, Phase::ZERO, 0);
    while seen < SAMPLES {
        let Some(sample) = samples.dequeue() else { continue };
        cage = cage.advanced(ratio.apply(sample.shaft.since(shaft)));
        shaft = sample.shaft;
        // Every sample: fixed cost, no failure.
        let (wrench, status) = bearing.sample(&mut held, &sample.displacement, &cage.into());
        log::sample(seen, &wrench, status);
        seen += 1;
    }
    log::held(held.held_count());
    done()
}

/// Ends the emulator's run.
fn done() -> ! {
    debug::exit(debug::EXIT_SUCCESS);
    loop {
        core::hint::spin_loop();
    }
}
