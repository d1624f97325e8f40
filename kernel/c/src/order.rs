//! Order tracking of a signal at any number of lines.

use crate::pointer::{self, check_pointers};
use crate::state::{self, Stored};
use crate::status;
use ballrace::phase::SpeedRatio;
use ballrace::rotor::ComponentAngles;
use ballrace::twin::{OrderSums, RevolutionBlock};
use ballrace::{Exact, Math, Phase};

/// Angle of a spectral line as a sum of multiples of the angles of the shaft, the cage and the balls: 1X is `{1, 0, 0}`, the
/// outer ball pass of N balls `{0, N, 0}`, the inner ball pass `{N, -N, 0}`, a defect of a ball `{0, 0, 2}`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default)]
pub struct OrderLine {
    /// Multiple of the shaft angle.
    pub shaft: i32,
    /// Multiple of the cage angle.
    pub cage: i32,
    /// Multiple of the angle of the balls about their own axes.
    pub ball: i32,
}

/// Accumulators of one line. Opaque: `ballrace_order_tracker_init` writes them.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct OrderAccumulators {
    /// Private.
    pub words: [u32; 4],
}

/// Order tracker of one signal. Opaque: `ballrace_order_tracker_init` writes it.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct OrderTracker {
    /// Private.
    pub words: [u64; 10],
}

/// Order tracker whose lines, sums and amplitudes are in memory of the caller.
struct Tracker {
    lines: *const OrderLine,
    sums: *mut OrderSums<f32>,
    amplitudes: *mut [f32; 2],
    line_count: u32,
    progress_per_revolution: SpeedRatio,
    shaft: Phase,
    block: RevolutionBlock<f32>,
}

impl Stored for Tracker {
    const KIND: u32 = 2;
}

/// Initialises a tracker for blocks of `turns` revolutions, starting at the shaft angle `shaft`. For set-up.
///
/// The signal at a line is `c cos p + s sin p` with the angle `p` of the line; `amplitudes` receives `c` and `s` of every
/// line at the end of each block. A Hann window separates lines that differ by more than two cycles per block.
///
/// # Safety
/// `lines` and `sums` have `line_count` entries, `amplitudes` twice as many; all exist as long as the tracker, and nothing
/// else uses `sums`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_order_tracker_init(
    tracker: *mut OrderTracker,
    lines: *const OrderLine,
    sums: *mut OrderAccumulators,
    amplitudes: *mut f32,
    line_count: u32,
    turns: u32,
    shaft: u64,
) -> u32 {
    const { assert!(size_of::<OrderAccumulators>() == size_of::<OrderSums<f32>>()) };
    check_pointers!(tracker, lines, sums, amplitudes);
    let value = Tracker {
        lines,
        sums: sums.cast(),
        amplitudes: amplitudes.cast(),
        line_count,
        progress_per_revolution: SpeedRatio::new(1.0 / f64::from(turns.max(1))),
        shaft: Phase(shaft),
        block: RevolutionBlock::new(),
    };
    for i in 0..line_count as usize {
        // SAFETY: entry `i` of `line_count`.
        unsafe {
            value.sums.add(i).write(OrderSums::new());
            value.amplitudes.add(i).write([0.0; 2]);
        }
    }
    // SAFETY: by the contract of the function.
    unsafe { state::write(tracker, value) };
    status::OK
}

/// Adds a sample at the angles of the shaft, the cage and the balls; returns `BALLRACE_BLOCK_COMPLETE` where it ends a block
/// and has written the amplitudes over it.
///
/// Constant number of instructions, more at the end of a block. A sample that is not finite spoils its block, not the next
/// one.
///
/// # Safety
/// `tracker` points to an initialised tracker that no other thread or interrupt uses.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_order_tracker_add(
    tracker: *mut OrderTracker,
    sample: f32,
    shaft: u64,
    cage: u64,
    ball: u64,
) -> u32 {
    check_pointers!(tracker);
    // SAFETY: by the contracts of this function and of `ballrace_order_tracker_init`.
    let (tracker, lines, sums, amplitudes) = unsafe {
        let Some(tracker) = state::get::<Tracker, _>(tracker) else { return status::STATE_INVALID };
        let count = tracker.line_count;
        let sums = core::slice::from_raw_parts_mut(tracker.sums, count as usize);
        let amplitudes = core::slice::from_raw_parts_mut(tracker.amplitudes, count as usize);
        let lines = pointer::slice(tracker.lines, count);
        (tracker, lines, sums, amplitudes)
    };
    let [shaft, cage, ball] = [shaft, cage, ball].map(Phase);
    let delta = shaft.since(tracker.shaft);
    // Both senses of rotation complete the block.
    let share = Phase(tracker.progress_per_revolution.apply(delta).0.unsigned_abs());
    let complete = tracker.block.advance(share);
    tracker.shaft = shaft;
    if complete {
        let scale = tracker.block.close();
        for (amplitude, sums) in amplitudes.iter_mut().zip(sums.iter_mut()) {
            *amplitude = sums.close(scale);
        }
    }
    let sample = tracker.block.window::<Exact>() * sample;
    let components = ComponentAngles { cage, ball, outer: Phase::ZERO };
    for (sums, line) in sums.iter_mut().zip(lines) {
        let line = ballrace::twin::OrderLine { shaft: line.shaft, cage: line.cage, ball: line.ball };
        sums.add(sample, Exact::sin_cos(line.angle(shaft, &components)));
    }
    if complete { status::BLOCK_COMPLETE } else { status::OK }
}
