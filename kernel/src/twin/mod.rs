//! State estimation and condition indicators for firmware, sample by sample.
//!
//! An [`Observer`] estimates the motion of the rotor, the forces of its bearings and the unmodelled load from probe
//! samples. The indicators take displacements, forces and residuals: [`OrderTracker`] for components that rotate with the
//! shaft, a cage or a ball, [`ForceOrderTracker`] for the radial force in the frame of each component of a bearing,
//! [`Statistics`], [`Envelope`], [`Life`]. A [`DamageDetector`] takes an acceleration and names the damaged component of a
//! bearing. Each works in independent blocks, so that the results do not drift.

mod damage;
mod envelope;
mod force_order;
mod life;
mod observer;
mod order;
mod statistics;
mod sum;
mod unmodelled_force;

pub use damage::{DamageDetector, DamageHypothesis, DamageVerdict, DamagedComponent};
pub use envelope::Envelope;
pub use force_order::{ForceLine, ForceOrderTracker, ForceOrders};
pub use life::{Life, LifeParams};
pub use observer::{Estimate, Observer, ObserverState, SpeedGain};
pub use order::{OrderLine, OrderSums, OrderTracker, OrderVector, RevolutionBlock};
pub use statistics::{BlockStatistics, Statistics};
pub use sum::{Accumulator, CompensatedSum};
pub use unmodelled_force::WithUnmodelledForce;
