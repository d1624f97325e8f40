"""Figures of results, by Plotly: ``pip install ballrace[plot]``."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ._errors import InputError

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from ._results import Balance, Campbell, Equilibrium, Outcome, Sweep, Trade
    from ._series import Motion, Series, Waterfall
    from .typing import Along

#: Symbol of the modes of each whirl.
_WHIRLS = {"forward": "triangle-up", "backward": "triangle-down", "straight": "circle"}
#: Most points along one line; a longer one is thinned to its extremes.
_MOST_POINTS = 20_000
#: Share of the highest amplitude down to which the frequencies of a waterfall are shown.
_SEEN = 0.1
#: Relative change of the speed beyond which spectra are drawn over it.
_CHANGES = 0.05
#: Harmonics of the shaft in a Campbell diagram.
_HARMONICS = (1, 2)


def _figure(title: str, x: str, y: str) -> go.Figure:
    """Return an empty figure whose axes have these titles."""
    try:
        import plotly.graph_objects as go
    except ImportError as error:
        raise InputError('plot: no package plotly, expected it installed: pip install "ballrace[plot]"') from error
    figure = go.Figure()
    figure.update_layout(title=title, xaxis_title=x, yaxis_title=y, template="plotly_white")
    figure.update_xaxes(exponentformat="power")
    figure.update_yaxes(exponentformat="power")
    return figure


def campbell(of: Campbell) -> go.Figure:
    """Return natural frequencies over the shaft speed, by the sense of whirl, with 1X and 2X."""
    figure = _figure("Campbell diagram", "shaft speed, rpm", "frequency, Hz")
    rows = of.columns()
    speeds = [float(speed["speed_rpm"]) for speed in of.speeds]
    highest = max((float(f) for f in rows["frequency_hz"]), default=0.0)
    for whirl, symbol in _WHIRLS.items():
        own = [i for i, found in enumerate(rows["whirl"]) if found == whirl]
        if own:
            figure.add_scatter(
                x=[rows["speed_rpm"][i] for i in own],
                y=[rows["frequency_hz"][i] for i in own],
                customdata=[100.0 * rows["damping_ratio"][i] for i in own],
                hovertemplate="%{x:.0f} rpm: %{y:.1f} Hz, damping %{customdata:.2f} %",
                name=whirl,
                mode="markers",
                marker={"symbol": symbol},
            )
    for order in _HARMONICS:
        figure.add_scatter(
            x=speeds, y=[order * speed / 60.0 for speed in speeds], name=f"{order}X", mode="lines", line={"dash": "dot"}
        )
    figure.update_yaxes(range=[0.0, 1.05 * highest])
    return figure


def equilibrium(of: Equilibrium) -> go.Figure:
    """Return the load of each rolling element around each bearing."""
    rows = of.columns()
    figure = _figure("Load distribution, N", "", "")
    for bearing in dict.fromkeys(rows["bearing"]):
        own = [i for i, name in enumerate(rows["bearing"]) if name == bearing]
        figure.add_barpolar(
            theta=[math.degrees(rows["azimuth_rad"][i]) for i in own],
            r=[rows["inner_load_n"][i] for i in own],
            name=str(bearing),
            hovertemplate="%{theta:.1f} deg: %{r:.4g} N",
            opacity=0.7,
        )
    figure.update_layout(polar={"angularaxis": {"direction": "counterclockwise", "rotation": 0}}, showlegend=True)
    return figure


def series(of: Series, names: Sequence[str], title: str) -> go.Figure:
    """Return columns over the first one."""
    along = of.names[0]
    units = dict.fromkeys(of.unit(name) for name in names)
    figure = _figure(title, _with_unit(of, along), _with_unit(of, names[0]) if len(names) == 1 else "; ".join(units))
    for name in names:
        kept = _extremes([float(value) for value in of[name]])
        figure.add_scatter(x=of[along][kept], y=of[name][kept], name=name, mode="lines")
    return figure


def waterfall(of: Waterfall, over: Along | None) -> go.Figure:
    """Return spectra one behind the other, over time or speed."""
    import numpy as np

    speeds = np.abs(of.speed_rpm)
    if over is None:
        over = "speed" if speeds.size and np.ptp(speeds) > _CHANGES * speeds.mean() else "time"
    kind, along, title = ("Cascade", speeds, "speed, rpm") if over == "speed" else ("Waterfall", of.time_s, "time, s")
    figure = _figure(f"{kind} of {of.name}", "", "")
    for i in np.argsort(along, kind="stable"):
        figure.add_scatter3d(
            x=of.frequency_hz,
            y=np.full(len(of.frequency_hz), along[i]),
            z=of.amplitude_um[i],
            mode="lines",
            line={"color": "#1f4e79"},
            name=f"{along[i]:.4g}",
            hovertemplate="%{x:.1f} Hz, %{y:.4g}: %{z:.3g} um",
            showlegend=False,
        )
    highest = of.amplitude_um.max(axis=0, initial=0.0)
    seen = np.abs(of.frequency_hz[highest > _SEEN * highest.max(initial=0.0)]).max(initial=0.0)
    figure.update_scenes(
        xaxis={"title": {"text": "frequency, Hz"}, "range": [max(of.frequency_hz.min(initial=0.0), -1.2 * seen), 1.2 * seen]},
        yaxis={"title": {"text": title}},
        zaxis={"title": {"text": "um peak"}},
        aspectratio={"x": 2.0, "y": 1.2, "z": 0.7},
        camera={"eye": {"x": 0.3, "y": -2.0, "z": 1.0}},
    )
    figure.update_layout(margin={"l": 0, "r": 0, "b": 0})
    return figure


def orbit(of: Motion, x: str, y: str) -> go.Figure:
    """Return one column over another, both axes to one scale."""
    figure = _figure("Orbit", _with_unit(of, x), _with_unit(of, y))
    figure.add_scatter(x=of[x], y=of[y], name=f"{y} over {x}", mode="lines")
    figure.update_yaxes(scaleanchor="x", scaleratio=1)
    return figure


def sweep(of: Sweep) -> go.Figure:
    """Return the peak-to-peak motion over the last key that was varied, a line for each value of the others and each direction."""
    rows = of.columns()
    keys = [f"{axis.key} ({axis.unit})" if axis.unit else str(axis.key) for axis in of.axes]
    *others, along = keys
    figure = _figure("Sweep", along, "peak to peak, um")
    lines: dict[tuple[Any, ...], list[int]] = {}
    for i, direction in enumerate(rows["direction"]):
        lines.setdefault((direction, *(rows[key][i] for key in others)), []).append(i)
    for (direction, *values), own in lines.items():
        given = [f"{key} = {value:g}" for key, value in zip(others, values)]
        for axis in "xyz":
            name = ", ".join([axis.upper(), *given, *([str(direction)] if direction != "rest" else [])])
            figure.add_scatter(
                x=[rows[along][i] for i in own],
                y=[rows[f"peak_to_peak_{axis}_um"][i] for i in own],
                name=name,
                mode="lines+markers",
            )
    return figure


def trade(of: Trade) -> go.Figure:
    """Return the error of each candidate over its cost: instructions on the Cortex-M4F where they are known, else time on this machine."""
    candidates = of.to_dict()["candidates"]
    is_counted = any(candidate.get("cortex") for candidate in candidates)
    cost = "instructions on a Cortex-M4F" if is_counted else "time on this machine, ns"
    figure = _figure("Error and cost", cost, "largest error, % of the largest load")
    points: dict[str, list[tuple[float, float, str]]] = {}
    for candidate in candidates:
        spent = (candidate.get("cortex") or {}).get("instructions") if is_counted else candidate.get("desktop_ns")
        error = (candidate.get("error") or {}).get("largest")
        if spent and error:
            arithmetic = candidate.get("arithmetic") or {}
            text = ", ".join(str(part) for part in (candidate["model"], *arithmetic.values()))
            points.setdefault(str(candidate["model"]), []).append((spent, 100.0 * error, text))
    for model, own in points.items():
        figure.add_scatter(
            x=[point[0] for point in own],
            y=[point[1] for point in own],
            text=[point[2] for point in own],
            hovertemplate="%{text}: %{x:.4g}, %{y:.3g} %",
            name=model,
            mode="markers",
        )
    figure.update_xaxes(type="log")
    figure.update_yaxes(type="log")
    return figure


def outcome(of: Outcome) -> go.Figure:
    """Return the motion of each probe: measured, of the twin, their difference and the noise of the probe."""
    probes: list[Mapping[str, Any]] = of.to_dict().get("probes", [])
    figure = _figure(str(of.verdict).split(". ", 1)[0], "probe", "um rms")
    bars: dict[str, list[Any]] = {
        "measured": [(probe.get("measured") or {}).get("rms_um") for probe in probes],
        "twin": [(probe.get("twin") or {}).get("rms_um") for probe in probes],
        "residual": [probe.get("residual_rms_um") for probe in probes],
        "noise of the probe": [probe.get("noise_um") for probe in probes],
    }
    for name, heights in bars.items():
        figure.add_bar(x=[probe["name"] for probe in probes], y=heights, name=name)
    return figure


def balance(of: Balance) -> go.Figure:
    """Return the correction of each plane as a vector of moment and angle."""
    figure = _figure("Correction, g mm", "", "")
    for plane in of.to_dict()["correction"]["planes"]:
        angle = plane["angle_deg"]
        figure.add_scatterpolar(r=[0.0, plane["moment_g_mm"]], theta=[angle, angle], name=str(plane["plane"]), mode="lines+markers")
    return figure


def _with_unit(of: Series, name: str) -> str:
    """Return the name of a column with its unit."""
    unit = of.unit(name)
    plain = name.removesuffix("_" + unit.replace(" ", "")).removesuffix("_" + unit.lower())
    return f"{plain}, {unit}" if unit else name


def _extremes(values: Sequence[float]) -> list[int]:
    """Return the indices of a line that looks as the one through all values: least and largest of equal parts."""
    if len(values) <= _MOST_POINTS:
        return list(range(len(values)))
    part = math.ceil(2 * len(values) / _MOST_POINTS)
    kept: set[int] = {0, len(values) - 1}
    for first in range(0, len(values), part):
        own = [i for i in range(first, min(first + part, len(values))) if not math.isnan(values[i])]
        if own:
            kept |= {min(own, key=values.__getitem__), max(own, key=values.__getitem__)}
    return sorted(kept)
