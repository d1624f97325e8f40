"""Displacements from arrays, lists, frames and tables of any kind, and forces as the same kind; the extension module calls it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from ._errors import InputError
from ._recording import _access, _numbers

#: Columns of displacements with their units, and of forces.
_UNITS = {"u": "m", "v": "m", "w": "m", "thu": "rad", "thv": "rad"}
_FORCES = ("FX", "FY", "FZ", "MX", "MY")

_EXPECTED = "u, v, w (m), thu, thv (rad): an array or a list of shape (n, 5) or (5,), a frame or a table with these columns"


def displacements(given: Any) -> tuple[npt.NDArray[np.float64], bool, bool]:
    """Return an array stored in rows, whether ``given`` has named columns, and whether it is in single precision."""
    if _has_columns(given):
        names, column = _access(given)
        missing = [name for name in _UNITS if name not in names]
        if missing:
            raise InputError(f"u: no column {', '.join(missing)}, expected {_EXPECTED}")
        columns = [_numbers(name, np.atleast_1d(_magnitude(column(name), unit))) for name, unit in _UNITS.items()]
        lengths = {len(values) for values in columns}
        if len(lengths) > 1:
            raise InputError(f"u: columns of {sorted(lengths)} values, expected the same number")
        return np.ascontiguousarray(np.stack(columns, axis=1)), True, False
    if hasattr(given, "magnitude"):
        raise InputError("u: one quantity for lengths and angles, expected a dictionary with a quantity for each of u, v, w, thu, thv")
    return _array("u", given, _EXPECTED), False, getattr(given, "dtype", None) == np.float32


def numbers(name: str, given: Any) -> npt.NDArray[np.float64]:
    """Return one number for each displacement as a contiguous array."""
    return _array(name, _magnitude(given, "rad" if name == "cage_angle" else "s"), "one finite number or an array of them")


def forces(of: npt.NDArray[np.float64], given: Any) -> Any:
    """Return forces as the kind of table that the displacements are."""
    columns = {name: np.ascontiguousarray(of[:, i]) for i, name in enumerate(_FORCES)}
    kind = type(given).__module__.partition(".")[0]
    if kind == "pandas":
        import pandas

        return pandas.DataFrame(columns, index=given.index)
    if kind == "polars":
        import polars

        return polars.DataFrame(columns)
    if kind == "pyarrow":
        import pyarrow

        return pyarrow.table(columns)
    if isinstance(given, np.ndarray):
        structured = np.empty(len(of), dtype=[(name, np.float64) for name in _FORCES])
        for name, values in columns.items():
            structured[name] = values
        return structured
    return columns


def _has_columns(given: Any) -> bool:
    if isinstance(given, np.ndarray):
        return given.dtype.names is not None
    return isinstance(given, Mapping) or hasattr(given, "columns") or hasattr(given, "__arrow_c_stream__")


def _magnitude(values: Any, unit: str) -> Any:
    """Return the values of a quantity of pint in a unit; other values as they are."""
    return values.to(unit).magnitude if hasattr(values, "magnitude") and hasattr(values, "to") else values


def _array(name: str, given: Any, expected: str) -> npt.NDArray[np.float64]:
    try:
        array = given.to_numpy() if hasattr(given, "to_numpy") else np.asarray(given)
    except ValueError as error:
        raise InputError(f"{name}: rows of different lengths, expected {expected}") from error
    if array.dtype.kind not in "fiu":
        raise InputError(f"{name}: values of type {array.dtype}, expected {expected}")
    return np.ascontiguousarray(array, dtype=np.float64)
