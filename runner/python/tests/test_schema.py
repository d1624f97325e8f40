"""Outputs of the program are valid by the JSON schemas in docs/schema."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet
import pytest
from jsonschema import Draft202012Validator, ValidationError

from conftest import ROOT


def validator(name: str) -> Draft202012Validator:
    schema = json.loads((ROOT / "docs" / "schema" / f"{name}.schema.json").read_text())
    Draft202012Validator.check_schema(schema)
    return Draft202012Validator(schema)


def replay(program: Path, *args: str) -> Any:
    output = subprocess.run([program, "replay", *args, "--format", "json", "--no-report"], capture_output=True, check=False)
    assert output.returncode in (0, 3, 4), output.stderr
    return json.loads(output.stdout)


def test_outcomes_are_valid_and_complete(program: Path) -> None:
    outcome = replay(program)
    schema = validator("outcome")
    schema.validate(outcome)
    flexible = ROOT / "tests" / "recordings" / "flexible"
    np.save("head.npy", np.load(flexible / "healthy.npy")[:5120])
    schema.validate(replay(program, str(flexible / "scene.toml"), "--recording", "head.npy"))
    # A missing key and an unknown key are errors.
    for key in ("schema", "findings", "timing"):
        with pytest.raises(ValidationError):
            schema.validate({k: v for k, v in outcome.items() if k != key})
    with pytest.raises(ValidationError):
        schema.validate({**outcome, "unknown": 1})
    with pytest.raises(ValidationError):
        schema.validate({**outcome, "schema": "ballrace-outcome-0"})


def test_events_and_indicator_files(program: Path) -> None:
    scene = (ROOT / "runner" / "demo" / "healthy.toml").read_text()
    Path("scene.toml").write_text(scene + '\n[[limit]]\nindicator = "rms"\nprobe = "DE_X_um"\nmax = "0.01 um"\n')
    lines = (ROOT / "runner" / "demo" / "healthy.csv").read_text().splitlines()
    rows = [line.split(",", 1)[1] for line in lines[1:]]
    text = [lines[0].split(",", 1)[1], *rows, *rows, *rows]
    Path("healthy.csv").write_text("\n".join(text) + "\n")
    outcome = replay(program, "scene.toml", "--paced", "--events", "log.jsonl", "--indicators", "trend")
    validator("outcome").validate(outcome)
    events = [json.loads(line) for line in Path("log.jsonl").read_text().splitlines()]
    schema = validator("event")
    for event in events:
        schema.validate(event)
    assert any(event["kind"] == "limit-crossed" for event in events), events
    table = pyarrow.parquet.read_table("trend/indicators-0001.parquet")
    metadata = table.schema.metadata
    assert metadata[b"schema"] == b"ballrace-indicators-1" and metadata[b"time_zone"] == b"UTC"
    units = json.loads(metadata[b"units"])
    assert (units["DE_FX_N"], units["DE_X_um_one_x_um"], units["speed_rpm"]) == ("N", "um", "rpm")
    assert set(units) <= set(table.column_names)
    assert str(table.schema.field("at").type) == "timestamp[ms, tz=UTC]"
