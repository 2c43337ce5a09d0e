"""Real-time factor of the simulation in CPU time, and its time beside scipy's Radau on the same right-hand side.

Run from the repository: ``python benchmarks/simulate.py``.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from time import thread_time

import numpy as np
from scipy.integrate import solve_ivp
from tables import print_machine

from trackctl.compiled import kernel
from trackctl.files.profile_yaml import load_terrain, load_vehicle
from trackctl.mechanics.parameters import STANDARD_GRAVITY
from trackctl.simulation.following import Feedback, follow, start_on
from trackctl.simulation.motion import Integration, State, integration, simulate
from trackctl.simulation.path import circle
from trackctl.simulation.path_rule import path_commands
from trackctl.simulation.track_speeds import constant_speeds
from trackctl.simulation.vehicle_rates import Scene, scene, vehicle_rates

SLOPE = math.radians(12.13)
LEFT, RIGHT = 0.2567, 0.5
DURATION = 20.0
ROUNDS = 3
#: Relative tolerance of the comparison, and of what both are measured against.
TOLERANCE, REFERENCE, FEEDBACK_REFERENCE = 1e-6, 1e-10, 1e-8
#: Fixed-point passes for the rates that the loads depend on.
PASSES = 30


def ground(*, remember: bool) -> Scene:
    """The slope of the paper's experiments."""
    return scene(load_vehicle("utv-61cm"), load_terrain("asphalt"), STANDARD_GRAVITY, SLOPE, remember=remember)


def driven(place: Scene, tolerance: float) -> Integration:
    """The simulation from rest."""
    return simulate(place, constant_speeds(LEFT, RIGHT, DURATION), State(), tolerance)[0]


def followed(place: Scene, feedback: Feedback, tolerance: float) -> Callable[[], Integration]:
    """Experiment B under the path rule, with contact memory, ready to run."""
    commands = path_commands(place, circle(2.0, 2.0 / 3.6, 2.0, (0.0, 0.0, 0.0)))

    def run() -> Integration:
        start = start_on(commands)
        return follow(place, commands, feedback, start, tolerance, steady_start=True, duration=DURATION)[0]

    return run


@kernel
def settle(place, pose, velocity, rate, memory, entries, result):
    """Rates that are consistent with the loads that they make, whatever rates came before."""
    rate[:] = 0.0
    for _ in range(PASSES):
        vehicle_rates(place, pose, velocity, rate, LEFT, RIGHT, memory, entries, result)
        rate[:] = result


def by_scipy(place: Scene, tolerance: float) -> np.ndarray:
    """The same by `solve_ivp`: pose and velocities at the end."""
    spare = integration(place, State(), 0.0, None)
    rate, result = np.zeros(3), np.zeros(3)

    def rates(_: float, state: np.ndarray) -> np.ndarray:
        pose, velocity = state[:3], state[3:]
        settle(place, pose, velocity, rate, spare.memory, spare.entries, result)
        cos_yaw, sin_yaw = math.cos(pose[2]), math.sin(pose[2])
        v_x, v_y, r = velocity
        return np.array([v_x * cos_yaw - v_y * sin_yaw, v_x * sin_yaw + v_y * cos_yaw, r, *rate])

    solution = solve_ivp(rates, (0.0, DURATION), np.zeros(6), method="Radau", rtol=tolerance, atol=0.1 * tolerance)
    return np.asarray(solution.y[:, -1])


def best_time(run, *arguments) -> float:
    """Least CPU time of some runs. [s]"""
    times = []
    for _ in range(ROUNDS):
        start = thread_time()
        run(*arguments)
        times.append(thread_time() - start)
    return min(times)


def main() -> None:
    """Print the table."""
    print_machine()
    with_memory, without = ground(remember=True), ground(remember=False)
    exact = driven(without, REFERENCE).pose
    print(f"{DURATION:.0f} s of experiment A from rest, tolerance {TOLERANCE:g}")
    print(f"{'':24}{'CPU / s':>10}{'real time':>11}{'steps':>7}{'error / m':>11}")
    for name, place in (("contact memory", with_memory), ("present motion", without)):
        reference = driven(place, REFERENCE).pose
        run = driven(place, TOLERANCE)
        seconds = best_time(driven, place, TOLERANCE)
        error = np.abs(run.pose - reference)[:2].max()
        print(f"{name:24}{seconds:10.3f}{DURATION / seconds:10.0f}x{run.count:7d}{error:11.1e}")
    for feedback in Feedback:
        reference = followed(with_memory, feedback, FEEDBACK_REFERENCE)().pose
        drive = followed(with_memory, feedback, TOLERANCE)
        run, seconds = drive(), best_time(drive)
        error = np.abs(run.pose - reference)[:2].max()
        name = f"B, feedback {feedback.value}"
        print(f"{name:24}{seconds:10.3f}{DURATION / seconds:10.0f}x{run.count:7d}{error:11.1e}")
    ours = best_time(driven, without, TOLERANCE)
    theirs = best_time(by_scipy, without, TOLERANCE)
    error = np.abs(by_scipy(without, TOLERANCE)[:3] - exact)[:2].max()
    print(f"{'scipy Radau, present':24}{theirs:10.3f}{DURATION / theirs:10.0f}x{'':7}{error:11.1e}")
    print(f"scipy over trackctl: {theirs / ours:.1f}")


if __name__ == "__main__":
    main()
