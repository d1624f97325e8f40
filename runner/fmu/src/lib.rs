//! Library in a unit that `ballrace fmu` writes: the C functions of FMI 3.0 for co-simulation (Modelica Association, Functional Mock-up
//! Interface Specification 3.0).
//!
//! The library is the same in every unit. An instance reads the scene in the resources of its unit and is a
//! [`Unit`](ballrace_studies::fmu::Unit). Everything that is not co-simulation without events returns an error. No panic reaches the
//! host; every error is a message to its logger.
//!
//! # Safety
//!
//! Of every function, `instance` is null or was returned by [`fmi3InstantiateCoSimulation`], was not freed, and is in no other call; each array
//! is null or has the stated number of values, and each text is null or ends with a 0.
// The functions take pointers from the host and have the names of the standard.
#![allow(unsafe_code, non_snake_case)]

mod exchange;
mod instance;
mod not_provided;
mod pointer;
mod state;
#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests;

use instance::{Host, Instance, LogMessage, Mode, call};
use pointer::{store, text};
use std::ffi::{c_char, c_int, c_void};

/// Words by which the program knows the library of its version.
#[used]
#[unsafe(no_mangle)]
pub static ballrace_unit_library: [u8; MARK.len()] = *MARK;
const MARK: &[u8; concat!("ballrace unit library ", env!("CARGO_PKG_VERSION"), "\n").len()] =
    as_array(concat!("ballrace unit library ", env!("CARGO_PKG_VERSION"), "\n"));

const fn as_array<const N: usize>(text: &'static str) -> &'static [u8; N] {
    match text.as_bytes().first_chunk() {
        Some(all) => all,
        None => &[0; N],
    }
}

/// Value reference of a variable.
type ValueReference = u32;

/// Returns the version of the interface.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// Creates an instance from the folder of the unit's resources; null with a message where that fails.
///
/// # Safety
/// The texts are null or end with a 0; `logMessage` may be called with `instanceEnvironment` until the instance is freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    instanceName: *const c_char,
    instantiationToken: *const c_char,
    resourcePath: *const c_char,
    _visible: bool,
    _loggingOn: bool,
    eventModeUsed: bool,
    _earlyReturnAllowed: bool,
    _requiredIntermediateVariables: *const ValueReference,
    nRequiredIntermediateVariables: usize,
    instanceEnvironment: *mut c_void,
    logMessage: LogMessage,
    _intermediateUpdate: *const c_void,
) -> *mut c_void {
    let host = Host { environment: instanceEnvironment, log: logMessage };
    let create = || {
        // SAFETY: the texts of the host end with a 0 or are null.
        let [_, token, folder] = unsafe {
            [
                text("instanceName", instanceName)?,
                text("instantiationToken", instantiationToken)?,
                text("resourcePath", resourcePath)?,
            ]
        };
        if eventModeUsed || nRequiredIntermediateVariables > 0 {
            return Err(
                "events or intermediate variables, expected neither of them (hasEventMode, providesIntermediateUpdate)"
                    .to_owned(),
            );
        }
        Instance::open(folder, token, host)
    };
    match host.outcome("fmi3InstantiateCoSimulation", create) {
        Ok(instance) => Box::into_raw(Box::new(instance)).cast(),
        Err(_) => std::ptr::null_mut(),
    }
}

/// Frees an instance; null is none.
///
/// # Safety
/// `instance` is null or was returned by [`fmi3InstantiateCoSimulation`] and is not used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(instance: *mut c_void) {
    if !instance.is_null() {
        // SAFETY: the host owns the instance and gives it back.
        let instance = unsafe { Box::from_raw(instance.cast::<Instance>()) };
        let host = instance.host;
        let _ = host.outcome("fmi3FreeInstance", move || {
            drop(instance);
            Ok(())
        });
    }
}

/// Accepts every choice of messages: the only ones are those of errors.
///
/// # Safety
/// As in the [crate](crate#safety).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetDebugLogging(
    instance: *mut c_void,
    _loggingOn: bool,
    _nCategories: usize,
    _categories: *const *const c_char,
) -> c_int {
    // SAFETY: the caller's.
    unsafe { call(instance, "fmi3SetDebugLogging", &Mode::ALL, |_| Ok(())) }
}

/// Begins the initialisation at a start time.
///
/// # Safety
/// As in the [crate](crate#safety).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    instance: *mut c_void,
    _toleranceDefined: bool,
    _tolerance: f64,
    startTime: f64,
    stopTimeDefined: bool,
    stopTime: f64,
) -> c_int {
    let enter = |instance: &mut Instance| {
        let stop = if stopTimeDefined { stopTime } else { f64::INFINITY };
        if !startTime.is_finite() || stop.is_nan() || stop < startTime {
            return Err(format!("startTime and stopTime: {startTime} and {stop}, expected finite times in this order"));
        }
        instance.unit.run_from(startTime, stop);
        instance.mode = Mode::Initialization;
        Ok(())
    };
    // SAFETY: the caller's.
    unsafe { call(instance, "fmi3EnterInitializationMode", &[Mode::Instantiated], enter) }
}

/// Ends the initialisation: the first step may follow.
///
/// # Safety
/// As in the [crate](crate#safety).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ExitInitializationMode(instance: *mut c_void) -> c_int {
    // SAFETY: the caller's.
    unsafe {
        call(instance, "fmi3ExitInitializationMode", &[Mode::Initialization], |instance| {
            instance.mode = Mode::Step;
            Ok(())
        })
    }
}

/// Ends a simulation; values can still be read.
///
/// # Safety
/// As in the [crate](crate#safety).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Terminate(instance: *mut c_void) -> c_int {
    // SAFETY: the caller's.
    unsafe {
        call(instance, "fmi3Terminate", &[Mode::Step], |instance| {
            instance.mode = Mode::Terminated;
            Ok(())
        })
    }
}

/// Returns an instance to its state after [`fmi3InstantiateCoSimulation`].
///
/// # Safety
/// As in the [crate](crate#safety).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Reset(instance: *mut c_void) -> c_int {
    // SAFETY: the caller's.
    unsafe {
        call(instance, "fmi3Reset", &Mode::ALL, |instance| {
            instance.unit.reset().map_err(|error| instance::message(&error))?;
            instance.mode = Mode::Instantiated;
            Ok(())
        })
    }
}

/// Advances by a communication step with the present inputs.
///
/// # Safety
/// As in the [crate](crate#safety); each pointer to a result is null or writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    instance: *mut c_void,
    currentCommunicationPoint: f64,
    communicationStepSize: f64,
    _noSetFMUStatePriorToCurrentPoint: bool,
    eventHandlingNeeded: *mut bool,
    terminateSimulation: *mut bool,
    earlyReturn: *mut bool,
    lastSuccessfulTime: *mut f64,
) -> c_int {
    let step = |instance: &mut Instance| {
        let stepped = instance.unit.step(currentCommunicationPoint, communicationStepSize);
        // SAFETY: the host's places for results are writable or null.
        unsafe {
            store(eventHandlingNeeded, false);
            store(terminateSimulation, false);
            store(earlyReturn, false);
            store(lastSuccessfulTime, instance.unit.time());
        }
        stepped.map_err(|error| instance::message(&error))
    };
    // SAFETY: the caller's.
    unsafe { call(instance, "fmi3DoStep", &[Mode::Step], step) }
}
