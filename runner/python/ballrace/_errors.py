"""Exceptions of ballrace."""

from __future__ import annotations

from pathlib import Path
from typing import Any


class Error(Exception):
    """Base class of all exceptions of ballrace, and error of a computation."""


class InputError(Error, ValueError):
    """A wrong argument, scene or recording."""


class FileError(InputError):
    """A file, or a table in memory, that cannot be read.

    Attributes
    ----------
    file : pathlib.Path
        The file; ``in memory`` for arrays.
    line : int or None
        Line or row, from 1.
    found : str or None
        Content found.
    expected : str or None
        Content expected.
    """

    def __init__(
        self,
        message: str,
        *,
        file: Path | None = None,
        line: int | None = None,
        found: str | None = None,
        expected: str | None = None,
    ) -> None:
        super().__init__(message)
        self.file = file
        self.line = line
        self.found = found
        self.expected = expected


class SceneError(FileError):
    """A scene that cannot be read.

    Attributes
    ----------
    key : str or None
        Path of the key, such as ``bearing[0].ball_diameter``.
    """

    def __init__(self, message: str, *, key: str | None = None, **place: Any) -> None:
        super().__init__(message, **place)
        self.key = key


class RecordingError(FileError):
    """A recording that cannot be read.

    Attributes
    ----------
    column : str or None
        Name of the column.
    """

    def __init__(self, message: str, *, column: str | None = None, **place: Any) -> None:
        super().__init__(message, **place)
        self.column = column
