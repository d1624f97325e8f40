"""Exceptions of ballrace."""

from __future__ import annotations

from pathlib import Path


class Error(Exception):
    """Base of all exceptions of ballrace: work that could not be done."""


class InputError(Error, ValueError):
    """A wrong argument, scene or recording."""


class SceneError(InputError):
    """A scene that cannot be read.

    Attributes
    ----------
    file : pathlib.Path
        The scene file.
    line : int or None
        Line in the file, from 1.
    key : str or None
        Path of the key, such as ``bearing[0].ball_diameter``.
    found : str or None
        Value found.
    expected : str or None
        Values allowed.
    """

    def __init__(
        self,
        message: str,
        *,
        file: Path | None = None,
        line: int | None = None,
        key: str | None = None,
        found: str | None = None,
        expected: str | None = None,
    ) -> None:
        super().__init__(message)
        self.file = file
        self.line = line
        self.key = key
        self.found = found
        self.expected = expected


class RecordingError(InputError):
    """A recording that cannot be read.

    Attributes
    ----------
    file : pathlib.Path
        The recording; ``in memory`` for arrays.
    line : int or None
        Line or row, from 1.
    column : str or None
        Name of the column.
    found : str or None
        Content found.
    expected : str or None
        Content allowed.
    """

    def __init__(
        self,
        message: str,
        *,
        file: Path | None = None,
        line: int | None = None,
        column: str | None = None,
        found: str | None = None,
        expected: str | None = None,
    ) -> None:
        super().__init__(message)
        self.file = file
        self.line = line
        self.column = column
        self.found = found
        self.expected = expected
