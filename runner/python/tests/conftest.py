"""Fixtures of the tests."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

import ballrace

ROOT = Path(__file__).resolve().parents[3]


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
