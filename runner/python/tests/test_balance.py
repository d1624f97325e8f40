"""Balancing from tables of vectors against NumPy's least squares, and the arguments of the function."""

from __future__ import annotations

import json
import pydoc
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas
import polars
import pyarrow
import pytest

import ballrace
from conftest import ROOT

Complex = npt.NDArray[np.complex128]

PLANES, PROBES = 4, 12


def _at(moment: float, degrees: float) -> complex:
    return complex(moment * np.exp(1j * np.radians(degrees)))


class Rotor:
    """A rotor of four planes and twelve probes by random coefficients; its vectors have noise."""

    def __init__(self, seed: int) -> None:
        self.random = np.random.default_rng(seed)
        self.baseline = 20 * self._complex(PROBES)
        self.coefficients = 0.1 * self._complex(PROBES, PLANES)
        self.rows: list[dict[str, Any]] = []

    def _complex(self, *shape: int) -> Complex:
        uniform = self.random.uniform
        return np.asarray(uniform(-1, 1, shape) + 1j * uniform(-1, 1, shape))

    def run(self, name: str, kind: str, masses: dict[int, complex]) -> None:
        moments = np.zeros(self.coefficients.shape[1], complex)
        for plane, moment in masses.items():
            moments[plane] = moment
        for repeat in (1, 2):
            row: dict[str, Any] = {"id": f"{name}_N1_{repeat}", "set": kind, "speed_rpm": 3000}
            for plane, moment in enumerate(moments, start=1):
                is_given = kind != "blind"
                row[f"p{plane}_g_mm"] = abs(moment) if is_given else None
                row[f"p{plane}_deg"] = np.degrees(np.angle(moment)) if is_given else None
            vectors = self.baseline + self.coefficients @ moments + 0.02 * self._complex(len(self.baseline))
            for probe, vector in enumerate(vectors, start=1):
                row |= {f"s{probe}_re_um": vector.real, f"s{probe}_im_um": vector.imag}
            self.rows.append(row)

    def frame(self) -> pandas.DataFrame:
        return pandas.DataFrame(self.rows)


@pytest.fixture(scope="module")
def rotor() -> Rotor:
    rotor = Rotor(20261130)
    rotor.run("BASE", "baseline", {})
    for plane in range(PLANES):
        rotor.run(f"T{plane + 1}", "trial", {plane: _at(40, 70 * plane)})
    rotor.run("T5", "trial", {0: _at(40, 120), 2: _at(40, 300)})
    rotor.run("T6", "trial", {1: _at(40, 270), 3: _at(40, 10)})
    rotor.run("X1", "blind", {0: _at(25, 70), 2: _at(10, 250)})
    return rotor


def _moments(planes: Any) -> Complex:
    return np.array([_at(plane["moment_g_mm"], plane["angle_deg"]) for plane in planes])


@pytest.mark.parametrize("seed", range(3))
def test_four_planes_and_twelve_probes_are_those_of_numpy(seed: int) -> None:
    """Within 2 % of the moments that leave the least squares of the true coefficients, and of the vibration that they leave."""
    rotor = Rotor(seed)
    rotor.run("BASE", "baseline", {})
    for plane in range(PLANES):
        rotor.run(f"T{plane + 1}", "trial", {plane: _at(40, 70 * plane)})
    rotor.run("AGAIN", "baseline", {})
    found = _moments(ballrace.balance(rotor.frame())["correction"]["planes"])
    best: Any = -np.linalg.lstsq(rotor.coefficients, rotor.baseline, rcond=None)[0]
    assert np.abs(found - best).max() < 0.02 * np.abs(best).max()

    def left(moments: Complex) -> float:
        return float(np.linalg.norm(rotor.baseline + rotor.coefficients @ moments))

    assert left(found) < 1.02 * left(best)


def test_intervals_hold_the_best_moments() -> None:
    """Planes that cannot balance all probes, few runs: errors of the coefficients change the moments by what is left as well."""
    inside = 0
    for seed in range(30):
        rotor = Rotor(1000 + seed)
        rotor.baseline, rotor.coefficients = rotor.baseline[:4], rotor.coefficients[:4, :2]
        rotor.run("BASE", "baseline", {})
        rotor.run("T1", "trial", {0: 40})
        rotor.run("T2", "trial", {1: 40j})
        rotor.run("T3", "trial", {0: _at(40, 120), 1: _at(40, 200)})
        rotor.run("AGAIN", "baseline", {})
        planes = ballrace.balance(rotor.frame())["correction"]["planes"]
        best: Any = -np.linalg.lstsq(rotor.coefficients, rotor.baseline, rcond=None)[0]
        errors = np.abs(_moments(planes) - best)
        inside += int(sum(error < np.sqrt(np.log(20)) * plane["deviation_g_mm"] for error, plane in zip(errors, planes)))
    assert 54 <= inside <= 60


def test_tables_of_any_kind(rotor: Rotor, program: Path, tmp_path: Path) -> None:
    frame = rotor.frame()
    file = tmp_path / "vectors.csv"
    frame.to_csv(file, index=False)
    found = ballrace.balance(file)
    for table in (frame, polars.DataFrame(rotor.rows), pyarrow.Table.from_pylist(rotor.rows), frame.to_dict("list")):
        assert ballrace.balance(table) == found
    output = subprocess.run([program, "balance", "--vectors", file, "--format", "json"], capture_output=True, check=True, text=True)
    assert json.loads(output.stdout) == found.to_dict()
    masses = found.masses().to_pandas()
    assert list(masses["plane"]) == ["p1", "p2", "p3", "p4"] and set(masses["condition"]) == {"X1"}
    for truth, low, high in zip((25, 0, 10, 0), masses["moment_low"], masses["moment_high"]):
        assert low <= truth <= high
    assert "<svg" in found.to_html() and len(found.to_pandas()) == PLANES


def test_holes_weights_and_quality(rotor: Rotor) -> None:
    found = ballrace.balance(
        rotor.frame(), holes=16, radius=0.03, stock=["2 x 4 g", 0.002, "1 g"], weights=3, taken=["p1 4"], grade=2.5, mass="12 kg"
    )
    masses = [mass for plane in found.correction.planes for mass in plane.holes]
    assert sum(mass.mass_g == 4 for mass in masses) <= 2 and {mass.mass_g for mass in masses} <= {1.0, 2.0, 4.0}
    assert all(mass.hole != 4 for mass in found.correction.planes[0].holes)
    assert found.correction.stock.added == found.correction.stock.bound
    assert abs(found.quality.permissible_g_mm - 9549.3 * 2.5 * 12 / 3000) < 0.1


def test_holes_of_each_plane(rotor: Rotor, program: Path, tmp_path: Path) -> None:
    """Each plane has its own circle, limit and weights, as on the command line; the masses have the moment of that circle."""
    planes = ["p1", "p2", "p3", "p4"]
    radius: dict[str, Any] = {"p1": "30 mm", "p2": 0.03, "p3": "40 mm", "p4": "30 mm"}
    found = ballrace.balance(rotor.frame(), holes=dict.fromkeys(planes, 16) | {"p3": "9 from 15 deg"}, radius=radius, hole_limit={"p3": 0.1})
    file = tmp_path / "vectors.csv"
    rotor.frame().to_csv(file, index=False)
    options = ["--holes", "16,p3 9 from 15 deg", "--radius", "30 mm,p3 40 mm", "--hole-limit", "p3 100 g"]
    output = subprocess.run([program, "balance", "--vectors", file, *options, "--format", "json"], capture_output=True, check=True, text=True)
    assert json.loads(output.stdout) == found.to_dict()
    assert [plane.circle.number for plane in found.correction.planes] == [16, 16, 9, 16]
    third = found.correction.planes[2]
    assert all(mass.angle_deg == pytest.approx(15 + 40 * (mass.hole - 1)) for mass in third.holes)
    placed = sum(_at(40 * mass.mass_g, mass.angle_deg) for mass in third.holes)
    assert abs(placed - _at(third.moment_g_mm, third.angle_deg)) < 1e-6
    weights = ballrace.balance(rotor.frame(), holes=16, radius=0.03, stock=dict.fromkeys(planes, ["2 g"]) | {"p3": ["1 x 3 g", 0.001]})
    masses = [{mass.mass_g for mass in plane.holes} for plane in weights.correction.planes]
    assert masses[2] <= {1.0, 3.0} and all(one <= {2.0} for one in masses[:2] + masses[3:])


def test_a_trim_run_gives_the_next_masses(rotor: Rotor) -> None:
    trimmed = Rotor(20261130)
    trimmed.rows = [row for row in rotor.rows if row["set"] != "blind"]
    mounted = _moments(ballrace.balance(trimmed.frame())["correction"]["planes"]) * 0.9
    trimmed.run("C1", "trim", dict(enumerate(mounted)))
    found = ballrace.balance(trimmed.frame())
    assert found.trim.condition == "C1" and found.trim.misfit < 1
    best = -np.linalg.lstsq(trimmed.coefficients, trimmed.baseline, rcond=None)[0]
    np.testing.assert_allclose(_moments(found["correction"]["planes"]), best - mounted, atol=0.02 * np.abs(best).max())


def test_wrong_arguments(rotor: Rotor) -> None:
    frame = rotor.frame()
    cases: list[tuple[dict[str, Any], str]] = [
        ({"holes": 16}, "radius: missing, expected"),
        ({"stock": ["1 g"]}, "holes: missing, expected"),
        ({"holes": {"p1": 16}, "radius": "30 mm"}, "holes: none for plane p2, expected"),
        ({"holes": 16, "radius": {"p5": 0.03}}, 'radius: "p5 0.03 m" .*, with a plane .p1, p2, p3, p4. in front'),
        ({"holes": 16, "radius": 0.03, "hole_limit": {"p1": -1}}, "hole_limit: plane p1: out of range"),
        ({"holes": 16, "radius": "3 kg"}, "radius: "),
        ({"holes": 16, "radius": "30 mm", "stock": "1 g"}, "stock, taken: a text"),
        ({"holes": 16, "radius": "30 mm", "stock": ["one"]}, "stock: \"one\""),
        ({"holes": 16, "radius": "30 mm", "taken": ["p9 1"]}, "taken: unknown hole"),
        ({"replace": True}, "no trim run"),
        ({"grade": 2.5}, "mass: none"),
        ({"grade": -1.0}, "grade: out of range"),
    ]
    for arguments, message in cases:
        with pytest.raises(ballrace.InputError, match=message):
            ballrace.balance(frame, **arguments)
    with pytest.raises(ballrace.InputError, match="column set: missing"):
        ballrace.balance(frame.drop(columns="set"))
    with pytest.raises(ballrace.InputError, match="vectors: line 2: s1_re_um: value out of range"):
        ballrace.balance(frame.assign(s1_re_um=None))
    with pytest.raises(ballrace.InputError, match="nothing.csv"):
        ballrace.balance("nothing.csv")


def test_help_states_arguments_and_result() -> None:
    text = pydoc.plain(pydoc.render_doc(ballrace.balance))
    for word in ("vectors", "times", "hole_limit", "trim", "Returns", "ballrace.balance("):
        assert word in text


def test_the_example_of_the_documents() -> None:
    found = ballrace.balance(ROOT / "docs/src/vectors.csv")
    assert found.planes == ["fan", "coupling"] and found.proof.inside == found.proof.moments
