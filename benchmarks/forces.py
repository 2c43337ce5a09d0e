"""Nominal track forces: accuracy on the exact circle and in simulation, and times.

Run from the repository: ``python benchmarks/forces.py``.
"""

from __future__ import annotations

import math
import os
import resource
import statistics
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

import numpy as np
from tables import print_machine

from trackctl.forces import speed_profile
from trackctl.forces.model import ForceModel
from trackctl.forces.nominal import nominal_forces
from trackctl.forces.reference import Reference
from trackctl.forces.sideslip_spline import solve_spline
from trackctl.forces.yaw_polynomial import solve_polynomial
from trackctl.geometry.clothoid_path import arc
from trackctl.workflows.forces_verification import try_out

REPOSITORY = Path(__file__).parents[1]
MODEL = ForceModel(
    mass=2000.0,
    yaw_inertia=15000.0,
    gauge=3.0,
    length=4.0,
    cog_height=0.6,
    lateral_friction=0.8,
    longitudinal_friction=0.8,
    gravity=9.81,
)
CIRCLE = arc(5.0, 2.0 * math.pi)
EXACT = {"sideslip": -0.1616753206, "zero_slide_offset": 0.8048595221, "total": 1030.220188, "difference": 8769.358207}
PEAKS = (2.0, 3.0, 4.0, 5.0)
ROUNDS = 20
POINTS = 100_000


def print_exact_circle() -> None:
    reference = Reference(CIRCLE, speed_profile.constant(CIRCLE.length, 4.0))
    yaw = solve_spline(MODEL, reference).yaw
    forces = nominal_forces(MODEL, reference, yaw, np.linspace(0.0, CIRCLE.length, 301))
    worst = max(float(np.abs(getattr(forces, name) / value - 1.0).max()) for name, value in EXACT.items())
    print(f"circle of 5 m at 4 m/s against the closed form (ten digits): {worst:.1e} relative")


def print_deviations() -> None:
    print("largest distance of the simulated mass centre from the path, m; circle of 5 m, 0.2 m/s to the peak and back")
    print(f"{'':28}" + "".join(f"{f'peak {peak:g} m/s':>14}" for peak in PEAKS))
    for name, order, profile in (
        *((f"triangle, order {order}", order, speed_profile.triangular) for order in (1, 3, 5, 7, 9)),
        ("triangle, spline", None, speed_profile.triangular),
        ("smooth, spline", None, speed_profile.smooth),
    ):
        cells = []
        for peak in PEAKS:
            reference = Reference(CIRCLE, profile(CIRCLE.length, 0.2, peak))
            solution = solve_polynomial(MODEL, reference, order) if order else solve_spline(MODEL, reference)
            cells.append(f"{try_out(MODEL, reference, solution).largest_deviation:14.2e}")
        print(f"{name:28}" + "".join(cells))


def print_solver_times() -> None:
    reference = Reference(CIRCLE, speed_profile.smooth(CIRCLE.length, 0.2, 3.0))
    for intervals in (20, 160):
        taken = []
        for _ in range(ROUNDS):
            started = perf_counter()
            solve_spline(MODEL, reference, intervals)
            taken.append(1e3 * (perf_counter() - started))
        print(f"solve, {intervals:3} intervals: {min(taken):.1f} ms best, {statistics.median(taken):.1f} ms median")


def print_command_times() -> None:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "path.csv"
        heading = np.cumsum(0.002 * np.sin(np.arange(POINTS) / 800.0))
        points = np.cumsum(0.1 * np.stack((np.cos(heading), np.sin(heading)), axis=1), axis=0)
        np.savetxt(path, points, delimiter=",", header="x_m,y_m", comments="", fmt="%.17g")
        for name, words, runs in (
            ("trackctl forces", [], 10),
            ("trackctl forces --verify", ["--verify"], 5),
            ("trackctl forces --speed-profile optimal", ["--speed-profile", "optimal"], 3),
            (f"trackctl forces PATH, 10 km, {POINTS} points", [str(path)], 3),
        ):
            taken = [seconds([*words, "--quiet", "-o", os.devnull]) for _ in range(runs)]
            print(f"{name}: {min(taken):.2f} s best, {statistics.median(taken):.2f} s median")
        peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024.0
        print(f"largest memory of all: {peak:.0f} MB")


def seconds(words: list[str]) -> float:
    """Wall time of one run of the command."""
    started = perf_counter()
    subprocess.run([sys.executable, "-m", "trackctl", "forces", *words], cwd=REPOSITORY, check=True)
    return perf_counter() - started


def main() -> None:
    print_machine()
    print_exact_circle()
    print_deviations()
    print_solver_times()
    print_command_times()


if __name__ == "__main__":
    main()
