"""Overhead of the Python package over Rust and over the command line, and forces beside NumPy; prints a table for docs/src/python.md.

    target/python/bin/python benches/python/measure.py [MACHINES]
"""

from __future__ import annotations

import resource
import subprocess
import sys
import tempfile
import time
import timeit
from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt

import ballrace
import ballrace.fleet

ROOT = Path(__file__).resolve().parents[2]
COUNT = 1_000_000
ROUNDS = 5
# The fastest of 128 to 16384 displacements.
BLOCK = 4096

Array = npt.NDArray[np.float64]


def one_call_us(bearing: ballrace.Bearing) -> float:
    u, out = np.array([1e-5, -1e-5, 0.0, 0.0, 0.0]), np.empty(5)
    calls = 20_000
    runs = timeit.repeat(lambda: bearing.force(u, cage_angle=0.1, out=out), number=calls, repeat=9)
    return 1e6 * min(runs) / calls


def displacements() -> tuple[Array, Array]:
    """Return a million displacements and cage angles."""
    i = np.arange(COUNT)
    turn = 0.01 * i
    return np.stack([1e-5 * np.cos(turn), 1e-5 * np.sin(turn) - 1e-5, *np.zeros((3, COUNT))], axis=1), 0.004 * i


def numpy_forces(u: Array, angles: Array, out: Array, stiffness: float = 1.0) -> None:
    """Compute the forces of the bearing of the demonstration as `angular` does, in blocks of the second-level cache."""
    balls, ball, pitch, conformity, clearance = 9, 7.94e-3, 39.04e-3, 0.52, 10e-6
    distance = (2 * conformity - 1) * ball
    cos_contact = 1 - clearance / (2 * distance)
    rest, arm = distance * cos_contact, pitch / 2 + (conformity - 0.5) * ball * cos_contact
    azimuths = 2 * np.pi * np.arange(balls) / balls
    along, across = np.cos(azimuths), np.sin(azimuths)
    buffers = np.empty((6, balls, BLOCK))
    for first in range(0, len(u), BLOCK):
        columns = u[first : first + BLOCK].T.copy()
        radial, axial, excess, length, load, spare = buffers[:, :, : columns.shape[1]]
        c, s = np.cos(angles[first : first + BLOCK]), np.sin(angles[first : first + BLOCK])
        x, y = c * columns[0] + s * columns[1], c * columns[1] - s * columns[0]
        tilt_x, tilt_y = arm * (c * columns[3] + s * columns[4]), arm * (c * columns[4] - s * columns[3])
        np.multiply(along[:, None], x, out=radial)
        radial += np.multiply(across[:, None], y, out=spare)
        np.multiply(across[:, None], tilt_x, out=axial)
        axial -= np.multiply(along[:, None], tilt_y, out=spare)
        axial += columns[2]
        np.add(radial, 2 * rest, out=excess)
        excess *= radial
        excess += np.multiply(axial, axial, out=spare)
        excess += rest * rest - distance * distance
        np.sqrt(np.add(excess, distance * distance, out=length), out=length)
        np.divide(excess, np.add(length, distance, out=spare), out=load)
        np.maximum(load, 0.0, out=load)
        load *= np.sqrt(load, out=spare)
        load /= length
        radial += rest
        radial *= load
        axial *= load
        fx, fy, mx, my = along @ radial, across @ radial, -arm * (across @ axial), arm * (along @ axial)
        block = out[first : first + BLOCK]
        block[:, 0], block[:, 1], block[:, 2] = -(c * fx - s * fy), -(c * fy + s * fx), -axial.sum(0)
        block[:, 3], block[:, 4] = c * mx - s * my, c * my + s * mx
        block *= stiffness


def processor_seconds(work: Callable[[], object]) -> float:
    begin = time.process_time()
    work()
    return time.process_time() - begin


def beside_numpy(bearing: ballrace.Bearing) -> tuple[float, float]:
    """Return the processor time of NumPy over that of the package, in turn, and the relative difference of the forces."""
    u, angles = displacements()
    out, other = np.empty((COUNT, 5)), np.empty((COUNT, 5))
    bearing.force(u, cage_angle=angles, out=out)
    numpy_forces(u, angles, other)
    stiffness = float((out * other).sum() / (other * other).sum())
    times = [
        processor_seconds(lambda: numpy_forces(u, angles, other, stiffness))
        / processor_seconds(lambda: bearing.force(u, cage_angle=angles, out=out))
        for _ in range(9)
    ]
    return float(np.median(times)), float(np.abs(out - other).max() / np.abs(out).max())


def million(bearing: ballrace.Bearing) -> tuple[float, float]:
    """Return the time in Python over that in Rust, in turn, and the difference of the sums of the forces."""
    u, angles = displacements()
    out = np.empty((COUNT, 5))
    ratios = []
    for _ in range(5):
        command = ["cargo", "bench", "--locked", "-q", "-p", "ballrace-benches", "--bench", "python"]
        answer = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
        seconds, total = (float(x) for x in answer.stdout.split()[-2:])
        python = min(timeit.repeat(lambda: bearing.force(u, cage_angle=angles, out=out), number=1, repeat=7))
        ratios.append(python / seconds)
    return float(np.median(ratios)), abs(out[:, 1].sum() / total - 1.0)


def fleet(count: int) -> tuple[float, float]:
    """Return the processor time of a machine of one second in the command line and in Python, seconds: medians of rounds in turn."""
    rounds = [one_round(max(1, count // ROUNDS)) for _ in range(ROUNDS)]
    return float(np.median([a for a, _ in rounds])), float(np.median([b for _, b in rounds]))


def one_round(count: int) -> tuple[float, float]:
    scene = ballrace.Scene.demonstration()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        rows = ["machine,scene,recording"]
        recording = scene.path.parent / "healthy.csv"
        rows += [f"pump {i},{scene.path},{recording}" for i in range(count)]
        (folder / "machines.csv").write_text("\n".join(rows))
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        program = [ROOT / "target/release/ballrace", "fleet", "machines.csv", "-o", "a", "--jobs", "1", "--no-report"]
        subprocess.run(program, cwd=folder, capture_output=True, check=False)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        command_line = (after.ru_utime - before.ru_utime) + (after.ru_stime - before.ru_stime)
        before = resource.getrusage(resource.RUSAGE_SELF)
        ballrace.fleet.replay(folder / "machines.csv", folder / "b", workers=0)
        after = resource.getrusage(resource.RUSAGE_SELF)
        python = (after.ru_utime - before.ru_utime) + (after.ru_stime - before.ru_stime)
    return command_line / count, python / count


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    bearing = ballrace.Scene.demonstration().bearing("DE")
    beside, other_difference = beside_numpy(bearing)
    ratio, difference = million(bearing)
    command_line, python = fleet(count)
    print("| figure | value |\n| --- | --- |")
    print(f"| one force, one sample, microseconds | {one_call_us(bearing):.2f} |")
    print(f"| 10^6 forces in one call, time over that of Rust | {ratio:.2f} |")
    print(f"| relative difference of the sums of these forces | {difference:.0e} |")
    print(f"| 10^6 forces of 9 balls by NumPy in blocks, processor time over that of one call | {beside:.2f} |")
    print(f"| largest difference of these forces, relative to the largest | {other_difference:.0e} |")
    print(f"| processor time of a machine of one second at 12.8 kHz, command line, s | {command_line:.2f} |")
    print(f"| the same in Python, s | {python:.2f} |")
    print(f"| throughput per core over that of the command line | {command_line / python:.2f} |")


if __name__ == "__main__":
    main()
