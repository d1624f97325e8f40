"""Recordings in memory: named columns from dictionaries, arrays, data frames and Arrow tables."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from ._errors import InputError

#: A path, or an object with named columns.
RecordingLike = Union[str, "os.PathLike[str]", Mapping[str, Any], Any]

_EXPECTED = (
    "a path, a dictionary of arrays, a structured array, a data frame or an Arrow table"
)


def columns(recording: RecordingLike | None, needed: Iterable[str] | None) -> Any:
    """Return a recording as an argument of the extension module: a path, or pairs of name and array.

    Columns that are not needed get empty arrays.
    """
    if recording is None or isinstance(recording, (str, os.PathLike)):
        return recording
    names, column = _access(recording)
    wanted = set(needed or ())
    empty = np.empty(0)
    return [(name, _numbers(name, column(name)) if name in wanted else empty) for name in names]


def _access(recording: Any) -> tuple[list[str], Callable[[str], Any]]:
    """Return the names of the columns and a function from a name to its values."""
    if isinstance(recording, Mapping):
        return [str(name) for name in recording], recording.__getitem__
    if isinstance(recording, np.ndarray):
        if recording.dtype.names is None:
            raise InputError(f"recording: an array without named columns, expected {_EXPECTED}")
        return list(recording.dtype.names), recording.__getitem__
    if hasattr(recording, "columns") and hasattr(recording, "__getitem__"):
        if hasattr(recording, "column_names"):  # pyarrow
            return [str(name) for name in recording.column_names], recording.__getitem__
        return [str(name) for name in recording.columns], recording.__getitem__
    if hasattr(recording, "__arrow_c_stream__"):
        try:
            import pyarrow
        except ImportError as error:
            raise InputError(
                "recording: an Arrow stream, which needs the package pyarrow: pip install 'ballrace[arrow]'"
            ) from error
        table = pyarrow.table(recording)
        return [str(name) for name in table.column_names], table.__getitem__
    raise InputError(f"recording: {type(recording).__name__}, expected {_EXPECTED}")


def _numbers(name: str, values: Any) -> npt.NDArray[np.float64]:
    """Return the values of a column in double precision; a contiguous array of this type is not copied."""
    if not isinstance(values, np.ndarray):
        values = values.to_numpy() if hasattr(values, "to_numpy") else np.asarray(values)
    if values.dtype.kind not in "fiu":
        raise InputError(f"column {name}: values of type {values.dtype}, expected numbers")
    if values.ndim != 1:
        raise InputError(f"column {name}: of shape {values.shape}, expected one dimension")
    if isinstance(values, np.ma.MaskedArray):
        # A masked reading is a missing one, as an empty cell of a file.
        masked: Any = values.astype(np.float64)
        values = masked.filled(np.nan)
    return np.ascontiguousarray(values, dtype=np.float64)
