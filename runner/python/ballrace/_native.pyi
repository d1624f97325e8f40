"""The extension module."""

from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

VERSION: str

class Bearing:
    """A bearing of a scene; models are built at their first use and kept.

    Displacements are those of the inner ring against the outer ring: ``u, v, w`` (m), ``thu, thv`` (rad), an array of shape
    (n, 5) or (5,).
    """

    @property
    def name(self) -> str: ...
    @property
    def elements(self) -> int: ...
    def force(
        self,
        u: Floats,
        *,
        cage_angle: float | Floats | None = None,
        time: float | Floats | None = None,
        model: str | None = None,
        precision: str = "f64",
        math: str = "exact",
        out: Floats | None = None,
        status: npt.NDArray[np.uint8] | None = None,
    ) -> Floats: ...
    def stiffness(
        self,
        u: Floats,
        *,
        cage_angle: float | Floats | None = None,
        time: float | Floats | None = None,
        model: str | None = None,
    ) -> Floats: ...
    def element_loads(
        self,
        u: Floats,
        *,
        cage_angle: float | Floats | None = None,
        time: float | Floats | None = None,
        model: str | None = None,
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
    ) -> tuple[list[str], Floats, int]: ...
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
    def fit(self, recording: Any, only: list[str] | None = None, turns: float = 64.0) -> tuple[str, str]: ...
    def replay(
        self,
        recording: Any,
        baseline: str | None = None,
        learn: bool = False,
        error: float | None = None,
        forces: str | None = None,
        force_source: str = "observer",
    ) -> Outcome: ...
