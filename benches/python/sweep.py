"""Processors kept busy by a sweep, and the time of a motion beside EXUDYN; prints a table for docs/src/performance.md.

    python3 -m venv exudyn && exudyn/bin/pip install exudyn && exudyn/bin/python benches/python/sweep.py [POINTS]

Without EXUDYN its row is left out. Build the program first: cargo build --release
"""

from __future__ import annotations

import csv
import math
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "target/release/ballrace"
SCENE = ROOT / "runner/scenes/tiwari-balanced.toml"

# The scene above: rad/s, kg, N s/m, N, N/m^1.5, m.
SPEED, MASS, DAMPING, LOAD = 1500 * math.tau / 60, 20.0, 2940.0, 196.0
STIFFNESS, PLAY, BALLS, CAGE_RATIO = 13.34e9, 3e-6, 8, 0.385576923
STEP, SECONDS, ROUNDS = 50e-6, 2.0, 5


def processor_seconds() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def busy(points: int) -> tuple[float, float]:
    """Return the share of all processors that a sweep keeps busy, and its time per point, seconds."""
    with tempfile.TemporaryDirectory() as folder:
        over = f"shaft.speed=500rpm..10000rpm:{points}"
        command = [PROGRAM, "sweep", SCENE, "--over", over, "-o", Path(folder) / "sweep"]
        used, begin = processor_seconds(), time.perf_counter()
        subprocess.run(command, check=True, capture_output=True)
        wall = time.perf_counter() - begin
        return (processor_seconds() - used) / (wall * (os.cpu_count() or 1)), wall / points


def range_of(x: list[float]) -> tuple[float, float]:
    """Return least and greatest of the second half."""
    second = x[len(x) // 2 :]
    return min(second), max(second)


def ours() -> tuple[float, tuple[float, float]]:
    """Return the time of a simulated second and the range of the motion along the load, seconds and metres."""
    with tempfile.TemporaryDirectory() as folder:
        scene, motion = Path(folder) / "scene.toml", Path(folder) / "motion.csv"
        scene.write_text(SCENE.read_text() + f'\n[integration]\nmethod = "verlet"\nstep = "{STEP * 1e6:g} us"\n')
        # The same integration at two lengths: their difference is without start and end of the program.
        times = []
        for seconds in (SECONDS, 11 * SECONDS):
            rate = ["--duration", f"{seconds:g} s", "--rate", "2 kHz"]
            used = processor_seconds()
            subprocess.run([PROGRAM, "simulate", scene, *rate, "-o", motion], check=True, capture_output=True)
            times.append(processor_seconds() - used)
        with motion.open() as file:
            u = [float(row["u"]) for row in csv.DictReader(file)]
        return (times[1] - times[0]) / (10 * SECONDS), range_of(u)


def exudyn_system() -> tuple[float, tuple[float, float]]:
    """Return the same of EXUDYN, with the bearing as a user function, its means for a force that it has not."""
    import exudyn as exu
    import numpy as np
    from exudyn.itemInterface import NodeGenericODE2, ObjectGenericODE2, SensorNode

    azimuths = math.tau * np.arange(BALLS) / BALLS

    def force(_mbs: object, t: float, _item: int, q: list[float], _q_t: list[float]) -> list[float]:
        turned = azimuths + CAGE_RATIO * SPEED * t
        cos, sin = np.cos(turned), np.sin(turned)
        load = STIFFNESS * np.maximum(q[0] * cos + q[1] * sin - PLAY, 0.0) ** 1.5
        return [LOAD - load @ cos, -(load @ sin)]

    system = exu.SystemContainer().AddSystem()
    zero = [0, 0]
    node = system.AddNode(
        NodeGenericODE2(
            referenceCoordinates=zero, initialCoordinates=zero, initialCoordinates_t=zero, numberOfODE2Coordinates=2
        )
    )
    system.AddObject(
        ObjectGenericODE2(
            nodeNumbers=[node],
            massMatrix=MASS * np.eye(2),
            dampingMatrix=DAMPING * np.eye(2),
            stiffnessMatrix=np.zeros((2, 2)),
            forceUserFunction=force,
        )
    )
    coordinates = exu.OutputVariableType.Coordinates
    sensor = system.AddSensor(SensorNode(nodeNumber=node, storeInternal=True, outputVariableType=coordinates))
    system.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = round(SECONDS / STEP)
    settings.timeIntegration.endTime = SECONDS
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = 5e-4
    begin = time.process_time()
    system.SolveDynamic(settings, solverType=exu.DynamicSolverType.VelocityVerlet)
    used = time.process_time() - begin
    return used / SECONDS, range_of(list(system.GetSensorStoredData(sensor)[:, 1]))


def median(x: list[float]) -> float:
    return sorted(x)[len(x) // 2]


def main() -> None:
    points = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    share, per_point = busy(points)
    print("| figure | value |\n| --- | --: |")
    print(f"| processors kept busy by a sweep of {points} points | {100 * share:.1f} % |")
    print(f"| time of a point on {os.cpu_count()} processors | {1e3 * per_point:.2f} ms |")
    both = []
    for _ in range(ROUNDS):
        mine, motion = ours()
        try:
            other, other_motion = exudyn_system()
        except ImportError:
            return
        for a, b in zip(motion, other_motion, strict=True):
            if abs(a - b) > 1e-9:
                sys.exit(f"the motions differ: {motion} and {other_motion} m")
        both.append((mine, other))
    mine, other = median([a for a, _ in both]), median([b for _, b in both])
    print(f"| one simulated second, {1 / STEP:.0f} Verlet steps | {1e3 * mine:.2f} ms |")
    print(f"| the same in EXUDYN | {1e3 * other:.1f} ms |")
    print(f"| EXUDYN to this program | {median([b / a for a, b in both]):.0f} |")


if __name__ == "__main__":
    main()
