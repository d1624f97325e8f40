"""The extension module."""

from collections.abc import Iterable, Mapping
from typing import Any, Protocol, overload

import numpy as np
import numpy.typing as npt
import pandas
import polars

from .typing import Math, Model, Precision

Floats = npt.NDArray[np.float64]

class ArrowTable(Protocol):
    """A table of pyarrow, whose package has no types."""

    @property
    def column_names(self) -> list[str]: ...
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...

DisplacementLike = npt.ArrayLike | pandas.DataFrame | polars.DataFrame | ArrowTable | Mapping[str, Any]

VERSION: str

class Bearing:
    """A bearing of a scene; models are built at their first use and kept.

    Displacements are those of the inner ring against the outer ring: ``u, v, w`` (m), ``thu, thv`` (rad), an array or a list of shape
    (n, 5) or (5,), or a frame, a table or a dictionary with these columns; forces are then one too.
    """

    @property
    def name(self) -> str: ...
    @property
    def elements(self) -> int: ...
    @overload
    def force(
        self,
        u: npt.NDArray[np.float32],
        *,
        cage_angle: npt.ArrayLike | None = None,
        time: npt.ArrayLike | None = None,
        model: Model | None = None,
        precision: Precision | None = None,
        math: Math = "exact",
        out: None = None,
        status: npt.NDArray[np.uint8] | None = None,
    ) -> npt.NDArray[np.float32]: ...
    @overload
    def force(
        self,
        u: pandas.DataFrame,
        *,
        cage_angle: npt.ArrayLike | None = None,
        time: npt.ArrayLike | None = None,
        model: Model | None = None,
        precision: Precision | None = None,
        math: Math = "exact",
        out: None = None,
        status: npt.NDArray[np.uint8] | None = None,
    ) -> pandas.DataFrame: ...
    @overload
    def force(
        self,
        u: polars.DataFrame,
        *,
        cage_angle: npt.ArrayLike | None = None,
        time: npt.ArrayLike | None = None,
        model: Model | None = None,
        precision: Precision | None = None,
        math: Math = "exact",
        out: None = None,
        status: npt.NDArray[np.uint8] | None = None,
    ) -> polars.DataFrame: ...
    @overload
    def force(
        self,
        u: ArrowTable,
        *,
        cage_angle: npt.ArrayLike | None = None,
        time: npt.ArrayLike | None = None,
        model: Model | None = None,
        precision: Precision | None = None,
        math: Math = "exact",
        out: None = None,
        status: npt.NDArray[np.uint8] | None = None,
    ) -> Any: ...
    @overload
    def force(
        self,
        u: Mapping[str, Any],
        *,
        cage_angle: npt.ArrayLike | None = None,
        time: npt.ArrayLike | None = None,
        model: Model | None = None,
        precision: Precision | None = None,
        math: Math = "exact",
        out: None = None,
        status: npt.NDArray[np.uint8] | None = None,
    ) -> dict[str, Floats]: ...
    @overload
    def force(
        self,
        u: npt.ArrayLike,
        *,
        cage_angle: npt.ArrayLike | None = None,
        time: npt.ArrayLike | None = None,
        model: Model | None = None,
        precision: Precision | None = None,
        math: Math = "exact",
        out: Floats | None = None,
        status: npt.NDArray[np.uint8] | None = None,
    ) -> Floats: ...
    def stiffness(
        self,
        u: DisplacementLike,
        *,
        cage_angle: npt.ArrayLike | None = None,
        time: npt.ArrayLike | None = None,
        model: Model | None = None,
    ) -> Floats: ...
    def element_loads(
        self,
        u: DisplacementLike,
        *,
        cage_angle: npt.ArrayLike | None = None,
        time: npt.ArrayLike | None = None,
        model: Model | None = None,
    ) -> Floats: ...

class Outcome:
    def json(self) -> str: ...
    def html(self) -> str: ...
    def text(self) -> str: ...
    def baseline(self) -> str: ...

class Trade:
    @property
    def chosen(self) -> str | None: ...
    def json(self) -> str: ...
    def html(self) -> str: ...

class Scene:
    @staticmethod
    def read(path: str) -> Scene: ...
    @staticmethod
    def from_text(text: str, path: str) -> Scene: ...
    @property
    def text(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def path(self) -> str: ...
    @property
    def bearing_names(self) -> list[str]: ...
    @property
    def columns(self) -> list[str] | None: ...
    def with_value(self, key: str, value: str) -> Scene: ...
    def bearing(self, name: str | None = None) -> Bearing: ...
    def equilibrium(self, bearing: str | None = None, load: list[float] | None = None) -> tuple[str, str]: ...
    def campbell(self, speeds: str | Iterable[float | str]) -> str: ...
    def simulate(
        self, duration: float | str, rate: float | str, settle: float | str | None = None
    ) -> tuple[list[str], Floats]: ...
    def sweep(
        self,
        over: list[str],
        settle: float | str | None = None,
        periods: int = 96,
        by_shaft: bool = False,
        follow: str = "none",
        lyapunov: bool = False,
        jobs: int | None = None,
    ) -> tuple[str, str]: ...
    def trade(
        self,
        error: float | None = None,
        deadline: float | str | None = None,
        clock: float | str | None = None,
        on: str = "cortex-m4f",
        forces_only: bool = False,
    ) -> Trade: ...
    def balance(
        self, runs: list[str], trials: list[tuple[str, str]], planes: list[str], grade: float | None = None
    ) -> tuple[str, str]: ...
    def fit(self, recording: Any, only: list[str] | None = None, turns: float = 64.0) -> tuple[str, str]: ...
    def replay(
        self,
        recording: Any,
        baseline: str | None = None,
        learn: bool = False,
        error: float | None = None,
        forces: str | None = None,
        force_source: str = "observer",
        force: bool = False,
    ) -> Outcome: ...

def read_machines(path: str) -> list[str]: ...
def machines(file: str, columns: list[str], rows: list[list[str]]) -> list[str]: ...
def evaluate(machine: str, with_report: bool, force_error: float | None = None) -> tuple[str, str | None]: ...
def failed(machine: str, error: str) -> str: ...
def trends(rows: list[str]) -> str: ...
def rows_as_parquet(rows: list[str]) -> bytes: ...

class Fleet:
    def __init__(self, name: str, machines: list[str], output: str) -> None: ...
    @property
    def index(self) -> str: ...
    def missing(self, with_report: bool) -> list[int]: ...
    def add(self, row: str, page: str | None) -> None: ...
    def close(self) -> None: ...
    def finish(self) -> None: ...
    def rows(self) -> list[str]: ...
