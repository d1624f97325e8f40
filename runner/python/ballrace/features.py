"""Indicators of recordings as features for scikit-learn; needs the package scikit-learn.

Examples
--------
>>> import ballrace
>>> from ballrace.features import Indicators
>>> from sklearn.pipeline import make_pipeline
>>> from sklearn.preprocessing import StandardScaler
>>> scene = ballrace.Scene.demonstration()
>>> recordings = [scene.path.parent / "healthy.csv", ballrace.demonstration_recording()]
>>> features = make_pipeline(Indicators(scene), StandardScaler()).fit_transform(recordings)
>>> features.shape[0]
2
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt
from sklearn.base import BaseEstimator, TransformerMixin
from sklearn.utils.validation import check_is_fitted

from ._recording import RecordingLike
from ._scene import Scene

#: Units by the end of a name.
_UNITS = {"um_pp": "um peak to peak", "um_peak": "um peak", "um": "um", "n": "N", "nm": "N m"}


class Indicators(TransformerMixin, BaseEstimator):  # type: ignore[misc]
    """Transformer from recordings of one machine to the indicators of their replay (:meth:`ballrace.Outcome.indicators`).

    Parameters
    ----------
    scene : Scene
        The machine.
    baseline : path, optional
        Baseline with which each recording is compared.

    A recording is a path or a table, as for :meth:`ballrace.Scene.replay`.
    """

    def __init__(self, scene: Scene, baseline: str | os.PathLike[str] | None = None) -> None:
        self.scene = scene
        self.baseline = baseline

    def fit(self, recordings: Iterable[RecordingLike], y: Any = None) -> Indicators:
        """Take the names of the indicators from the first recording."""
        for recording in recordings:
            self._names = list(self._row(recording))
            return self
        raise ValueError("recordings: none, expected at least one")

    def transform(self, recordings: Iterable[RecordingLike]) -> npt.NDArray[np.float64]:
        """Return an array of shape (recordings, indicators); NaN where a replay has no value for an indicator."""
        check_is_fitted(self, "_names")
        return self._array([self._row(recording) for recording in recordings])

    def fit_transform(self, recordings: Iterable[RecordingLike], y: Any = None) -> npt.NDArray[np.float64]:
        """Fit and transform with one replay of each recording."""
        rows = [self._row(recording) for recording in recordings]
        if not rows:
            raise ValueError("recordings: none, expected at least one")
        self._names = list(rows[0])
        return self._array(rows)

    def get_feature_names_out(self, input_features: Any = None) -> npt.NDArray[np.object_]:
        """Return the names of the indicators."""
        check_is_fitted(self, "_names")
        return np.array(self._names, dtype=object)

    @property
    def units(self) -> list[str]:
        """Unit of each indicator; empty for a ratio."""
        check_is_fitted(self, "_names")
        ends = sorted(_UNITS, key=len, reverse=True)
        return [next((_UNITS[end] for end in ends if name.endswith("_" + end)), "") for name in self._names]

    def __sklearn_is_fitted__(self) -> bool:
        return hasattr(self, "_names")

    def _array(self, rows: list[dict[str, float]]) -> npt.NDArray[np.float64]:
        return np.array([[row.get(name, np.nan) for name in self._names] for row in rows]).reshape(len(rows), -1)

    def _row(self, recording: RecordingLike) -> dict[str, float]:
        return self.scene.replay(recording, self.baseline).indicators()
