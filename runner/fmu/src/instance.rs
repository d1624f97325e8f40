//! One instance of a unit, and calls of its host.

use ballrace_base::caught::caught;
use ballrace_plant::error::{Error, with_causes};
use ballrace_studies::fmu::Unit;
use std::ffi::{CString, c_char, c_int, c_void};
use std::path::Path;

/// Result of a call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub enum Status {
    /// Done.
    Ok = 0,
    /// Not done; the instance can be read and reset.
    Error = 3,
    /// A panic: the instance cannot be used any more.
    Fatal = 4,
}

/// Function of the host that takes messages: environment, status, category, text.
pub type LogMessage = Option<unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char)>;

/// The host of an instance.
#[derive(Clone, Copy)]
pub struct Host {
    /// Its own pointer.
    pub environment: *mut c_void,
    /// Its logger.
    pub log: LogMessage,
}

impl Host {
    /// Runs `work` of the function `name`; passes an error or a panic to the logger.
    pub fn outcome<T>(self, name: &str, work: impl FnOnce() -> Result<T, String>) -> Result<T, Status> {
        let (status, category, text) = match caught(work) {
            Ok(Ok(done)) => return Ok(done),
            Ok(Err(error)) => (Status::Error, c"logStatusError", error),
            Err(panic) => (Status::Fatal, c"logStatusFatal", format!("internal error: {panic}")),
        };
        let text = format!("{name}: {text}").replace('\0', " ");
        if let (Some(log), Ok(text)) = (self.log, CString::new(text)) {
            // SAFETY: the host gave function and environment for this call; both texts live until it returns.
            unsafe { log(self.environment, status as c_int, category.as_ptr(), text.as_ptr()) };
        }
        Err(status)
    }
}

/// State of an instance as the standard names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Created or reset.
    Instantiated,
    /// Between `fmi3EnterInitializationMode` and `fmi3ExitInitializationMode`.
    Initialization,
    /// Between steps.
    Step,
    /// After `fmi3Terminate` or an error.
    Terminated,
    /// After a panic.
    Failed,
}

impl Mode {
    /// All in which an instance can be used.
    pub const ALL: [Self; 4] = [Self::Instantiated, Self::Initialization, Self::Step, Self::Terminated];
}

/// One instance.
pub struct Instance {
    /// The machine with its variables.
    pub unit: Unit,
    /// State.
    pub mode: Mode,
    /// The host.
    pub host: Host,
}

impl Instance {
    /// Opens the unit with its resources in `folder`.
    pub fn open(folder: &str, token: &str, host: Host) -> Result<Self, String> {
        let unit = Unit::open(Path::new(folder), token).map_err(|error| message(&error))?;
        Ok(Self { unit, mode: Mode::Instantiated, host })
    }
}

/// Returns the text of an error with its causes.
pub fn message(error: &Error) -> String {
    with_causes(error)
}

/// Runs `work` of the function `name` on an instance in one of `modes`.
///
/// # Safety
/// `instance` is null or was returned by `fmi3InstantiateCoSimulation`, was not freed, and is in no other call.
pub unsafe fn call(
    instance: *mut c_void,
    name: &str,
    modes: &[Mode],
    work: impl FnOnce(&mut Instance) -> Result<(), String>,
) -> c_int {
    // SAFETY: the caller's.
    let Some(instance) = (unsafe { instance.cast::<Instance>().as_mut() }) else { return Status::Error as c_int };
    let host = instance.host;
    let result = host.outcome(name, || {
        if modes.contains(&instance.mode) {
            work(instance)
        } else {
            let expected: Vec<String> = modes.iter().map(|mode| format!("{mode:?}")).collect();
            Err(format!("called in the state {:?}, expected {}", instance.mode, expected.join(" or ")))
        }
    });
    match result {
        Ok(()) => Status::Ok as c_int,
        Err(status) => {
            // An error ends the simulation, as the standard demands; a reset begins another one.
            instance.mode = if status == Status::Fatal { Mode::Failed } else { Mode::Terminated };
            status as c_int
        }
    }
}
