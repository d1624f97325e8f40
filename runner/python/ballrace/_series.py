"""Series over time or frequency: one row for each sample or line."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _plots
from ._errors import InputError
from ._tables import Floats, Table
from .typing import Along

if TYPE_CHECKING:
    import plotly.graph_objects as go
    import xarray


class Series(Table):
    """Columns over the first one.

    Attributes
    ----------
    names : list of str
        Names of the columns.
    values : numpy.ndarray
        Array of shape (rows, columns).
    """

    def __init__(self, names: list[str], values: Floats) -> None:
        self.names = names
        self.values = values

    def __getitem__(self, name: str) -> Floats:
        if name not in self.names:
            raise KeyError(f"no column {name!r}, expected one of {', '.join(self.names)}")
        column: Floats = self.values[:, self.names.index(name)]
        return column

    def __len__(self) -> int:
        return len(self.values)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Series):
            return False
        same_kind = type(self) is type(other) and self.names == other.names
        return same_kind and np.array_equal(self.values, other.values, equal_nan=True)

    def unit(self, name: str) -> str:
        """Return the unit of a column; empty for a ratio or flags."""
        raise NotImplementedError

    def to_dict(self) -> dict[str, Any]:
        """Return the columns as lists."""
        return {name: list(column.tolist()) for name, column in self._arrays().items()}

    def columns(self) -> dict[str, Sequence[Any] | Floats]:
        """Return the columns."""
        return dict(self._arrays())

    def _arrays(self) -> dict[str, Any]:
        return {name: self[name] for name in self.names}

    def to_xarray(self) -> xarray.Dataset:
        """Return the columns over the first one as an ``xarray.Dataset``, with their units; needs the package xarray."""
        import xarray

        along = self.names[0]
        values = {name: (along, column, {"units": self.unit(name)}) for name, column in self._arrays().items()}
        return xarray.Dataset({name: values[name] for name in self.names[1:]}, coords={along: values[along]})

    def __repr__(self) -> str:
        return f"{type(self).__name__}({len(self)} rows of {', '.join(self.names)})"


class Motion(Series):
    """Simulated motion.

    Attributes
    ----------
    names : list of str
        Names of the columns: ``t`` (s), coordinates (m, rad), their rates, forces of each bearing (N, N m).
    values : numpy.ndarray
        Array of shape (samples, columns).

    Examples
    --------
    >>> import ballrace
    >>> motion = ballrace.Scene.demonstration().simulate("0.02 s", "12.8 kHz").to_xarray()
    >>> motion["v"].sel(t=0.01, method="nearest").attrs["units"]
    'm'
    """

    def unit(self, name: str) -> str:
        """Return the unit of a column."""
        kind = name.removesuffix("_dot").rsplit("_", 1)[-1]
        base = {"F": "N", "M": "N m", "t": "rad" if len(kind) > 1 else "s"}.get(kind[:1], "m")
        return f"{base}{'/s' if name.endswith('_dot') else ''}"

    def plot(self, names: Sequence[str] | None = None) -> go.Figure:
        """Return a Plotly figure of columns over time, by default of the translations; needs the package plotly."""
        chosen = list(names) if names is not None else [name for name in ("u", "v", "w") if name in self.names]
        return _plots.series(self, chosen, "Motion")

    def plot_orbit(self, x: str = "u", y: str = "v") -> go.Figure:
        """Return a Plotly figure of one column over another, both to one scale; needs the package plotly."""
        return _plots.orbit(self, x, y)


#: Units by the end of a name.
_UNITS = {"s": "s", "rpm": "rpm", "rad": "rad", "m": "m", "um": "um", "N": "N", "Nm": "N m", "hz": "Hz"}


class Samples(Series):
    """Every sample of a replay; names end in their units.

    Attributes
    ----------
    names : list of str
        ``time_s``, ``speed_rpm``, ``shaft_angle_rad``; of each probe ``..._measured_um``, ``..._twin_um`` and their difference
        ``..._residual_um``; of each bearing ``..._element_1_azimuth_rad``, the displacement of the inner ring ``..._u_m``, ``v_m``, ``w_m``,
        ``thu_rad``, ``thv_rad`` and the force on it ``..._FX_N``, ``FY_N``, ``FZ_N``, ``MX_Nm``, ``MY_Nm``; ``status``, flags as in
        the file of ``forces``. A reading that is missing is NaN, and the force then the last valid one.
    values : numpy.ndarray
        Array of shape (samples, columns).

    Examples
    --------
    >>> import ballrace
    >>> outcome = ballrace.Scene.demonstration().replay(ballrace.demonstration_recording(), samples=True)
    >>> samples = outcome.samples()
    >>> samples.unit("DE_FY_N"), bool(samples["DE_FY_N"].mean() > 0.0)
    ('N', True)
    """

    def unit(self, name: str) -> str:
        """Return the unit of a column; empty for ``status``."""
        return _UNITS.get(name.rsplit("_", 1)[-1], "")

    def _arrays(self) -> dict[str, Any]:
        return {**super()._arrays(), "status": self["status"].astype(np.uint16)}

    def plot(self, names: Sequence[str] | None = None) -> go.Figure:
        """Return a Plotly figure of columns over time, by default of the residuals; needs the package plotly."""
        chosen = list(names) if names is not None else [name for name in self.names if name.endswith("_residual_um")]
        return _plots.series(self, chosen, "Samples")


class Spectra(Series):
    """Amplitude spectra of the probes (peak amplitude of a sine, mean power of windows of the recording).

    Attributes
    ----------
    names : list of str
        ``frequency_hz``; of each probe ``..._measured_um``, ``..._twin_um``, ``..._residual_um``.
    values : numpy.ndarray
        Array of shape (lines, columns).

    Examples
    --------
    >>> import ballrace
    >>> spectra = ballrace.Scene.demonstration().replay(ballrace.demonstration_recording()).spectra()
    >>> amplitudes = spectra["DE_Y_um_measured_um"]
    >>> float(spectra["frequency_hz"][amplitudes.argmax()])
    50.0
    """

    def unit(self, name: str) -> str:
        """Return the unit of a column."""
        return _UNITS.get(name.rsplit("_", 1)[-1], "")

    def plot(self, names: Sequence[str] | None = None) -> go.Figure:
        """Return a Plotly figure of spectra, by default of what is measured; needs the package plotly."""
        chosen = list(names) if names is not None else [name for name in self.names if name.endswith("_measured_um")]
        return _plots.series(self, chosen, "Spectra")


class Waterfall(Table):
    """Spectra of a plane of probes, or of one probe, in the order of time; the table has a row for each line of each spectrum.

    Attributes
    ----------
    name : str
        Probes of the plane, or the probe.
    time_s, speed_rpm : numpy.ndarray
        Middle and mean speed of each spectrum.
    frequency_hz : numpy.ndarray
        Frequencies; those of a plane are negative for backward precession.
    amplitude_um : numpy.ndarray
        Peak amplitudes, array of shape (spectra, frequencies).
    """

    def __init__(self, name: str, time_s: Floats, speed_rpm: Floats, frequency_hz: Floats, amplitude_um: Floats) -> None:
        self.name = name
        self.time_s = time_s
        self.speed_rpm = speed_rpm
        self.frequency_hz = frequency_hz
        self.amplitude_um = amplitude_um

    def to_dict(self) -> dict[str, Any]:
        """Return name and arrays as text and lists."""
        return {
            "name": self.name,
            "time_s": self.time_s.tolist(),
            "speed_rpm": self.speed_rpm.tolist(),
            "frequency_hz": self.frequency_hz.tolist(),
            "amplitude_um": self.amplitude_um.tolist(),
        }

    def columns(self) -> dict[str, Sequence[Any] | Floats]:
        """Return the columns of the table of lines."""
        lines, spectra = len(self.frequency_hz), len(self.time_s)
        return {
            "time_s": np.repeat(self.time_s, lines),
            "speed_rpm": np.repeat(self.speed_rpm, lines),
            "frequency_hz": np.tile(self.frequency_hz, spectra),
            "amplitude_um": self.amplitude_um.ravel(),
        }

    def to_xarray(self) -> xarray.DataArray:
        """Return the amplitudes over time and frequency, with the speeds, as an ``xarray.DataArray``; needs the package xarray.

        Examples
        --------
        >>> import ballrace
        >>> outcome = ballrace.Scene.demonstration().replay(ballrace.demonstration_recording())
        >>> one = outcome.waterfalls()[0].to_xarray()
        >>> one.dims, one.attrs["units"]
        (('time_s', 'frequency_hz'), 'um')
        """
        import xarray

        return xarray.DataArray(
            self.amplitude_um,
            dims=("time_s", "frequency_hz"),
            coords={
                "time_s": ("time_s", self.time_s, {"units": "s"}),
                "frequency_hz": ("frequency_hz", self.frequency_hz, {"units": "Hz"}),
                "speed_rpm": ("time_s", self.speed_rpm, {"units": "rpm"}),
            },
            name=self.name,
            attrs={"units": "um"},
        )

    def __repr__(self) -> str:
        return f"Waterfall({len(self.time_s)} spectra of {self.name})"

    def plot(self, over: Along | None = None) -> go.Figure:
        """Return a Plotly figure of the spectra one behind the other; needs the package plotly.

        Parameters
        ----------
        over : {"time", "speed"}, optional
            By default the speed where it changes by more than 5 %, else the time.
        """
        if over not in (None, "time", "speed"):
            raise InputError(f"over: {over!r}, expected 'time' or 'speed'")
        return _plots.waterfall(self, over)
