//! Calls of a host: those of a simulation, and hostile ones.

use crate::exchange::{fmi3GetFloat64, fmi3GetInt32, fmi3SetFloat64};
use crate::instance::Status;
use crate::not_provided::{fmi3EnterEventMode, fmi3GetFloat32, fmi3InstantiateModelExchange};
use crate::state::{fmi3FreeFMUState, fmi3GetFMUState, fmi3SetFMUState};
use crate::*;
use ballrace_scene::read::read_str;
use ballrace_studies::fmu::{Content, Resources, Unit};
use std::ffi::{CStr, CString};
use std::fs;
use std::path::Path;
use std::ptr::{null, null_mut};
use std::sync::Mutex;
use tempfile::TempDir;

const SCENE: &str = r#"
    [shaft]
    speed = "3000 rpm"
    [rotor]
    mass = "6 kg"
    diametral_inertia = 0.030
    polar_inertia = 0.006
    damping = [400, 400, 400, 0.4, 0.4]
    unbalance = [{ moment = "120 g mm", angle = "17 deg", station = "20 mm" }]
    [[bearing]]
    name = "DE"
    station = "-100 mm"
    model = "lumped"
    elements = 9
    stiffness = 1e10
    radial_play = "5 um"
    cage_ratio = 0.4
    axial = { stiffness = 1e9, exponent = 1.5, play = "0 um", radius = "20 mm" }
    [[bearing]]
    name = "NDE"
    station = "100 mm"
    model = "lumped"
    elements = 9
    stiffness = 1e10
    radial_play = "5 um"
    cage_ratio = 0.4
    axial = { stiffness = 1e9, exponent = 1.5, play = "0 um", radius = "20 mm" }
"#;
const OK: c_int = Status::Ok as c_int;
const ERROR: c_int = Status::Error as c_int;
/// Samples per second of the rotor: a step without rounding.
const RATE: f64 = 8192.0;
const ROTOR: Content = Content::Rotor { rate: RATE };

/// Messages of the units of a test, which is the environment of its host.
type Messages = Mutex<Vec<String>>;

unsafe extern "C" fn log(environment: *mut c_void, status: c_int, category: *const c_char, message: *const c_char) {
    // SAFETY: the environment is the list of the test, the texts are those of the library.
    let (messages, texts) = unsafe {
        (environment.cast::<Messages>().as_ref().unwrap(), [category, message].map(|text| CStr::from_ptr(text)))
    };
    let [category, message] = texts.map(|text| text.to_str().unwrap());
    assert_eq!((status, category), (ERROR, "logStatusError"));
    messages.lock().unwrap().push(message.to_owned());
}

/// A unit on disk, and the messages of its instances.
struct Host {
    folder: TempDir,
    token: String,
    messages: Box<Messages>,
}

impl Host {
    fn new(text: &str, content: &Content) -> Self {
        let scene = read_str(text, Path::new("scene.toml")).unwrap();
        let (folder, resources) = (TempDir::new().unwrap(), Resources::of(&scene, text, content).unwrap());
        for (name, bytes) in &resources.files {
            fs::write(folder.path().join(name), bytes).unwrap();
        }
        Self { folder, token: resources.token, messages: Box::default() }
    }

    fn rotor() -> Self {
        Self::new(SCENE, &ROTOR)
    }

    fn bearing() -> Self {
        Self::new(SCENE, &Content::Bearing { name: "DE".to_owned() })
    }

    fn instance_with(&self, token: &str, folder: &Path, event_mode: bool) -> *mut c_void {
        let [name, token, folder] =
            ["one", token, folder.to_str().unwrap()].map(|text| CString::new(text.to_owned()).unwrap());
        let environment = std::ptr::from_ref(&*self.messages).cast_mut().cast();
        let texts = [name.as_ptr(), token.as_ptr(), folder.as_ptr()];
        // SAFETY: texts and messages outlive the call, the messages the instance.
        unsafe {
            fmi3InstantiateCoSimulation(
                texts[0],
                texts[1],
                texts[2],
                false,
                false,
                event_mode,
                false,
                null(),
                0,
                environment,
                Some(log),
                null(),
            )
        }
    }

    fn instance(&self) -> *mut c_void {
        let instance = self.instance_with(&self.token, self.folder.path(), false);
        assert!(!instance.is_null(), "{:?}", self.messages);
        instance
    }

    fn started(&self) -> *mut c_void {
        let instance = self.instance();
        // SAFETY: an instance.
        unsafe {
            assert_eq!(fmi3EnterInitializationMode(instance, false, 0.0, 0.0, false, 0.0), OK);
            assert_eq!(fmi3ExitInitializationMode(instance), OK);
        }
        instance
    }

    /// Returns the only message since the last call.
    fn message(&self) -> String {
        let messages = std::mem::take(&mut *self.messages.lock().unwrap());
        let [message] = messages.as_slice() else { unreachable!("{messages:?}") };
        message.clone()
    }
}

fn get<const N: usize>(instance: *mut c_void, references: [u32; N]) -> Result<[f64; N], c_int> {
    let mut values = [0.0; N];
    // SAFETY: an instance, and arrays of this length.
    match unsafe { fmi3GetFloat64(instance, references.as_ptr(), N, values.as_mut_ptr(), N) } {
        OK => Ok(values),
        status => Err(status),
    }
}

fn set<const N: usize>(instance: *mut c_void, references: [u32; N], values: [f64; N]) -> c_int {
    // SAFETY: an instance, and arrays of this length.
    unsafe { fmi3SetFloat64(instance, references.as_ptr(), N, values.as_ptr(), N) }
}

fn step(instance: *mut c_void, point: f64, length: f64) -> c_int {
    // SAFETY: an instance; no place for results is one.
    unsafe { fmi3DoStep(instance, point, length, true, null_mut(), null_mut(), null_mut(), null_mut()) }
}

fn free(instance: *mut c_void) {
    // SAFETY: an instance of this test.
    unsafe { fmi3FreeInstance(instance) }
}

/// Displacement and rate of the centre of mass, value references of the rotor after time and five forces.
const MOTION: [u32; 10] = [6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

#[test]
fn a_bearing_is_evaluated_without_a_step() {
    let host = Host::bearing();
    let instance = host.started();
    assert_eq!(get(instance, [8, 9]).unwrap(), [0.0; 2]);
    assert_eq!(set(instance, [1, 2], [2e-5, -3e-5]), OK);
    let [fx, fy] = get(instance, [8, 9]).unwrap();
    assert!(fx < 0.0 && fy > 0.0, "{fx} {fy}");
    let mut status = [-1];
    // SAFETY: an instance, and arrays of one value.
    unsafe { assert_eq!(fmi3GetInt32(instance, [13].as_ptr(), 1, status.as_mut_ptr(), 1), OK) };
    assert_eq!(status, [0]);
    // A displacement that is no number repeats the last force and says so.
    assert_eq!(set(instance, [1], [f64::NAN]), OK);
    assert_eq!(get(instance, [8, 9]).unwrap(), [fx, fy]);
    // SAFETY: as above.
    unsafe { assert_eq!(fmi3GetInt32(instance, [13].as_ptr(), 1, status.as_mut_ptr(), 1), OK) };
    assert_eq!(status, [1]);
    assert_eq!(step(instance, 0.0, 0.123), OK);
    assert_eq!(get(instance, [0]).unwrap(), [0.123]);
    free(instance);
}

#[test]
fn a_rotor_is_saved_restored_reset_and_loaded() {
    let host = Host::rotor();
    let (instance, other) = (host.started(), host.started());
    let period = 1.0 / RATE;
    let run = |instance, from: u32, to: u32| {
        (from..to).for_each(|i| assert_eq!(step(instance, f64::from(i) * period, period), OK));
        get(instance, MOTION).unwrap()
    };
    let rest = get(instance, MOTION).unwrap();
    run(instance, 0, 100);
    let mut state = null_mut();
    // SAFETY: an instance, and a place for a state.
    unsafe { assert_eq!(fmi3GetFMUState(instance, &mut state), OK) };
    let first = run(instance, 100, 200);
    // Another instance takes the state; one long step is as many short ones.
    // SAFETY: instances, and a state of one of them.
    unsafe {
        assert_eq!(fmi3SetFMUState(other, state), OK);
        assert_eq!(step(other, 100.0 * period, 100.0 * period), OK);
        assert_eq!(get(other, MOTION).unwrap(), first);
        assert_eq!(fmi3FreeFMUState(other, &mut state), OK);
        assert!(state.is_null());
        assert_eq!(fmi3FreeFMUState(other, &mut state), OK);
        assert_eq!(fmi3Reset(instance), OK);
        assert_eq!(fmi3EnterInitializationMode(instance, false, 0.0, 0.0, false, 0.0), OK);
        assert_eq!(fmi3ExitInitializationMode(instance), OK);
    }
    assert_eq!(get(instance, MOTION).unwrap(), rest);
    assert_eq!(run(instance, 0, 200), first);
    // SAFETY: an instance.
    unsafe { assert_eq!(fmi3Reset(other), OK) };
    assert_eq!(set(other, [1], [500.0]), OK);
    // SAFETY: an instance.
    unsafe {
        assert_eq!(fmi3EnterInitializationMode(other, false, 0.0, 10.0, true, 20.0), OK);
        assert_eq!(fmi3ExitInitializationMode(other), OK);
    }
    assert_eq!(step(other, 10.0, 200.0 * period), OK);
    let loaded = get(other, MOTION).unwrap();
    assert!(loaded[0] > first[0] + 1e-6, "{loaded:?} {first:?}");
    free(instance);
    free(other);
    assert!(host.messages.lock().unwrap().is_empty());
}

#[test]
fn an_external_force_is_a_load_of_the_scene() {
    // Balanced, the rotor has one motion under a load, which it approaches from the equilibrium without the load.
    // The step is given, since that of the scene depends on the load.
    let balanced = SCENE.replace("120 g mm", "0 g mm") + "[integration]\nstep = \"20 us\"\n";
    let host = Host::new(&balanced, &ROTOR);
    let instance = host.started();
    assert_eq!(set(instance, [1, 2, 3, 5], [120.0, -400.0, 60.0, 1.5]), OK);
    assert_eq!(step(instance, 0.0, 5.0), OK);
    let text = balanced.replace("damping", "load = [120, -400, 60, 0, 1.5]\ndamping");
    let scene = read_str(&text, Path::new("scene.toml")).unwrap();
    let mut unit = Unit::try_new(&scene, &ROTOR).unwrap();
    unit.step(0.0, 5.0).unwrap();
    let expected = MOTION.map(|reference| unit.get(reference).unwrap());
    for (found, expected) in get(instance, MOTION).unwrap().into_iter().zip(expected) {
        assert!((found - expected).abs() < 1e-9 * expected.abs().max(1e-3), "{found} {expected}");
    }
    free(instance);
}

#[test]
fn refused_steps_say_why() {
    let host = Host::rotor();
    let period = 1.0 / RATE;
    for (point, length, words) in [
        (0.0, 1.5 * period, "multiple of the internal step of 0.0001220703125 s, such as 0.000244140625 s"),
        (0.0, 0.0, "above 0 s"),
        (0.0, -period, "above 0 s"),
        (0.0, f64::NAN, "above 0 s"),
        (0.0, f64::INFINITY, "above 0 s"),
        (period, period, "expected 0 s, the end of the last step"),
        (f64::NAN, period, "expected 0 s"),
        (f64::INFINITY, period, "expected 0 s"),
    ] {
        let instance = host.started();
        assert_eq!(step(instance, point, length), ERROR, "{point} {length}");
        let message = host.message();
        assert!(message.starts_with("fmi3DoStep: ") && message.contains(words), "{message}");
        // After an error values can be read, and a reset begins another simulation.
        assert!(get(instance, [0]).is_ok());
        assert_eq!(step(instance, 0.0, period), ERROR);
        assert!(host.message().contains("Terminated, expected Step"));
        // SAFETY: an instance.
        unsafe { assert_eq!(fmi3Reset(instance), OK) };
        free(instance);
    }
    let instance = host.instance();
    // SAFETY: an instance.
    unsafe {
        assert_eq!(fmi3EnterInitializationMode(instance, false, 0.0, 0.0, true, period), OK);
        assert_eq!(fmi3ExitInitializationMode(instance), OK);
    }
    assert_eq!(step(instance, 0.0, 2.0 * period), ERROR);
    assert!(host.message().contains("stop time of 0.0001220703125 s"));
    free(instance);
}

#[test]
fn hostile_calls_are_errors() {
    let host = Host::bearing();
    let null_instance = null_mut();
    // SAFETY: null is no instance.
    unsafe {
        assert_eq!(fmi3Reset(null_instance), ERROR);
        fmi3FreeInstance(null_instance);
    }
    assert_eq!(get(null_instance, [0]), Err(ERROR));
    let refused = |expected: &str, call: &dyn Fn(*mut c_void) -> c_int| {
        let instance = host.started();
        assert_eq!(call(instance), ERROR, "{expected}");
        let message = host.message();
        assert!(message.contains(expected), "{message}: expected {expected}");
        free(instance);
    };
    let place = &mut [0.0];
    let place: *mut f64 = place.as_mut_ptr();
    // SAFETY: every call has an instance, and arrays of the stated lengths or null.
    unsafe {
        refused("valueReferences: null", &|i| fmi3GetFloat64(i, null(), 1, place, 1));
        refused("values: null", &|i| fmi3GetFloat64(i, [0].as_ptr(), 1, null_mut(), 1));
        refused("nValues: 1, expected 2", &|i| fmi3GetFloat64(i, [0, 1].as_ptr(), 2, place, 1));
        refused("value reference 14: no such variable, expected 0 to 13", &|i| {
            fmi3GetFloat64(i, [14].as_ptr(), 1, place, 1)
        });
        refused("value reference 4294967295", &|i| fmi3GetFloat64(i, [u32::MAX].as_ptr(), 1, place, 1));
        refused("no place of 9223372036854775807 values", &|i| {
            fmi3GetFloat64(i, [0].as_ptr(), 1, place, isize::MAX as usize)
        });
        refused("status: another type, expected a variable of Float64", &|i| {
            fmi3GetFloat64(i, [13].as_ptr(), 1, place, 1)
        });
        refused("FX: another type, expected a variable of Int32", &|i| {
            fmi3GetInt32(i, [8].as_ptr(), 1, [0].as_mut_ptr(), 1)
        });
        refused("FX: this variable is no input", &|i| set(i, [1, 8], [1e-5, 1.0]));
        refused("time: this variable is no input", &|i| set(i, [0], [1.0]));
        refused("does not provide", &|i| fmi3GetFloat32(i, null(), 0, null_mut(), 0));
        refused("does not provide", &|i| fmi3EnterEventMode(i));
        refused("FMUState: null", &|i| fmi3GetFMUState(i, null_mut()));
        refused("FMUState: null", &|i| fmi3SetFMUState(i, null_mut()));
        refused("called in the state Step", &|i| fmi3ExitInitializationMode(i));
        let instance = host.instance();
        assert_eq!(fmi3FreeFMUState(instance, null_mut()), OK);
        assert_eq!(fmi3GetFloat64(instance, null(), 0, null_mut(), 0), OK);
        assert_eq!(step(instance, 0.0, 1.0), ERROR);
        assert!(host.message().contains("called in the state Instantiated, expected Step"));
        free(instance);
        let instance = host.instance();
        assert_eq!(fmi3EnterInitializationMode(instance, false, 0.0, f64::NAN, false, 0.0), ERROR);
        assert!(host.message().contains("startTime"));
        free(instance);
    }
}

#[test]
fn what_is_no_unit_gives_no_instance() {
    let host = Host::bearing();
    let refused = |token: &str, folder: &Path, events: bool, expected: &str| {
        assert!(host.instance_with(token, folder, events).is_null());
        let message = host.message();
        assert!(message.starts_with("fmi3InstantiateCoSimulation: ") && message.contains(expected), "{message}");
    };
    let folder = host.folder.path();
    refused("another", folder, false, "instantiationToken: \"another\", expected");
    refused(&host.token, &folder.join("none"), false, "no file of this name");
    refused(&host.token, folder, true, "hasEventMode");
    fs::write(folder.join("unit.toml"), "rate = 0").unwrap();
    refused(&host.token, folder, false, "instantiationToken");
    fs::write(folder.join("scene.toml"), "[shaft]").unwrap();
    refused(&host.token, folder, false, "speed");
    // SAFETY: null texts, and no logger.
    unsafe {
        let none = fmi3InstantiateCoSimulation(
            null(),
            null(),
            null(),
            false,
            false,
            false,
            false,
            null(),
            0,
            null_mut(),
            None,
            null(),
        );
        assert!(none.is_null());
    }
    assert!(fmi3InstantiateModelExchange(null(), null(), null(), false, false, null_mut(), None).is_null());
    // SAFETY: a static text.
    assert_eq!(unsafe { CStr::from_ptr(fmi3GetVersion()) }, c"3.0");
}

#[test]
fn instances_run_in_threads_beside_each_other() {
    let host = Host::rotor();
    let motion = || {
        let instance = host.started();
        assert_eq!(step(instance, 0.0, 500.0 / RATE), OK);
        let motion = get(instance, MOTION).unwrap();
        free(instance);
        motion
    };
    let expected = motion();
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4).map(|_| scope.spawn(motion)).collect();
        threads.into_iter().for_each(|thread| assert_eq!(thread.join().unwrap(), expected));
    });
}
