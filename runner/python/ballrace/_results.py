"""Results of the studies: objects with units in their names, convertible to dictionaries and tables."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _plots
from ._errors import InputError
from ._series import Samples, Spectra, Waterfall
from ._tables import Floats, Page, Record, Table, columns_of
from .typing import Along

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from . import _native


class _KeptOutcome:
    """Texts and arrays of a native outcome, which a copy in another process has instead of it."""

    def __init__(self, native: _native.Outcome | _KeptOutcome) -> None:
        self._html, self._text = native.html(), native.text()
        self._samples, self._spectra, self._cascades = native.samples(), native.spectra(), native.cascades()
        self._baseline, self._no_baseline = "", ""
        try:
            self._baseline = native.baseline()
        except InputError as error:
            self._no_baseline = str(error)

    def html(self) -> str:
        return self._html

    def text(self) -> str:
        return self._text

    def baseline(self) -> str:
        if self._no_baseline:
            raise InputError(self._no_baseline)
        return self._baseline

    def samples(self) -> tuple[list[str], Floats] | None:
        return self._samples

    def spectra(self) -> tuple[list[str], Floats]:
        return self._spectra

    def cascades(self) -> list[tuple[str, Floats, Floats, Floats, Floats]]:
        return self._cascades


class _KeptTrade:
    """Texts of a native trade study, which a copy in another process has instead of it."""

    def __init__(self, html: str, chosen: str | None) -> None:
        self._html, self.chosen = html, chosen

    def html(self) -> str:
        return self._html


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

    def __init__(self, native: _native.Outcome | _KeptOutcome, entries: Mapping[str, Any]) -> None:
        super().__init__(entries)
        self._native = native

    def __reduce__(self) -> tuple[Any, ...]:
        return Outcome, (_KeptOutcome(self._native), self._entries)

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
        return columns_of(rows)

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
        7.43
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

    def samples(self) -> Samples:
        """Return every sample of a replay with ``samples=True`` as a table.

        Raises
        ------
        InputError
            A replay without ``samples=True``, or without displacement probes.

        Examples
        --------
        >>> import ballrace
        >>> outcome = ballrace.Scene.demonstration().replay(ballrace.demonstration_recording(), samples=True)
        >>> frame = outcome.samples().to_pandas()
        >>> list(frame.columns[frame.columns.str.startswith("DE_F")])
        ['DE_FX_N', 'DE_FY_N', 'DE_FZ_N']
        """
        kept = self._native.samples()
        if kept is None:
            raise InputError("samples: none are kept, expected replay(..., samples=True) of a recording of displacement probes")
        return Samples(*kept)

    def spectra(self) -> Spectra:
        """Return the amplitude spectra of the probes; without lines where no probe was compared."""
        return Spectra(*self._native.spectra())

    def waterfalls(self) -> list[Waterfall]:
        """Return the spectra in the order of time of each plane of probes, or of each radial probe where there is no plane."""
        return [Waterfall(*one) for one in self._native.cascades()]

    def plot(self) -> go.Figure:
        """Return a Plotly figure of the motion of each probe, measured and of the twin; needs the package plotly."""
        return _plots.outcome(self)

    def plot_waterfall(self, name: str | None = None, over: Along | None = None) -> go.Figure:
        """Return a Plotly figure of one of :meth:`waterfalls`; needs the package plotly.

        Parameters
        ----------
        name : str, optional
            Name of a waterfall, such as ``"DE_X_um / DE_Y_um"``; by default the first.
        over : {"time", "speed"}, optional
            As for :meth:`Waterfall.plot`.

        Examples
        --------
        >>> import ballrace
        >>> outcome = ballrace.Scene.demonstration().replay(ballrace.demonstration_recording())
        >>> outcome.plot_waterfall().layout.title.text
        'Waterfall of DE_X_um / DE_Y_um'
        """
        all_of_them = self.waterfalls()
        chosen = [one for one in all_of_them if name is None or one.name == name]
        if not chosen:
            known = ", ".join(f"{one.name!r}" for one in all_of_them) or "a recording of displacement probes"
            raise InputError(f"waterfall: none{'' if name is None else f' named {name!r}'}, expected {known}")
        return chosen[0].plot(over)


class Equilibrium(Record, Table, Page):
    """Static equilibrium; the table has a row for each rolling element."""

    def __init__(self, entries: Mapping[str, Any], page: str) -> None:
        super().__init__(_with_units(entries, _EQUILIBRIUM_UNITS))
        self._page = page

    def columns(self) -> dict[str, Sequence[Any] | Floats]:
        """Return the columns of the table of rolling elements."""
        return columns_of(self._entries["elements"])

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
        return columns_of(self._entries["correction"]["planes"])

    def masses(self) -> Masses:
        """Return the masses of the blind conditions with their 95 % intervals, a row for each condition and plane."""
        return Masses(self._entries["planes"], self._entries["conditions"])

    def to_html(self) -> str:
        """Return the report as one self-contained page."""
        return self._page

    def plot(self) -> go.Figure:
        """Return a Plotly figure of the correction of each plane; needs the package plotly."""
        return _plots.balance(self)


class Masses(Table):
    """Masses of blind conditions with their 95 % intervals."""

    def __init__(self, planes: Sequence[str], conditions: Sequence[Mapping[str, Any]]) -> None:
        self._rows = [
            {"condition": condition["condition"], "plane": name, **moment}
            for condition in conditions
            for name, moment in zip(planes, condition["planes"])
        ]

    def columns(self) -> dict[str, Sequence[Any] | Floats]:
        """Return the columns of the table of masses."""
        return columns_of(self._rows)

    def to_dict(self) -> dict[str, Any]:
        """Return the table as plain dictionaries, lists and numbers."""
        return {"masses": self._rows}

    def __repr__(self) -> str:
        return f"Masses({len(self._rows)} rows)"


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
        return columns_of(rows)

    def __repr__(self) -> str:
        return f"Campbell({len(self.speeds)} speeds)"

    def plot(self) -> go.Figure:
        """Return a Plotly figure of the natural frequencies over the shaft speed; needs the package plotly."""
        return _plots.campbell(self)


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
        return columns_of(rows)

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

    def __init__(self, native: _native.Trade | _KeptTrade, entries: Mapping[str, Any]) -> None:
        super().__init__(entries)
        self._native = native
        self.chosen_scene = native.chosen

    def __reduce__(self) -> tuple[Any, ...]:
        return Trade, (_KeptTrade(self.to_html(), self.chosen_scene), self._entries)

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
        return columns_of(rows)

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
        return columns_of(self._entries["parameters"])
