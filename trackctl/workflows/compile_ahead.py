"""Compiling on several cores: other processes compile what a first run needs last, this one what it needs first.

All keep what they have compiled in the same folder and look there before they compile.
"""

from __future__ import annotations

import math
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

import numpy as np

from trackctl.compiled import kernels_are_compiled, kernels_can_be_kept
from trackctl.files.profile_yaml import load_terrain, load_vehicle
from trackctl.lut.axes import Axes
from trackctl.mechanics.parameters import STANDARD_GRAVITY, track_model

Wait = Callable[[str], object]

#: Profiles that come along; any would do.
VEHICLE, TERRAIN = "utv-61cm", "asphalt"


@contextmanager
def compiling_ahead(*tasks: str) -> Iterator[Wait]:
    """Let other processes compile, while the block runs, what some of `TASKS` use; gives a function that waits for one.

    Should one fail, its kernels are compiled where they are used. There is none for what an earlier run has compiled,
    nor if there is but one core, or no folder to keep it in.
    """
    if (os.cpu_count() or 1) < 2 or not kernels_can_be_kept():
        tasks = ()
    with ExitStack() as running:
        missing = [task for task in tasks if not kernels_are_compiled(TASKS[task][1])]
        others = {task: running.enter_context(other_process(task)) for task in missing}
        yield lambda task: others[task].wait() if task in others else None


@contextmanager
def other_process(task: str) -> Iterator[subprocess.Popen[bytes]]:
    """A process that does a task while the block runs."""
    command = [sys.executable, "-m", __name__, task]
    with subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    ) as other:
        try:
            yield other
        finally:
            other.kill()


def small_axes() -> Axes:
    """Grid of a few cells."""
    return Axes(np.array([0.1]), np.array([0.1, 0.2]), np.array([0.0, 0.5]), np.array([0.0, 0.1]), False)


def use_interpolation() -> None:
    """A look-up in a table of zeros."""
    from trackctl.lut.interpolation import interpolant_of, look_up

    axes = small_axes()
    table = interpolant_of(
        axes, np.zeros((*axes.shape, 3)), np.zeros(axes.shape, np.uint8), load_vehicle(VEHICLE), math.inf
    )
    look_up(table, axes.slope, axes.velocity[:1], axes.curvature[:1], axes.heading[:1])


def use_sensitivity() -> None:
    """PAWN indices of noise."""
    from trackctl.sensitivity.pawn import pawn_indices

    noise = np.random.default_rng(0).random((200, 2))
    pawn_indices(noise[:, :1], noise[:, 1:], ("input",), ("output",), slices=2, resamples=2)


def use_column() -> None:
    """A column of a table; the swarm first, which the other process compiles last."""
    from trackctl.lut.swarm_search import linked_search
    from trackctl.lut.sweep import Seeding, Sweep, solve

    linked_search.link()
    model = track_model(load_vehicle(VEHICLE), load_terrain(TERRAIN), STANDARD_GRAVITY)
    solve(Sweep(model, small_axes(), Seeding.CONTINUATION, 0), 0)


def use_table() -> None:
    """What a table takes, that which is needed last before that which is needed first."""
    use_interpolation()
    use_sensitivity()
    use_column()


def use_search() -> None:
    """A search of a way."""
    from trackctl.planning.search import load_kernels

    load_kernels()


def use_driving() -> None:
    """Commands along a short way in an empty room."""
    from trackctl.planning.clearance import least_clearance
    from trackctl.planning.collision import obstacles_of
    from trackctl.planning.footprint import footprint_of
    from trackctl.planning.search import empty_room
    from trackctl.workflows.plan_kernels import load_driving_kernels
    from trackctl.workflows.plan_model import drive_model

    room, vehicle, terrain = empty_room(), load_vehicle(VEHICLE), load_terrain(TERRAIN)
    obstacles, limits = obstacles_of(room.grid, footprint_of(room.footprint)), (room.forward, None)
    model = drive_model(vehicle, terrain, STANDARD_GRAVITY, room.field, obstacles, limits, vehicle.max_speed)
    load_driving_kernels(model, room.start)
    least_clearance(obstacles, *np.array(room.start)[:, None])


def use_simulation() -> None:
    """A short motion."""
    from trackctl.simulation.motion import State, integration, sample
    from trackctl.simulation.run_state import Settings
    from trackctl.simulation.track_speeds import TrackSpeeds, speed_pieces
    from trackctl.simulation.vehicle_rates import scene

    vehicle = load_vehicle(VEHICLE)
    surroundings = scene(vehicle, load_terrain(TERRAIN), STANDARD_GRAVITY, 0.0)
    simulation = integration(surroundings, State(), 0.0, None)
    speed = np.array([0.0, 0.01])
    simulation.advance(speed_pieces(TrackSpeeds(speed, speed, speed)), Settings(1e-3, math.inf, math.inf))
    sample(simulation, vehicle.mass, speed)


#: What can be compiled ahead, and a kernel that is there once that is done.
TASKS: dict[str, tuple[Callable[[], None], str]] = {
    "table": (use_table, "column.solve_column"),
    "column": (use_column, "column.solve_column"),
    "search": (use_search, "simplification.simplify"),
    "driving": (use_driving, "clearance._least_clearance"),
    "simulation": (use_simulation, "motion.loads_along"),
}


def make_ready(task: str) -> None:
    """Compile what a task uses here and now, unless an earlier run has."""
    use, kernel = TASKS[task]
    if not kernels_are_compiled(kernel):
        use()


if __name__ == "__main__":
    TASKS[sys.argv[1]][0]()
