"""Figures have the numbers of their results."""

from __future__ import annotations

import builtins
import math
from typing import Any

import numpy as np
import pytest

import ballrace


def test_a_campbell_diagram(scene: ballrace.Scene) -> None:
    diagram = scene.campbell("0rpm..6000rpm:4")
    traces = {trace.name: trace for trace in diagram.plot().data}
    assert {"forward", "backward", "1X", "2X"} <= set(traces)
    np.testing.assert_allclose(traces["2X"].y, [0.0, 200.0 / 3.0, 400.0 / 3.0, 200.0])
    drawn = sorted(f for name in ("forward", "backward", "straight") if name in traces for f in traces[name].y)
    assert drawn == sorted(diagram.columns()["frequency_hz"])


def test_a_load_distribution(scene: ballrace.Scene) -> None:
    rest = scene.equilibrium()
    first = rest.plot().data[0]
    assert first.name == "DE" and len(first.r) == 9
    assert first.r[0] == rest.elements[0].inner_load_n
    assert first.theta[1] == pytest.approx(math.degrees(rest.elements[1].azimuth_rad))


def test_a_motion_and_its_orbit(scene: ballrace.Scene) -> None:
    motion = scene.simulate("0.02 s", "12.8 kHz")
    figure = motion.plot(["DE_FX"])
    assert [trace.name for trace in figure.data] == ["DE_FX"]
    np.testing.assert_array_equal(figure.data[0].y, motion["DE_FX"])
    assert figure.layout.yaxis.title.text == "DE_FX, N"
    orbit = motion.plot_orbit("thu", "v_dot")
    np.testing.assert_array_equal(orbit.data[0].x, motion["thu"])
    assert (orbit.layout.xaxis.title.text, orbit.layout.yaxis.title.text) == ("thu, rad", "v_dot, m/s")
    with pytest.raises(KeyError, match="no column 'DE_F'"):
        motion.plot(["DE_F"])


def test_a_long_line_keeps_its_extremes() -> None:
    values = np.sin(np.arange(100_000))
    values[77_777], values[123] = 5.0, -5.0
    long = ballrace.Motion(["t", "u"], np.stack([np.arange(100_000.0), values], axis=1))
    line = long.plot(["u"]).data[0]
    assert len(line.y) <= 20_002 and max(line.y) == 5.0 and min(line.y) == -5.0


def test_a_sweep(scene: ballrace.Scene) -> None:
    sweep = scene.sweep({"rotor.mass": ["5 kg", "6 kg"], "shaft.speed": "1000rpm..3000rpm:3"}, periods=16)
    figure = sweep.plot()
    assert len(figure.data) == 6 and all(len(trace.x) == 3 for trace in figure.data)
    assert "rotor.mass" in figure.data[0].name and "shaft.speed" in figure.layout.xaxis.title.text
    assert sorted(y for trace in figure.data if trace.name.startswith("X") for y in trace.y) == sorted(
        sweep.columns()["peak_to_peak_x_um"]
    )


def test_a_trade(scene: ballrace.Scene) -> None:
    trade = scene.trade(deadline="30 us", clock="170 MHz", forces_only=True)
    figure = trade.plot()
    assert {"linear", "lumped", "angular"} & {trace.name for trace in figure.data}
    assert figure.layout.xaxis.type == "log" and "Cortex-M4F" in figure.layout.xaxis.title.text


def test_an_outcome(scene: ballrace.Scene) -> None:
    outcome = scene.replay(ballrace.demonstration_recording())
    bars = {trace.name: trace for trace in outcome.plot().data}
    assert list(bars["measured"].x) == [probe.name for probe in outcome.probes]
    assert bars["residual"].y[0] == outcome.probes[0].residual_rms_um


def test_a_correction(scene: ballrace.Scene) -> None:
    recording = ballrace.Scene.demonstration().path.parent / "healthy.csv"
    found = scene.balance(recording)
    (vector,) = found.plot().data
    (plane,) = found.correction.planes
    assert (vector.name, vector.r[1], vector.theta[1]) == (plane.plane, plane.moment_g_mm, plane.angle_deg)


def test_without_plotly(scene: ballrace.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    found = builtins.__import__

    def missing(name: str, *rest: Any, **more: Any) -> Any:
        if name.startswith("plotly"):
            raise ImportError(name)
        return found(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", missing)
    with pytest.raises(ballrace.InputError, match=r"ballrace\[plot\]"):
        scene.equilibrium().plot()
