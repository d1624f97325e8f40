"""Rolling-bearing forces, a digital twin of rotating machines, and the diagnosis of measured shaft motion.

The computations are those of the command line ``ballrace``, with the same bits.

Examples
--------
>>> import ballrace
>>> scene = ballrace.Scene.demonstration()
>>> outcome = scene.replay(ballrace.demonstration_recording())
>>> print(outcome.verdict)
The machine departs from its twin. Outer race of DE: a spall at 269...
"""

from __future__ import annotations

import enum

from ._balance import balance
from ._errors import Error, InputError, RecordingError, SceneError
from ._native import VERSION as __version__
from ._native import Bearing
from ._results import Balance, Campbell, Equilibrium, Fit, Masses, Outcome, Sweep, Trade
from ._scene import Scene, demonstration_recording
from ._series import Motion, Samples, Spectra, Waterfall
from ._tables import Record


class Status(enum.IntFlag):
    """Flags of one force, as :meth:`Bearing.force` writes them to ``status``."""

    OK = 0
    INPUT_NOT_FINITE = 1
    RESULT_NOT_FINITE = 2
    CONTACT_LOST = 4
    NOT_CONVERGED = 8
    GYROSCOPIC_SLIP = 16
    OUT_OF_TABLE = 32


__all__ = [
    "Balance",
    "Bearing",
    "Campbell",
    "Equilibrium",
    "Error",
    "Fit",
    "InputError",
    "Masses",
    "Motion",
    "Outcome",
    "Record",
    "RecordingError",
    "Samples",
    "Scene",
    "SceneError",
    "Spectra",
    "Status",
    "Sweep",
    "Trade",
    "Waterfall",
    "__version__",
    "balance",
    "demonstration_recording",
]
