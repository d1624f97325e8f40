"""Indicators of recordings as features, and results as labelled arrays."""

from __future__ import annotations

import copy
import json
import pickle
from typing import Union

import numpy as np
import pytest
from sklearn.base import clone
from sklearn.linear_model import LogisticRegression
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

import ballrace
from ballrace.features import Indicators


Result = Union[
    ballrace.Balance,
    ballrace.Campbell,
    ballrace.Equilibrium,
    ballrace.Fit,
    ballrace.Motion,
    ballrace.Outcome,
    ballrace.Sweep,
    ballrace.Trade,
]


@pytest.fixture(scope="module")
def recordings(scene: ballrace.Scene, recording: dict[str, np.ndarray]) -> list[dict[str, np.ndarray]]:
    """A machine in good order and one with a spall, each twice, the second time with a noise of 3 nm."""
    table = np.genfromtxt(scene.path.parent / "healthy.csv", delimiter=",", names=True, deletechars="")
    healthy = {name: np.ascontiguousarray(table[name]) for name in table.dtype.names or ()}
    random = np.random.default_rng(7)

    def noisy(of: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        return {name: x + random.normal(0.0, 0.003, len(x)) if name.endswith("_um") else x for name, x in of.items()}

    return [healthy, recording, noisy(healthy), noisy(recording)]


def test_indicators_are_those_of_the_outcome(scene: ballrace.Scene, recording: dict[str, np.ndarray]) -> None:
    outcome = scene.replay(recording)
    found = outcome.indicators()
    assert found["DE_X_um.residual_rms_um"] == outcome.probes[0].residual_rms_um
    assert found["DE_X_um.kurtosis"] == outcome.probes[0].list.kurtosis
    assert found["NDE.largest_element_load_n"] == outcome.bearings[1].largest_element_load_n
    assert found["DE.fy_n"] == outcome.bearings[0].force_estimated[1].mean
    lines = {line.order: line.measured_um for line in outcome.probes[0].ball_pass if line.bearing == "DE"}
    assert found["DE_X_um.DE.outer_race_measured_um"] == lines[min(lines)]
    assert not any(name.endswith("_deg") for name in found)
    assert all(isinstance(value, float) for value in found.values())


def test_a_pipeline_tells_a_spall_by_its_indicators(
    scene: ballrace.Scene, recordings: list[dict[str, np.ndarray]]
) -> None:
    pipeline = make_pipeline(Indicators(scene), StandardScaler(), LogisticRegression())
    pipeline.fit(recordings[:2], [0, 1])
    assert pipeline.predict(recordings[2:]).tolist() == [0, 1]
    names = pipeline[0].get_feature_names_out()
    assert len(names) == len(pipeline[0].units) == len(set(names)) > 40
    units = dict(zip(names, pipeline[0].units))
    assert units["DE_X_um.direct_um_pp"] == "um peak to peak" and units["DE.mx_nm"] == "N m"
    assert units["DE_X_um.kurtosis"] == "" and units["DE.fx_n"] == "N"


def test_features_are_a_frame_where_it_is_asked_for(
    scene: ballrace.Scene, recordings: list[dict[str, np.ndarray]]
) -> None:
    transformer = clone(Indicators(scene)).set_output(transform="pandas")
    frame = transformer.fit(recordings[:1]).transform(recordings[:2])
    assert list(frame.columns) == list(transformer.get_feature_names_out()) and len(frame) == 2
    line = frame["DE_Y_um.DE.outer_race_measured_um"]
    assert line[1] > 10.0 * line[0]
    again = pickle.loads(pickle.dumps(transformer))
    assert list(again.get_feature_names_out()) == list(frame.columns)


def test_no_recording_and_no_fit_are_errors(scene: ballrace.Scene) -> None:
    with pytest.raises(ValueError, match="recordings: none, expected at least one"):
        Indicators(scene).fit([])
    with pytest.raises(ValueError, match="recordings: none, expected at least one"):
        Indicators(scene).fit_transform([])
    with pytest.raises(ValueError, match="not fitted"):
        Indicators(scene).transform([])


def test_a_pipeline_replays_each_recording_once(scene: ballrace.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    replayed: list[str] = []

    class Replayed:
        def indicators(self) -> dict[str, float]:
            return {"level": float(len(replayed))}

    def replay(scene: ballrace.Scene, recording: str, baseline: None) -> Replayed:
        replayed.append(recording)
        return Replayed()

    monkeypatch.setattr(ballrace.Scene, "replay", replay)
    features = make_pipeline(Indicators(scene)).fit_transform(["a.csv", "b.csv"])
    assert replayed == ["a.csv", "b.csv"] and features.tolist() == [[1.0], [2.0]]


def test_a_motion_is_a_labelled_dataset(scene: ballrace.Scene) -> None:
    motion = scene.simulate("0.02 s", "12.8 kHz")
    dataset = motion.to_xarray()
    assert dataset.sizes == {"t": len(motion)} and dataset["t"].attrs["units"] == "s"
    np.testing.assert_array_equal(dataset["DE_FX"], motion["DE_FX"])
    units = {name: dataset[name].attrs["units"] for name in ("v", "v_dot", "thu", "DE_FX", "DE_MX")}
    assert units == {"v": "m", "v_dot": "m/s", "thu": "rad", "DE_FX": "N", "DE_MX": "N m"}


def test_copies_of_results_are_equal_and_their_json_is_theirs(scene: ballrace.Scene) -> None:
    recording = scene.path.parent / "healthy.csv"
    slow = scene.with_value("shaft.speed", "100 rpm")
    results: list[tuple[Result, Result | None]] = [
        (scene.equilibrium(), slow.equilibrium()),
        (scene.campbell("0rpm..3000rpm:2"), scene.campbell("0rpm..3000rpm:3")),
        (scene.simulate("0.02 s", "12.8 kHz"), slow.simulate("0.02 s", "12.8 kHz")),
        (scene.sweep({"shaft.speed": "2900rpm,3000rpm"}, settle="20 ms", periods=16), None),
        (scene.trade(forces_only=True, error=0.01), None),
        (scene.replay(recording), None),
        (scene.balance(recording), None),
        (scene.fit(scene.path.parent / "healthy.csv", only=["unbalance"], turns=8), None),
    ]
    for result, other in results:
        for again in (copy.copy(result), copy.deepcopy(result), pickle.loads(pickle.dumps(result))):
            assert again == result and again.to_json() == result.to_json()
        assert json.loads(result.to_json()) == result.to_dict()
        assert result != other
