"""Scenes and the studies on them."""

from __future__ import annotations

import json
import pickle
from pathlib import Path

import numpy as np
import pytest

import ballrace
from conftest import ROOT


def test_an_error_names_file_line_key_found_and_expected(tmp_path: Path, scene: ballrace.Scene) -> None:
    path = tmp_path / "pump.toml"
    path.write_text(scene.text.replace('"3000 rpm"', '"3000 kg"'))
    with pytest.raises(ballrace.SceneError) as caught:
        ballrace.Scene.read(path)
    error = caught.value
    line = next(i for i, text in enumerate(path.read_text().splitlines(), 1) if "3000 kg" in text)
    assert (error.file, error.line, error.key) == (path, line, "shaft.speed")
    assert error.found is not None and "3000 kg" in error.found
    assert error.expected is not None and "rpm" in error.expected
    assert isinstance(error, ValueError)


def test_a_scene_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(ballrace.SceneError, match="nothing.toml: .*no file of this name"):
        ballrace.Scene.read(tmp_path / "nothing.toml")


def test_a_scene_is_pickled(scene: ballrace.Scene) -> None:
    copy = pickle.loads(pickle.dumps(scene))
    assert (copy.text, copy.path) == (scene.text, scene.path)


def test_values_are_changed(scene: ballrace.Scene) -> None:
    wide = scene.with_value("bearing.DE.diametral_clearance", "40 um")
    u = np.array([0.0, -10e-6, 0.0, 0.0, 0.0])
    assert np.linalg.norm(wide.bearing("DE").force(u)) < np.linalg.norm(scene.bearing("DE").force(u))
    assert "40 um" in wide.text and "40 um" not in scene.text
    assert scene.with_value("rotor.load", [0, -5, 0, 0, 0]).text.count("[0, -5, 0, 0, 0]") == 1
    with pytest.raises(ballrace.InputError, match="no such key in the scene"):
        scene.with_value("bearing.XX.diametral_clearance", "40 um")
    with pytest.raises(ballrace.SceneError, match="colour"):
        scene.with_value("shaft.colour", "red")


def test_equilibrium(scene: ballrace.Scene) -> None:
    rest = scene.equilibrium()
    assert rest.residual < 1e-9
    table = rest.to_pandas()
    assert len(table) == 18 and {"bearing", "inner_load_n", "azimuth_rad"} <= set(table.columns)
    loaded = scene.equilibrium("DE", [0, -500, 0, 0, 0])
    assert abs(loaded.force_n_nm[1] - 500) < 1e-6
    assert "<svg" in rest.to_html()
    json.dumps(rest.to_dict())


def test_temperatures_that_friction_and_cooling_keep() -> None:
    spindle = ballrace.Scene.read(ROOT / "runner/scenes/spindle-thermal.toml")
    front = spindle.equilibrium(thermal=True).to_dict()["bearings"][0]
    warm = front["temperatures"]
    assert warm["inner"] > warm["outer"] > 295
    assert abs(warm["through_shaft"] + warm["through_housing"] - front["friction"]["power"]) < 0.5
    with pytest.raises(ballrace.Error, match="no steady temperature"):
        spindle.with_value("shaft.speed", "13000 rpm").equilibrium(thermal=True)


def test_balance(scene: ballrace.Scene) -> None:
    """This recording of the demonstration's machine has 120 g mm at 0.3 rad in the plane at 20 mm, and no run-out."""
    recording = ROOT / "tests" / "recordings" / "healthy.csv"
    found = scene.balance(recording, grade=2.5)
    (plane,) = found.correction.planes
    assert abs(plane.moment_g_mm - 120) < 12 and abs(plane.angle_deg - 180 - np.degrees(0.3)) < 5
    assert abs(found.quality.permissible_g_mm - 9549 * 2.5 * 6 / 3000) < 0.1
    assert len(found.to_pandas()) == 1 and "<svg" in found.to_html()
    with pytest.raises(ballrace.InputError, match="unknown plane: 'XY'|unknown plane: \"XY\""):
        scene.balance(recording, {"trial.csv": "XY 5 g mm at 30 deg"})


def test_campbell(scene: ballrace.Scene) -> None:
    diagram = scene.campbell(["0 rpm", "6000 rpm"])
    assert [round(at.speed_rpm) for at in diagram.speeds] == [0, 6000]
    assert diagram.to_dict() == scene.campbell("0rpm..6000rpm:2").to_dict()
    assert set(diagram.to_pandas()["whirl"]) <= {"forward", "backward", "straight"}
    with pytest.raises(ballrace.InputError, match="speeds: "):
        scene.campbell("fast")


def test_simulate(scene: ballrace.Scene) -> None:
    motion = scene.simulate("0.1 s", "12.8 kHz", settle="0.05 s")
    assert motion.values.shape == (1280, len(motion.names))
    assert abs(motion["t"][0] - 0.05) < 1e-12
    assert motion.to_arrow().num_rows == 1280
    with pytest.raises(ballrace.InputError, match="rate: "):
        scene.simulate("0.1 s", "12.8 kg")
    with pytest.raises(ballrace.InputError, match="number of samples out of range"):
        scene.simulate("0.1 s", 1.0)


def test_sweep(scene: ballrace.Scene) -> None:
    swept = scene.sweep({"shaft.speed": "2000rpm..3000rpm:2", "bearing.DE.elements": [8, 9]}, settle=0.02, periods=16)
    assert len(swept.rows) == 4
    table = swept.to_pandas()
    assert table["shaft.speed (rpm)"].tolist() == [2000.0, 3000.0, 2000.0, 3000.0]
    assert "<svg" in swept.to_html()


def test_trade(scene: ballrace.Scene) -> None:
    study = scene.trade(error=0.05, forces_only=True)
    assert study.chosen_scene is not None
    assert ballrace.Scene.from_toml(study.chosen_scene, path=scene.path).bearing_names == scene.bearing_names
    assert len(study.to_pandas()) == len(study.candidates)
    with pytest.raises(ballrace.InputError, match="deadline and clock together"):
        scene.trade(deadline="20 us")


def test_a_trade_study_is_pickled(scene: ballrace.Scene) -> None:
    study = scene.trade(error=0.05, forces_only=True)
    copy = pickle.loads(pickle.dumps(study))
    assert copy.to_dict() == study.to_dict() and copy.chosen_scene == study.chosen_scene
    assert copy.to_html() == study.to_html()


def test_fit(scene: ballrace.Scene) -> None:
    motion = scene.simulate("0.4 s", "12.8 kHz")
    columns = _probes(scene, motion)
    found = scene.fit(columns, only=["clearance"], turns=10)
    clearances = [p for p in found.parameters if "clearance" in p.name]
    assert clearances and all(p.low is None or p.low <= p.value <= p.high for p in clearances)
    ballrace.Scene.from_toml(found.scene_text, path=scene.path)
    assert len(found.to_arrow()) == len(found.parameters)
    with pytest.raises(ballrace.InputError, match="only: no such parameters"):
        scene.fit(columns, only=["colour"])  # type: ignore[list-item]


def _probes(scene: ballrace.Scene, motion: ballrace.Motion) -> dict[str, np.ndarray]:
    """Return what the probes of the demonstration read of a simulated motion."""
    noise = np.random.default_rng(1)
    x, y, z, thu, thv = (motion[name] for name in ("u", "v", "w", "thu", "thv"))
    read = {
        "DE_X_um": x - 0.12 * thv,
        "DE_Y_um": y + 0.12 * thu,
        "NDE_X_um": x + 0.12 * thv,
        "NDE_Y_um": y - 0.12 * thu,
        "axial_um": z,
    }
    columns = {name: 1e6 * values + noise.normal(0, 0.03, len(values)) for name, values in read.items()}
    turns = 50.0 * motion["t"]
    columns["keyphasor"] = (turns % 1.0 < 0.05).astype(float)
    return columns
