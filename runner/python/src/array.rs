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
    let Ok(array) = given.cast::<PyUntypedArray>() else {
        return Err(fail(format!("not an array: {}", given.get_type().name()?)));
    };
    let found = || format!("of shape {:?} and type {}", array.shape(), array.dtype());
    if !array.is_c_contiguous() {
        return Err(fail(format!("an array {}, not contiguous (see numpy.ascontiguousarray)", found())));
    }
    given.cast::<PyArray<T, D>>().cloned().map_err(|_| fail(format!("an array {}", found())))
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
