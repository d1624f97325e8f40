"""Runs that depart from the others: random tables with a mistake in one run, and without one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import ballrace

Complex = npt.NDArray[np.complex128]
#: Changes of the acting masses and of the vectors of a run.
Change = Callable[[Complex], Complex]


def _same(of: Complex) -> Complex:
    return of


class Machine:
    """A rotor by random coefficients, with noise, drift from run to run, and masses that act within 2 % of the stated ones."""

    def __init__(self, seed: int, planes: int, probes: int) -> None:
        self.random = np.random.default_rng(seed)
        self.noise = 10 ** self.random.uniform(-2, 0)
        self.baseline = 20 * self._uniform(probes)
        self.coefficients = 0.1 * self._uniform(probes, planes)
        self.rows: list[dict[str, Any]] = []

    def _uniform(self, *shape: int) -> Complex:
        uniform = self.random.uniform
        return np.asarray(uniform(-1, 1, shape) + 1j * uniform(-1, 1, shape))

    def _normal(self, count: int) -> Complex:
        return np.asarray(self.random.normal(size=count) + 1j * self.random.normal(size=count))

    def mass(self) -> complex:
        return complex(40 * np.exp(2j * np.pi * self.random.uniform()))

    def run(self, name: str, kind: str, stated: Complex, acting: Change = _same, read: Change = _same) -> None:
        probes, planes = self.coefficients.shape
        moments = acting(stated) * (1 + 0.014 * self._normal(planes))
        drift = 0.1 * self.noise * self.random.uniform(0, 3) * self._normal(probes)
        for repeat in range(int(self.random.integers(1, 4))):
            vectors = read(self.baseline + self.coefficients @ moments + drift + 0.05 * self.noise * self._uniform(probes))
            row: dict[str, Any] = {"id": f"{name}_N1_{repeat}", "set": kind, "speed_rpm": 3000}
            for plane, moment in enumerate(stated):
                row |= {f"p{plane}_g_mm": abs(moment), f"p{plane}_deg": np.degrees(np.angle(moment))}
            for probe, vector in enumerate(vectors):
                row |= {f"s{probe}_re_um": vector.real, f"s{probe}_im_um": vector.imag}
            self.rows.append(row)

    def departure(self) -> Any:
        """Return the run that is named without a cause, if any; a cause is an error."""
        table = {name: [row[name] for row in self.rows] for name in self.rows[0]}
        return ballrace.balance(table).to_dict().get("departure")


def test_sound_tables_are_not_refused() -> None:
    named = 0
    for seed in range(200):
        choose = np.random.default_rng(seed).integers
        planes, probes = int(choose(1, 4)), int(choose(2, 9))
        machine = Machine(seed, planes, probes)
        machine.run("BASE", "baseline", np.zeros(planes, complex))
        for plane in range(planes):
            for repeat in range(int(choose(1, 4))):
                machine.run(f"T{plane}{repeat}", "trial", np.eye(planes)[plane] * machine.mass())
        machine.run("ALL", "trial", np.array([machine.mass() for _ in range(planes)]))
        for repeat in range(int(choose(1, 4))):
            machine.run(f"AGAIN{repeat}", "baseline", np.zeros(planes, complex))
        named += machine.departure() is not None
    assert named <= 5


def _exchanged(of: Complex) -> Complex:
    return of[[1, 0, *range(2, len(of))]]


MISTAKES: dict[str, tuple[Change, Change]] = {
    "no mass mounted": (lambda u: 0 * u, _same),
    "the masses half a turn": (lambda u: -u, _same),
    "the masses of planes p0 and p1 exchanged": (_exchanged, _same),
    "probes s0 and s1 exchanged": (_same, _exchanged),
    "vectors in mil in place of um": (_same, lambda y: y / 25.4),
    "vectors in peak-to-peak in place of peak": (_same, lambda y: 2 * y),
    "the angles of the vectors counted the other way": (_same, np.conj),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_in_one_run_is_named(mistake: str) -> None:
    """In the first of four trials of two planes: nine of ten at least."""
    acting, read = MISTAKES[mistake]
    found = 0
    for seed in range(20):
        machine = Machine(seed, 2, 3 + seed % 6)
        first, second = np.array([1, 0]), np.array([0, 1])
        machine.run("BASE", "baseline", np.zeros(2, complex))
        machine.run("T1", "trial", first * machine.mass(), acting, read)
        machine.run("T2", "trial", second * machine.mass())
        machine.run("T3", "trial", np.array([machine.mass(), machine.mass()]))
        machine.run("T4", "trial", first * machine.mass())
        machine.run("AGAIN", "baseline", np.zeros(2, complex))
        try:
            machine.departure()
        except ballrace.InputError as error:
            found += f"T1: the vectors agree with the other runs only with {mistake}" in str(error)
    assert found >= 18
