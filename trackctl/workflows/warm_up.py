"""Compiling kernels before they are needed, side by side on all cores.

A piece is what one process compiles at a time. What it has compiled is kept in the kernels' folder with a mark of its
name, so that later runs neither compile nor look further.
"""

from __future__ import annotations

import contextlib
import math
import os
import subprocess
import sys
from collections.abc import Callable, Collection, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue
from threading import Lock, Thread
from typing import TYPE_CHECKING

from trackctl.compiled import Compiled, compile_for, kernel_folder, reason_not_kept
from trackctl.machine import cores

if TYPE_CHECKING:
    from trackctl.mechanics.parameters import TrackModel

Progress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True)
class Piece:
    """Kernels that are compiled together.

    Attributes
    ----------
    compile
        Compiles them, or loads them.
    seconds
        About how long that takes on one core.
    """

    compile: Callable[[], object]
    seconds: float


def _model() -> TrackModel:
    from trackctl.files.profile_yaml import load_terrain, load_vehicle
    from trackctl.mechanics.parameters import STANDARD_GRAVITY, track_model

    return track_model(load_vehicle(VEHICLE), load_terrain(TERRAIN), STANDARD_GRAVITY)


def _balance() -> None:
    from trackctl.lut.cell import improve_there, linearise_there, residuals_there

    for procedure in (linearise_there, residuals_there, improve_there):
        procedure.load()


def _branch() -> None:
    from trackctl.lut.branch import follow_there

    follow_there.load()


def _swarm() -> None:
    from trackctl.lut.swarm_search import search_there

    search_there.load()


def _column() -> None:
    from trackctl.lut.column import compile_column

    compile_column()


def _point() -> None:
    from trackctl.lut.point import compile_batch

    compile_batch()


def _interpolation() -> None:
    import numpy as np

    from trackctl.files.profile_yaml import load_vehicle
    from trackctl.lut.axes import Axes
    from trackctl.lut.interpolation import interpolant_of, look_up, table_points

    axes = Axes(np.array([0.1]), np.array([0.1, 0.2]), np.array([0.0, 0.5]), np.array([0.0, 0.1]), False)
    zeros, status = np.zeros((*axes.shape, 3)), np.zeros(axes.shape, np.uint8)
    table = interpolant_of(axes, zeros, status, load_vehicle(VEHICLE), math.inf)
    look_up(table, axes.slope, axes.velocity[:1], axes.curvature[:1], axes.heading[:1])
    compile_for(table_points, np.zeros((4, 1)), True, 0.0)


def _sensitivity() -> None:
    import numpy as np

    from trackctl.sensitivity.pawn import pawn_indices

    noise = np.random.default_rng(0).random((200, 2))
    pawn_indices(noise[:, :1], noise[:, 1:], ("input",), ("output",), slices=2, resamples=2)


def _growth() -> None:
    from trackctl.planning.search import compile_growth

    compile_growth()


def _polishing() -> None:
    from trackctl.planning.search import compile_polishing

    compile_polishing()


def _simplification() -> None:
    from trackctl.planning.search import compile_simplification

    compile_simplification()


def _driving() -> None:
    import numpy as np

    from trackctl.files.profile_yaml import load_terrain, load_vehicle
    from trackctl.mechanics.parameters import STANDARD_GRAVITY
    from trackctl.planning.clearance import least_clearance
    from trackctl.planning.collision import obstacles_of
    from trackctl.planning.footprint import footprint_of
    from trackctl.planning.planning_map import block_unknown_ground
    from trackctl.planning.pose import advanced
    from trackctl.planning.search import empty_room
    from trackctl.workflows.plan_kernels import load_driving_kernels
    from trackctl.workflows.plan_model import drive_model

    room, vehicle, terrain = empty_room(), load_vehicle(VEHICLE), load_terrain(TERRAIN)
    obstacles, limits = obstacles_of(room.grid, footprint_of(room.footprint)), (room.forward, None)
    model = drive_model(vehicle, terrain, STANDARD_GRAVITY, room.field, obstacles, limits, vehicle.max_speed)
    load_driving_kernels(model, room.start)
    compile_for(advanced, 0.0, 0.0, 0.0, 0.0, 0.0)
    least_clearance(obstacles, *np.array(room.start)[:, None])
    block_unknown_ground(room.grid.blocked, room.field, (0.0, 0.0), (1.0, 0.0))


def _track_force() -> None:
    from trackctl.simulation.ground_force import track_force_there

    track_force_there.load()


def _simulation() -> None:
    from trackctl.simulation.motion import compile_simulation

    compile_simulation(_model())


def _path_rule() -> None:
    from trackctl.simulation.path_rule import compile_path_rule

    compile_path_rule(_model())


def _filter() -> None:
    import numpy as np

    from trackctl.identification.identifier import FilterSettings, LogFilter

    learning = LogFilter(FilterSettings(1.0))
    learning.feed(np.zeros((1, 6)))
    learning.finish()


def _steady_motions() -> None:
    import numpy as np

    from trackctl.identification.steady_motion import steady_motions

    steady_motions(_model(), np.ones((1, 2)))


#: Profiles that come along; any would do.
VEHICLE, TERRAIN = "utv-61cm", "asphalt"

#: In the order in which they are begun: what takes long first, what shares kernels with an earlier one last.
PIECES = {
    "growth": Piece(_growth, 18.0),
    "filter": Piece(_filter, 10.0),
    "simulation": Piece(_simulation, 6.0),
    "balance": Piece(_balance, 3.5),
    "column": Piece(_column, 4.0),
    "branch": Piece(_branch, 2.0),
    "swarm": Piece(_swarm, 1.6),
    "track force": Piece(_track_force, 2.5),
    "interpolation": Piece(_interpolation, 2.0),
    "path rule": Piece(_path_rule, 2.5),
    "driving": Piece(_driving, 3.0),
    "steady motions": Piece(_steady_motions, 3.0),
    "point": Piece(_point, 0.6),
    "sensitivity": Piece(_sensitivity, 1.0),
    "polishing": Piece(_polishing, 6.5),
    "simplification": Piece(_simplification, 3.0),
}

_SOLVER = ("balance", "branch", "swarm")
#: Pieces that commands need, by what they do.
TASKS = {
    "solve points": (*_SOLVER, "point"),
    "solve columns": (*_SOLVER, "column"),
    "compile a table": (*_SOLVER, "point", "column", "interpolation", "sensitivity"),
    "look up": ("interpolation",),
    "indices": (*_SOLVER, "point", "sensitivity"),
    "plan": ("growth", "track force", "polishing", "simplification", "path rule", "driving"),
    "simulate": ("simulation", "track force", "path rule"),
    "filter a log": ("filter",),
    "calibrate": ("filter", "steady motions"),
}


def missing(tasks: Iterable[str]) -> list[str]:
    """Pieces of tasks that no earlier run has compiled, in the order of `PIECES`."""
    wanted = {name for task in tasks for name in TASKS[task]}
    return [name for name in PIECES if name in wanted and not _is_marked(name)]


def estimate(names: Collection[str]) -> float:
    """About how long pieces take, side by side where they can be kept. [s]"""
    total = sum(PIECES[name].seconds for name in names)
    return total if reason_not_kept() else total / min(cores(), len(names))


def warm_up(names: Collection[str], progress: Progress = lambda done, total: None) -> None:
    """Compile pieces: in other processes, or in this one where it could not load what they compile.

    Parameters
    ----------
    names
        Of `PIECES`.
    progress
        Told a measure of the work done, and of all.
    """
    total = sum(PIECES[name].seconds for name in names)
    left, lock = list(names), Lock()

    def done(name: str) -> None:
        with lock:
            left.remove(name)
            progress(round(100.0 * (1.0 - sum(PIECES[each].seconds for each in left) / total)), 100)

    progress(0, 100)
    workers = min(cores(), len(left))
    if workers > 1 and not reason_not_kept():
        _compile_side_by_side(left, workers, done)
    for name in list(left):
        _compile(name)
        done(name)


def _compile_side_by_side(names: Iterable[str], workers: int, done: Callable[[str], None]) -> None:
    """Let other processes compile pieces; what a process fails at, or does not get to, is left over."""
    waiting = iter(list(names))
    with contextlib.ExitStack() as running:
        pool = running.enter_context(ThreadPoolExecutor(workers))  # first, since it ends once they are killed
        others = [running.enter_context(_other_process()) for _ in range(workers)]

        def serve(other: subprocess.Popen[str]) -> None:
            for name in waiting:
                if not _ask(other, name):
                    return
                done(name)

        for served in [pool.submit(serve, other) for other in others]:
            served.result()


@contextlib.contextmanager
def _other_process() -> Iterator[subprocess.Popen[str]]:
    """A process that runs `main` while the block runs."""
    pipe, nowhere = subprocess.PIPE, subprocess.DEVNULL
    with subprocess.Popen(
        [sys.executable, "-P", "-m", __name__], stdin=pipe, stdout=pipe, stderr=nowhere, text=True
    ) as other:
        try:
            yield other
        finally:
            other.kill()


def _ask(other: subprocess.Popen[str], name: str) -> bool:
    """Let a process compile a piece; False if it fails."""
    if other.stdin is None or other.stdout is None:
        return False
    try:
        print(name, file=other.stdin, flush=True)
    except OSError:
        return False
    return other.stdout.readline().strip() == name


def _compile(name: str) -> None:
    """Compile a piece here and now; if it could be kept, mark it by the names of its files."""
    PIECES[name].compile()
    if Compiled.are_kept():
        with contextlib.suppress(OSError):
            _mark(name).parent.mkdir(parents=True, exist_ok=True)
            files = "".join(f"{file.as_posix()}\n" for file in Compiled.kept_files())
            _mark(name).write_text(files, encoding="utf-8")


def _mark(name: str) -> Path:
    return kernel_folder() / "compiled" / name.replace(" ", "-")


def _is_marked(name: str) -> bool:
    """Whether a piece has been compiled, and its files are still there."""
    try:
        files = _mark(name).read_text(encoding="utf-8").splitlines()
        return all((kernel_folder() / file).is_file() for file in files)
    except (OSError, UnicodeDecodeError):
        return False


def main() -> None:
    """Compile the pieces named on standard input, a line each, and name each on standard output once it is kept."""
    asked: SimpleQueue[str] = SimpleQueue()

    def listen() -> None:
        for line in sys.stdin:
            asked.put(line.strip())
        os._exit(0)  # whoever asks has ended

    Thread(target=listen, daemon=True).start()
    while True:
        name = asked.get()
        _compile(name)
        print(name if _is_marked(name) else "not kept", flush=True)  # noqa: T201  the other process reads it


if __name__ == "__main__":
    main()
