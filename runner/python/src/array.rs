//! Checks of NumPy arrays. Each error message contains the array found and the array expected.

use crate::error::wrong_argument;
use numpy::{
    Element, PyArray, PyArrayMethods, PyReadonlyArray, PyReadwriteArray, PyUntypedArray, PyUntypedArrayMethods,
};
use numpy::{dtype, ndarray};
use pyo3::prelude::*;

/// Returns `given` as an array of type `T` and dimension `D`, stored in rows (C order).
///
/// # Errors
/// `InputError` for any other object; the message contains its type and shape.
pub fn checked<'py, T: Element, D: ndarray::Dimension>(
    name: &str,
    given: &Bound<'py, PyAny>,
    shape: &str,
) -> PyResult<Bound<'py, PyArray<T, D>>> {
    let py = given.py();
    let fail = |found: String| {
        let scalar = dtype::<T>(py);
        wrong_argument(py, &format!("{name}: {found}, expected an array {shape} of {scalar}, stored in rows (C order)"))
    };
    unmasked(name, given)?;
    let Ok(array) = given.cast::<PyUntypedArray>() else {
        return Err(fail(format!("not an array: {}", given.get_type().name()?)));
    };
    let found = || format!("of shape {:?} and type {}", array.shape(), array.dtype());
    if !array.is_c_contiguous() {
        return Err(fail(format!("an array {}, not contiguous (see numpy.ascontiguousarray)", found())));
    }
    given.cast::<PyArray<T, D>>().cloned().map_err(|_| fail(format!("an array {}", found())))
}

/// Checks that no element of a NumPy masked array is masked: behind its mask there is a number that means nothing.
///
/// # Errors
/// `InputError` for a masked element.
pub fn unmasked(name: &str, given: &Bound<'_, PyAny>) -> PyResult<()> {
    // A masked array is a subclass.
    if given.is_exact_instance_of::<PyUntypedArray>() {
        return Ok(());
    }
    let py = given.py();
    let masked = py.import("numpy")?.getattr("ma")?;
    if !given.is_instance(&masked.getattr("MaskedArray")?)? {
        return Ok(());
    }
    let count: usize = masked.getattr("count_masked")?.call1((given,))?.extract()?;
    if count == 0 {
        return Ok(());
    }
    let message =
        format!("{name}: {count} masked elements, expected an array without a masked element (see numpy.ma.filled)");
    Err(wrong_argument(py, &message))
}

/// Borrows an array for reading.
///
/// # Errors
/// `InputError` for an array that is being written.
pub fn read<'py, T: Element, D: ndarray::Dimension>(
    name: &str,
    array: &Bound<'py, PyArray<T, D>>,
) -> PyResult<PyReadonlyArray<'py, T, D>> {
    let busy = |_| wrong_argument(array.py(), &format!("{name}: this array is also written, expected another one"));
    array.try_readonly().map_err(busy)
}

/// Borrows an array for writing.
///
/// # Errors
/// `InputError` for an array that is read-only or in use.
pub fn write<'py, T: Element, D: ndarray::Dimension>(
    name: &str,
    array: &Bound<'py, PyArray<T, D>>,
) -> PyResult<PyReadwriteArray<'py, T, D>> {
    let busy =
        |_| wrong_argument(array.py(), &format!("{name}: this array is read-only or in use, expected a writeable one"));
    array.try_readwrite().map_err(busy)
}
