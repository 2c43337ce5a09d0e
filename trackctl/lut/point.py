"""One operating point on its own: no neighbours, no start given."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel
from trackctl.lut.branch import REACHED, Way, follow
from trackctl.lut.cell import residual_at, solve_warm
from trackctl.lut.swarm_search import Searcher, no_slip, search
from trackctl.mechanics.limits import ADMISSIBLE, GRIP, exceeded_limit, proven_infeasible
from trackctl.mechanics.operating_point import operating_point
from trackctl.solvers.levenberg_marquardt import largest
from trackctl.solvers.random_stream import Stream

Array = NDArray[np.float64]

NOT_CONVERGED = 5
#: A point without a root whose least residual lies above this is infeasible; below it, the search has failed.
CLEARLY_UNBALANCED = 1e-2


@kernel
def solve_point(
    searcher: Searcher,
    slope: float,
    velocity: float,
    curvature: float,
    heading: float,
    stream: Stream,
    try_no_slip: bool,
    x: Array,
) -> tuple[int, float]:
    """Solve one operating point; x receives the track speed ratios and the sideslip.

    Levenberg-Marquardt from the no-slip speeds comes first if `try_no_slip`, then the swarm. Where neither finds a root,
    the branch is followed from standstill: where it ends on the way, the point is infeasible.

    Returns
    -------
    tuple of int and float
        Code of `trackctl.lut.table.Status`, and the largest residual (without a root, the least met).
    """
    solver = searcher.fine
    model = solver.model
    point = operating_point(model, slope, velocity, curvature, heading)
    no_slip(model, curvature, x)
    proven = proven_infeasible(model, point)
    if proven != ADMISSIBLE:
        return proven, residual_at(solver, point, x)
    if try_no_slip and solve_warm(solver, point, x):
        return exceeded_limit(model, point, x), largest(solver.work.residual)
    found, least = search(searcher, point, stream, x)
    if found:
        return exceeded_limit(model, point, x), least
    standing = operating_point(model, slope, 0.0, curvature, heading)
    no_slip(model, curvature, x)
    if solve_warm(solver, standing, x) or search(searcher, standing, stream, x)[0]:
        end = follow(solver, Way(slope, curvature, 0.0, velocity, heading, heading), x)
        if end == REACHED and solve_warm(solver, point, x):
            return exceeded_limit(model, point, x), largest(solver.work.residual)
        if end > 0:
            return end, least
    return (GRIP if least > CLEARLY_UNBALANCED else NOT_CONVERGED), least
