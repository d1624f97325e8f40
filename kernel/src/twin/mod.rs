//! What firmware runs every sample beside its system: the state behind the probes and what stands out of it.
//!
//! Probe samples go into an [`Observer`], which gives the rotor's motion, the forces of its bearings and what the model
//! does not explain. Displacements, forces and residuals go into indicators: [`OrderTracker`] for what turns with the
//! shaft or a bearing's parts, [`Statistics`], [`Envelope`], [`Life`]. Each works in blocks that start anew: figures are
//! exact over any length.

mod envelope;
mod life;
mod observer;
mod order;
mod statistics;
mod sum;
mod unmodelled_force;

pub use envelope::Envelope;
pub use life::{Life, LifeParams};
pub use observer::{Estimate, Observer, ObserverState, SpeedGain};
pub use order::{OrderLine, OrderTracker, OrderVector};
pub use statistics::{BlockStatistics, Statistics};
pub use sum::CompensatedSum;
pub use unmodelled_force::WithUnmodelledForce;
