//! Long computations that Ctrl-C interrupts.

use pyo3::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::Duration;

/// Interval at which the interpreter's signals are handled.
const INTERVAL: Duration = Duration::from_millis(20);
/// Stack size of the computing thread, bytes.
const STACK: usize = 8 << 20;

/// Flag that requests the end of the work.
#[derive(Default)]
pub struct Interrupt(AtomicBool);

/// Payload of the unwinding that ends interrupted work.
struct Interrupted;

impl Interrupt {
    /// Ends the work by unwinding to [`interruptible`], if a signal handler has raised an exception. Called from the progress
    /// functions of the library, which have no other way to stop it.
    pub fn check(&self) {
        if self.0.load(Ordering::Relaxed) {
            resume_unwind(Box::new(Interrupted));
        }
    }
}

/// Runs `work` on a thread of its own without the interpreter; this thread handles signals in the meantime.
///
/// # Errors
/// Returns the exception of a signal handler, such as `KeyboardInterrupt`, after the work has ended, or an error if no thread can be
/// started.
pub fn interruptible<T: Send>(py: Python<'_>, work: impl FnOnce(&Interrupt) -> T + Send) -> PyResult<T> {
    let interrupt = Interrupt::default();
    let (sender, receiver) = sync_channel::<()>(1);
    let mut raised = None;
    let outcome = py.detach(|| {
        // A receiver is not `Sync`: the closure has to own it.
        let receiver = receiver;
        std::thread::scope(|scope| {
            let run = || {
                let outcome = catch_unwind(AssertUnwindSafe(|| work(&interrupt)));
                drop(sender);
                outcome
            };
            let builder = std::thread::Builder::new().name("ballrace".to_owned()).stack_size(STACK);
            let thread = builder.spawn_scoped(scope, run)?;
            while receiver.recv_timeout(INTERVAL) == Err(RecvTimeoutError::Timeout) {
                if raised.is_none()
                    && let Err(error) = Python::attach(|py| py.check_signals())
                {
                    raised = Some(error);
                    interrupt.0.store(true, Ordering::Relaxed);
                }
            }
            Ok::<_, std::io::Error>(thread.join().and_then(|outcome| outcome))
        })
    })?;
    match (raised, outcome) {
        (Some(error), _) => Err(error),
        (None, Ok(found)) => Ok(found),
        (None, Err(payload)) => resume_unwind(payload),
    }
}
