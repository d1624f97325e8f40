"""Names that arguments take, and what forces are computed from."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Literal, Union

#: Bearing models with forces.
Model = Literal[
    "linear",
    "lumped",
    "angular",
    "quasi-static",
    "tabulated",
    "roller",
    "quasi-static-roller",
    "dynamic",
    "multibody",
]
Precision = Literal["f64", "f32"]
Math = Literal["exact", "fast"]
#: Event at which a Poincare section is taken.
Section = Literal["ball-pass", "shaft"]
#: Direction in which a sweep follows a branch.
Follow = Literal["none", "up", "down", "both"]
#: Processor whose cost a trade study minimises.
Target = Literal["cortex-m4f", "desktop"]
ForceSource = Literal["observer", "displacement"]
#: What a waterfall is drawn over.
Along = Literal["time", "speed"]
#: Parameters that a fit estimates.
FitGroup = Literal["unbalance", "clearance", "damping", "stiffness", "offset"]
#: A number in SI, or text with a unit such as ``"12 um"``.
Quantity = Union[float, str]
#: A quantity of all planes, or of each by its name.
ByPlane = Union[Quantity, Mapping[str, Quantity]]
#: Number of holes, or text with the angle of the first one such as ``"12 from 15 deg"``, of all planes or of each.
Holes = Union[int, str, Mapping[str, Union[int, str]]]
#: Weights of all planes, or of each.
Stock = Union[Sequence[Quantity], Mapping[str, Sequence[Quantity]]]
Path = Union[str, "os.PathLike[str]"]
