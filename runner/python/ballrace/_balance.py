"""Balancing from a table of vectors, and the arguments that it shares with that of recordings."""

from __future__ import annotations

import csv
import io
import json
import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from . import _native
from ._errors import InputError
from ._recording import RecordingLike, _access
from ._results import Balance
from .typing import ByPlane, Holes, Quantity, Stock
from .typing import Path as Path_


def balance(
    vectors: RecordingLike,
    *,
    times: Path_ | None = None,
    holes: Holes | None = None,
    radius: ByPlane | None = None,
    stock: Stock = (),
    weights: int = 2,
    hole_limit: ByPlane | None = None,
    taken: Sequence[str] = (),
    remove: bool = False,
    replace: bool = False,
    grade: float | None = None,
    mass: Quantity | None = None,
    service_speed: Quantity | None = None,
) -> Balance:
    """Balance a rotor from a table of once-per-turn vectors, without a scene.

    Parameters
    ----------
    vectors : path, or table
        CSV file, data frame, Arrow table or dictionary of columns: ``id``, ``set`` (``baseline``, ``trial``, ``trim`` or ``blind``),
        ``speed_rpm``, ``PLANE_g_mm`` and ``PLANE_deg`` of each plane, ``PROBE_re_UNIT`` and ``PROBE_im_UNIT`` of each probe, and
        ``time_s`` where there are times.
    times : path, optional
        Table of ``condition, speed, unix_time_of_one_record``.
    holes, radius : int or str, and float or str, or mappings of planes, optional
        Holes, evenly spread, and the radius of their circle, in m or with a unit: ``16`` for all planes, or
        ``{"fan": 12, "coupling": "8 from 22.5 deg"}`` where planes differ or the first hole is not at 0.
    stock : sequence of float or str, or mapping of planes, optional
        Weights, one for a hole, in kg or with a unit: ``"2 g"``, or ``"3 x 2 g"`` where there are three. Any mass where it is empty.
    weights : int, optional
        Most weights of the stock in a plane, at most 4.
    hole_limit : float or str, or mapping of planes, optional
        Largest mass of a hole.
    taken : sequence of str, optional
        Holes that take no mass: ``"fan 3"``.
    remove : bool, optional
        Remove masses, as by drilling.
    replace : bool, optional
        Take off the masses of the last trim run; the correction is then instead of them.
    grade, mass, service_speed : optional
        Balance quality grade of ISO 21940-11 that is asked for, the mass of the rotor, and its service speed.

    Returns
    -------
    Balance
        ``correction``, ``influence``, ``conditions`` (masses of blind conditions), ``trim``, ``proof``, ``quality``; the table has a row
        for each correction plane, that of ``masses()`` a row for each blind condition and plane.

    Examples
    --------
    >>> import ballrace
    >>> found = ballrace.balance(
    ...     {
    ...         "id": ["before_N1_1", "trial_N1_1"],
    ...         "set": ["baseline", "trial"],
    ...         "speed_rpm": [3000, 3000],
    ...         "fan_g_mm": [0, 60],
    ...         "fan_deg": [0, 90],
    ...         "DE_re_um": [12.0, 12.0],
    ...         "DE_im_um": [5.0, 7.0],
    ...     },
    ...     holes=12,
    ...     radius="100 mm",
    ... )
    >>> plane = found.correction.planes[0]
    >>> round(plane.moment_g_mm, 3), round(plane.angle_deg, 1)
    (390.0, 202.6)
    >>> [(mass.hole, round(mass.mass_g, 2)) for mass in plane.holes]
    [(7, 1.0), (8, 3.0)]
    """
    path: str
    if isinstance(vectors, (str, os.PathLike)):
        path, text = os.fspath(vectors), None
    else:
        path, text = "vectors", _as_csv(vectors)
    options = options_of(
        holes=holes,
        radius=radius,
        stock=stock,
        weights=weights,
        hole_limit=hole_limit,
        taken=taken,
        remove=remove,
        replace=replace,
        grade=grade,
        mass=mass,
        service_speed=service_speed,
    )
    found, page = _native.balance(path, text, None if times is None else os.fspath(times), options)
    return Balance(json.loads(found), page)


def options_of(
    *,
    holes: Holes | None,
    radius: ByPlane | None,
    hole_limit: ByPlane | None,
    stock: Stock,
    taken: Sequence[str],
    **others: Any,
) -> dict[str, Any]:
    """Return the options of a correction as the extension module takes them."""
    if any(isinstance(text, str) for text in (stock, taken)):
        raise InputError("stock, taken: a text, expected a list of weights and of holes")
    of_planes = stock if isinstance(stock, Mapping) else {"": stock}
    return {
        **others,
        "holes": _entries(holes, str),
        "radius": _entries(radius, lambda length: _text(length, "m")),
        "hole_limit": _entries(hole_limit, lambda mass: _text(mass, "kg")),
        "stock": [f"{plane} {_text(mass, 'kg')}" for plane, masses in of_planes.items() for mass in masses],
        "taken": list(taken),
    }


def _entries(value: Any, text: Callable[[Any], str]) -> list[str]:
    """Return an option as entries, each with its plane in front where planes are named."""
    if value is None:
        return []
    return [f"{plane} {text(of)}" for plane, of in value.items()] if isinstance(value, Mapping) else [text(value)]


def _text(of: Quantity, unit: str) -> str:
    return of if isinstance(of, str) else f"{float(of)!r} {unit}"


def _as_csv(table: Any) -> str:
    """Return a table as CSV; a missing value is an empty cell."""
    names, column = _access(table)
    columns = [_values(column(name)) for name in names]
    lengths = {len(values) for values in columns}
    if len(lengths) > 1:
        raise InputError(f"vectors: columns of {sorted(lengths)} values, expected the same number")
    out = io.StringIO()
    writer = csv.writer(out)
    writer.writerow(names)
    writer.writerows([_cell(value) for value in row] for row in zip(*columns))
    return out.getvalue()


def _values(column: Any) -> list[Any]:
    return list(column.to_pylist() if hasattr(column, "to_pylist") else column)


def _cell(value: Any) -> str:
    # NaN and the missing values of pandas are not equal to themselves.
    if value is None or not bool(value == value):
        return ""
    return value if isinstance(value, str) else repr(float(value))
