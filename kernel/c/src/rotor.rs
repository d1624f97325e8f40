//! Rigid rotor on one to four bearings, integrated by Verlet's leapfrog method.

use crate::bearing::{Bearing, KinematicState};
use crate::geometry::{InvalidParameter, check, report};
use crate::model::stiffness_of;
use crate::pointer::{self, check_pointers};
use crate::state::{self, Stored};
use crate::status;
use ballrace::bearing::Reaction;
use ballrace::rotor::{
    BearingAtStation, Integrator, RigidRotor, RotorBearingSystem, RotorParams, RotorState, ShaftMotion, SpeedRatios,
    Unbalance, Verlet,
};
use ballrace::{BearingKinematicState, Displacement, Exact, Phase, Stiffness};

/// Parameters of a rigid rotor. Coordinates: displacement of the centre of mass, `u v w` in m and tilts about X and Y in
/// rad.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct RigidRotorParams {
    /// Mass, kg.
    pub mass: f64,
    /// I_d, moment of inertia about X and Y, kg m^2.
    pub diametral_inertia: f64,
    /// I_p, moment of inertia about Z, kg m^2.
    pub polar_inertia: f64,
    /// B, symmetric damping matrix, row by row: N s/m, N s, N m s.
    pub damping: [f64; 25],
    /// Stiffness of springs on the rotor: N/m (three), N m/rad (two).
    pub stiffness: [f64; 5],
    /// Gravity, m/s^2.
    pub gravity: [f64; 3],
    /// Constant force and moment, N and N m.
    pub load: [f64; 5],
    /// Unbalances; NULL without.
    pub unbalances: *const UnbalancePlane,
    /// Number of unbalances.
    pub unbalance_count: u32,
}

/// An unbalance in one plane.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct UnbalancePlane {
    /// Mass times eccentricity, kg m.
    pub moment: f64,
    /// Angle from the keyphasor mark in the direction of positive rotation, rad.
    pub angle: f64,
    /// Station along Z from the centre of mass, m.
    pub station: f64,
}

// The kernel reads an array of them in place.
const _: () = {
    assert!(size_of::<UnbalancePlane>() == size_of::<Unbalance>());
    assert!(core::mem::offset_of!(UnbalancePlane, angle) == core::mem::offset_of!(Unbalance, angle));
    assert!(core::mem::offset_of!(UnbalancePlane, station) == core::mem::offset_of!(Unbalance, station));
};

/// A bearing on a rotor.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct RotorBearing {
    /// Head of the bearing, which exists as long as the rotor.
    pub bearing: *const Bearing,
    /// Speed of the cage divided by that of the shaft.
    pub cage_ratio: f64,
    /// Speed of the balls about their own axes divided by that of the shaft; 0 where no result depends on it.
    pub ball_ratio: f64,
    /// Speed of the outer ring divided by that of the shaft; 0 for a fixed ring.
    pub outer_ratio: f64,
    /// Station along Z from the centre of mass, m.
    pub station: f32,
}

/// Motion of the shaft at the start of a step; the acceleration is constant during it.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Shaft {
    /// Angle of the keyphasor mark, 2^-64 revolutions.
    pub angle: u64,
    /// Speed about +Z, rad/s.
    pub speed: f32,
    /// Angular acceleration, rad/s^2.
    pub acceleration: f32,
}

impl From<&Shaft> for ShaftMotion<f32> {
    #[inline(always)]
    fn from(shaft: &Shaft) -> Self {
        Self { angle: Phase(shaft.angle), speed: shaft.speed, acceleration: shaft.acceleration }
    }
}

/// A rotor with its bearings: constant after `ballrace_rotor_init`, which writes it. Opaque.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Rotor {
    /// Private.
    pub model: *const RotorModel,
    /// Private.
    pub words: [u64; 60],
}

/// State of a rotor. Opaque: `ballrace_rotor_state_init` writes it.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Motion {
    /// Private.
    pub words: [u64; 24],
}

/// Functions of a rotor with a number of bearings. The library exports one constant per number; a program uses only their
/// addresses.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct RotorModel {
    /// Number of bearings.
    pub bearing_count: u32,
    /// Implementation of `ballrace_rotor_init`.
    pub init: unsafe extern "C" fn(
        rotor: *mut Rotor,
        params: *const RigidRotorParams,
        bearings: *const RotorBearing,
        step: f32,
        invalid: *mut InvalidParameter,
    ) -> u32,
    /// Implementation of `ballrace_rotor_state_init`.
    pub state_init: unsafe extern "C" fn(
        state: *mut Motion,
        displacement: *const f32,
        shaft_angle: u64,
        cage_angles: *const u64,
    ) -> u32,
    /// Implementation of `ballrace_rotor_step`.
    pub step: unsafe extern "C" fn(rotor: *const Rotor, state: *mut Motion, shaft: *const Shaft) -> u32,
    /// Implementation of `ballrace_rotor_motion`.
    pub motion: unsafe extern "C" fn(state: *const Motion, displacement: *mut f32, velocity: *mut f32) -> u32,
}

/// A bearing of the C interface that implements the `Bearing` trait of the kernel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BearingOfC(*const Bearing);

// SAFETY: a bearing is constant.
unsafe impl Send for BearingOfC {}
// SAFETY: a bearing is constant.
unsafe impl Sync for BearingOfC {}

impl ballrace::Bearing<f32> for BearingOfC {
    #[inline(always)]
    fn reaction(&self, u: &Displacement<f32>, at: &BearingKinematicState<f32>) -> Reaction<f32> {
        let (u, mut wrench) = (u.to_array(), [0.0; 5]);
        // SAFETY: the pointer is valid by the contract of the function that stored it.
        let bits = unsafe {
            ((*(*self.0).model).force_and_contact)(
                self.0,
                u.as_ptr(),
                KinematicState::from_kernel(at),
                wrench.as_mut_ptr(),
            )
        };
        status::to_reaction(wrench, bits)
    }

    fn reaction_and_stiffness(
        &self,
        u: &Displacement<f32>,
        at: &BearingKinematicState<f32>,
    ) -> (Reaction<f32>, Stiffness<f32>) {
        let (u, mut wrench, mut rows) = (u.to_array(), [0.0; 5], [0.0; 25]);
        // SAFETY: the pointer is valid by the contract of the function that stored it.
        let bits = unsafe {
            ((*(*self.0).model).force_and_stiffness)(
                self.0,
                u.as_ptr(),
                KinematicState::from_kernel(at),
                wrench.as_mut_ptr(),
                rows.as_mut_ptr(),
            )
        };
        (status::to_reaction(wrench, bits), stiffness_of(&rows))
    }

    /// Writes nothing: neither a rotor nor an observer reads element loads.
    fn element_loads(&self, _u: &Displacement<f32>, _at: &BearingKinematicState<f32>, _loads: &mut [f32]) {}
}

/// Rigid rotor on `N` bearings of C.
pub(crate) type System<const N: usize> =
    RotorBearingSystem<RigidRotor<f32, Exact>, BearingAtStation<f32, BearingOfC>, N>;

/// A system with its integrator.
pub(crate) struct Integrated<const N: usize> {
    system: System<N>,
    integrator: Verlet<f32>,
}

impl<const N: usize> Stored for Integrated<N> {
    const KIND: u32 = 0x10 + N as u32;
}

impl<const N: usize> Stored for RotorState<f32, 5, N> {
    const KIND: u32 = 0x20 + N as u32;
}

/// Returns the system with these parameters, or an error of the kernel.
///
/// # Safety
/// The pointers are valid; there are `N` bearings.
pub(crate) unsafe fn system<const N: usize>(
    params: *const RigidRotorParams,
    bearings: *const RotorBearing,
) -> Result<System<N>, ballrace::bearing::geometry::InvalidParameter> {
    // SAFETY: by the contract of the function.
    let (params, bearings) = unsafe { (&*params, &*bearings.cast::<[RotorBearing; N]>()) };
    let unbalances: &[Unbalance] = if params.unbalance_count == 0 {
        &[]
    } else {
        // SAFETY: by the contract of the function; both types have the same layout.
        unsafe { pointer::slice(params.unbalances.cast(), params.unbalance_count) }
    };
    let (rows, _) = params.damping.as_chunks::<5>();
    let mut damping = [[0.0; 5]; 5];
    for (row, given) in damping.iter_mut().zip(rows) {
        *row = *given;
    }
    let kernel_params = RotorParams {
        mass: params.mass,
        diametral_inertia: params.diametral_inertia,
        polar_inertia: params.polar_inertia,
        damping,
        stiffness: params.stiffness,
        gravity: params.gravity,
        load: params.load,
    };
    let rotor = RigidRotor::try_new(&kernel_params, unbalances)?;
    let bearings = bearings.each_ref().map(|bearing| {
        let mut speed_ratios = SpeedRatios::new(bearing.cage_ratio);
        if bearing.ball_ratio != 0.0 {
            speed_ratios = speed_ratios.with_ball(bearing.ball_ratio);
        }
        if bearing.outer_ratio != 0.0 {
            speed_ratios = speed_ratios.with_outer(bearing.outer_ratio);
        }
        BearingAtStation { bearing: BearingOfC(bearing.bearing), station: bearing.station, speed_ratios }
    });
    Ok(RotorBearingSystem { rotor, bearings })
}

/// Returns the state at `displacement` with zero velocity.
///
/// # Safety
/// `displacement` points to five floats, `cage_angles` to `N` angles.
pub(crate) unsafe fn stationary<const N: usize>(
    displacement: *const f32,
    shaft_angle: u64,
    cage_angles: *const u64,
) -> RotorState<f32, 5, N> {
    // SAFETY: by the contract of the function.
    let (start, cages) = unsafe { (pointer::displacement(displacement), *cage_angles.cast::<[u64; N]>()) };
    RotorState::stationary(start, Phase(shaft_angle), cages.map(Phase))
}

unsafe extern "C" fn init<const N: usize>(
    rotor: *mut Rotor,
    params: *const RigidRotorParams,
    bearings: *const RotorBearing,
    step: f32,
    invalid: *mut InvalidParameter,
) -> u32 {
    // SAFETY: the contract is that of `ballrace_rotor_init`.
    unsafe {
        if check(step > 0.0, "step", f64::from(step), "above 0 s", invalid) {
            return status::INVALID_ARGUMENT;
        }
        match system::<N>(params, bearings) {
            Ok(system) => {
                let words = (&raw mut (*rotor).words).cast::<[u64; 60]>();
                state::write(words, Integrated { system, integrator: Verlet { step } });
                status::OK
            }
            Err(error) => report(error, invalid),
        }
    }
}

unsafe extern "C" fn state_init<const N: usize>(
    state: *mut Motion,
    displacement: *const f32,
    shaft_angle: u64,
    cage_angles: *const u64,
) -> u32 {
    // SAFETY: the contract is that of `ballrace_rotor_state_init`.
    unsafe { state::write(state, stationary::<N>(displacement, shaft_angle, cage_angles)) };
    status::OK
}

unsafe extern "C" fn step<const N: usize>(rotor: *const Rotor, state: *mut Motion, shaft: *const Shaft) -> u32 {
    // SAFETY: the contract is that of `ballrace_rotor_step`.
    unsafe {
        let rotor = state::read::<Integrated<N>, _>(&raw const (*rotor).words);
        let (Some(rotor), Some(state)) = (rotor, state::get::<RotorState<f32, 5, N>, _>(state)) else {
            return status::STATE_INVALID;
        };
        u32::from(rotor.integrator.step(&rotor.system, state, &(&*shaft).into()).bits())
    }
}

/// Writes coordinates and velocities where the pointers are not null.
///
/// # Safety
/// The pointers point to five floats or are null.
pub(crate) unsafe fn write_motion<const N: usize>(
    motion: &RotorState<f32, 5, N>,
    displacement: *mut f32,
    velocity: *mut f32,
) {
    // SAFETY: by the contract of the function.
    unsafe {
        write_entries(displacement, &motion.q);
        write_entries(velocity, &motion.velocity);
    }
}

/// Writes five numbers where the pointer is not null.
///
/// # Safety
/// The pointer points to five floats or is null.
pub(crate) unsafe fn write_entries(to: *mut f32, entries: &[f32; 5]) {
    if !to.is_null() {
        // SAFETY: by the contract of the function.
        unsafe { *to.cast::<[f32; 5]>() = *entries };
    }
}

unsafe extern "C" fn motion<const N: usize>(state: *const Motion, displacement: *mut f32, velocity: *mut f32) -> u32 {
    // SAFETY: the contract is that of `ballrace_rotor_motion`.
    unsafe {
        let Some(state) = state::read::<RotorState<f32, 5, N>, _>(state) else { return status::STATE_INVALID };
        write_motion(state, displacement, velocity);
    }
    status::OK
}

impl RotorModel {
    const fn of<const N: usize>() -> Self {
        Self {
            bearing_count: N as u32,
            init: init::<N>,
            state_init: state_init::<N>,
            step: step::<N>,
            motion: motion::<N>,
        }
    }
}

/// Rotor on one bearing.
#[unsafe(no_mangle)]
pub static ballrace_rotor_on_1_bearing: RotorModel = RotorModel::of::<1>();

/// Rotor on two bearings.
#[unsafe(no_mangle)]
pub static ballrace_rotor_on_2_bearings: RotorModel = RotorModel::of::<2>();

/// Rotor on three bearings.
#[unsafe(no_mangle)]
pub static ballrace_rotor_on_3_bearings: RotorModel = RotorModel::of::<3>();

/// Rotor on four bearings.
#[unsafe(no_mangle)]
pub static ballrace_rotor_on_4_bearings: RotorModel = RotorModel::of::<4>();

/// Initialises a rotor. For set-up: uses `double`.
///
/// `model` is one of `&ballrace_rotor_on_..._bearings`, `bearings` has that number of entries, which are copied. `step` is
/// the time step in s; the integrator is stable up to 2 divided by the largest natural angular frequency.
///
/// Returns `BALLRACE_INVALID_ARGUMENT` and fills `invalid`, if it is not NULL, for a parameter outside its range.
///
/// # Safety
/// `invalid` points to a struct or is NULL; all other pointers, also those in structs, are valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_rotor_init(
    rotor: *mut Rotor,
    model: *const RotorModel,
    params: *const RigidRotorParams,
    bearings: *const RotorBearing,
    step: f32,
    invalid: *mut InvalidParameter,
) -> u32 {
    check_pointers!(rotor, model, params, bearings);
    // SAFETY: by the contract of the function.
    unsafe {
        (*rotor).model = model;
        ((*model).init)(rotor, params, bearings, step, invalid)
    }
}

/// Initialises the state of a rotor without velocity at `displacement`, with these angles of the shaft and of the cage of
/// each bearing in 2^-64 revolutions.
///
/// # Safety
/// `rotor` is initialised, `cage_angles` has one entry per bearing.
///
/// cbindgen:ptrs-as-arrays=[[displacement; 5]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_rotor_state_init(
    rotor: *const Rotor,
    state: *mut Motion,
    displacement: *const f32,
    shaft_angle: u64,
    cage_angles: *const u64,
) -> u32 {
    check_pointers!(rotor, state, displacement, cage_angles);
    // SAFETY: by the contract of the function.
    let Some(model) = (unsafe { (*rotor).model.as_ref() }) else { return status::STATE_INVALID };
    // SAFETY: by the contract of the function.
    unsafe { (model.state_init)(state, displacement, shaft_angle, cage_angles) }
}

/// Advances the state by one step, with the shaft motion at its start. Constant number of instructions.
///
/// A shaft motion or result that is not finite leaves displacement and velocity unchanged and is flagged. Returns status
/// bits; `BALLRACE_STATE_INVALID` for a rotor or state that is not initialised, or for another number of bearings.
///
/// # Safety
/// `rotor` is initialised; all pointers are valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_rotor_step(rotor: *const Rotor, state: *mut Motion, shaft: *const Shaft) -> u32 {
    check_pointers!(rotor, state, shaft);
    // SAFETY: by the contract of the function.
    let Some(model) = (unsafe { (*rotor).model.as_ref() }) else { return status::STATE_INVALID };
    // SAFETY: by the contract of the function.
    unsafe { (model.step)(rotor, state, shaft) }
}

/// Reads displacement (m, rad) and velocity (m/s, rad/s) of the centre of mass. Either pointer may be NULL.
///
/// # Safety
/// `rotor` is initialised; all pointers are valid or NULL.
///
/// cbindgen:ptrs-as-arrays=[[displacement; 5], [velocity; 5]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_rotor_motion(
    rotor: *const Rotor,
    state: *const Motion,
    displacement: *mut f32,
    velocity: *mut f32,
) -> u32 {
    check_pointers!(rotor, state);
    // SAFETY: by the contract of the function.
    let Some(model) = (unsafe { (*rotor).model.as_ref() }) else { return status::STATE_INVALID };
    // SAFETY: by the contract of the function.
    unsafe { (model.motion)(state, displacement, velocity) }
}

/// Returns the shaft motion after the time `dt` in s: at most half a revolution.
///
/// # Safety
/// `shaft` points to a struct.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_shaft_after(shaft: *const Shaft, dt: f32) -> Shaft {
    // SAFETY: by the contract of the function.
    let after = ShaftMotion::from(unsafe { &*shaft }).after(dt);
    Shaft { angle: after.angle.0, speed: after.speed, acceleration: after.acceleration }
}
