//! Measurement of one subject: instructions over the inputs, stack by painting, address in flash.

use crate::counter::Counter;
use core::hint::black_box;
#[cfg(target_arch = "arm")]
use cortex_m_stack::{current_stack_in_use, repaint_stack, stack_painted, stack_size};
use semihosting::println;

/// Identity of a subject in the table.
#[derive(Clone, Copy)]
pub struct Name {
    /// The model.
    pub what: &'static str,
    /// Elements, 0 where it has none.
    pub elements: usize,
    /// `f32` or `f64`.
    pub precision: &'static str,
    /// `exact` or `fast`.
    pub math: &'static str,
    /// Which of its functions.
    pub function: &'static str,
}

/// The running counter and how many inputs to count over.
#[derive(Clone)]
pub struct Bench {
    counter: Counter,
    inputs: u32,
}

/// Inputs for which the stack is painted, if there are more: painting takes longer than calling.
const PAINTED: u32 = 3;

impl Bench {
    /// With the timer running. Call once.
    pub fn start(inputs: u32) -> Option<Self> {
        Some(Self { counter: Counter::start()?, inputs })
    }

    /// Returns a bench that counts over fewer inputs.
    pub fn with_inputs(&self, inputs: u32) -> Self {
        Self { inputs, ..self.clone() }
    }

    /// Prints `what;elements;precision;math;function;least;most;stack;address`: instructions, bytes, where it begins.
    ///
    /// `prepare` makes input number `i`, `call` does nothing but call the function at `address`.
    #[inline(always)]
    pub fn measure<I, R>(
        &self,
        name: Name,
        address: *const (),
        prepare: impl Fn(u32) -> I,
        mut call: impl FnMut(&mut I) -> R,
    ) {
        let (mut least, mut most, mut stack) = (u32::MAX, 0, 0);
        for i in 1..=self.inputs {
            let mut input = black_box(prepare(i));
            if i <= PAINTED && i < self.inputs {
                stack = stack.max(stack_of(|| call(&mut input)));
                input = black_box(prepare(i));
            }
            let count = self.counter.count(|| call(&mut input));
            (least, most) = (least.min(count), most.max(count));
        }
        let Name { what, elements, precision, math, function } = name;
        let address = address.addr() & !1; // the lowest bit says Thumb
        println!("{};{};{};{};{};{};{};{};{}", what, elements, precision, math, function, least, most, stack, address);
    }
}

/// Returns the bytes of stack that a call overwrites.
#[cfg(target_arch = "arm")]
#[inline(always)]
fn stack_of<R>(call: impl FnOnce() -> R) -> u32 {
    repaint_stack();
    let before = current_stack_in_use();
    black_box(call());
    stack_size() - stack_painted() - before
}

/// Returns 0: the stack is measured on Arm.
#[cfg(not(target_arch = "arm"))]
fn stack_of<R>(call: impl FnOnce() -> R) -> u32 {
    black_box(call());
    0
}
