"""Results of the studies: objects with units in their names, convertible to dictionaries and tables."""

from __future__ import annotations

import base64
import html as _html
import json
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _plots
from ._errors import InputError

if TYPE_CHECKING:
    import pandas
    import plotly.graph_objects as go
    import pyarrow
    import xarray

    from . import _native

Floats = npt.NDArray[np.float64]


class Record(Mapping[str, Any]):
    """A result whose entries are attributes and keys.

    Examples
    --------
    >>> point = Record({"speed_rpm": 3000.0, "modes": [{"frequency_hz": 97.5}]})
    >>> point.modes[0].frequency_hz
    97.5
    >>> point["speed_rpm"]
    3000.0
    """

    def __init__(self, entries: Mapping[str, Any]) -> None:
        self._entries = dict(entries)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        entries = self.__dict__.get("_entries", {})
        if name not in entries:
            raise AttributeError(f"no entry {name!r}, expected one of {', '.join(entries)}")
        return _wrapped(entries[name])

    def __getitem__(self, name: str) -> Any:
        return _wrapped(self._entries[name])

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._entries]

    def __repr__(self) -> str:
        shown = []
        for name, value in self._entries.items():
            text = f"[{len(value)}]" if isinstance(value, (list, dict)) and len(value) > 6 else repr(value)
            shown.append(f"{name}={text if len(text) <= 80 else text[:77] + '...'}")
        return f"{type(self).__name__}({', '.join(shown)})"

    def to_dict(self) -> dict[str, Any]:
        """Return the entries as plain dictionaries, lists, texts and numbers."""
        return self._entries


def _wrapped(value: Any) -> Any:
    if isinstance(value, dict):
        return Record(value)
    if isinstance(value, list):
        return [_wrapped(entry) for entry in value]
    return value


class Table:
    """Base class of results that are tables: one entry per column, all of one length."""

    def columns(self) -> dict[str, Sequence[Any] | Floats]:
        """Return the columns of the table."""
        raise NotImplementedError

    def to_dict(self) -> dict[str, Any]:
        """Return the result as plain dictionaries, lists, texts and numbers."""
        raise NotImplementedError

    def to_json(self) -> str:
        """Return the result as JSON.

        Examples
        --------
        >>> import ballrace, json
        >>> diagram = ballrace.Scene.demonstration().campbell("0rpm..3000rpm:2")
        >>> len(json.loads(diagram.to_json())["speeds"])
        2
        """
        return json.dumps(self.to_dict())

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Table) and type(self) is type(other) and self.to_dict() == other.to_dict()

    def to_arrow(self) -> pyarrow.Table:
        """Return the table as a ``pyarrow.Table``; needs the package pyarrow."""
        import pyarrow

        return pyarrow.table(dict(self.columns()))

    def to_pandas(self) -> pandas.DataFrame:
        """Return the table as a ``pandas.DataFrame``; needs the package pandas."""
        import pandas

        return pandas.DataFrame(dict(self.columns()))


def _columns_of(rows: Sequence[Mapping[str, Any]]) -> dict[str, Sequence[Any] | Floats]:
    """Return the columns of rows; rows may lack entries."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    return {name: [row.get(name) for row in rows] for name in names}


class Page:
    """Base class of results with an HTML report."""

    def to_html(self) -> str:
        """Return the report as one self-contained page."""
        raise NotImplementedError

    def save_html(self, path: str | os.PathLike[str]) -> Path:
        """Write the report to a file and return its path."""
        target = Path(path)
        target.write_text(self.to_html(), encoding="utf-8")
        return target

    def _repr_html_(self) -> str:
        page = base64.b64encode(self.to_html().encode()).decode()
        source = _html.escape(f"data:text/html;charset=utf-8;base64,{page}", quote=True)
        return f'<iframe src="{source}" style="width:100%;height:720px;border:1px solid #ccc"></iframe>'


class _Kept:
    """Texts of a native result, which a copy in another process has instead of it."""

    def __init__(self, html: str, text: str, baseline: str | InputError, chosen: str | None) -> None:
        self._html, self._text, self._baseline = html, text, baseline
        self.chosen = chosen

    def html(self) -> str:
        return self._html

    def text(self) -> str:
        return self._text

    def baseline(self) -> str:
        if isinstance(self._baseline, InputError):
            raise self._baseline
        return self._baseline


def _kept_outcome(entries: Mapping[str, Any], html: str, text: str, baseline: str | None, why: str) -> Outcome:
    """Return the copy of an outcome; pickle calls it."""
    return Outcome(_Kept(html, text, InputError(why) if baseline is None else baseline, None), entries)


def _kept_trade(entries: Mapping[str, Any], html: str, chosen: str | None) -> Trade:
    """Return the copy of a trade study; pickle calls it."""
    return Trade(_Kept(html, "", "", chosen), entries)


class Outcome(Record, Table, Page):
    """Outcome of a replay: verdict, diagnoses, probes, limits.

    Attributes
    ----------
    verdict : str
        The verdict in a sentence.
    findings : list of Record
        Faults with bearing, place, size and evidence.
    probes : list of Record
        Measured and computed motion at each probe, um.
    """

    def __init__(self, native: _native.Outcome | _Kept, entries: Mapping[str, Any]) -> None:
        super().__init__(entries)
        self._native = native

    def __reduce__(self) -> tuple[Any, ...]:
        baseline, why = None, ""
        try:
            baseline = self._native.baseline()
        except InputError as error:
            why = str(error)
        return _kept_outcome, (self._entries, self.to_html(), self.to_text(), baseline, why)

    def columns(self) -> dict[str, Sequence[Any] | Floats]:
        """Return the columns of the table of probes."""
        rows = []
        for probe in self._entries.get("probes", []):
            row = {name: value for name, value in probe.items() if not isinstance(value, (dict, list))}
            for part in ("measured", "twin"):
                for name, value in (probe.get(part) or {}).items():
                    if not isinstance(value, (dict, list)):
                        row[f"{part}_{name}"] = value
            rows.append(row)
        return _columns_of(rows)

    def to_html(self) -> str:
        """Return the report as one self-contained page."""
        return self._native.html()

    def to_text(self) -> str:
        """Return the report as text, as the command line prints it."""
        return self._native.text()

    def indicators(self) -> dict[str, float]:
        """Return the figures of the machine's condition by their names, as features for learning.

        Each probe has its levels, the residual to the twin and the ball-pass lines of each bearing; each plane of probes its orbit; each
        bearing its mean force and the largest load of an element. Phases are left out: an angle is no number to learn from. A value
        that the replay lacks is NaN.

        Examples
        --------
        >>> import ballrace
        >>> outcome = ballrace.Scene.demonstration().replay(ballrace.demonstration_recording())
        >>> round(outcome.indicators()["DE_X_um.direct_um_pp"], 2)
        0.4
        """
        found: dict[str, float] = {}

        def add(place: str, values: Mapping[str, Any]) -> None:
            for name, value in values.items():
                is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
                if (is_number or value is None) and not name.endswith("_deg"):
                    found[f"{place}.{name}"] = math.nan if value is None else float(value)

        for probe in self._entries.get("probes", []):
            place = probe["name"]
            add(place, probe.get("list") or {})
            add(place, {"residual_rms_um": probe.get("residual_rms_um")})
            for line in probe.get("ball_pass") or []:
                race = "inner" if line["order"] > self._middle_order(line["bearing"]) else "outer"
                lines = {f"{race}_race_{what}_um": line.get(f"{what}_um") for what in ("measured", "residual")}
                add(f"{place}.{line['bearing']}", lines)
        for plane in self._entries.get("planes") or []:
            add(plane["name"], {name: value for name, value in plane.items() if name != "station_mm"})
        for bearing in self._entries.get("bearings", []):
            place = bearing["name"]
            add(place, {"largest_element_load_n": bearing.get("largest_element_load_n")})
            forces = bearing.get("force_estimated") or []
            for component, force in zip(("fx_n", "fy_n", "fz_n", "mx_nm", "my_nm"), forces):
                add(place, {component: (force or {}).get("mean")})
        return found

    def _middle_order(self, name: str) -> float:
        """Return half the number of elements of a bearing: the ball-pass orders of its races are to either side."""
        orders = next((b.get("orders") or {} for b in self._entries.get("bearings", []) if b["name"] == name), {})
        return 0.5 * (float(orders.get("outer_race", 0.0)) + float(orders.get("inner_race", 0.0)))

    def save_baseline(self, path: str | os.PathLike[str]) -> Path:
        """Write the baseline of a replay with ``learn=True`` and return its path."""
        if self._entries.get("implausible"):
            raise InputError("baseline: a recording that is not plausible for the scene, expected one of the machine in good order")
        target = Path(path)
        target.write_text(self._native.baseline(), encoding="utf-8")
        return target

    def plot(self) -> go.Figure:
        """Return a Plotly figure of the motion of each probe, measured and of the twin; needs the package plotly."""
        return _plots.outcome(self)


class Equilibrium(Record, Table, Page):
    """Static equilibrium; the table has a row for each rolling element."""

    def __init__(self, entries: Mapping[str, Any], page: str) -> None:
        super().__init__(_with_units(entries, _EQUILIBRIUM_UNITS))
        self._page = page

    def columns(self) -> dict[str, Sequence[Any] | Floats]:
        """Return the columns of the table of rolling elements."""
        return _columns_of(self._entries["elements"])

    def to_html(self) -> str:
        """Return the report as one self-contained page."""
        return self._page

    def plot(self) -> go.Figure:
        """Return a Plotly figure of the load of each rolling element; needs the package plotly.

        Examples
        --------
        >>> import ballrace
        >>> figure = ballrace.Scene.demonstration().equilibrium().plot()
        >>> [trace.name for trace in figure.data]
        ['DE', 'NDE']
        """
        return _plots.equilibrium(self)


#: Units of the entries of an equilibrium, which are in SI.
_EQUILIBRIUM_UNITS = {
    "speed": "rad_s",
    "displacement": "m_rad",
    "force": "n_nm",
    "stiffness": "si",
    "azimuth": "rad",
    "inner_load": "n",
    "outer_load": "n",
    "inner_angle": "rad",
    "outer_angle": "rad",
    "inner_pressure": "pa",
    "outer_pressure": "pa",
    "inner_film": "m",
    "outer_film": "m",
    "centrifugal": "n",
    "gyroscopic_moment": "nm",
    "solving_seconds": "",
    "free": "rad",
    "loaded": "rad",
}


def _with_units(value: Any, units: Mapping[str, str]) -> Any:
    """Return entries with the unit at the end of each name that has one."""
    if isinstance(value, Mapping):
        named = {}
        for name, entry in value.items():
            unit = units.get(name, "")
            # Shares of effects are ratios.
            is_share = name == "stiffness" and isinstance(entry, list) and entry and not isinstance(entry[0], list)
            full = f"{name}_{unit}" if unit and not is_share else name
            named[full] = _with_units(entry, units)
        return named
    if isinstance(value, list):
        return [_with_units(entry, units) for entry in value]
    return value


class Balance(Record, Table, Page):
    """Influence coefficients and correction of a rotor; the table has a row for each correction plane."""

    def __init__(self, entries: Mapping[str, Any], page: str) -> None:
        super().__init__(entries)
        self._page = page

    def columns(self) -> dict[str, Sequence[Any] | Floats]:
        """Return the columns of the table of correction planes."""
        return _columns_of(self._entries["correction"]["planes"])

    def to_html(self) -> str:
        """Return the report as one self-contained page."""
        return self._page

    def plot(self) -> go.Figure:
        """Return a Plotly figure of the correction of each plane; needs the package plotly."""
        return _plots.balance(self)


class Campbell(Table):
    """Natural frequencies over the shaft speed; the table has a row for each mode at each speed."""

    def __init__(self, speeds: Sequence[Mapping[str, Any]]) -> None:
        self.speeds = [Record(speed) for speed in speeds]

    def to_dict(self) -> dict[str, Any]:
        """Return the diagram as plain dictionaries, lists and numbers."""
        return {"speeds": [speed.to_dict() for speed in self.speeds]}

    def columns(self) -> dict[str, Sequence[Any] | Floats]:
        """Return the columns of the table of modes."""
        rows = [
            {"speed_rpm": speed["speed_rpm"], "mode": number, **mode}
            for speed in self.speeds
            for number, mode in enumerate(speed["modes"], start=1)
        ]
        return _columns_of(rows)

    def __repr__(self) -> str:
        return f"Campbell({len(self.speeds)} speeds)"

    def plot(self) -> go.Figure:
        """Return a Plotly figure of the natural frequencies over the shaft speed; needs the package plotly."""
        return _plots.campbell(self)


class Motion(Table):
    """Simulated motion.

    Attributes
    ----------
    names : list of str
        Names of the columns: ``t`` (s), coordinates (m, rad), their rates, forces of each bearing (N, N m).
    values : numpy.ndarray
        Array of shape (samples, columns).
    """

    def __init__(self, names: list[str], values: Floats) -> None:
        self.names = names
        self.values = values

    def __getitem__(self, name: str) -> Floats:
        if name not in self.names:
            raise KeyError(f"no column {name!r}, expected one of {', '.join(self.names)}")
        column: Floats = self.values[:, self.names.index(name)]
        return column

    def __len__(self) -> int:
        return len(self.values)

    def to_dict(self) -> dict[str, Any]:
        """Return the columns as lists."""
        return {name: self[name].tolist() for name in self.names}

    def columns(self) -> dict[str, Sequence[Any] | Floats]:
        """Return the columns."""
        return {name: self[name] for name in self.names}

    def to_xarray(self) -> xarray.Dataset:
        """Return the columns over the time ``t`` in s as an ``xarray.Dataset``, with their units; needs the package xarray.

        Examples
        --------
        >>> import ballrace
        >>> motion = ballrace.Scene.demonstration().simulate("0.02 s", "12.8 kHz").to_xarray()
        >>> motion["v"].sel(t=0.01, method="nearest").attrs["units"]
        'm'
        """
        import xarray

        values = {name: ("t", self[name], {"units": _plots.unit(name)}) for name in self.names if name != "t"}
        return xarray.Dataset(values, coords={"t": ("t", self["t"], {"units": "s"})})

    def __repr__(self) -> str:
        return f"Motion({len(self)} samples of {', '.join(self.names)})"

    def plot(self, names: Sequence[str] | None = None) -> go.Figure:
        """Return a Plotly figure of columns over time, by default of the translations; needs the package plotly."""
        return _plots.motion(self, names)

    def plot_orbit(self, x: str = "u", y: str = "v") -> go.Figure:
        """Return a Plotly figure of one column over another, both to one scale; needs the package plotly."""
        return _plots.orbit(self, x, y)


class Sweep(Table, Page):
    """Response over ranges of keys; the table has a row for each point."""

    def __init__(self, entries: Mapping[str, Any], page: str) -> None:
        self.axes = [Record(axis) for axis in entries["axes"]]
        self.rows = [Record(row) for row in entries["rows"]]
        self._page = page

    def to_dict(self) -> dict[str, Any]:
        """Return axes and rows as plain dictionaries, lists and numbers."""
        return {"axes": [axis.to_dict() for axis in self.axes], "rows": [row.to_dict() for row in self.rows]}

    def columns(self) -> dict[str, Sequence[Any] | Floats]:
        """Return the columns of the table of points."""
        rows = []
        for row in self.rows:
            figures = row.to_dict()["figures"]
            values = {
                (f"{axis.key} ({axis.unit})" if axis.unit else axis.key): value
                for axis, value in zip(self.axes, row["values"])
            }
            vectors = {
                f"{name}_{along}_um": figures[name][i]
                for name in ("peak_to_peak", "mean")
                for i, along in enumerate("xyz")
            }
            scalars = {name: figures[name] for name in ("speed_rpm", "overflow", "period", "lyapunov")}
            rows.append({"direction": row["direction"], **values, **scalars, **vectors})
        return _columns_of(rows)

    def to_html(self) -> str:
        """Return the report as one self-contained page."""
        return self._page

    def __repr__(self) -> str:
        return f"Sweep({len(self.rows)} points over {', '.join(axis.key for axis in self.axes)})"

    def plot(self) -> go.Figure:
        """Return a Plotly figure of the peak-to-peak motion over the last key that was varied; needs the package plotly."""
        return _plots.sweep(self)


class Trade(Record, Table, Page):
    """Error and cost of every model that a scene allows; the table has a row for each candidate.

    Attributes
    ----------
    chosen_scene : str or None
        Text of the scene with the chosen model, where a goal was given.
    """

    def __init__(self, native: _native.Trade | _Kept, entries: Mapping[str, Any]) -> None:
        super().__init__(entries)
        self._native = native
        self.chosen_scene = native.chosen

    def __reduce__(self) -> tuple[Any, ...]:
        return _kept_trade, (self._entries, self.to_html(), self.chosen_scene)

    def columns(self) -> dict[str, Sequence[Any] | Floats]:
        """Return the columns of the table of candidates."""
        rows = []
        for candidate in self._entries["candidates"]:
            row: dict[str, Any] = {}
            for name, value in candidate.items():
                if isinstance(value, dict):
                    row.update({f"{name}_{part}": entry for part, entry in value.items()})
                else:
                    row[name] = value
            rows.append(row)
        return _columns_of(rows)

    def to_html(self) -> str:
        """Return the report as one self-contained page."""
        return self._native.html()

    def plot(self) -> go.Figure:
        """Return a Plotly figure of the error of each candidate over its cost; needs the package plotly."""
        return _plots.trade(self)


class Fit(Record, Table):
    """Parameters of a scene from a recording, with their intervals; the table has a row for each parameter.

    Attributes
    ----------
    scene_text : str
        Text of the scene with the fitted values.
    """

    def __init__(self, entries: Mapping[str, Any], scene_text: str) -> None:
        super().__init__(entries)
        self.scene_text = scene_text

    def columns(self) -> dict[str, Sequence[Any] | Floats]:
        """Return the columns of the table of parameters."""
        return _columns_of(self._entries["parameters"])
