"""Evaluation of a table of machines, on one computer or on a Dask cluster.

A row of the table is a machine with one of its recordings. Columns ``machine`` and ``scene`` (a file, or the text of a scene)
are required; ``recording``, ``baseline`` and ``time`` (ISO 8601) are optional; every other column is a tag. An error of one
machine is a row of the result and never stops the others.

Examples
--------
>>> import ballrace, ballrace.fleet
>>> scene = ballrace.Scene.demonstration()
>>> machines = {"machine": ["pump 1", "pump 2"], "scene": [str(scene.path), "missing.toml"]}
>>> result = ballrace.fleet.replay(machines, "results", workers=0)
>>> [(row.machine, row.state) for row in result.rows]
[('pump 1', 'normal'), ('pump 2', 'error')]
"""

from __future__ import annotations

import asyncio
import contextlib
import datetime
import json
import os
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union

from . import _native
from ._errors import InputError
from ._tables import Floats, Page, Record, Table, columns_of

if TYPE_CHECKING:
    import pyarrow
    from distributed import Client

#: A path of a CSV or Parquet file, or a table in memory.
Machines = Union[str, "os.PathLike[str]", Mapping[str, Sequence[Any]], Any]

#: Seconds between looks at the workers of a cluster, and without a worker after which a machine is given up.
_LOOK_S, _WITHOUT_WORKER_S = 5, 60

#: A local cluster gives a worker up for good that happens to start again 15 s after it ended for the first time.
_KEEP_WORKERS = {"distributed.deploy.lost-worker-timeout": "1h"}

#: Largest number of machines that one task evaluates: a task that is lost with its worker is evaluated again.
_MOST_PER_TASK = 8


class Result(Table, Page):
    """Outcomes of a fleet.

    Attributes
    ----------
    rows : list of Record
        One row for each machine and recording, in the order of the table.
    trends : list of Record
        Slope of each indicator and diagnosed size over the recordings of a machine, and the time at which its limit was or will
        be crossed.
    evaluated : int
        Number of rows that this call has evaluated; the others are of an earlier call.
    index : pathlib.Path
        The overview, an HTML page.
    """

    def __init__(self, rows: list[str], evaluated: int, index: Path) -> None:
        self._json = rows
        self.rows = [Record(json.loads(row)) for row in rows]
        self.trends = [Record(trend) for trend in json.loads(_native.trends(rows))]
        self.evaluated = evaluated
        self.index = index

    def to_dict(self) -> dict[str, Any]:
        """Return rows and trends as plain dictionaries, lists and numbers."""
        return {"rows": [row.to_dict() for row in self.rows], "trends": [trend.to_dict() for trend in self.trends]}

    def columns(self) -> dict[str, Sequence[Any] | Floats]:
        """Return the columns of the rows."""
        return columns_of([row.to_dict() for row in self.rows])

    def to_arrow(self) -> pyarrow.Table:
        """Return the rows as a ``pyarrow.Table`` with the columns of the Parquet files."""
        return _as_arrow(self._json)

    def to_html(self) -> str:
        """Return the overview as one self-contained page."""
        return self.index.read_text(encoding="utf-8")

    def __repr__(self) -> str:
        states = [row.state for row in self.rows]
        counts = ", ".join(f"{states.count(state)} {state}" for state in dict.fromkeys(states))
        return f"Result({len(states)} rows: {counts})"


def replay(
    machines: Machines,
    output: str | os.PathLike[str],
    client: Client | None = None,
    *,
    workers: int | None = None,
    reports: bool = False,
    error: float | None = None,
    folder: str | os.PathLike[str] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Result:
    """Replay the recordings of many machines.

    Rows are written to ``output/outcomes/part-*.parquet`` during the evaluation. A second call evaluates only rows that are missing
    or whose scene, recording or baseline has changed. The machines of a worker that ends are evaluated again; each row is written
    once.

    Parameters
    ----------
    machines : path or table
        A CSV or Parquet file, a dictionary of lists, a pandas or polars frame, an Arrow table.
    output : path
        Folder of the results: outcomes, reports, ``trends.csv``, ``index.html``.
    client : distributed.Client, optional
        A Dask cluster, whose workers have access to the same files.
    workers : int, optional
        Without a client: number of processes of a cluster on this computer, by default the number of processors; 0 evaluates in
        this process.
    reports : bool
        Write an HTML report of each machine.
    error : float, optional
        Acceptable relative error of the force.
    folder : path, optional
        Folder from which relative paths of a table in memory start; the working directory by default.
    progress : callable, optional
        Called with the number of finished rows and of all rows.

    Returns
    -------
    Result

    Raises
    ------
    InputError
        A wrong table, with its row and column.
    """
    name, encoded = _encoded(machines, folder)
    fleet = _native.Fleet(name, encoded, os.fspath(output))
    try:
        missing = fleet.missing(reports)
        finished = len(encoded) - len(missing)
        if progress is not None:
            progress(finished, len(encoded))
        todo = [encoded[i] for i in missing]
        for row, page in _evaluated(todo, client, workers, reports, error):
            fleet.add(row, page)
            finished += 1
            if progress is not None:
                progress(finished, len(encoded))
        fleet.finish()
    finally:
        fleet.close()
    return Result(fleet.rows(), len(missing), Path(fleet.index))


def replay_batches(
    batches: Iterable[pyarrow.RecordBatch],
    *,
    error: float | None = None,
    folder: str | os.PathLike[str] | None = None,
) -> Iterator[pyarrow.RecordBatch]:
    """Evaluate batches of machines, for ``mapInArrow`` of Spark, ``map_batches`` of Ray and others.

    Parameters
    ----------
    batches : iterable of pyarrow.RecordBatch
        Rows of machines with the columns of :func:`replay`.
    error : float, optional
        Acceptable relative error of the force.
    folder : path, optional
        Folder from which relative paths start; the working directory by default.

    Yields
    ------
    pyarrow.RecordBatch
        One row for each machine, with the columns of ``outcomes/part-*.parquet`` (:func:`schema`).
    """
    for batch in batches:
        if batch.num_rows == 0:
            continue
        _, machines = _encoded(batch, folder)
        rows = [_native.evaluate(machine, False, error)[0] for machine in machines]
        yield from _as_arrow(rows).to_batches()


def schema() -> pyarrow.Schema:
    """Return the schema of the table of outcomes."""
    return _as_arrow([]).schema


def _as_arrow(rows: list[str]) -> pyarrow.Table:
    import pyarrow
    import pyarrow.parquet

    return pyarrow.parquet.read_table(pyarrow.BufferReader(_native.rows_as_parquet(rows)))


def _encoded(machines: Machines, folder: str | os.PathLike[str] | None) -> tuple[str, list[str]]:
    """Return the name of the table and its machines, each as JSON."""
    if isinstance(machines, (str, os.PathLike)):
        path = Path(machines)
        return path.name, _native.read_machines(os.fspath(path.absolute()))
    columns, rows = _cells(machines)
    file = Path.cwd() if folder is None else Path(folder).absolute()
    return "machines", _native.machines(os.fspath(file / "machines"), columns, rows)


def _cells(table: Any) -> tuple[list[str], list[list[str]]]:
    """Return names and cells of a table in memory."""
    if isinstance(table, Mapping):
        columns = {str(name): list(values) for name, values in table.items()}
    elif hasattr(table, "to_pylist") and hasattr(table, "column"):  # pyarrow
        columns = {str(name): table.column(name).to_pylist() for name in table.schema.names}
    elif hasattr(table, "columns"):  # pandas, polars
        columns = {str(name): list(table[name]) for name in table.columns}
    else:
        raise InputError(f"machines: {type(table).__name__}, expected a path, a dictionary of lists or a table")
    lengths = {name: len(values) for name, values in columns.items()}
    if len(set(lengths.values())) > 1:
        raise InputError(f"machines: columns of lengths {lengths}, expected one length")
    rows = [[_text(value) for value in row] for row in zip(*columns.values())]
    return list(columns), rows


def _text(value: Any) -> str:
    if value is None or value != value:  # NaN and NaT are not equal to themselves.
        return ""
    if isinstance(value, (datetime.date, datetime.datetime)):
        return value.isoformat()
    return str(value)


Evaluated = tuple[str, Union[str, None]]


def _evaluate_task(machines: list[str], reports: bool, error: float | None) -> list[Evaluated]:
    """Evaluate some machines; runs in a worker."""
    return [_native.evaluate(machine, reports, error) for machine in machines]


def _evaluated(
    machines: list[str], client: Client | None, workers: int | None, reports: bool, error: float | None
) -> Iterator[Evaluated]:
    """Evaluate machines in any order."""
    if not machines:
        return
    if client is not None:
        yield from _on_cluster(client, machines, reports, error)
    elif workers == 0:
        for machine in machines:
            yield _native.evaluate(machine, reports, error)
    else:
        try:
            import dask
            from distributed import Client, LocalCluster
        except ImportError as cause:
            message = "fleet: the package distributed is missing: pip install 'ballrace[fleet]', or workers=0"
            raise InputError(message) from cause
        count = workers or os.cpu_count() or 1
        with (
            dask.config.set(_KEEP_WORKERS),
            LocalCluster(n_workers=count, threads_per_worker=1, dashboard_address=None) as cluster,
            Client(cluster) as own,
        ):
            yield from _on_cluster(own, machines, reports, error)
            _wait_for_workers(own, count)


def _wait_for_workers(client: Client, count: int) -> None:
    """Wait until workers that ended are there again: a cluster that is closed while it starts one raises."""
    with contextlib.suppress(TimeoutError, asyncio.TimeoutError):
        client.wait_for_workers(count, timeout=20)


def _result_alone(client: Client, task: Any) -> list[Evaluated]:
    """Return the result of the only task. Dask does not start a worker again that ended while it was started."""
    from distributed import wait

    last_worker = time.monotonic()
    while not task.done():
        with contextlib.suppress(TimeoutError, asyncio.TimeoutError):
            wait(task, timeout=_LOOK_S)
        if client.nthreads():
            last_worker = time.monotonic()
        elif time.monotonic() - last_worker > _WITHOUT_WORKER_S:
            raise RuntimeError("the cluster has had no worker for a minute")
    result: list[Evaluated] = task.result()
    return result


def _on_cluster(client: Client, machines: list[str], reports: bool, error: float | None) -> Iterator[Evaluated]:
    """Evaluate machines on a Dask cluster, task by task as they finish."""
    from distributed import KilledWorker, as_completed

    workers = len(client.nthreads())
    slots = max(1, sum(client.nthreads().values()))
    size = max(1, min(_MOST_PER_TASK, len(machines) // (4 * slots)))
    parts = [machines[i : i + size] for i in range(0, len(machines), size)]

    def submit(part: list[str]) -> Any:
        return client.submit(_evaluate_task, part, reports, error, pure=False)

    def failed(machine: str, reason: str) -> Evaluated:
        return _native.failed(machine, f"the machine could not be evaluated: {reason}"), None

    tasks = {submit(part): part for part in parts}
    done = as_completed(list(tasks))
    suspects: list[str] = []
    for task in done:
        part = tasks.pop(task)
        try:
            yield from task.result()
        except Exception as cause:  # Every exception of a task is an error of its machines.
            if len(part) > 1:
                # The machines are evaluated one by one, so that one that ends its worker does not affect the others.
                for machine in part:
                    single = submit([machine])
                    tasks[single] = [machine]
                    done.add(single)
            elif isinstance(cause, KilledWorker):
                suspects += part
            else:
                yield failed(part[0], repr(cause))
        task.release()
    # Dask also counts a lost worker against tasks that waited on it. A machine that runs alone is the cause itself.
    for machine in suspects:
        task = submit([machine])
        try:
            yield from _result_alone(client, task)
        except KilledWorker:
            _wait_for_workers(client, workers)
            yield failed(machine, "its worker ended several times")
        except Exception as cause:
            yield failed(machine, repr(cause))
        task.release()
