"""Growth of processor time with the size of a problem; prints a table for docs/src/performance.md.

    cargo build --release && python3 benches/python/growth.py

The exponent is that of a power law through the processor times of the sizes of each row, after the time that does not depend on the size: a motion is computed
over two durations, and the difference counts. The last column is the exponent of the last doubling alone.
"""

from __future__ import annotations

import math
import resource
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "target/release/ballrace"
ROUNDS = 3

ROTOR = """[shaft]
speed = "3000 rpm"
[rotor]
mass = 6
diametral_inertia = 0.03
polar_inertia = 0.006
damping = [400, 400, 400, 0.4, 0.4]
stiffness = [0, 0, 1e6, 1e4, 1e4]
load = [0, -300, 60, 0, 0]
"""
BALLS = """ball_diameter = "2 mm"
pitch_diameter = "60 mm"
inner_conformity = 0.52
outer_conformity = 0.52
"""
STEP = '[integration]\nmethod = "verlet"\nstep = "10 us"\n'


def processor_seconds(folder: Path, *arguments: str) -> float:
    """Return the least processor time of a command in some rounds; a folder `fleet` of the round before is removed."""
    times = []
    for _ in range(ROUNDS):
        shutil.rmtree(folder / "fleet", ignore_errors=True)
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([PROGRAM, *arguments], cwd=folder, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        times.append(after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime)
    return min(times)


def motion(folder: Path, scene: str, seconds: float) -> float:
    """Return the processor time of a motion, less that of its first tenth."""
    (folder / "scene.toml").write_text(scene)

    def of(duration: float) -> float:
        return processor_seconds(folder, "simulate", "scene.toml", "--duration", f"{duration} s", "--rate", "500 Hz", "-o", "motion.csv")

    return of(seconds) - of(0.1 * seconds)


def bearing(name: str, station: int, model: str, elements: int, more: str) -> str:
    return f'[[bearing]]\nname = "{name}"\nstation = "{station} mm"\nmodel = "{model}"\nelements = {elements}\n{more}\n'


def elements(folder: Path, count: int) -> float:
    """Return the time with so many balls in each of two bearings."""
    more = BALLS + 'diametral_clearance = "10 um"'
    scene = ROTOR + bearing("A", -100, "angular", count, more) + bearing("B", 100, "angular", count, more) + STEP
    return motion(folder, scene, 20.0)


def bodies(folder: Path, count: int) -> float:
    """Return the time with so many balls as bodies."""
    more = BALLS + 'contact_angle = "15 deg"\nfacing = "+z"'
    return motion(folder, ROTOR + bearing("A", 0, "multibody", count, more), 0.02)


def laminae(folder: Path, count: int) -> float:
    """Return the time with so many laminae on each of 14 rollers."""
    more = f'roller_diameter = "7.5 mm"\nroller_length = "9 mm"\npitch_diameter = "38.5 mm"\nradial_play = "5 um"\nlaminae = {count}'
    return motion(folder, ROTOR + bearing("A", 0, "roller", 14, more) + STEP, 10.0)


def bearings(folder: Path, count: int) -> float:
    """Return the time with so many bearings of nine balls."""
    more = BALLS + 'diametral_clearance = "10 um"'
    all_of_them = "".join(bearing(f"B{i}", 40 * i - 140, "angular", 9, more) for i in range(count))
    return motion(folder, ROTOR + all_of_them + STEP, 20.0)


def coordinates(folder: Path, count: int) -> float:
    """Return the time of a system with full matrices of so many coordinates."""
    for name, diagonal, other in (("M", 1.0, 0.001), ("K", 1e6, 10.0), ("B", 100.0, 0.01)):
        values = "\n".join(f"{diagonal if i == j else other}" for j in range(count) for i in range(count))
        (folder / f"{name}.mtx").write_text(f"%%MatrixMarket matrix array real general\n{count} {count}\n{values}\n")
    springs = "[[1e5, 0, 0, 0, 0], [0, 1e5, 0, 0, 0], [0, 0, 1e5, 0, 0], [0, 0, 0, 1e3, 0], [0, 0, 0, 0, 1e3]]"
    scene = f"""[shaft]
speed = "3000 rpm"
[system]
mass = "M.mtx"
stiffness = "K.mtx"
damping = "B.mtx"
[[bearing]]
name = "A"
coordinates = [1, 2, 0, 0, 0]
model = "linear"
elements = 9
stiffness_matrix = {springs}
""" + '[integration]\nmethod = "runge-kutta"\nstep = "50 us"\n'
    return motion(folder, scene, 4.0)


def recorded(folder: Path, seconds: float, probes: int) -> str:
    """Write a recording of the demonstration with so many probes; return its scene."""
    text = (ROOT / "runner/demo/healthy.toml").read_text()
    begin, end = text.index("probes = ["), text.index("\n]", text.index("probes = [")) + 2
    probe = '  {{ column = "P{0}", unit = "um", station = "{1} mm", angle = "{2} deg", noise = "0.03 um" }},\n'
    lines = "".join(probe.format(i, 240 * (i // 2) / max(1, probes // 2 - 1) - 120, 90 * (i % 2)) for i in range(probes))
    scene = text[:begin] + "probes = [\n" + lines + "]" + text[end:]
    scene = scene.replace('file = "healthy.csv"', 'file = "recording.npy"')
    (folder / "machine.toml").write_text(scene)
    command = [PROGRAM, "simulate", "machine.toml", "--duration", f"{seconds} s", "--as-recording", "-o", "recording.npy"]
    subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return scene


def length(folder: Path, seconds: int) -> float:
    """Return the time of a replay of a recording so long."""
    recorded(folder, seconds, 4)
    return processor_seconds(folder, "replay", "machine.toml", "--no-report")


def probes(folder: Path, count: int) -> float:
    """Return the time of a replay with so many probes."""
    recorded(folder, 8.0, count)
    return processor_seconds(folder, "replay", "machine.toml", "--no-report")


def machines(folder: Path, count: int) -> float:
    """Return the time of a fleet of so many machines."""
    recorded(folder, 2.0, 4)
    (folder / "machines.csv").write_text("machine,scene,recording\n" + "".join(f"m{i},machine.toml,recording.npy\n" for i in range(count)))
    return processor_seconds(folder, "fleet", "machines.csv", "-o", "fleet")


ROWS: list[tuple[str, Callable[[Path, int], float], list[int]]] = [
    ("elements of two bearings, `angular`", elements, [8, 16, 32, 64]),
    ("balls of `multibody`", bodies, [8, 16, 32, 64]),
    ("laminae of 14 rollers", laminae, [5, 10, 20, 40]),
    ("bearings", bearings, [1, 2, 4, 8]),
    ("coordinates, full matrices", coordinates, [8, 16, 32, 64, 128]),
    ("probes, replay of 8 s", probes, [4, 8, 16]),
    ("length of a recording, s", length, [4, 8, 16, 32]),
    ("machines of a fleet", machines, [2, 4, 8]),
]


def exponent(sizes: list[int], times: list[float]) -> float:
    """Return the slope of the line through the logarithms."""
    x, y = [math.log(size) for size in sizes], [math.log(time) for time in times]
    middle = sum(x) / len(x), sum(y) / len(y)
    return sum((a - middle[0]) * (b - middle[1]) for a, b in zip(x, y)) / sum((a - middle[0]) ** 2 for a in x)


def main() -> None:
    print("| time over | sizes | processor seconds | exponent | last doubling |")
    print("| --- | --- | --- | --: | --: |")
    for name, measured, sizes in ROWS:
        with tempfile.TemporaryDirectory() as folder:
            times = [measured(Path(folder), size) for size in sizes]
        cells = ", ".join(map(str, sizes)), ", ".join(f"{time:.2f}" for time in times)
        last = math.log2(times[-1] / times[-2])
        print(f"| {name} | {cells[0]} | {cells[1]} | {exponent(sizes, times):.2f} | {last:.2f} |", flush=True)


if __name__ == "__main__":
    main()
