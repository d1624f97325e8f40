//! What firmware runs every sample beside its machine: the state behind the probes and what stands out of it.
//!
//! Probe samples go into an [`Observer`], which gives the rotor's motion, the forces of its bearings and what the model
//! does not explain.

mod disturbed;
mod observer;

pub use disturbed::Disturbed;
pub use observer::{Estimate, Observer, ObserverState, SpeedGain};
