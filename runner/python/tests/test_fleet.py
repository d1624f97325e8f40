"""Fleets on one process and on Dask workers, one of which is killed."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import dask
import numpy as np
import pandas
import pyarrow
import pyarrow.parquet
import pytest
from distributed import Client, LocalCluster, Worker, WorkerPlugin

import ballrace
import ballrace.fleet
from ballrace import _native

COUNT = 10


@pytest.fixture(scope="module")
def machines(tmp_path_factory: pytest.TempPathFactory, scene: ballrace.Scene, recording: dict[str, np.ndarray]) -> Path:
    """A table of machines: sound ones, damaged ones, one without a recording, one with a wrong scene."""
    folder = tmp_path_factory.mktemp("plant")
    healthy = pandas.read_csv(scene.path.parent / "healthy.csv")
    (folder / "rig.toml").write_text(scene.text)
    (folder / "wrong.toml").write_text(scene.text.replace("3000 rpm", "3000 kg"))
    healthy[:3200].to_parquet(folder / "healthy.parquet")
    pandas.DataFrame(recording)[:6400].to_parquet(folder / "spall.parquet")
    rows = []
    for i in range(COUNT):
        row = {"machine": f"pump {i}", "scene": "rig.toml", "recording": "healthy.parquet", "hall": "A"}
        if i == 1:
            row["recording"] = "spall.parquet"
        if i == 7:
            row["recording"] = "missing.parquet"
        if i == 8:
            row["scene"] = "wrong.toml"
        rows.append(row)
    table = folder / "machines.csv"
    pandas.DataFrame(rows).to_csv(table, index=False)
    return table


@pytest.fixture(scope="module")
def single(machines: Path, tmp_path_factory: pytest.TempPathFactory) -> ballrace.fleet.Result:
    return ballrace.fleet.replay(machines, tmp_path_factory.mktemp("single"), workers=0)


def _rows(result: ballrace.fleet.Result) -> list[str]:
    return [json.dumps(row.to_dict(), sort_keys=True) for row in result.rows]


def test_states_and_errors_are_values(single: ballrace.fleet.Result) -> None:
    states = {row.machine: row.state for row in single.rows}
    assert len(single.rows) == COUNT == single.evaluated
    assert states["pump 0"] == "normal" and states["pump 1"] == "fault"
    assert states["pump 7"] == states["pump 8"] == "error"
    errors = {row.machine: row.error for row in single.rows if row.error}
    assert "missing.parquet" in errors["pump 7"] and "shaft.speed" in errors["pump 8"]
    spall = next(row for row in single.rows if row.machine == "pump 1").diagnoses[0]
    assert (spall.fault, spall.bearing, spall.size_unit) == ("outer-race", "DE", "um")
    table = single.to_arrow()
    assert table.num_rows == COUNT and table.schema == ballrace.fleet.schema()
    assert "pump 7" in single.to_html()


def test_a_second_call_evaluates_nothing(machines: Path, tmp_path: Path) -> None:
    few = pandas.read_csv(machines)[:3]
    folder = machines.parent
    assert ballrace.fleet.replay(few, tmp_path / "o", workers=0, folder=folder).evaluated == 3
    assert ballrace.fleet.replay(few, tmp_path / "o", workers=0, folder=folder).evaluated == 0
    more = pandas.read_csv(machines)[:4]
    assert ballrace.fleet.replay(more, tmp_path / "o", workers=0, folder=folder).evaluated == 1


@pytest.mark.cluster
def test_two_workers_of_which_one_is_killed(
    machines: Path, single: ballrace.fleet.Result, tmp_path: Path
) -> None:
    with (
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        killed: list[int] = []

        def kill(finished: int, total: int) -> None:
            if finished >= 3 and not killed:
                killed.append(next(iter(client.run(os.getpid).values())))
                os.kill(killed[0], signal.SIGKILL)

        result = ballrace.fleet.replay(machines, tmp_path / "o", client, progress=kill)
    assert killed
    assert _rows(result) == _rows(single)
    parts = pyarrow.parquet.read_table(tmp_path / "o" / "outcomes")
    assert parts.num_rows == COUNT and len(set(parts["machine"].to_pylist())) == COUNT


class Deadly(WorkerPlugin):
    """Ends each worker that evaluates the machine ``pump 2``."""

    def setup(self, worker: Worker) -> None:
        import os
        import time

        from ballrace import _native

        evaluate = _native.evaluate

        def deadly(machine: str, *others: object) -> object:
            if '"pump 2"' in machine:
                # In the middle of its work: Dask gives up a worker that ends while it is started.
                time.sleep(3)
                os._exit(3)
            return evaluate(machine, *others)  # type: ignore[arg-type]

        _native.evaluate = deadly  # type: ignore[assignment]


@pytest.mark.cluster
def test_a_machine_that_ends_its_workers_is_an_error(
    machines: Path, single: ballrace.fleet.Result, tmp_path: Path
) -> None:
    few = pandas.read_csv(machines)[:5]
    # One worker holds the next machine ready while "pump 2" runs, so each of its ends strikes both.
    with (
        dask.config.set(ballrace.fleet._KEEP_WORKERS),
        LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        client.register_plugin(Deadly())
        result = ballrace.fleet.replay(few, tmp_path / "o", client, folder=machines.parent)
    rows = {row.machine: row for row in result.rows}
    assert rows["pump 2"].state == "error" and "its worker ended" in rows["pump 2"].error
    others = [i for i in range(5) if i != 2]
    assert [_rows(result)[i] for i in others] == [_rows(single)[i] for i in others]


@pytest.mark.cluster
def test_a_cluster_without_workers_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ballrace.fleet, "_LOOK_S", 0.2)
    monkeypatch.setattr(ballrace.fleet, "_WITHOUT_WORKER_S", 2)
    with LocalCluster(n_workers=0, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        with pytest.raises(RuntimeError, match="no worker for a minute"):
            ballrace.fleet._result_alone(client, client.submit(time.sleep, 0))
        # A worker that comes, and a machine that takes longer than a cluster may be without workers.
        cluster.scale(1)
        client.wait_for_workers(1)
        monkeypatch.setattr(ballrace.fleet, "_WITHOUT_WORKER_S", 2)
        ballrace.fleet._result_alone(client, client.submit(time.sleep, 3))


def test_a_folder_has_one_writer(machines: Path, tmp_path: Path) -> None:
    few = pandas.read_csv(machines)[:2]

    def second(finished: int, total: int) -> None:
        if finished == 1:
            with pytest.raises(ballrace.Error, match=f"in use by process {os.getpid()}"):
                ballrace.fleet.replay(few, tmp_path / "o", workers=0, folder=machines.parent)

    result = ballrace.fleet.replay(few, tmp_path / "o", workers=0, folder=machines.parent, progress=second)
    assert result.evaluated == 2


def test_a_run_that_is_killed_goes_on(machines: Path, single: ballrace.fleet.Result, tmp_path: Path) -> None:
    # Outcomes are written every two seconds: a run takes several times as long.
    few = pandas.read_csv(machines)
    halls = [f" of hall {i}" for i in range(3)]
    many = machines.parent / "many.csv"
    pandas.concat([few.assign(machine=few["machine"] + hall) for hall in halls]).to_csv(many, index=False)
    program = f"import ballrace.fleet; ballrace.fleet.replay({str(many)!r}, 'o', workers=0)"
    process = subprocess.Popen([sys.executable, "-c", program], cwd=tmp_path)
    outcomes = tmp_path / "o" / "outcomes"
    deadline = time.monotonic() + 600
    while not list(outcomes.glob("part-*.parquet")) and time.monotonic() < deadline:
        time.sleep(0.02)
    process.kill()
    process.wait()
    result = ballrace.fleet.replay(many, tmp_path / "o", workers=0)
    assert 0 < result.evaluated < len(halls) * COUNT
    rows = [row.to_dict() for _ in halls for row in single.rows]
    expected = [{**row, "machine": row["machine"] + halls[i // COUNT]} for i, row in enumerate(rows)]
    assert _rows(result) == [json.dumps(row, sort_keys=True) for row in expected]


def test_batches_are_a_plain_arrow_function(machines: Path, single: ballrace.fleet.Result) -> None:
    table = pyarrow.Table.from_pandas(pandas.read_csv(machines)[:4])
    batches = list(ballrace.fleet.replay_batches(table.to_batches(max_chunksize=2), folder=machines.parent))
    found = pyarrow.Table.from_batches(batches)
    assert found.schema == ballrace.fleet.schema()
    assert found.equals(single.to_arrow().slice(0, 4))


def test_the_command_line_gives_the_same(
    program: Path, machines: Path, single: ballrace.fleet.Result, tmp_path: Path
) -> None:
    run = [str(program), "fleet", str(machines), "-o", "o", "--format", "json", "--no-report"]
    answer = subprocess.run(run, cwd=tmp_path, capture_output=True, check=False, text=True)
    rows = [json.dumps(row, sort_keys=True) for row in json.loads(answer.stdout)]
    assert rows == _rows(single)


def test_trends(scene: ballrace.Scene, tmp_path: Path) -> None:
    limited = scene.text + '\n[[limit]]\nindicator = "1X"\nmax = "0.5 um"\n'
    (tmp_path / "rig.toml").write_text(limited)
    healthy = pandas.read_csv(scene.path.parent / "healthy.csv")[:3200]
    turns = 2 * np.pi * 50.0 * np.arange(3200) / 12800.0
    table = []
    for day in range(1, 5):
        grown = healthy.copy()
        for column, phase in (("DE_X_um", 0.0), ("DE_Y_um", np.pi / 2), ("NDE_X_um", 0.0), ("NDE_Y_um", np.pi / 2)):
            grown[column] += 0.05 * day * np.cos(turns - phase)
        grown.to_parquet(tmp_path / f"{day}.parquet")
        time_ = pandas.Timestamp(2026, 3, day)
        table.append({"machine": "pump", "scene": "rig.toml", "recording": f"{day}.parquet", "time": time_})
    result = ballrace.fleet.replay(pandas.DataFrame(table), tmp_path / "o", workers=0, folder=tmp_path)
    trend = next(t for t in result.trends if t.quantity.name == "1X" and t.quantity.probe == "NDE_X_um")
    assert abs(trend.slope_per_day - 0.05) < 0.005
    assert trend.crosses_on is not None or trend.crossed_on is not None


def test_wrong_tables(tmp_path: Path) -> None:
    replay = ballrace.fleet.replay
    with pytest.raises(ballrace.InputError, match='missing column "scene"'):
        replay({"machine": ["a"]}, tmp_path / "o")
    with pytest.raises(ballrace.InputError, match="one length"):
        replay({"machine": ["a"], "scene": []}, tmp_path / "o")
    with pytest.raises(ballrace.InputError, match="repeated machine"):
        replay({"machine": ["a", "a"], "scene": ["x.toml", "y.toml"]}, tmp_path / "o")
    with pytest.raises(ballrace.InputError, match="column time"):
        replay({"machine": ["a"], "scene": ["x.toml"], "time": ["monday"]}, tmp_path / "o")
    with pytest.raises(ballrace.InputError, match="machines: int"):
        replay(3, tmp_path / "o")


def test_many_machines_keep_the_memory_flat(machines: Path) -> None:
    """Peak memory of a worker after 13 machines is that after 3, within 20 MB."""
    import resource

    rows = pandas.read_csv(machines)[:1]
    _, one = ballrace.fleet._encoded(rows, machines.parent)

    def peak_mb() -> float:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024

    for _ in range(3):
        _native.evaluate(one[0], True)
    first = peak_mb()
    for _ in range(10):
        _native.evaluate(one[0], True)
    assert peak_mb() - first < 20


def test_threads_evaluate_at_the_same_time(machines: Path) -> None:
    """The interpreter is free while a machine is evaluated."""
    rows = pandas.read_csv(machines)[:1]
    _, one = ballrace.fleet._encoded(rows, machines.parent)
    thread = threading.Thread(target=_native.evaluate, args=(one[0], False))
    thread.start()
    ticks = 0
    while thread.is_alive():
        ticks += 1
        time.sleep(0.001)
    assert ticks > 5
