"""Overhead of the Python package over Rust and over the command line; prints a table for docs/src/python.md.

    target/python/bin/python benches/python/measure.py [MACHINES]
"""

from __future__ import annotations

import resource
import subprocess
import sys
import tempfile
import timeit
from pathlib import Path

import numpy as np

import ballrace
import ballrace.fleet

ROOT = Path(__file__).resolve().parents[2]
COUNT = 1_000_000
ROUNDS = 5


def one_call_us(bearing: ballrace.Bearing) -> float:
    u, out = np.array([1e-5, -1e-5, 0.0, 0.0, 0.0]), np.empty(5)
    calls = 20_000
    runs = timeit.repeat(lambda: bearing.force(u, cage_angle=0.1, out=out), number=calls, repeat=9)
    return 1e6 * min(runs) / calls


def million(bearing: ballrace.Bearing) -> tuple[float, float]:
    """Return the time in Python over that in Rust, in turn, and the difference of the sums of the forces."""
    i = np.arange(COUNT)
    turn = 0.01 * i
    u = np.stack([1e-5 * np.cos(turn), 1e-5 * np.sin(turn) - 1e-5, *np.zeros((3, COUNT))], axis=1)
    angles, out = 0.004 * i, np.empty((COUNT, 5))
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
    ratio, difference = million(bearing)
    command_line, python = fleet(count)
    print("| figure | value |\n| --- | --- |")
    print(f"| one force, one sample, microseconds | {one_call_us(bearing):.2f} |")
    print(f"| 10^6 forces in one call, time over that of Rust | {ratio:.2f} |")
    print(f"| relative difference of the sums of these forces | {difference:.0e} |")
    print(f"| processor time of a machine of one second at 12.8 kHz, command line, s | {command_line:.2f} |")
    print(f"| the same in Python, s | {python:.2f} |")
    print(f"| throughput per core over that of the command line | {command_line / python:.2f} |")


if __name__ == "__main__":
    main()
