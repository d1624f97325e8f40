//! Order tracking of the radial force at a bearing in the frames of its components.

use crate::bearing::KinematicState;
use crate::pointer::check_pointers;
use crate::state::{self, Stored};
use crate::status;
use ballrace::Exact;
use ballrace::twin::{self, ForceOrderTracker};

/// Largest number of orders of a force tracker.
pub const MAX_FORCE_ORDERS: u32 = 8;

/// One line of the full spectrum of a force in the frame of a component.
///
/// At the angle `p` of its fundamental the line of order `k` is `F e^(i k p) + B e^(-i k p)`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default)]
pub struct ForceLine {
    /// F, amplitude of forward precession, N: real and imaginary part.
    pub forward: [f32; 2],
    /// B, amplitude of backward precession, N: real and imaginary part.
    pub backward: [f32; 2],
}

/// Force tracker. Opaque: `ballrace_force_tracker_init` writes it.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct ForceTracker {
    /// Private.
    pub model: *const ForceTrackerModel,
    /// Private: as many words as `ballrace_force_tracker_init` demands.
    pub words: *mut u64,
}

/// Functions of a force tracker with a number of orders. The library exports one constant per number; a program uses only
/// their addresses.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct ForceTrackerModel {
    /// Number of orders.
    pub order_count: u32,
    /// Implementation of `ballrace_force_tracker_init`.
    pub init: unsafe extern "C" fn(words: *mut u64, elements: u32, turns: u32, at: *const KinematicState) -> u32,
    /// Implementation of `ballrace_force_tracker_add`.
    pub add: unsafe extern "C" fn(words: *mut u64, fx: f32, fy: f32, at: *const KinematicState) -> u32,
    /// Implementation of `ballrace_force_tracker_close`.
    pub close: unsafe extern "C" fn(
        words: *mut u64,
        outer: *mut ForceLine,
        inner: *mut ForceLine,
        element: *mut ForceLine,
    ) -> u32,
}

impl<const H: usize> Stored for ForceOrderTracker<f32, H> {
    const KIND: u32 = 0x80 + H as u32;
}

unsafe extern "C" fn init<const H: usize>(
    words: *mut u64,
    elements: u32,
    turns: u32,
    at: *const KinematicState,
) -> u32 {
    // 12 words per order and 8: the size in the documentation of `ballrace_force_tracker_init`.
    const { assert!(size_of::<ForceOrderTracker<f32, H>>() <= 8 * (12 * H + 7)) };
    // SAFETY: the contract is that of `ballrace_force_tracker_init`.
    unsafe { state::write_to(words, ForceOrderTracker::<f32, H>::new(elements, turns, (*at).of_kernel())) };
    status::OK
}

unsafe extern "C" fn add<const H: usize>(words: *mut u64, fx: f32, fy: f32, at: *const KinematicState) -> u32 {
    // SAFETY: the contract is that of `ballrace_force_tracker_add`.
    unsafe {
        let Some(tracker) = state::get::<ForceOrderTracker<f32, H>, _>(words) else { return status::STATE_INVALID };
        if tracker.add::<Exact>([fx, fy], (*at).of_kernel()) { status::BLOCK_COMPLETE } else { status::OK }
    }
}

unsafe extern "C" fn close<const H: usize>(
    words: *mut u64,
    outer: *mut ForceLine,
    inner: *mut ForceLine,
    element: *mut ForceLine,
) -> u32 {
    // SAFETY: the contract is that of `ballrace_force_tracker_close`.
    unsafe {
        let Some(tracker) = state::get::<ForceOrderTracker<f32, H>, _>(words) else { return status::STATE_INVALID };
        let orders = tracker.close();
        for (to, from) in [(outer, orders.outer), (inner, orders.inner), (element, orders.element)] {
            if let Some(lines) = to.cast::<[ForceLine; H]>().as_mut() {
                *lines = from.map(|twin::ForceLine { forward, backward }| ForceLine { forward, backward });
            }
        }
    }
    status::OK
}

impl ForceTrackerModel {
    const fn of<const H: usize>() -> Self {
        Self { order_count: H as u32, init: init::<H>, add: add::<H>, close: close::<H> }
    }
}

/// Force tracker of 1 order per component.
#[unsafe(no_mangle)]
pub static ballrace_force_tracker_of_1_order: ForceTrackerModel = ForceTrackerModel::of::<1>();

/// Force tracker of 2 orders per component.
#[unsafe(no_mangle)]
pub static ballrace_force_tracker_of_2_orders: ForceTrackerModel = ForceTrackerModel::of::<2>();

/// Force tracker of 3 orders per component.
#[unsafe(no_mangle)]
pub static ballrace_force_tracker_of_3_orders: ForceTrackerModel = ForceTrackerModel::of::<3>();

/// Force tracker of 4 orders per component.
#[unsafe(no_mangle)]
pub static ballrace_force_tracker_of_4_orders: ForceTrackerModel = ForceTrackerModel::of::<4>();

/// Force tracker of 5 orders per component.
#[unsafe(no_mangle)]
pub static ballrace_force_tracker_of_5_orders: ForceTrackerModel = ForceTrackerModel::of::<5>();

/// Force tracker of 6 orders per component.
#[unsafe(no_mangle)]
pub static ballrace_force_tracker_of_6_orders: ForceTrackerModel = ForceTrackerModel::of::<6>();

/// Force tracker of 7 orders per component.
#[unsafe(no_mangle)]
pub static ballrace_force_tracker_of_7_orders: ForceTrackerModel = ForceTrackerModel::of::<7>();

/// Force tracker of 8 orders per component.
#[unsafe(no_mangle)]
pub static ballrace_force_tracker_of_8_orders: ForceTrackerModel = ForceTrackerModel::of::<8>();

/// Initialises a force tracker for a bearing of `elements` rolling elements and blocks of `turns` revolutions of the inner
/// relative to the outer ring, starting at `at`. For set-up.
///
/// `model` is one of `&ballrace_force_tracker_of_..._orders`, `words` is memory of `12 n + 8` words for n orders, aligned to
/// 8 bytes.
///
/// Each sample is turned into the frame of the outer ring, of the inner ring and of the cage, and demodulated at orders of
/// the ball pass of the outer ring, of the inner ring, and of -2 times the angle of the balls.
///
/// # Safety
/// All pointers are valid; `words` exists as long as the tracker, and nothing else uses it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_force_tracker_init(
    tracker: *mut ForceTracker,
    model: *const ForceTrackerModel,
    words: *mut u64,
    elements: u32,
    turns: u32,
    at: *const KinematicState,
) -> u32 {
    check_pointers!(tracker, model, words, at);
    // SAFETY: by the contract of the function.
    unsafe {
        tracker.write(ForceTracker { model, words });
        ((*model).init)(words, elements, turns, at)
    }
}

/// Adds a force in N in the fixed frame; returns `BALLRACE_BLOCK_COMPLETE` where it ends a block, which
/// `ballrace_force_tracker_close` must read before the next sample. Constant number of instructions.
///
/// # Safety
/// `tracker` points to an initialised tracker that no other thread or interrupt uses, `at` to a state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_force_tracker_add(
    tracker: *const ForceTracker,
    fx: f32,
    fy: f32,
    at: *const KinematicState,
) -> u32 {
    check_pointers!(tracker, at);
    // SAFETY: by the contract of the function.
    unsafe {
        let ForceTracker { model, words } = *tracker;
        let Some(model) = model.as_ref() else { return status::STATE_INVALID };
        (model.add)(words, fx, fy, at)
    }
}

/// Ends the block and writes its lines of the outer ring, the inner ring and the rolling elements: one entry per order in
/// each array. Each pointer may be NULL.
///
/// # Safety
/// As `ballrace_force_tracker_add`; the arrays have one entry per order or are NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_force_tracker_close(
    tracker: *const ForceTracker,
    outer: *mut ForceLine,
    inner: *mut ForceLine,
    element: *mut ForceLine,
) -> u32 {
    check_pointers!(tracker);
    // SAFETY: by the contract of the function.
    unsafe {
        let ForceTracker { model, words } = *tracker;
        let Some(model) = model.as_ref() else { return status::STATE_INVALID };
        (model.close)(words, outer, inner, element)
    }
}
