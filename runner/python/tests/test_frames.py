"""Forces of frames, lists, tables and quantities; wrong types are found before a program runs."""

from __future__ import annotations

import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any, cast

import numpy as np
import pandas
import polars
import pyarrow
import pytest

import ballrace

DISPLACEMENTS = ["u", "v", "w", "thu", "thv"]
FORCES = ["FX", "FY", "FZ", "MX", "MY"]


@pytest.fixture(scope="module")
def displacements() -> np.ndarray:
    return np.asarray(np.random.default_rng(3).normal(size=(40, 5)) * np.array([2e-5, 2e-5, 1e-5, 1e-4, 1e-4]))


def test_any_array_has_the_force_of_its_numbers(scene: ballrace.Scene, displacements: np.ndarray) -> None:
    bearing = scene.bearing("DE")
    expected = bearing.force(displacements, cage_angle=0.3)
    for given in (np.asfortranarray(displacements), np.repeat(displacements, 2, axis=0)[::2], displacements.tolist()):
        np.testing.assert_array_equal(bearing.force(given, cage_angle=0.3), expected)
        np.testing.assert_array_equal(bearing.stiffness(given), bearing.stiffness(displacements))
        np.testing.assert_array_equal(bearing.element_loads(given), bearing.element_loads(displacements))
    np.testing.assert_array_equal(bearing.force(displacements[7].tolist(), cage_angle=0.3), expected[7])
    angles = np.linspace(0.0, 6.0, 40)
    by_angle = bearing.force(displacements, cage_angle=angles)
    for given_angles in (angles.tolist(), pandas.Series(angles), angles[::-1][::-1]):
        np.testing.assert_array_equal(bearing.force(displacements, cage_angle=given_angles), by_angle)


def test_a_frame_has_a_frame_of_forces(scene: ballrace.Scene, displacements: np.ndarray) -> None:
    bearing = scene.bearing("DE")
    expected = bearing.force(displacements)
    columns = {name: displacements[:, i] for i, name in enumerate(DISPLACEMENTS)}
    index = pandas.date_range("2026-01-01", periods=40, freq="s")
    # Further columns and another order change nothing.
    frame = pandas.DataFrame({"speed": 1.0, **dict(reversed(columns.items()))}, index=index)
    found = bearing.force(frame)
    assert list(found.columns) == FORCES and found.index.equals(index)
    np.testing.assert_array_equal(found.to_numpy(), expected)
    of_polars = bearing.force(polars.DataFrame(columns))
    assert of_polars.columns == FORCES
    np.testing.assert_array_equal(of_polars.to_numpy(), expected)
    of_arrow = bearing.force(pyarrow.table(columns))
    assert isinstance(of_arrow, pyarrow.Table) and of_arrow.column_names == FORCES
    np.testing.assert_array_equal(of_arrow.to_pandas().to_numpy(), expected)
    of_dictionary = bearing.force(columns)
    np.testing.assert_array_equal(np.stack([of_dictionary[name] for name in FORCES], axis=1), expected)
    structured = np.empty(40, dtype=[(name, np.float64) for name in DISPLACEMENTS])
    for name, values in columns.items():
        structured[name] = values
    np.testing.assert_array_equal(cast(Any, bearing.force(structured))["FY"], expected[:, 1])
    np.testing.assert_array_equal(bearing.stiffness(frame), bearing.stiffness(displacements))


def test_single_precision_stays_single(scene: ballrace.Scene, displacements: np.ndarray) -> None:
    bearing = scene.bearing("DE")
    single = displacements.astype(np.float32)
    found = bearing.force(single)
    assert found.dtype == np.float32
    np.testing.assert_array_equal(found, bearing.force(single.astype(np.float64), precision="f32"))
    assert bearing.force(single[3]).shape == (5,)
    # Where it is asked for, the numbers of an array of float32 are computed with in double precision.
    np.testing.assert_array_equal(bearing.force(single, precision="f64"), bearing.force(single.astype(np.float64)).astype(np.float32))


def test_lengths_in_another_unit_are_warned_of(scene: ballrace.Scene) -> None:
    bearing = scene.bearing("DE")
    rows = [[10e-6, 0.0, 0.0, 0.0, 0.0], [-20.0, 0.0, 0.0, 0.0, 0.0]]
    for call in (bearing.force, bearing.stiffness, bearing.element_loads):
        with pytest.warns(RuntimeWarning, match="u: 1 of 2 displacements are beyond 7.9 mm, .* the first at row 1, expected m"):
            call(rows)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        bearing.force(rows[:1])


def test_quantities_carry_their_units(scene: ballrace.Scene, displacements: np.ndarray) -> None:
    pint = pytest.importorskip("pint")
    unit = pint.UnitRegistry()
    bearing = scene.bearing("DE")
    given = {name: displacements[:, i] * 1e6 * unit.um for i, name in enumerate(DISPLACEMENTS[:3])}
    given |= {name: np.degrees(displacements[:, 3 + i]) * unit.deg for i, name in enumerate(DISPLACEMENTS[3:])}
    found = bearing.force(given, cage_angle=30.0 * unit.deg)
    expected = bearing.force(displacements, cage_angle=np.radians(30.0))
    np.testing.assert_allclose(np.stack([found[name] for name in FORCES], axis=1), expected, rtol=1e-9, atol=1e-6)
    with pytest.raises(ballrace.InputError, match="one quantity for lengths and angles"):
        bearing.force(displacements * unit.m)
    with pytest.raises(pint.DimensionalityError):
        bearing.force({**given, "u": given["u"] / unit.s})


#: A line each that a type checker has to find.
PLANTED = [
    'scene.bearing("DE").force(displacements, model="angluar")',
    'scene.bearing("DE").force(displacements, precision="f16")',
    'scene.sweep({"shaft.speed": "1rpm..2rpm:2"}, follow="sideways")',
    "scene.replay(forces=3)",
    "frame: int = scene.bearing().force(displacements)",
    'scene.fit(only=["unbalanced"])',
]


def test_planted_errors_of_type_are_found(tmp_path: Path) -> None:
    lines = ["import numpy as np", "import ballrace", "", "scene = ballrace.Scene.demonstration()", "displacements = np.zeros((3, 5))"]
    program = tmp_path / "planted.py"
    program.write_text("\n".join(lines + PLANTED) + "\n")
    found = subprocess.run(
        [sys.executable, "-m", "mypy", "--cache-dir", str(tmp_path / "cache"), str(program)], capture_output=True, text=True, check=False
    )
    numbers = {int(line.split(":")[1]) for line in found.stdout.splitlines() if "error:" in line}
    assert numbers == {len(lines) + 1 + i for i in range(len(PLANTED))}, found.stdout + found.stderr
