"""Scenes of rotating machines and the studies on them."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _native
from ._balance import options_of
from ._recording import RecordingLike, columns
from ._results import Balance, Campbell, Equilibrium, Fit, Outcome, Sweep, Trade
from ._series import Motion
from .typing import ByPlane, FitGroup, Follow, ForceSource, Holes, Quantity, Section, Stock, Target
from .typing import Path as Path_

#: Folder of the built-in scene and its recordings.
_DEMONSTRATION = Path(__file__).parent / "demonstration"


class Scene:
    """A machine: shaft, rotor, bearings, probes. Scenes do not change; :meth:`with_value` returns another one.

    Examples
    --------
    >>> import ballrace
    >>> scene = ballrace.Scene.demonstration()
    >>> scene.bearing_names
    ['DE', 'NDE']
    >>> scene.with_value("bearing.DE.diametral_clearance", "12 um").bearing("DE")
    <ballrace.Bearing DE: angular, 9 elements>
    """

    def __init__(self, native: _native.Scene) -> None:
        self._native = native

    @classmethod
    def read(cls, path: Path_) -> Scene:
        """Read a scene file.

        Raises
        ------
        SceneError
            The first error in the file, with file, line, key, found and expected value.
        """
        return cls(_native.Scene.read(os.fspath(path)))

    @classmethod
    def from_toml(cls, text: str, path: Path_ = "scene.toml") -> Scene:
        """Read a scene from its text; relative paths in it start from the folder of ``path``.

        Raises
        ------
        SceneError
            The first error in the text.
        """
        return cls(_native.Scene.from_text(text, os.fspath(path)))

    @classmethod
    def demonstration(cls) -> Scene:
        """Return the built-in scene: a rotor of 6 kg on two deep-groove bearings with five displacement probes."""
        return cls.read(_DEMONSTRATION / "healthy.toml")

    def with_value(self, key: str, value: Any) -> Scene:
        """Return the scene with another value at a key.

        Parameters
        ----------
        key : str
            Such as ``shaft.speed``, ``bearing.DE.diametral_clearance``, ``rotor.load[1]``.
        value : float, str, bool, list or dict
            The value as a scene writes it, with its unit.

        Examples
        --------
        >>> import ballrace
        >>> ballrace.Scene.demonstration().with_value("shaft.speed", "50 furlong")
        Traceback (most recent call last):
        ...
        ballrace._errors.SceneError: ...healthy.toml:...: shaft.speed: ...
        """
        return Scene(self._native.with_value(key, json.dumps(value)))

    @property
    def name(self) -> str:
        """Name of the scene."""
        return self._native.name

    @property
    def path(self) -> Path:
        """Path of the scene file."""
        return Path(self._native.path)

    @property
    def text(self) -> str:
        """Text of the scene (TOML)."""
        return self._native.text

    @property
    def bearing_names(self) -> list[str]:
        """Names of the bearings."""
        return self._native.bearing_names

    def bearing(self, name: str | None = None) -> _native.Bearing:
        """Return a bearing by its name, which may be omitted where there is only one.

        Examples
        --------
        >>> import ballrace, numpy as np
        >>> bearing = ballrace.Scene.demonstration().bearing("DE")
        >>> force = bearing.force(np.array([10e-6, -20e-6, 0.0, 0.0, 0.0]), cage_angle=0.1)
        >>> force.shape
        (5,)
        """
        return self._native.bearing(name)

    def equilibrium(
        self, bearing: str | None = None, load: Sequence[float] | None = None, thermal: bool = False
    ) -> Equilibrium:
        """Compute the static equilibrium of the rotor, or of one bearing under a load.

        Parameters
        ----------
        bearing : str, optional
            Name of a bearing to be solved alone.
        load : sequence of five numbers, optional
            FX, FY, FZ (N), MX, MY (N m) on its inner ring.
        thermal : bool
            At the temperatures that friction and ``cooling`` of the scene keep, instead of those of the scene.

        Examples
        --------
        >>> import ballrace
        >>> rest = ballrace.Scene.demonstration().equilibrium()
        >>> round(rest.force_n_nm[1], 1)
        58.8
        """
        text, page = self._native.equilibrium(bearing, None if load is None else [float(x) for x in load], thermal)
        return Equilibrium(json.loads(text), page)

    def balance(
        self,
        runs: Path_ | Sequence[Path_],
        trials: Mapping[Path_, str] | None = None,
        planes: Sequence[str] = (),
        grade: float | None = None,
        *,
        trims: Mapping[Path_, str] | None = None,
        holes: Holes | None = None,
        radius: ByPlane | None = None,
        stock: Stock = (),
        weights: int = 2,
        hole_limit: ByPlane | None = None,
        taken: Sequence[str] = (),
        remove: bool = False,
        replace: bool = False,
        mass: Quantity | None = None,
        service_speed: Quantity | None = None,
    ) -> Balance:
        """Balance the rotor from recordings of runs without and with trial masses.

        Parameters
        ----------
        runs : path or sequence of paths
            Recordings of the rotor without added masses.
        trials : mapping, optional
            Masses of each trial by its recording: ``{"trial.csv": "20 mm 60 g mm at 90 deg"}``. A plane is the name of a bearing or
            a station; angles count from the keyphasor mark in the direction of positive rotation. Without trials the
            coefficients are those of the twin.
        planes : sequence of str, optional
            Planes of the correction; those of the trials, else of the scene, where it is empty.
        grade : float, optional
            Balance quality grade of ISO 21940-11 that is asked for, such as 2.5.
        trims : mapping, optional
            Masses of each trim run, which stay mounted, as those of trials; the correction is that of the rotor with the last ones.
        holes, radius, stock, weights, hole_limit, taken, remove, replace, mass, service_speed : optional
            Holes, weights and quality as in :func:`ballrace.balance`.

        Examples
        --------
        >>> import ballrace
        >>> scene = ballrace.Scene.demonstration()
        >>> found = scene.balance(scene.path.parent / "healthy.csv")
        >>> found.correction.planes[0].plane
        '20 mm'
        """
        all_runs = [runs] if isinstance(runs, (str, os.PathLike)) else list(runs)
        of_trials, of_trims = ([(os.fspath(file), masses) for file, masses in (given or {}).items()] for given in (trials, trims))
        options = options_of(
            holes=holes,
            radius=radius,
            stock=stock,
            weights=weights,
            hole_limit=hole_limit,
            taken=taken,
            remove=remove,
            replace=replace,
            grade=grade,
            mass=mass,
            service_speed=service_speed,
        )
        text, page = self._native.balance([os.fspath(run) for run in all_runs], of_trials, of_trims, list(planes), options)
        return Balance(json.loads(text), page)

    def campbell(self, speeds: str | Iterable[Quantity] = "0rpm..30000rpm:31") -> Campbell:
        """Compute natural frequencies, damping and whirl over the shaft speed.

        Parameters
        ----------
        speeds : str or iterable
            A range such as ``"0rpm..30000rpm:31"``, or speeds as text with a unit or numbers in rad/s.
        """
        given = speeds if isinstance(speeds, str) else [s if isinstance(s, str) else float(s) for s in speeds]
        return Campbell(json.loads(self._native.campbell(given)))

    def simulate(self, duration: Quantity, rate: Quantity, settle: Quantity | None = None) -> Motion:
        """Simulate the motion of the rotor from its static equilibrium.

        Parameters
        ----------
        duration, settle : float or str
            Time in s or with a unit; ``settle`` is simulated first and omitted.
        rate : float or str
            Samples per second, in Hz or with a unit.

        Examples
        --------
        >>> import ballrace
        >>> motion = ballrace.Scene.demonstration().simulate("0.02 s", "12.8 kHz")
        >>> motion["v"].shape
        (256,)
        """
        names, values = self._native.simulate(duration, rate, settle)
        return Motion(names, values)

    def sweep(
        self,
        over: Mapping[str, str | Iterable[Quantity]],
        *,
        settle: Quantity | None = None,
        periods: int = 96,
        section: Section = "ball-pass",
        follow: Follow = "none",
        lyapunov: bool = False,
        jobs: int | None = None,
    ) -> Sweep:
        """Simulate the scene over ranges of its keys, in parallel.

        Parameters
        ----------
        over : mapping
            Key to values: a range such as ``"500rpm..10000rpm:200"`` or a list; the first key varies fastest.
        settle : float or str, optional
            Transient at each point, s; by default from the rotor's damping, longer until it has died out.
        periods : int
            Section periods measured at each point.
        section : {"ball-pass", "shaft"}
            Event at which the Poincare section is taken.
        follow : {"none", "up", "down", "both"}
            Whether each point starts from the final state of its neighbour.
        lyapunov : bool
            Whether the largest Lyapunov exponent is computed.
        jobs : int, optional
            Points computed in parallel; all processors by default.
        """
        if section not in ("ball-pass", "shaft"):
            raise ValueError(f'section: {section!r}, expected "ball-pass" or "shaft"')
        axes = [
            f"{key}={values if isinstance(values, str) else ','.join(str(value) for value in values)}"
            for key, values in over.items()
        ]
        rows, page = self._native.sweep(axes, settle, periods, section == "shaft", follow, lyapunov, jobs)
        return Sweep(json.loads(rows), page)

    def trade(
        self,
        *,
        error: float | None = None,
        deadline: Quantity | None = None,
        clock: Quantity | None = None,
        on: Target = "cortex-m4f",
        forces_only: bool = False,
    ) -> Trade:
        """Compare error and cost of every model, precision, integrator and step on the scene's own motion.

        Parameters
        ----------
        error : float, optional
            Choose the cheapest model within this relative error of the force.
        deadline, clock : float or str, optional
            Choose the most accurate model within this time at this clock frequency.
        on : {"cortex-m4f", "desktop"}
            Processor whose cost ``error`` minimises.
        forces_only : bool
            Leave out simulated motions, which take most of the time.
        """
        native = self._native.trade(error, deadline, clock, on, forces_only)
        return Trade(native, json.loads(native.json()))

    def fit(
        self, recording: RecordingLike | None = None, *, only: Sequence[FitGroup] | None = None, turns: float = 64.0
    ) -> Fit:
        """Estimate unbalance, clearance, damping, stiffness and offsets from a recording.

        Parameters
        ----------
        recording : path or table, optional
            As for :meth:`replay`.
        only : sequence of str, optional
            Groups among ``unbalance``, ``clearance``, ``damping``, ``stiffness``, ``offset``; all by default.
        turns : float
            Revolutions used, from the start of the recording.
        """
        source = columns(recording, self._native.columns)
        text, scene_text = self._native.fit(source, None if only is None else list(only), float(turns))
        return Fit(json.loads(text), scene_text)

    def replay(
        self,
        recording: RecordingLike | None = None,
        baseline: Path_ | None = None,
        *,
        learn: bool = False,
        error: float | None = None,
        forces: Path_ | None = None,
        force_source: ForceSource = "observer",
        force: bool = False,
        samples: bool = False,
    ) -> Outcome:
        """Compare a recording with the digital twin and diagnose the machine.

        Parameters
        ----------
        recording : path or table, optional
            A file in any format of the command line, or columns in memory: a dictionary of arrays, a structured array, a
            pandas or polars frame, an Arrow table. By default the file that the scene names.
        baseline : path, optional
            Baseline with which the recording is compared.
        learn : bool
            Learn a baseline from a recording of the healthy machine (:meth:`Outcome.save_baseline`).
        error : float, optional
            Acceptable relative error of the force.
        forces : path, optional
            CSV file for the force of every bearing at every sample.
        force_source : {"observer", "displacement"}
            Displacement at which these forces, and those of ``samples``, are evaluated.
        force : bool
            Diagnose a recording that is not plausible for the scene all the same.
        samples : bool
            Keep every sample for :meth:`Outcome.samples`, in memory.

        Examples
        --------
        >>> import ballrace
        >>> outcome = ballrace.Scene.demonstration().replay(ballrace.demonstration_recording())
        >>> outcome.findings[0].kind, outcome.findings[0].bearing
        ('outer-race', 'DE')
        """
        native = self._native.replay(
            columns(recording, self._native.columns),
            None if baseline is None else os.fspath(baseline),
            learn,
            error,
            None if forces is None else os.fspath(forces),
            force_source,
            force,
            samples,
        )
        return Outcome(native, json.loads(native.json()))

    def __reduce__(self) -> tuple[Any, ...]:
        return Scene.from_toml, (self.text, str(self.path))

    def __repr__(self) -> str:
        return f"<ballrace.Scene {self.name}: bearings {', '.join(self.bearing_names)}>"


def _bearing(text: str, path: str, name: str) -> _native.Bearing:
    """Return a bearing of a scene by its name; pickle calls it."""
    return Scene.from_toml(text, path).bearing(name)


def demonstration_recording() -> dict[str, npt.NDArray[np.float64]]:
    """Return the built-in recording of a machine with a spall on an outer race: columns by their names."""
    table = np.genfromtxt(_DEMONSTRATION / "outer-spall.csv", delimiter=",", names=True, deletechars="")
    return {name: np.ascontiguousarray(table[name]) for name in table.dtype.names or ()}
