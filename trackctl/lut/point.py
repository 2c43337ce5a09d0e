"""One operating point on its own: no neighbours, no start given."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import compile_for, kernel
from trackctl.lut.branch import LOST, REACHED, settle
from trackctl.lut.cell import SOLVER, Solver, forget, model_of, near_no_slip, residual_at, solve_cold
from trackctl.lut.cells import Cells, pending_cells
from trackctl.lut.solver import load_procedures, solver
from trackctl.lut.swarm_search import SURELY_SMALLEST, search
from trackctl.mechanics.limits import ADMISSIBLE, exceeded_limit, proven_infeasible
from trackctl.mechanics.operating_point import operating_point
from trackctl.mechanics.parameters import TrackModel
from trackctl.solvers.random_stream import Stream, stream

Array = NDArray[np.float64]

NOT_CONVERGED = 5
#: Points that a thread takes at a time.
BATCH = 64


@kernel
def solve_point(
    solver: Solver,
    slope: float,
    velocity: float,
    curvature: float,
    heading: float,
    draws: Stream,
    try_no_slip: bool,
    x: Array,
) -> tuple[int, float]:
    """Solve one operating point; x receives the track speed ratios and the sideslip.

    Levenberg-Marquardt from the no-slip speeds comes first if `try_no_slip`, else the swarm. Where that finds no root,
    or one of large sideslip, the branch is followed from level ground; where this finds none, either, the swarm is the
    last to be asked.

    Returns
    -------
    tuple of int and float
        Code of `trackctl.lut.table.Status`, and the largest residual (without a root, the least met).
    """
    forget(solver)
    model = model_of(solver)
    point = operating_point(model, slope, velocity, curvature, heading)
    near_no_slip(model, curvature, x)
    least = residual_at(solver, point, x)
    proven = proven_infeasible(model, point)
    if proven != ADMISSIBLE:
        return proven, least
    if try_no_slip:
        found = solve_cold(solver, point, x)
    else:
        found, least = search(solver, point, draws, x)
    if not found or abs(x[2]) >= SURELY_SMALLEST:
        left, right, sideslip = x[0], x[1], x[2]
        end = settle(solver, point, x)
        if found and not (end == REACHED and abs(x[2]) <= abs(sideslip)):
            x[0], x[1], x[2] = left, right, sideslip
        elif not found and end != REACHED:
            if try_no_slip:
                found, least = search(solver, point, draws, x)
            if not found:
                return (NOT_CONVERGED if end == LOST else end), least
    # The balance at x, for its tractions.
    least = residual_at(solver, point, x)
    return exceeded_limit(model, point, x), least


@kernel
def solve_batch(
    memory: NDArray[np.void], points: Array, seed: int, first: int, try_no_slip: bool, cells: Cells
) -> None:
    """Solve the rows of `points` in one thread; row i draws from stream `first + i` of the seed."""
    solver = memory[0]
    x = np.empty(3)
    for i in range(points.shape[0]):
        slope, velocity, curvature, heading = points[i, 0], points[i, 1], points[i, 2], points[i, 3]
        draws = stream(seed, first + i)
        cell = cells[i]
        cell.status, cell.residual = solve_point(solver, slope, velocity, curvature, heading, draws, try_no_slip, x)
        if cell.status == ADMISSIBLE:
            for k in range(3):
                cell.unknowns[k] = x[k]
            for k in range(2):
                cell.traction[k] = solver.traction[k]


def compile_batch() -> None:
    """Compile `solve_batch`, or load it."""
    compile_for(solve_batch, np.zeros(1, SOLVER), np.zeros((1, 4)), 0, 0, True, pending_cells((1,)))


def solve_points(
    model: TrackModel, points: Array, *, seed: int = 0, swarm_always: bool = False, jobs: int = 1
) -> Cells:
    """Solve operating points one by one, by PSO-LM.

    Parameters
    ----------
    model
        Vehicle on its terrain.
    points
        Slope [rad], velocity [m/s], curvature [1/m] and heading [rad] of each point, shape (n, 4).
    seed
        Of the swarms; the answer of a point does not depend on the others, nor on `jobs`.
    swarm_always
        Search with the swarm at every point, instead of only where Levenberg-Marquardt fails from the no-slip speeds.
    jobs
        Number of threads.

    Returns
    -------
    Cells
        Shape (n,); unknowns and tractions are NaN unless the status is converged.
    """
    points = np.ascontiguousarray(points, dtype=np.float64)
    cells = pending_cells((points.shape[0],))
    bounds = range(0, points.shape[0], BATCH)

    def solve(first: int) -> None:
        part = slice(first, first + BATCH)
        solve_batch(solver(model), points[part], seed, first, not swarm_always, cells[part])

    load_procedures()
    compile_batch()
    with ThreadPoolExecutor(jobs) as pool:
        list(pool.map(solve, bounds))
    return cells
