//! Values of variables.

use crate::ValueReference;
use crate::instance::{Instance, Mode, call, message};
use crate::pointer::{places, values};
use ballrace_studies::fmu::Variable;
use std::ffi::{c_int, c_void};

/// Type of the values of a call.
struct Kind {
    /// Name in the standard.
    name: &'static str,
    /// True where a variable has this type.
    has: fn(&Variable) -> bool,
}

const FLOAT64: Kind = Kind { name: "Float64", has: |variable| !variable.is_whole };
const INT32: Kind = Kind { name: "Int32", has: |variable| variable.is_whole };

impl Kind {
    /// Checks that a call has a value for each variable, and that the variables are of this type.
    fn check(&self, instance: &Instance, references: &[ValueReference], count: usize) -> Result<(), String> {
        if references.len() != count {
            return Err(format!("nValues: {count}, expected {} as nValueReferences", references.len()));
        }
        for &reference in references {
            let variable = instance.unit.variable(reference).map_err(|error| error.to_string())?;
            if !(self.has)(variable) {
                return Err(format!("{}: another type, expected a variable of {}", variable.name, self.name));
            }
        }
        Ok(())
    }

    /// Reads variables into the places of the host.
    unsafe fn get<T>(
        &self,
        instance: &mut Instance,
        (references, count): (*const ValueReference, usize),
        (into, places_count): (*mut T, usize),
        convert: impl Fn(f64) -> T,
    ) -> Result<(), String> {
        // SAFETY: the caller's.
        let (references, into) =
            unsafe { (values("valueReferences", references, count)?, places("values", into, places_count)?) };
        self.check(instance, references, into.len())?;
        for (&reference, place) in references.iter().zip(into) {
            *place = convert(instance.unit.get(reference).map_err(|error| message(&error))?);
        }
        Ok(())
    }
}

/// Reads variables of type Float64.
///
/// # Safety
/// As in the [crate](crate#safety); the arrays are null or have the stated lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFloat64(
    instance: *mut c_void,
    valueReferences: *const ValueReference,
    nValueReferences: usize,
    values: *mut f64,
    nValues: usize,
) -> c_int {
    // SAFETY: the caller's.
    unsafe {
        call(instance, "fmi3GetFloat64", &Mode::ALL, |instance| {
            FLOAT64.get(instance, (valueReferences, nValueReferences), (values, nValues), |x| x)
        })
    }
}

/// Reads variables of type Int32: the status.
///
/// # Safety
/// As [`fmi3GetFloat64`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetInt32(
    instance: *mut c_void,
    valueReferences: *const ValueReference,
    nValueReferences: usize,
    values: *mut i32,
    nValues: usize,
) -> c_int {
    // SAFETY: the caller's.
    unsafe {
        call(instance, "fmi3GetInt32", &Mode::ALL, |instance| {
            INT32.get(instance, (valueReferences, nValueReferences), (values, nValues), |x| x as i32)
        })
    }
}

/// Sets inputs; all of them or, after an error, none.
///
/// # Safety
/// As [`fmi3GetFloat64`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFloat64(
    instance: *mut c_void,
    valueReferences: *const ValueReference,
    nValueReferences: usize,
    values: *const f64,
    nValues: usize,
) -> c_int {
    let set = |instance: &mut Instance| {
        // SAFETY: the arrays of the host have the stated lengths or are null.
        let (references, values) = unsafe {
            (
                crate::pointer::values("valueReferences", valueReferences, nValueReferences)?,
                crate::pointer::values("values", values, nValues)?,
            )
        };
        FLOAT64.check(instance, references, values.len())?;
        for &reference in references {
            instance.unit.input(reference).map_err(|error| error.to_string())?;
        }
        references
            .iter()
            .zip(values)
            .try_for_each(|(&reference, &value)| instance.unit.set(reference, value))
            .map_err(|error| error.to_string())
    };
    // SAFETY: the caller's.
    unsafe { call(instance, "fmi3SetFloat64", &[Mode::Instantiated, Mode::Initialization, Mode::Step], set) }
}
