"""Units of `ballrace fmu` in FMPy, a host of the FMI standard, against the program itself."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

from conftest import ROOT

RATE = 12_800
STEP = 1 / RATE
BUILT_IN = ["hajzman-bending-ring", "spherical-22210-fan", "two-spring-rotor", "wang-angular-pair"]
SYSTEM = """
[shaft]
speed = "1500 rpm"
[system]
mass = "m.mtx"
stiffness = "matrices/k.mtx"
proportional_damping = "20 us"
[[bearing]]
name = "drive end"
coordinates = [1, 2, 0, 0, 0]
model = "lumped"
elements = 8
stiffness = 1e9
radial_play = "2 um"
cage_ratio = 0.4
"""


def _bits(values: Any) -> list[int]:
    # Zeros of either sign are equal.
    return [int(bits) for bits in (np.ascontiguousarray(values, dtype=np.float64) + 0.0).view(np.int64)]


def _scene(program: Path, name: str, folder: Path) -> Path:
    """Write a scene: that of the demonstration or of a recording, one of the program, or one of matrices."""
    path = folder / f"{name}.toml"
    if name == "demonstration":
        path.write_text((ROOT / "runner/demo/healthy.toml").read_text())
    elif name == "flexible":
        path.write_text((ROOT / "tests/recordings/flexible/scene.toml").read_text())
    elif name == "system":
        (folder / "matrices").mkdir()
        for file, diagonal in (("m.mtx", "3\n0\n0\n3"), ("matrices/k.mtx", "4e6\n1e5\n1e5\n5e6")):
            (folder / file).write_text(f"%%MatrixMarket matrix array real general\n2 2\n{diagonal}\n")
        path.write_text(SYSTEM)
    else:
        path.write_bytes(subprocess.run([program, "scenes", name], check=True, capture_output=True).stdout)
    return path


def _unit(program: Path, scene: Path, *more: str) -> Path:
    path = scene.with_suffix(".fmu")
    subprocess.run([program, "fmu", scene, "-o", path, *more], check=True, capture_output=True)
    return path


def _table(program: Path, scene: Path, samples: int) -> dict[str, Any]:
    """Return the columns that `simulate` writes."""
    path = scene.with_suffix(".csv")
    span = ["--duration", f"{samples * STEP} s", "--rate", f"{RATE} Hz"]
    subprocess.run([program, "simulate", scene, *span, "-o", path], check=True, capture_output=True)
    header = path.read_text().split("\n", 1)[0].split(",")
    return dict(zip(header, np.loadtxt(path, delimiter=",", skiprows=1).T, strict=True))


class Instance:
    """An instance of a unit from its creation to its end."""

    def __init__(self, unit: Path, folder: str, name: str = "one") -> None:
        self.description = fmpy.read_model_description(str(unit))
        self.references = {variable.name: variable.valueReference for variable in self.description.modelVariables}
        self.messages: list[str] = []
        identifier = self.description.coSimulation.modelIdentifier
        token = self.description.guid or self.description.instantiationToken
        self.slave = FMU3Slave(instanceName=name, guid=token, modelIdentifier=identifier, unzipDirectory=folder)
        self.slave.instantiate()
        self.start()

    def start(self) -> None:
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()
        self.time = 0.0

    def get(self, names: Sequence[str]) -> list[float]:
        return list(self.slave.getFloat64([self.references[name] for name in names]))

    def set(self, **values: float) -> None:
        self.slave.setFloat64([self.references[name] for name in values], list(values.values()))

    def step(self, steps: int, length: float = STEP) -> None:
        for _ in range(steps):
            self.slave.doStep(currentCommunicationPoint=self.time, communicationStepSize=length)
            self.time += length

    def end(self) -> None:
        self.slave.freeInstance()


MOTION = ["u", "v", "w", "thu", "thv", "der(u)", "der(v)", "DE.FX", "DE.FY", "NDE.FX"]


@pytest.fixture
def rotors(program: Path, tmp_path: Path) -> Iterator[tuple[Instance, Instance]]:
    unit = _unit(program, _scene(program, "demonstration", tmp_path))
    folder = fmpy.extract(str(unit), str(tmp_path / "unit"))
    both = Instance(unit, folder, "one"), Instance(unit, folder, "other")
    yield both
    for one in both:
        one.end()


@pytest.mark.parametrize("name", ["demonstration", "flexible", "system", *BUILT_IN])
def test_a_rotor_moves_as_simulate_says_bit_for_bit(program: Path, tmp_path: Path, name: str) -> None:
    samples = 3000
    scene = _scene(program, name, tmp_path)
    unit = _unit(program, scene, "--rate", f"{RATE} Hz")
    assert validate_fmu(str(unit)) == []
    moved = fmpy.simulate_fmu(str(unit), stop_time=(samples - 1) * STEP, step_size=STEP, output_interval=STEP)
    expected = _table(program, scene, samples)
    names = [name for name in moved.dtype.names if name not in ("time", "status") and "load." not in name]
    columns = [name for name in expected if name != "t"]
    assert len(names) == len(columns) and len(moved) == samples
    for found, column in zip(names, columns, strict=True):
        assert _bits(moved[found]) == _bits(expected[column]), (found, column)


def test_a_bearing_has_the_forces_of_force_bit_for_bit(program: Path, tmp_path: Path) -> None:
    scene = _scene(program, "demonstration", tmp_path)
    unit = _unit(program, scene, "--bearing", "DE")
    assert validate_fmu(str(unit)) == []
    random = np.random.default_rng(1)
    size = [20e-6, 20e-6, 40e-6, 1e-3, 1e-3]
    displacements = random.uniform(-1, 1, (200, 5)) * size
    displacements[100, 1] = np.nan
    times = random.uniform(0, 10, 200)
    rows = [",".join(repr(float(x)) for x in [*u, t]) for u, t in zip(displacements, times, strict=True)]
    (tmp_path / "u.csv").write_text("u,v,w,thu,thv,t\n" + "\n".join(rows) + "\n")
    command = [str(program), "force", str(scene), "--bearing", "DE", "--displacements", "u.csv", "--bits", "--format", "csv"]
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()[1:]
    instance = Instance(unit, fmpy.extract(str(unit), str(tmp_path / "unit")))
    (speed,) = instance.get(["speed"])
    found = []
    for u, t in zip(displacements, times, strict=True):
        instance.set(**dict(zip(["u", "v", "w", "thu", "thv"], map(float, u), strict=True)), angle=speed * t)
        force = instance.get(["FX", "FY", "FZ", "MX", "MY"])
        (status,) = instance.slave.getInt32([instance.references["status"]])
        found.append(",".join([*(f"{bits & (2**64 - 1):#018x}" for bits in _raw(force)), f"{status:#04x}"]))
    instance.end()
    assert found == printed
    assert sum(row.endswith("0x00") for row in found) > 100


def _raw(values: Sequence[float]) -> list[int]:
    return [int(bits) for bits in np.array(values, dtype=np.float64).view(np.int64)]


def test_a_shaft_bends_most_where_the_force_acts(program: Path, tmp_path: Path) -> None:
    unit = _unit(program, _scene(program, "flexible", tmp_path), "--rate", "12.8 kHz")
    folder = fmpy.extract(str(unit), str(tmp_path / "unit"))
    names = ["u", "load.u", "der(u)", "der(load.u)"]
    moved = []
    for force in (0.0, 100.0):
        instance = Instance(unit, folder)
        instance.set(FX=force)
        instance.step(4)
        moved.append(instance.get(names))
        instance.end()
    change = np.subtract(moved[1], moved[0])
    assert change[1] > change[0] > 0
    assert change[3] > change[2] > 0


def test_two_instances_move_apart_from_each_other(rotors: tuple[Instance, Instance]) -> None:
    one, other = rotors
    other.set(FX=300.0)
    for _ in range(200):
        one.step(1)
        other.step(1)
    first, loaded = one.get(MOTION), other.get(MOTION)
    assert loaded[0] > first[0] + 1e-6
    for instance in rotors:
        instance.slave.reset()
        instance.start()
    assert one.get(MOTION) == other.get(MOTION)
    other.step(20, 10 * STEP)
    assert _bits(other.get(MOTION)) == _bits(first)


def test_a_state_is_restored(rotors: tuple[Instance, Instance]) -> None:
    one, other = rotors
    one.set(FY=-150.0)
    one.step(100)
    state, time = one.slave.getFMUState(), one.time
    one.step(100)
    expected = _bits(one.get(MOTION))
    for instance in rotors:
        instance.slave.setFMUState(state)
        instance.time = time
        instance.step(100)
        assert _bits(instance.get(MOTION)) == expected
    one.slave.freeFMUState(state)


def test_a_state_has_the_memory_of_quasi_static_bearings(program: Path, tmp_path: Path) -> None:
    unit = _unit(program, _scene(program, "wang-angular-pair", tmp_path), "--rate", "12.8 kHz")
    one = Instance(unit, fmpy.extract(str(unit), str(tmp_path / "unit")))
    names = [name for name in one.references if name.startswith(("u", "v", "w", "th", "der", "'"))]
    one.step(50)
    state, time = one.slave.getFMUState(), one.time
    one.step(100)
    expected = _bits(one.get(names))
    one.slave.setFMUState(state)
    one.time = time
    one.step(100)
    assert _bits(one.get(names)) == expected
    one.slave.freeFMUState(state)
    one.end()


@pytest.mark.parametrize("length", [1.5 * STEP, 1e-3, 0.0, -STEP])
def test_a_wrong_step_is_refused(rotors: tuple[Instance, Instance], length: float) -> None:
    one, _ = rotors
    with pytest.raises(FMICallException):
        one.step(1, length)


def test_the_step_is_in_the_description(rotors: tuple[Instance, Instance]) -> None:
    co_simulation = rotors[0].description.coSimulation
    assert float(co_simulation.fixedInternalStepSize) == STEP
    assert co_simulation.canHandleVariableCommunicationStepSize
    assert co_simulation.canGetAndSetFMUstate
