//! Evaluation of a table on several threads.

use super::evaluation::{Evaluation, evaluate_watched, without_answer};
use super::machine::Machine;
use super::patience::within;
use super::row::Row;
use super::store::Store;
use ballrace_base::caught::caught;
use ballrace_plant::error::{Error, Result};
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// Settings of a run.
#[derive(Debug, Clone, Copy)]
pub struct Settings {
    /// Number of machines evaluated in parallel.
    pub jobs: usize,
    /// Tolerated error of the force, as [`Options::error`](crate::Options::error).
    pub force_error: Option<f64>,
    /// Longest time of an evaluation without progress, after which its row is an error.
    pub patience: Duration,
}

/// Evaluates a machine; where its files do not answer, the row has an error.
fn evaluated(machine: &Machine, settings: Settings) -> std::io::Result<Evaluation> {
    let (one, force_error) = (machine.clone(), settings.force_error);
    let work = move |steps: &AtomicU64| {
        evaluate_watched(&one, force_error, &|_| {
            steps.fetch_add(1, Ordering::Relaxed);
        })
    };
    Ok(within(settings.patience, work)?.unwrap_or_else(|| without_answer(machine, settings.patience)))
}

/// Evaluates `machines`, `settings.jobs` in parallel, and adds each row to the store when it is complete.
///
/// `finish` is called in the thread of each evaluation before its row is stored, for example to write a report; its panic becomes the
/// error of the row. `progress` is called after each stored row.
///
/// # Errors
/// Returns the first error of `finish`, of the store or of the start of a thread; earlier rows stay in the store.
pub fn run(
    machines: &[&Machine],
    store: &mut Store,
    settings: Settings,
    finish: impl Fn(&Machine, &mut Evaluation) -> Result<()> + Sync,
    mut progress: impl FnMut(&Row),
) -> Result<()> {
    let next = AtomicUsize::new(0);
    let stop = || next.store(machines.len(), Ordering::Relaxed);
    let (sender, receiver) = channel::<Result<Row>>();
    let work = |sender: std::sync::mpsc::Sender<Result<Row>>| {
        while let Some(machine) = machines.get(next.fetch_add(1, Ordering::Relaxed)) {
            let mut evaluation = match evaluated(machine, settings) {
                Ok(evaluation) => evaluation,
                Err(error) => {
                    let _ = sender.send(Err(Error::from(error)));
                    return;
                }
            };
            let finished = match caught(|| finish(machine, &mut evaluation)) {
                Ok(finished) => finished,
                Err(panic) => {
                    evaluation.row.error = Some(ballrace_base::printable::message(&format!("internal error: {panic}")));
                    Ok(())
                }
            };
            if sender.send(finished.map(|()| evaluation.row)).is_err() {
                return;
            }
        }
    };
    let result = std::thread::scope(|scope| {
        for _ in 0..settings.jobs.clamp(1, machines.len().max(1)) {
            let (work, sender) = (&work, sender.clone());
            let thread = std::thread::Builder::new().name("fleet".to_owned()).spawn_scoped(scope, || work(sender));
            thread.map_err(Error::from).inspect_err(|_| stop())?;
        }
        // The channel closes when the last thread drops its sender.
        drop(sender);
        loop {
            let left = store.flush_if_due().map_err(Error::from).inspect_err(|_| stop())?;
            match receiver.recv_timeout(left) {
                Ok(Ok(row)) => {
                    progress(&row);
                    store.add(row).map_err(Error::from).inspect_err(|_| stop())?;
                }
                Ok(Err(error)) => {
                    stop();
                    return Err(error);
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            }
        }
    });
    store.flush()?;
    result
}
