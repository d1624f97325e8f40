//! Functions of FMI 3.0 that the unit does not provide. Each returns an error: there is no variable of the type, no event, no clock, no
//! derivative, no configuration, no serialised state, and no other interface than co-simulation.

use crate::ValueReference;
use crate::instance::{Host, Instance, LogMessage, Mode, call};
use std::ffi::{c_char, c_int, c_void};
use std::ptr::null_mut;

/// Refuses a function.
fn refuse(_: &mut Instance) -> Result<(), String> {
    Err("this unit does not provide the function, expected co-simulation with values of Float64 and Int32".to_owned())
}

/// Defines functions with the types of their arguments after the instance.
macro_rules! not_provided {
    ($($name:ident($($argument:ty),*);)*) => {
        $(
            /// Not provided.
            ///
            /// # Safety
            /// As in the [crate](crate#safety).
            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn $name(instance: *mut c_void, $(_: $argument),*) -> c_int {
                // SAFETY: the caller's.
                unsafe { call(instance, stringify!($name), &Mode::ALL, refuse) }
            }
        )*
    };
}

// Values of other types.
not_provided! {
    fmi3GetFloat32(*const ValueReference, usize, *mut f32, usize);
    fmi3GetInt8(*const ValueReference, usize, *mut i8, usize);
    fmi3GetUInt8(*const ValueReference, usize, *mut u8, usize);
    fmi3GetInt16(*const ValueReference, usize, *mut i16, usize);
    fmi3GetUInt16(*const ValueReference, usize, *mut u16, usize);
    fmi3GetUInt32(*const ValueReference, usize, *mut u32, usize);
    fmi3GetInt64(*const ValueReference, usize, *mut i64, usize);
    fmi3GetUInt64(*const ValueReference, usize, *mut u64, usize);
    fmi3GetBoolean(*const ValueReference, usize, *mut bool, usize);
    fmi3GetString(*const ValueReference, usize, *mut *const c_char, usize);
    fmi3GetBinary(*const ValueReference, usize, *mut usize, *mut *const u8, usize);
    fmi3GetClock(*const ValueReference, usize, *mut bool);
    fmi3SetFloat32(*const ValueReference, usize, *const f32, usize);
    fmi3SetInt8(*const ValueReference, usize, *const i8, usize);
    fmi3SetUInt8(*const ValueReference, usize, *const u8, usize);
    fmi3SetInt16(*const ValueReference, usize, *const i16, usize);
    fmi3SetUInt16(*const ValueReference, usize, *const u16, usize);
    fmi3SetInt32(*const ValueReference, usize, *const i32, usize);
    fmi3SetUInt32(*const ValueReference, usize, *const ValueReference, usize);
    fmi3SetInt64(*const ValueReference, usize, *const i64, usize);
    fmi3SetUInt64(*const ValueReference, usize, *const u64, usize);
    fmi3SetBoolean(*const ValueReference, usize, *const bool, usize);
    fmi3SetString(*const ValueReference, usize, *const *const c_char, usize);
    fmi3SetBinary(*const ValueReference, usize, *const usize, *const *const u8, usize);
    fmi3SetClock(*const ValueReference, usize, *const bool);
}

// Dependencies, serialised states, derivatives, configuration, clocks, events, model exchange.
not_provided! {
    fmi3EnterEventMode();
    fmi3GetNumberOfVariableDependencies(u32, *mut usize);
    fmi3GetVariableDependencies(u32, *mut usize, *mut u32, *mut usize, *mut c_int, usize);
    fmi3SerializedFMUStateSize(*mut c_void, *mut usize);
    fmi3SerializeFMUState(*mut c_void, *mut u8, usize);
    fmi3DeserializeFMUState(*const u8, usize, *mut *mut c_void);
    fmi3GetDirectionalDerivative(*const ValueReference, usize, *const ValueReference, usize, *const f64, usize, *mut f64, usize);
    fmi3GetAdjointDerivative(*const ValueReference, usize, *const ValueReference, usize, *const f64, usize, *mut f64, usize);
    fmi3EnterConfigurationMode();
    fmi3ExitConfigurationMode();
    fmi3GetIntervalDecimal(*const ValueReference, usize, *mut f64, *mut c_int);
    fmi3GetIntervalFraction(*const ValueReference, usize, *mut u64, *mut u64, *mut c_int);
    fmi3GetShiftDecimal(*const ValueReference, usize, *mut f64);
    fmi3GetShiftFraction(*const ValueReference, usize, *mut u64, *mut u64);
    fmi3SetIntervalDecimal(*const ValueReference, usize, *const f64);
    fmi3SetIntervalFraction(*const ValueReference, usize, *const u64, *const u64);
    fmi3SetShiftDecimal(*const ValueReference, usize, *const f64);
    fmi3SetShiftFraction(*const ValueReference, usize, *const u64, *const u64);
    fmi3EvaluateDiscreteStates();
    fmi3UpdateDiscreteStates(*mut bool, *mut bool, *mut bool, *mut bool, *mut bool, *mut f64);
    fmi3EnterContinuousTimeMode();
    fmi3CompletedIntegratorStep(bool, *mut bool, *mut bool);
    fmi3SetTime(f64);
    fmi3SetContinuousStates(*const f64, usize);
    fmi3GetContinuousStateDerivatives(*mut f64, usize);
    fmi3GetEventIndicators(*mut f64, usize);
    fmi3GetContinuousStates(*mut f64, usize);
    fmi3GetNominalsOfContinuousStates(*mut f64, usize);
    fmi3GetNumberOfEventIndicators(*mut usize);
    fmi3GetNumberOfContinuousStates(*mut usize);
    fmi3EnterStepMode();
    fmi3GetOutputDerivatives(*const ValueReference, usize, *const i32, *mut f64, usize);
    fmi3ActivateModelPartition(u32, f64);
}

/// Refuses another interface than co-simulation.
fn no_instance(name: &str, environment: *mut c_void, log: LogMessage) -> *mut c_void {
    let refused = Err("this unit has no such interface, expected fmi3InstantiateCoSimulation".to_owned());
    let _: Result<(), _> = Host { environment, log }.outcome(name, || refused);
    null_mut()
}

/// Not provided: returns null.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3InstantiateModelExchange(
    _instanceName: *const c_char,
    _instantiationToken: *const c_char,
    _resourcePath: *const c_char,
    _visible: bool,
    _loggingOn: bool,
    instanceEnvironment: *mut c_void,
    logMessage: LogMessage,
) -> *mut c_void {
    no_instance("fmi3InstantiateModelExchange", instanceEnvironment, logMessage)
}

/// Not provided: returns null.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3InstantiateScheduledExecution(
    _instanceName: *const c_char,
    _instantiationToken: *const c_char,
    _resourcePath: *const c_char,
    _visible: bool,
    _loggingOn: bool,
    instanceEnvironment: *mut c_void,
    logMessage: LogMessage,
    _clockUpdate: *const c_void,
    _lockPreemption: *const c_void,
    _unlockPreemption: *const c_void,
) -> *mut c_void {
    no_instance("fmi3InstantiateScheduledExecution", instanceEnvironment, logMessage)
}
