//! Observer of a rigid rotor: a steady-state Kalman filter with baked gains.

use crate::geometry::{InvalidParameter, check, report};
use crate::pointer::{self, check_pointers};
use crate::rotor::{
    BearingOfC, RigidRotorParams, RotorBearing, Shaft, stationary, system, write_entries, write_motion,
};
use crate::state::{self, Stored};
use crate::status;
use ballrace::Exact;
use ballrace::rotor::{BearingAtStation, RigidRotor, Verlet};
use ballrace::twin;

/// Largest number of probes of an observer.
pub const MAX_PROBES: u32 = 8;

/// Parameters of an observer beside its rotor. `ballrace bake --language c` writes them.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct ObserverParams {
    /// Readings of each probe per unit of each coordinate: five entries per probe.
    pub probes: *const f32,
    /// Gains at each speed: for `P` probes `20 P + P^2` floats, of which five per probe for displacement, for velocity, for
    /// the constant load and for the rotating load, then the whitening matrix row by row.
    pub gains: *const f32,
    /// Number of speeds with gains, 1 or more.
    pub gain_count: u32,
    /// Time steps per sample, 1 or more.
    pub substeps: u32,
    /// Time step, s.
    pub step: f32,
    /// Speed of the first gains, rad/s.
    pub first_speed: f32,
    /// Gains per rad/s.
    pub speed_density: f32,
    /// Factor of the unmodelled load from sample to sample without correction, at most 1.
    pub load_retention: f32,
    /// Largest normalised innovation squared of a sample that corrects the state; infinity for any.
    pub gate: f32,
}

/// Result of one sample.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Estimate {
    /// Readings less predictions, m; 0 for a missing reading. As many as there are probes.
    pub innovation: [f32; 8],
    /// Normalised innovation squared.
    pub nis: f32,
}

/// An observer: constant after `ballrace_observer_init`, which writes it. Opaque.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Observer {
    /// Private.
    pub model: *const ObserverModel,
    /// Private.
    pub words: [u64; 86],
}

/// State of an observer. Opaque: `ballrace_observer_state_init` writes it.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct ObserverState {
    /// Private.
    pub words: [u64; 30],
}

/// Functions of an observer with a number of bearings and probes. The library exports one constant per pair of numbers; a
/// program uses only their addresses.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct ObserverModel {
    /// Number of bearings.
    pub bearing_count: u32,
    /// Number of probes.
    pub probe_count: u32,
    /// Implementation of `ballrace_observer_init`.
    pub init: unsafe extern "C" fn(
        observer: *mut Observer,
        rotor: *const RigidRotorParams,
        bearings: *const RotorBearing,
        params: *const ObserverParams,
        invalid: *mut InvalidParameter,
    ) -> u32,
    /// Implementation of `ballrace_observer_state_init`.
    pub state_init: unsafe extern "C" fn(
        state: *mut ObserverState,
        displacement: *const f32,
        shaft_angle: u64,
        cage_angles: *const u64,
    ) -> u32,
    /// Implementation of `ballrace_observer_sample`.
    pub sample: unsafe extern "C" fn(
        observer: *const Observer,
        state: *mut ObserverState,
        shaft: *const Shaft,
        readings: *const f32,
        estimate: *mut Estimate,
    ) -> u32,
    /// Implementation of `ballrace_observer_motion`.
    pub motion: unsafe extern "C" fn(
        state: *const ObserverState,
        displacement: *mut f32,
        velocity: *mut f32,
        load: *mut f32,
        rotating_load: *mut f32,
    ) -> u32,
}

type Gains<const P: usize> = &'static [twin::SpeedGain<f32, 5, P>];

type KernelObserver<const N: usize, const P: usize> =
    twin::Observer<f32, RigidRotor<f32, Exact>, BearingAtStation<f32, BearingOfC>, Verlet<f32>, Gains<P>, 5, N, P>;

impl<const N: usize, const P: usize> Stored for KernelObserver<N, P> {
    const KIND: u32 = 0x40 + 8 * N as u32 + P as u32;
}

impl<const N: usize> Stored for twin::ObserverState<f32, 5, N> {
    const KIND: u32 = 0x30 + N as u32;
}

unsafe extern "C" fn init<const N: usize, const P: usize>(
    observer: *mut Observer,
    rotor: *const RigidRotorParams,
    bearings: *const RotorBearing,
    params: *const ObserverParams,
    invalid: *mut InvalidParameter,
) -> u32 {
    const { assert!(size_of::<twin::SpeedGain<f32, 5, P>>() == 4 * (20 * P + P * P)) };
    // SAFETY: the contract is that of `ballrace_observer_init`.
    unsafe {
        let params = &*params;
        let fails = |ok, name, found, allowed| check(ok, name, found, allowed, invalid);
        if fails(params.step > 0.0, "step", f64::from(params.step), "above 0 s")
            || fails(params.substeps > 0, "substeps", f64::from(params.substeps), "1 or more")
            || fails(params.gain_count > 0, "gain_count", f64::from(params.gain_count), "1 or more")
        {
            return status::INVALID_ARGUMENT;
        }
        let system = match system::<N>(rotor, bearings) {
            Ok(system) => system,
            Err(error) => return report(error, invalid),
        };
        let value: KernelObserver<N, P> = twin::Observer {
            system,
            integrator: Verlet { step: params.step },
            step: params.step,
            substeps: params.substeps,
            probes: *params.probes.cast::<[[f32; 5]; P]>(),
            gains: pointer::slice(params.gains.cast(), params.gain_count),
            speeds: [params.first_speed, params.speed_density],
            load_retention: params.load_retention,
            gate: params.gate,
        };
        state::write((&raw mut (*observer).words).cast::<[u64; 86]>(), value);
    }
    status::OK
}

unsafe extern "C" fn state_init<const N: usize>(
    state: *mut ObserverState,
    displacement: *const f32,
    shaft_angle: u64,
    cage_angles: *const u64,
) -> u32 {
    // SAFETY: the contract is that of `ballrace_observer_state_init`.
    unsafe {
        let start = twin::ObserverState::<f32, 5, N>::new(stationary(displacement, shaft_angle, cage_angles));
        state::write(state, start);
    }
    status::OK
}

unsafe extern "C" fn sample<const N: usize, const P: usize>(
    observer: *const Observer,
    state: *mut ObserverState,
    shaft: *const Shaft,
    readings: *const f32,
    estimate: *mut Estimate,
) -> u32 {
    // SAFETY: the contract is that of `ballrace_observer_sample`.
    unsafe {
        let observer = state::read::<KernelObserver<N, P>, _>(&raw const (*observer).words);
        let (Some(observer), Some(state)) = (observer, state::get::<twin::ObserverState<f32, 5, N>, _>(state)) else {
            return status::STATE_INVALID;
        };
        let result = observer.sample::<Exact>(state, &(&*shaft).into(), &*readings.cast::<[f32; P]>());
        if let Some(estimate) = estimate.as_mut() {
            for (to, from) in estimate.innovation.iter_mut().zip(result.innovation) {
                *to = from;
            }
            estimate.nis = result.nis;
        }
        u32::from(result.status.bits())
    }
}

unsafe extern "C" fn motion<const N: usize>(
    state: *const ObserverState,
    displacement: *mut f32,
    velocity: *mut f32,
    load: *mut f32,
    rotating_load: *mut f32,
) -> u32 {
    // SAFETY: the contract is that of `ballrace_observer_motion`.
    unsafe {
        let Some(state) = state::read::<twin::ObserverState<f32, 5, N>, _>(state) else {
            return status::STATE_INVALID;
        };
        write_motion(&state.motion, displacement, velocity);
        write_entries(load, &state.load);
        write_entries(rotating_load, &state.rotating_load);
    }
    status::OK
}

impl ObserverModel {
    /// Returns the functions for `N` bearings and `P` probes.
    pub const fn of<const N: usize, const P: usize>() -> Self {
        Self {
            bearing_count: N as u32,
            probe_count: P as u32,
            init: init::<N, P>,
            state_init: state_init::<N>,
            sample: sample::<N, P>,
            motion: motion::<N>,
        }
    }
}

/// Initialises an observer. For set-up: uses `double`.
///
/// `model` is one of `&ballrace_observer_of_..._bearings_..._probes`. `bearings` has one entry per bearing; parameters and
/// bearings are copied, the gains are not.
///
/// Returns `BALLRACE_INVALID_ARGUMENT` and fills `invalid`, if it is not NULL, for a parameter outside its range.
///
/// # Safety
/// `invalid` points to a struct or is NULL; all other pointers, also those in structs, are valid; the gains exist as long as
/// the observer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_observer_init(
    observer: *mut Observer,
    model: *const ObserverModel,
    rotor: *const RigidRotorParams,
    bearings: *const RotorBearing,
    params: *const ObserverParams,
    invalid: *mut InvalidParameter,
) -> u32 {
    check_pointers!(observer, model, rotor, bearings, params);
    // SAFETY: by the contract of the function.
    unsafe {
        (*observer).model = model;
        ((*model).init)(observer, rotor, bearings, params, invalid)
    }
}

/// Initialises the state of an observer without velocity and unmodelled loads; as `ballrace_rotor_state_init`.
///
/// # Safety
/// `observer` is initialised, `cage_angles` has one entry per bearing.
///
/// cbindgen:ptrs-as-arrays=[[displacement; 5]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_observer_state_init(
    observer: *const Observer,
    state: *mut ObserverState,
    displacement: *const f32,
    shaft_angle: u64,
    cage_angles: *const u64,
) -> u32 {
    check_pointers!(observer, state, displacement, cage_angles);
    // SAFETY: by the contract of the function.
    let Some(model) = (unsafe { (*observer).model.as_ref() }) else { return status::STATE_INVALID };
    // SAFETY: by the contract of the function.
    unsafe { (model.state_init)(state, displacement, shaft_angle, cage_angles) }
}

/// Processes one sample: `shaft` is the motion of the shaft at the last sample, `readings` are the present readings of the
/// probes in m. Constant number of instructions for one observer.
///
/// A reading that is not finite corrects nothing; the others do. A sample above the gate corrects nothing at all. Returns
/// status bits. `estimate` may be NULL.
///
/// # Safety
/// `observer` is initialised, `readings` has one entry per probe, all other pointers are valid or NULL.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_observer_sample(
    observer: *const Observer,
    state: *mut ObserverState,
    shaft: *const Shaft,
    readings: *const f32,
    estimate: *mut Estimate,
) -> u32 {
    check_pointers!(observer, state, shaft, readings);
    // SAFETY: by the contract of the function.
    let Some(model) = (unsafe { (*observer).model.as_ref() }) else { return status::STATE_INVALID };
    // SAFETY: by the contract of the function.
    unsafe { (model.sample)(observer, state, shaft, readings, estimate) }
}

/// Reads the estimated displacement (m, rad) and velocity of the centre of mass, the unmodelled constant load and the
/// unmodelled load that rotates with the shaft (N, N m). Each pointer may be NULL.
///
/// # Safety
/// `observer` is initialised; all pointers are valid or NULL.
///
/// cbindgen:ptrs-as-arrays=[[displacement; 5], [velocity; 5], [load; 5], [rotating_load; 5]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ballrace_observer_motion(
    observer: *const Observer,
    state: *const ObserverState,
    displacement: *mut f32,
    velocity: *mut f32,
    load: *mut f32,
    rotating_load: *mut f32,
) -> u32 {
    check_pointers!(observer, state);
    // SAFETY: by the contract of the function.
    let Some(model) = (unsafe { (*observer).model.as_ref() }) else { return status::STATE_INVALID };
    // SAFETY: by the contract of the function.
    unsafe { (model.motion)(state, displacement, velocity, load, rotating_load) }
}
