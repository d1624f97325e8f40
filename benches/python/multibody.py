"""Balls and cage as bodies: `ballrace simulate` beside EXUDYN on one ball bearing; prints a table for docs/src/performance.md.

    python3 -m venv exudyn && exudyn/bin/pip install exudyn && exudyn/bin/python benches/python/multibody.py

Both have the same geometry, masses, speed and thrust. They differ in the contacts with the races (Hertz and a traction curve here, linear with regularised Coulomb friction
there, whose stiffness gives nearly the same axial displacement) and in the cage (pockets here, springs there). Build the program first: cargo build --release
"""

from __future__ import annotations

import csv
import json
import math
import subprocess
import tempfile
import time
import warnings
from pathlib import Path

import exudyn as exu
import numpy as np
from exudyn.machines import CreateBallBearing, GetBallBearingData
from exudyn.utilities import MarkerBodyRigid, RigidBodyInertia

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "target/release/ballrace"
# m, rad/s, N, s, kg/m^3, kg, N s/m
BALLS, DIAMETER, PITCH, CONFORMITY = 9, 7.94e-3, 39.04e-3, 0.52
SPEED, THRUST, SECONDS, DENSITY = 3000 * math.tau / 60, 500.0, 0.1, 7800.0
MASS, INERTIA, DAMPING, ACROSS = 1.0, (0.004, 0.004, 0.002), 2000.0, 1e6
#: Stiffness (N/m), damping (N s/m), friction coefficient and slip speed (m/s) of EXUDYN's linear contacts.
LINEAR = {"contactStiffness": 2.735e7, "contactDamping": 30, "dynamicFriction": 0.06, "frictionProportionalZone": 0.05}
#: Steps of EXUDYN, s.
STEPS = (1e-4, 1e-5)

SCENE = f"""
[shaft]
speed = {SPEED}
[rotor]
mass = {MASS}
diametral_inertia = {INERTIA[0]}
polar_inertia = {INERTIA[2]}
damping = [{DAMPING}, {DAMPING}, {DAMPING}, 5, 5]
stiffness = [{ACROSS}, {ACROSS}, 0, "1e5 N m/rad", "1e5 N m/rad"]
gravity = [0, 0, 0]
load = [0, 0, {THRUST}, 0, 0]
[[bearing]]
name = "B"
station = 0
model = "multibody"
elements = {BALLS}
ball_diameter = {DIAMETER}
pitch_diameter = {PITCH}
inner_conformity = {CONFORMITY}
outer_conformity = {CONFORMITY}
diametral_clearance = 0
density = {DENSITY}
"""


def ours(folder: Path) -> tuple[float, float, float]:
    """Return the mean speed of the cage (rad/s), the axial displacement (m) and processor seconds per second."""
    scene, motion, elements = (folder / name for name in ("scene.toml", "motion.csv", "elements.csv"))
    scene.write_text(SCENE)
    command = [PROGRAM, "simulate", scene, "--duration", f"{SECONDS} s", "--rate", "5 kHz", "-o", motion, "--format", "json"]
    out = subprocess.run([*command, "--elements", elements], check=True, capture_output=True, text=True)

    def mean(path: Path, column: str) -> float:
        values = [float(row[column]) for row in csv.DictReader(path.open())]
        return float(np.mean(values[len(values) // 2 :]))

    seconds = json.loads(out.stdout)["computing_seconds"] / SECONDS
    return mean(elements, "B_cage_speed"), mean(motion, "w"), seconds


def exudyn(step: float) -> tuple[float, float, float]:
    """Return the same of EXUDYN with implicit steps of `step`, s."""
    mbs = exu.SystemContainer().AddSystem()
    groove = CONFORMITY * DIAMETER
    data = GetBallBearingData(
        [0, 0, 1], 62e-3, 25e-3, 16e-3, BALLS, radiusBalls=DIAMETER / 2, radiusCage=PITCH / 2, heightCage=0.3 * DIAMETER,
        widthCage=1.2 * DIAMETER, innerGrooveRadius=groove, outerGrooveRadius=groove,
    )
    ground = mbs.CreateGround()
    # Its constraint turns the shaft in the negative sense.
    speed = -SPEED
    shaft = mbs.CreateRigidBody(
        referencePosition=[0, 0, 0], nodeType=exu.NodeType.RotationRxyz, initialAngularVelocity=[0, 0, speed],
        inertia=RigidBodyInertia(mass=MASS, inertiaTensor=np.diag(INERTIA)),
    )
    mbs.CreateCoordinateConstraint(bodyNumbers=[shaft, None], coordinates=[5, None], velocityLevel=True, offset=-speed)
    for tilt in (3, 4):
        mbs.CreateCoordinateConstraint(bodyNumbers=[shaft, None], coordinates=[tilt, None])
    mbs.CreateCartesianSpringDamper(bodyNumbers=[shaft, ground], stiffness=[ACROSS, ACROSS, 0], damping=[DAMPING] * 3)
    mbs.CreateForce(bodyNumber=shaft, loadVector=[0, 0, THRUST])
    rings = [mbs.AddMarker(MarkerBodyRigid(bodyNumber=body, localPosition=[0, 0, 0])) for body in (shaft, ground)]
    ratio = DIAMETER / PITCH
    cage = 0.5 * speed * (1 - ratio)
    spin = cage - 0.5 * speed / ratio * (1 - ratio**2)
    items = CreateBallBearing(
        mbs, data, *rings, DENSITY, 1400, cageInitialAngularVelocity=[0, 0, cage], ballsInitialAngularVelocity=[0, 0, spin],
        springStiffnessCage=1e5, springDampingCage=1e2, contactParametersRingBalls={**LINEAR, "contactStiffnessExponent": 1},
    )
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = round(SECONDS / step)
    settings.timeIntegration.endTime = SECONDS
    settings.timeIntegration.newton.useModifiedNewton = True
    settings.solutionSettings.writeSolutionToFile = False
    settings.linearSolverType = exu.LinearSolverType.EigenSparse
    settings.parallel.numberOfThreads = 1
    begin = time.process_time()
    mbs.SolveDynamic(settings)
    seconds = (time.process_time() - begin) / SECONDS
    spin_of_cage = mbs.GetObjectOutputBody(items["objectCage"], exu.OutputVariableType.AngularVelocity, localPosition=[0, 0, 0])
    moved = mbs.GetObjectOutputBody(shaft, exu.OutputVariableType.Displacement, localPosition=[0, 0, 0])
    return -spin_of_cage[2], moved[2], seconds


def main() -> None:
    """Print the table."""
    warnings.simplefilter("ignore")
    print("| program | cage over shaft | axial displacement, um | processor seconds per second |")
    print("| --- | --: | --: | --: |")
    with tempfile.TemporaryDirectory() as folder:
        rows = [("ballrace, error of a step below 0.1 nm", *ours(Path(folder)))]
    rows += [(f"EXUDYN {exu.GetVersionString()}, steps of {step * 1e6:.0f} us", *exudyn(step)) for step in STEPS]
    for name, cage, moved, seconds in rows:
        print(f"| {name} | {cage / SPEED:.4f} | {moved * 1e6:.1f} | {seconds:.1f} |")


if __name__ == "__main__":
    main()
