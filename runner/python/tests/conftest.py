"""Fixtures of the tests."""

from __future__ import annotations

import functools
import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ballrace

ROOT = Path(__file__).resolve().parents[3]

#: Outcomes by scene, recording and options.
_known: dict[tuple[object, ...], ballrace.Outcome] = {}


def _once(replay: Callable[..., ballrace.Outcome]) -> Callable[..., ballrace.Outcome]:
    """Evaluate a recording once for all tests and examples that read its outcome, which none of them changes."""

    @functools.wraps(replay)
    def known(scene: ballrace.Scene, recording: Any = None, baseline: Any = None, **options: Any) -> ballrace.Outcome:
        # Other tables are the subject of tests; a baseline may change, and a file of forces is to be written.
        is_file = isinstance(recording, (str, Path)) and Path(recording).is_file()
        is_table = type(recording) is dict and all(
            type(values) is np.ndarray and values.dtype == float and values.ndim == 1 for values in recording.values()
        )
        if baseline is not None or options.keys() - {"samples"} or not (is_file or is_table):
            return replay(scene, recording, baseline, **options)
        read = hashlib.sha256()
        for name, values in recording.items() if is_table else [(str(recording), Path(recording).read_bytes())]:
            read.update(name.encode() + bytes(values))
        key = (scene.text, scene.path, read.digest(), *sorted(options.items()))
        if key not in _known:
            _known[key] = replay(scene, recording, **options)
        return _known[key]

    return known


ballrace.Scene.replay = _once(ballrace.Scene.replay)  # type: ignore[method-assign]


@pytest.fixture(autouse=True)
def _in_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="session")
def scene() -> ballrace.Scene:
    return ballrace.Scene.demonstration()


@pytest.fixture(scope="session")
def recording() -> dict[str, np.ndarray]:
    return ballrace.demonstration_recording()


@pytest.fixture(scope="session")
def program() -> Path:
    """The command line, built in release mode."""
    path = Path(os.environ.get("BALLRACE_PROGRAM", ROOT / "target" / "release" / "ballrace"))
    if not path.exists():
        pytest.fail(f"no program: {path}, expected one built by cargo build --release, or BALLRACE_PROGRAM=PATH")
    return path
