"""Outputs of the program and scenes are valid by the JSON schemas in docs/schema."""

from __future__ import annotations

import json
import re
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


def toml(text: str) -> Any:
    # Python 3.10 has no reader of TOML.
    return pytest.importorskip("tomllib").loads(text)


def documented_scenes() -> list[tuple[str, str]]:
    """Scenes in README and chapters."""
    scenes = []
    for document in [ROOT / "README.md", *sorted((ROOT / "docs" / "src").glob("*.md"))]:
        blocks = re.findall(r"^```toml\n(.*?)^```", document.read_text(), re.MULTILINE | re.DOTALL)
        scenes += [(document.name, block) for block in blocks if block.startswith("name = ")]
    return scenes


def scene_files() -> list[tuple[str, str]]:
    """Scenes among the files of the repository."""
    listed = subprocess.run(["git", "ls-files", "*.toml"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    texts = [(name, (ROOT / name).read_text()) for name in listed.splitlines()]
    return [(name, text) for name, text in texts if "[shaft]" in text and "[[bearing]]" in text]


def test_scenes_are_valid(program: Path) -> None:
    schema = validator("scene")
    printed = subprocess.run([program, "schema"], capture_output=True, check=True).stdout
    assert json.loads(printed) == schema.schema
    scenes = scene_files() + documented_scenes()
    assert len(scenes) > 25, [name for name, _ in scenes]
    for name, text in scenes:
        errors = [f"{error.json_path}: {error.message}" for error in schema.iter_errors(toml(text))]
        assert not errors, (name, errors)


# Changes of the demonstration, each of which the program rejects too.
WRONG = {
    "unknown key": ("ball_diameter", "ball_diametre"),
    "unknown table": ("[recording]", "[recordings]"),
    "unknown key of an inline table": ("noise =", "noises ="),
    "missing key": ('model = "angular"', ""),
    "missing key of an inline table": (', angle = "0.3 rad"', ""),
    "unknown word": ('facing = "both"', 'facing = "up"'),
    "unit of another dimension": ('mass = "6 kg"', 'mass = "6 mm"'),
    "unknown unit": ('mass = "6 kg"', 'mass = "6 stone"'),
    "no unit": ('mass = "6 kg"', 'mass = "6"'),
    "frequency for a speed": ('speed = "3000 rpm"', 'speed = "50 Hz"'),
    "not above 0": ('mass = "6 kg"', "mass = 0"),
    "negative": ('mass = "6 kg"', 'mass = "-6 kg"'),
    "probably in mm": ('ball_diameter = "7.94 mm"', "ball_diameter = 7.94"),
    "above the range": ("inner_conformity = 0.52", "inner_conformity = 1.2"),
    "no whole number": ("elements = 9", "elements = 9.5"),
    "short list": ('"0 N m", "0 N m"]', '"0 N m"]'),
    "long list": ('"0 N m", "0 N m"]', '"0 N m", "0 N m", "0 N m"]'),
    "text for a list": ('damping = ["', 'damping = "1 N s/m"  # ["'),
    "keys that exclude each other": ('rate = "12.8 kHz"', 'rate = "12.8 kHz"\ntime = "t"'),
    "two forms of a speed": ('speed = "3000 rpm"', 'speed = { from = "1 rpm", mean = "3 rpm" }'),
}


@pytest.mark.parametrize("change", WRONG)
def test_wrong_scenes_are_not_valid(change: str, program: Path) -> None:
    found, replaced = WRONG[change]
    text = (ROOT / "runner" / "demo" / "healthy.toml").read_text()
    assert found in text
    text = text.replace(found, replaced)
    assert not validator("scene").is_valid(toml(text))
    Path("scene.toml").write_text(text)
    assert subprocess.run([program, "equilibrium", "scene.toml"], capture_output=True, check=False).returncode == 2
