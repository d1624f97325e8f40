//! The kernel's rotor-bearing system with the scene's numbers of coordinates and bearings, which are constants of its type.

use super::plant_error::{PlantError, Result, rejected};
use super::system::{OnHeap, RIGID};
use super::warm::Held;
use super::{MountedBearing, Plant};
use ballrace::bearing::{Bearing, ElementPosition, Reaction};
use ballrace::rotor::{
    AttachedBearing, Attachment, BearingAtStation, ForceElement, HasSpeedRatios, LinearSystem, MovingBalls, RigidRotor,
    RotorBearingSystem, SecondOrderSystem, SpeedRatios,
};
use ballrace::{BearingKinematicState, Displacement, Exact, Status, Stiffness};
use ballrace_models::build::{self, Shared};
use nalgebra::SMatrix;
use std::sync::Arc;

/// Largest number of bearings on one rotor.
pub const MAX_BEARINGS: usize = 8;
/// Largest number of coordinates of a system.
pub const LARGEST: usize = 128;
/// Largest number of coordinates that an observer follows.
pub const MAX_OBSERVED: usize = 32;

/// A force element that also returns the reaction of its bearing.
pub trait ReactingElement<const D: usize>: ForceElement<f64, D> {
    /// Returns the reaction of the bearing at the coordinates `q`.
    fn reaction(&self, q: &[f64; D], at: &BearingKinematicState<f64>) -> Reaction<f64>;
}

/// Task with a rotor-bearing system of any size.
pub trait SystemTask<R> {
    /// Runs the task.
    fn run<S, C, const D: usize, const N: usize>(self, machine: RotorBearingSystem<S, C, N>) -> R
    where
        S: SecondOrderSystem<f64, D> + Clone + Send + 'static,
        C: ReactingElement<D> + Clone + Send + 'static;
}

/// A rigid rotor on bearings.
pub(crate) type RigidSystem<const N: usize> =
    RotorBearingSystem<RigidRotor<f64, Exact>, BearingAtStation<f64, Held>, N>;

/// Function that returns the kernel's bearing of a mounted bearing: [`MountedBearing::resting`] or [`MountedBearing::moving`].
pub(crate) type Hold = fn(&MountedBearing) -> Held;

/// A bearing without force, for an unused position of the system.
struct NoBearing;

impl Bearing<f64> for NoBearing {
    fn reaction(&self, _u: &Displacement<f64>, _at: &BearingKinematicState<f64>) -> Reaction<f64> {
        Reaction::default()
    }
    fn reaction_and_stiffness(
        &self,
        _u: &Displacement<f64>,
        _at: &BearingKinematicState<f64>,
    ) -> (Reaction<f64>, Stiffness<f64>) {
        (Reaction::default(), Stiffness::from_element(0.0))
    }
    fn element_loads(&self, _u: &Displacement<f64>, _at: &BearingKinematicState<f64>, _loads: &mut [f64]) {}
}

impl ReactingElement<5> for BearingAtStation<f64, Held> {
    fn reaction(&self, q: &[f64; 5], at: &BearingKinematicState<f64>) -> Reaction<f64> {
        self.bearing.reaction(&Displacement::from_array(*q).at_station(self.station), at)
    }
}

/// A bearing on any coordinates, or one whose balls are coordinates.
#[derive(Clone)]
pub(crate) enum MountedElement<const D: usize> {
    /// Bearing on coordinates of the system.
    Bearing(AttachedBearing<f64, Held, D>),
    /// Balls with coordinates of their own.
    Balls(Box<MovingBalls<f64, Exact, Vec<ElementPosition<f64>>, D>>),
}

impl<const D: usize> HasSpeedRatios<f64> for MountedElement<D> {
    fn speed_ratios(&self) -> &SpeedRatios<f64> {
        match self {
            Self::Bearing(bearing) => bearing.speed_ratios(),
            Self::Balls(balls) => balls.speed_ratios(),
        }
    }
}

impl<const D: usize> ForceElement<f64, D> for MountedElement<D> {
    fn add_force(&self, q: &[f64; D], at: &BearingKinematicState<f64>, f: &mut [f64; D]) -> (f64, Status) {
        match self {
            Self::Bearing(bearing) => bearing.add_force(q, at, f),
            Self::Balls(balls) => balls.add_force(q, at, f),
        }
    }
    fn add_force_and_stiffness(
        &self,
        q: &[f64; D],
        at: &BearingKinematicState<f64>,
        f: &mut [f64; D],
        k: &mut SMatrix<f64, D, D>,
    ) -> (f64, Status) {
        match self {
            Self::Bearing(bearing) => bearing.add_force_and_stiffness(q, at, f, k),
            Self::Balls(balls) => balls.add_force_and_stiffness(q, at, f, k),
        }
    }
}

impl<const D: usize> ReactingElement<D> for MountedElement<D> {
    fn reaction(&self, q: &[f64; D], at: &BearingKinematicState<f64>) -> Reaction<f64> {
        match self {
            Self::Bearing(bearing) => bearing.bearing.reaction(&bearing.attachment.displacement(q), at),
            Self::Balls(balls) => balls.reaction(q, at),
        }
    }
}

impl Plant {
    /// Runs `task` with a system that has at least the scene's coordinates and bearings. Unused ones have no effect; each
    /// pair of counts is compiled separately.
    pub(super) fn with_machine<R>(&self, hold: Hold, task: impl SystemTask<R>) -> Result<R> {
        match self.layout.order {
            small if small <= MAX_OBSERVED => self.with_observed_machine(hold, task),
            medium if medium <= 64 => self.general::<R, 64, MAX_BEARINGS>(hold, task),
            large if large <= LARGEST => self.general::<R, LARGEST, MAX_BEARINGS>(hold, task),
            found => Err(PlantError::Coordinates { found, most: LARGEST }),
        }
    }

    /// Runs `task` as [`Plant::with_machine`], with at most [`MAX_OBSERVED`] coordinates.
    pub(super) fn with_observed_machine<R>(&self, hold: Hold, task: impl SystemTask<R>) -> Result<R> {
        // Each arm calls a function that is not inlined: one stack frame with the local variables of all arms is too large.
        match (self.layout.order, self.bearings.len()) {
            (_, 1) if self.layout.is_rigid() => self.rigid::<R, 1>(hold, task),
            (_, 2) if self.layout.is_rigid() => self.rigid::<R, 2>(hold, task),
            _ if self.layout.is_rigid() => self.rigid::<R, MAX_BEARINGS>(hold, task),
            (..=12, ..=2) => self.general::<R, 12, 2>(hold, task),
            (..=16, ..=2) => self.general::<R, 16, 2>(hold, task),
            (..=MAX_OBSERVED, _) => self.general::<R, MAX_OBSERVED, MAX_BEARINGS>(hold, task),
            (found, _) => Err(PlantError::Coordinates { found, most: MAX_OBSERVED }),
        }
    }

    #[inline(never)]
    fn rigid<R, const N: usize>(&self, hold: Hold, task: impl SystemTask<R>) -> Result<R> {
        Ok(task.run::<_, _, RIGID, N>(self.rotor_on_bearings(hold)?))
    }

    fn rotor_on_bearings<const N: usize>(&self, hold: Hold) -> Result<RigidSystem<N>> {
        let Some(rotor) = &self.rotor else { return Err(PlantError::NoSystem) };
        let mut params = build::rotor_params(rotor);
        for (i, row) in params.damping.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry += self.damping[(i, j)];
            }
        }
        let rotor =
            RigidRotor::<f64, Exact>::try_new(&params, &build::unbalances(rotor)).map_err(rejected("[rotor]"))?;
        let bearings = std::array::from_fn(|i| match self.bearings.get(i) {
            Some(mounted) => BearingAtStation {
                bearing: hold(mounted),
                station: mounted.station,
                speed_ratios: mounted.kinematics.speed_ratios(),
            },
            None => BearingAtStation { bearing: nothing(), station: 0.0, speed_ratios: SpeedRatios::new(0.0) },
        });
        Ok(RotorBearingSystem { rotor, bearings })
    }

    #[inline(never)]
    fn general<R, const D: usize, const N: usize>(&self, hold: Hold, task: impl SystemTask<R>) -> Result<R> {
        let matrices = self.layout.matrices::<D>(self.rotor.as_ref(), &self.bearings, &self.damping)?;
        let rotor =
            LinearSystem::<f64, Exact, D, OnHeap<D>>::try_with_storage(&matrices).map_err(PlantError::System)?;
        let fitted = |i: usize| match self.bearings.get(i) {
            Some(mounted) => self.mounted_element(i, mounted, hold),
            None => Ok(MountedElement::Bearing(AttachedBearing {
                bearing: nothing(),
                attachment: Attachment::on_rigid_rotor(0.0, None),
                speed_ratios: SpeedRatios::new(0.0),
            })),
        };
        let all = (0..N).map(fitted).collect::<Result<Vec<_>>>()?;
        let Ok(bearings) = <[MountedElement<D>; N]>::try_from(all) else {
            return Err(PlantError::NoSystem);
        };
        Ok(task.run::<_, _, D, N>(RotorBearingSystem { rotor, bearings }))
    }

    fn mounted_element<const D: usize>(
        &self,
        i: usize,
        mounted: &MountedBearing,
        hold: Hold,
    ) -> Result<MountedElement<D>> {
        let (attachment, speed_ratios) = (self.layout.attachment::<D>(i), mounted.kinematics.speed_ratios());
        let first = self.layout.balls.get(i).copied().flatten();
        Ok(match (&mounted.balls, first) {
            (Some(balls), Some(first)) => {
                let places = (balls.places.clone(), first);
                let moving = MovingBalls::try_new(&balls.params, (attachment, speed_ratios), places)
                    .map_err(rejected(&format!("bearing {}", mounted.name)))?;
                MountedElement::Balls(Box::new(moving))
            }
            _ => MountedElement::Bearing(AttachedBearing { bearing: hold(mounted), attachment, speed_ratios }),
        })
    }
}

/// Returns a bearing without force.
pub(crate) fn nothing() -> Held {
    Held::Plain(Shared(Arc::new(NoBearing)))
}
