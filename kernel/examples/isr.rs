//! Bearing force inside an interrupt on a Cortex-M4F; statistics of blocks in the main loop.
//!
//! Set-up: `try_new` checks the parameters once. Interrupt: the cage follows the shaft and `sample` evaluates the force, at a
//! constant number of instructions. Main loop: statistics of every block of samples, whose cost has no deadline.
//!
//! The system timer takes the place of the converter of two probes. The package `tests/target/isr` builds this file for
//! `thumbv7em-none-eabihf`.
#![no_std]
#![no_main]

use ballrace::bearing::angular::DisplacementDatum;
use ballrace::bearing::geometry::{BEARING_STEEL, BallBearingGeometry, InvalidParameter};
use ballrace::bearing::{Bearing, LastValidWrench, evenly_spaced};
use ballrace::phase::{PhaseDelta, SpeedRatio};
use ballrace::twin::Statistics;
use ballrace::{DeepGroove, Displacement, Exact, Math, Phase};
use core::cell::RefCell;
use cortex_m::interrupt::{Mutex, free};
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::{Peripherals, singleton};
use cortex_m_rt::{entry, exception};
use cortex_m_semihosting::{debug, hprintln};
use heapless::spsc::{Producer, Queue};
use panic_semihosting as _;

/// Shaft rotation from sample to sample: 1/16 revolution.
const STEP: PhaseDelta = PhaseDelta(1 << 60);
/// Samples per block: four revolutions.
const BLOCK: u32 = 64;
const BLOCKS: u32 = 3;

/// State that belongs to the interrupt.
struct Sampler {
    bearing: DeepGroove<f32, 9>,
    cage_ratio: SpeedRatio,
    shaft: Phase,
    cage: Phase,
    last_valid: LastValidWrench<f32>,
    forces: Producer<'static, f32>,
}

static SAMPLER: Mutex<RefCell<Option<Sampler>>> = Mutex::new(RefCell::new(None));

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
        let displacement = Displacement { u: 8e-6 * cos, v: 8e-6 * sin, w: 20e-6, thu: 0.0, thv: 0.0 };
        let (wrench, _) = self.bearing.sample(&mut self.last_valid, &displacement, &self.cage.into());
        // A full queue drops the sample: the main loop is late.
        let _ = self.forces.enqueue(wrench.fx);
        self.shaft = self.shaft.advanced(STEP);
        self.cage = self.cage.advanced(self.cage_ratio.apply(STEP));
    }
}

fn bearing() -> Result<DeepGroove<f32, 9>, InvalidParameter> {
    let geometry = BallBearingGeometry {
        ball_diameter: 7.94e-3,
        pitch_diameter: 39.04e-3,
        inner_conformity: 0.52,
        outer_conformity: 0.52,
        contact_angle: 0.0,
        ball: BEARING_STEEL,
        race: BEARING_STEEL,
    };
    DeepGroove::try_new(geometry.with_clearance(10e-6)?, evenly_spaced(Phase::ZERO), DisplacementDatum::Centred)
}

#[entry]
fn main() -> ! {
    let (Ok(bearing), Some(peripherals)) = (bearing(), Peripherals::take()) else { exit(debug::EXIT_FAILURE) };
    let Some(queue) = singleton!(: Queue<f32, 16> = Queue::new()) else { exit(debug::EXIT_FAILURE) };
    let (forces, mut received) = queue.split();
    let sampler = Sampler {
        bearing,
        cage_ratio: SpeedRatio::new(0.4),
        shaft: Phase::ZERO,
        cage: Phase::ZERO,
        last_valid: LastValidWrench::new(),
        forces,
    };
    free(|token| *SAMPLER.borrow(token).borrow_mut() = Some(sampler));
    let mut timer = peripherals.SYST;
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(50_000);
    timer.clear_current();
    timer.enable_counter();
    timer.enable_interrupt();

    let mut statistics = Statistics::<f32>::new(BLOCK);
    let mut blocks = 0;
    while blocks < BLOCKS {
        let Some(force) = received.dequeue() else { continue };
        if let Some(block) = statistics.add::<Exact>(force) {
            hprintln!("{},{},{}", block.mean, block.rms, block.peak_to_peak);
            blocks += 1;
        }
    }
    exit(debug::EXIT_SUCCESS)
}

/// Ends the run of the emulator.
fn exit(status: debug::ExitStatus) -> ! {
    debug::exit(status);
    loop {
        core::hint::spin_loop();
    }
}
