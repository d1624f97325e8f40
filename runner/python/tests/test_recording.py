"""Recordings: files and every table in memory."""

from __future__ import annotations

import json
import os
import pickle
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas
import polars
import pyarrow
import pytest

import ballrace

Columns = dict[str, np.ndarray]


@pytest.fixture(scope="module")
def short(recording: Columns) -> Columns:
    return {name: values[:3200].copy() for name, values in recording.items()}


@pytest.fixture(scope="module")
def expected(scene: ballrace.Scene, short: Columns) -> dict[str, object]:
    return _comparable(scene.replay(short))


def _comparable(outcome: ballrace.Outcome) -> dict[str, object]:
    entries = json.loads(json.dumps(outcome.to_dict()))
    return {key: value for key, value in entries.items() if key not in ("recording", "timing", "compute", "record")}


class _Stream:
    """An object that only speaks the Arrow PyCapsule interface."""

    def __init__(self, table: pyarrow.Table) -> None:
        self._table = table

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        return self._table.__arrow_c_stream__(requested_schema)


def _structured(columns: Columns) -> np.ndarray:
    array = np.empty(len(columns["DE_X_um"]), dtype=[(name, float) for name in columns])
    for name, values in columns.items():
        array[name] = values
    return array


@pytest.mark.parametrize(
    "table",
    [
        _structured,
        pandas.DataFrame,
        polars.DataFrame,
        pyarrow.table,
        lambda columns: _Stream(pyarrow.table(columns)),
        lambda columns: {name: values.tolist() for name, values in columns.items()},
    ],
    ids=["structured array", "pandas", "polars", "pyarrow", "arrow stream", "lists"],
)
def test_every_table_gives_the_same(
    scene: ballrace.Scene, short: Columns, expected: dict[str, object], table: object
) -> None:
    assert _comparable(scene.replay(table(short))) == expected  # type: ignore[operator]


def test_a_file_gives_the_same(scene: ballrace.Scene, short: Columns, expected: dict[str, object], tmp_path: Path) -> None:
    path = tmp_path / "short.parquet"
    pandas.DataFrame(short).to_parquet(path)
    assert _comparable(scene.replay(path)) == expected


def test_columns_are_not_copied(scene: ballrace.Scene, short: Columns) -> None:
    from ballrace._recording import columns

    passed = dict(columns(short, scene._native.columns))
    assert all(np.shares_memory(passed[name], short[name]) for name in short if passed[name].size)
    assert passed["DE_X_um"].size


def test_wrong_recordings(scene: ballrace.Scene, short: Columns) -> None:
    with pytest.raises(ballrace.RecordingError, match="no such column") as caught:
        scene.replay({name: values for name, values in short.items() if name != "DE_Y_um"})
    assert caught.value.expected == "DE_Y_um"
    with pytest.raises(ballrace.RecordingError, match="equal length"):
        scene.replay({**short, "DE_X_um": short["DE_X_um"][:-1]})
    with pytest.raises(ballrace.InputError, match="column DE_X_um: values of type"):
        scene.replay({**short, "DE_X_um": np.array(["a"] * 3200)})
    with pytest.raises(ballrace.InputError, match="one dimension"):
        scene.replay({**short, "DE_X_um": np.zeros((3200, 2))})
    with pytest.raises(ballrace.InputError, match="without named columns"):
        scene.replay(np.zeros((3200, 5)))
    with pytest.raises(ballrace.InputError, match="expected a path"):
        scene.replay(17)
    with pytest.raises(ballrace.RecordingError, match="missing.csv: cannot be opened"):
        scene.replay("missing.csv")
    with pytest.raises(ballrace.RecordingError, match="at least one value"):
        scene.replay({name: values[:0] for name, values in short.items()})


def test_missing_readings_are_counted(scene: ballrace.Scene, short: Columns) -> None:
    gap = {name: values.copy() for name, values in short.items()}
    gap["DE_X_um"][1000:1010] = np.nan
    outcome = scene.replay(gap)
    assert any(flaw.column == "DE_X_um" and flaw.samples_affected == 10 for flaw in outcome.flaws)


def test_baseline_is_learned_and_used(scene: ballrace.Scene, short: Columns, tmp_path: Path) -> None:
    path = scene.replay(short, learn=True).save_baseline(tmp_path / "baseline.json")
    judged = scene.replay(short, baseline=path)
    assert json.loads(path.read_text()) and judged.to_dict() != scene.replay(short).to_dict()


def test_report_in_a_notebook(scene: ballrace.Scene, short: Columns, tmp_path: Path) -> None:
    outcome = scene.replay(short)
    assert outcome._repr_html_().startswith("<iframe")
    page = outcome.save_html(tmp_path / "report.html").read_text()
    assert page.startswith("<!DOCTYPE html>") and "<svg" in page


def test_same_bits_as_the_command_line(program: Path, scene: ballrace.Scene, short: Columns, tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(scene.text)
    pandas.DataFrame(short).to_csv(tmp_path / "short.csv", index=False)
    run = [str(program), "replay", "scene.toml", "--recording", "short.csv", "--format", "json"]
    answer = subprocess.run(run, cwd=tmp_path, capture_output=True, check=False)
    read = ballrace.Scene.read(tmp_path / "scene.toml")
    mine = json.loads(json.dumps(read.replay(short).to_dict()))
    theirs = json.loads(answer.stdout)
    assert _differences(mine, theirs) <= {"file", "recording", "scene", "timing"}


def test_same_force_bits_as_the_command_line(program: Path, scene: ballrace.Scene, tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(scene.text)
    u = np.random.default_rng(3).normal(size=(200, 5)) * np.array([2e-5, 2e-5, 1e-5, 1e-4, 1e-4])
    angles = np.linspace(0.0, 6.0, 200)
    header = "u,v,w,thu,thv,cage_angle"
    np.savetxt(tmp_path / "u.csv", np.column_stack([u, angles]), delimiter=",", header=header, comments="", fmt="%.17g")
    for model in ("angular", "quasi-static", "tabulated"):
        run = [str(program), "force", "scene.toml", "--bearing", "DE", "--displacements", "u.csv", "--format", "csv"]
        answer = subprocess.run([*run, "--model", model], cwd=tmp_path, capture_output=True, check=True, text=True)
        theirs = np.genfromtxt(answer.stdout.splitlines(), delimiter=",", skip_header=1, usecols=range(5))
        assert np.array_equal(scene.bearing("DE").force(u, cage_angle=angles, model=model), theirs), model


def _differences(mine: dict[str, object], theirs: dict[str, object]) -> set[str]:
    return {key for key in mine.keys() | theirs.keys() if mine.get(key) != theirs.get(key)}


LONG_WORK = [
    "scene.simulate('1000 s', '25.6 kHz')",
    "scene.trade()",
    "scene.replay(recording)",
    "scene.sweep({'shaft.speed': '1000rpm..6000rpm:200'})",
    "scene.fit(recording)",
    "scene.bearing('DE').force(np.full((3_000_000, 5), 1e-6), model='quasi-static')",
    "scene.bearing('DE').stiffness(np.full((3_000_000, 5), 1e-6), model='quasi-static')",
    "scene.bearing('DE').element_loads(np.full((3_000_000, 5), 1e-6), model='quasi-static')",
]


@pytest.mark.parametrize("work", LONG_WORK)
def test_ctrl_c_stops_long_work(work: str) -> None:
    program = (
        "import ballrace, sys\nimport numpy as np\n"
        "scene, recording = ballrace.Scene.demonstration(), ballrace.demonstration_recording()\n"
        "recording = {name: list(values) * 20 for name, values in recording.items()}\n"
        "print('started', flush=True)\n"
        f"try:\n    {work}\nexcept KeyboardInterrupt:\n    print('stopped', flush=True)\n    sys.exit(0)\nsys.exit(7)\n"
    )
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline() == "started\n"
    try:
        process.wait(0.7)
    except subprocess.TimeoutExpired:
        os.kill(process.pid, signal.SIGINT)
    assert process.wait(30) == 0
    assert process.stdout.read() == "stopped\n"
    assert process.stderr is not None and process.stderr.read() == ""


def test_a_masked_reading_is_missing(scene: ballrace.Scene, short: Columns) -> None:
    mask = np.zeros(len(short["DE_X_um"]), dtype=bool)
    mask[100:400] = True
    spoiled = np.where(mask, 1e6, short["DE_X_um"])
    missing = np.where(mask, np.nan, short["DE_X_um"])
    masked = scene.replay({**short, "DE_X_um": np.ma.array(spoiled, mask=mask)})
    assert masked.flaws and masked.probes == scene.replay({**short, "DE_X_um": missing}).probes


def test_an_outcome_is_pickled(
    scene: ballrace.Scene, recording: dict[str, np.ndarray], tmp_path: Path
) -> None:
    outcome = scene.replay(recording)
    copy = pickle.loads(pickle.dumps(outcome))
    again = pickle.loads(pickle.dumps(copy))
    for other in (copy, again):
        assert type(other) is ballrace.Outcome and other.to_dict() == outcome.to_dict()
        assert other.to_html() == outcome.to_html() and other.to_text() == outcome.to_text()
        saved = [one.save_baseline(tmp_path / "b.json").read_text() for one in (outcome, other)]
        assert saved[0] == saved[1]


def test_an_outcome_returns_from_another_process(tmp_path: Path) -> None:
    path = tmp_path / "run.py"
    path.write_text(
        "import multiprocessing\n"
        "import ballrace\n"
        "def work(text):\n"
        "    return ballrace.Scene.from_toml(text).replay(ballrace.demonstration_recording())\n"
        "if __name__ == '__main__':\n"
        "    with multiprocessing.get_context('spawn').Pool(1) as pool:\n"
        "        print(pool.map(work, [ballrace.Scene.demonstration().text])[0].verdict)\n"
    )
    shown = subprocess.run([sys.executable, str(path)], capture_output=True, text=True, check=True)
    assert "Outer race of DE" in shown.stdout
