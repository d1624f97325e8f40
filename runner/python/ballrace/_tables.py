"""Base classes of results: entries as attributes, tables, reports."""

from __future__ import annotations

import base64
import html as _html
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    import pandas
    import pyarrow

Floats = npt.NDArray[np.float64]


class Record(Mapping[str, Any]):
    """A result whose entries are attributes and keys.

    Examples
    --------
    >>> point = Record({"speed_rpm": 3000.0, "modes": [{"frequency_hz": 97.5}]})
    >>> point.modes[0].frequency_hz
    97.5
    >>> point["speed_rpm"]
    3000.0
    """

    def __init__(self, entries: Mapping[str, Any]) -> None:
        self._entries = dict(entries)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        entries = self.__dict__.get("_entries", {})
        if name not in entries:
            raise AttributeError(f"no entry {name!r}, expected one of {', '.join(entries)}")
        return _wrapped(entries[name])

    def __getitem__(self, name: str) -> Any:
        return _wrapped(self._entries[name])

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._entries]

    def __repr__(self) -> str:
        shown = []
        for name, value in self._entries.items():
            text = f"[{len(value)}]" if isinstance(value, (list, dict)) and len(value) > 6 else repr(value)
            shown.append(f"{name}={text if len(text) <= 80 else text[:77] + '...'}")
        return f"{type(self).__name__}({', '.join(shown)})"

    def to_dict(self) -> dict[str, Any]:
        """Return the entries as plain dictionaries, lists, texts and numbers."""
        return self._entries


def _wrapped(value: Any) -> Any:
    if isinstance(value, dict):
        return Record(value)
    if isinstance(value, list):
        return [_wrapped(entry) for entry in value]
    return value


class Table:
    """Base class of results that are tables: one entry per column, all of one length."""

    def columns(self) -> dict[str, Sequence[Any] | Floats]:
        """Return the columns of the table."""
        raise NotImplementedError

    def to_dict(self) -> dict[str, Any]:
        """Return the result as plain dictionaries, lists, texts and numbers."""
        raise NotImplementedError

    def to_json(self) -> str:
        """Return the result as JSON.

        Examples
        --------
        >>> import ballrace, json
        >>> diagram = ballrace.Scene.demonstration().campbell("0rpm..3000rpm:2")
        >>> len(json.loads(diagram.to_json())["speeds"])
        2
        """
        return json.dumps(self.to_dict())

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Table) and type(self) is type(other) and self.to_dict() == other.to_dict()

    def to_arrow(self) -> pyarrow.Table:
        """Return the table as a ``pyarrow.Table``; needs the package pyarrow."""
        import pyarrow

        return pyarrow.table(dict(self.columns()))

    def to_pandas(self) -> pandas.DataFrame:
        """Return the table as a ``pandas.DataFrame``; needs the package pandas."""
        import pandas

        return pandas.DataFrame(dict(self.columns()))


def columns_of(rows: Sequence[Mapping[str, Any]]) -> dict[str, Sequence[Any] | Floats]:
    """Return the columns of rows; rows may lack entries."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    return {name: [row.get(name) for row in rows] for name in names}


class Page:
    """Base class of results with an HTML report."""

    def to_html(self) -> str:
        """Return the report as one self-contained page."""
        raise NotImplementedError

    def save_html(self, path: str | os.PathLike[str]) -> Path:
        """Write the report to a file and return its path."""
        target = Path(path)
        target.write_text(self.to_html(), encoding="utf-8")
        return target

    def _repr_html_(self) -> str:
        page = base64.b64encode(self.to_html().encode()).decode()
        source = _html.escape(f"data:text/html;charset=utf-8;base64,{page}", quote=True)
        return f'<iframe src="{source}" style="width:100%;height:720px;border:1px solid #ccc"></iframe>'
