"""A column of a table: all velocities and headings at one slope and curvature, solved by continuation.

A column depends on no other, so a table's cells do not depend on how columns are dealt to workers. Within it a row is
one velocity. A row goes round the headings both ways, each cell started by extrapolating its neighbours, or from the
row below; a gap next to a root is entered by following the branch. What that leaves is decided by following the branch
from level ground: to a root, which leads on into its neighbours, or to the fold or limit that ends it, which is the
evidence that the cell is infeasible. Only where the branch gets lost, the swarm decides.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import compile_for, inlined, kernel
from trackctl.lut.branch import LOST, REACHED, Way, follow, settle
from trackctl.lut.cell import MOST_DIFFERENCES, SOLVER, Solver, forget, model_of, near_no_slip, residual_at, solve_warm
from trackctl.lut.cells import PENDING, Cells, pending_cells
from trackctl.lut.point import NOT_CONVERGED
from trackctl.lut.swarm_search import search
from trackctl.mechanics.limits import ADMISSIBLE, exceeded_limit, proven_infeasible, surely_admissible
from trackctl.mechanics.operating_point import OperatingPoint, operating_point
from trackctl.solvers.levenberg_marquardt import largest
from trackctl.solvers.random_stream import stream

Array = NDArray[np.float64]

#: Infeasible cells are decided one by one unless they lie between two at most so far apart [rad] for which the branch
#: from level ground ends so early that it would still do so, did the end move on by `CAUTION` times their difference.
SPAN = math.radians(8.0)
CAUTION = 3.0


class Column(NamedTuple):
    """What is asked of a column.

    Attributes
    ----------
    slope, curvature
        [rad], [1/m]
    velocity, heading
        Nodes, shapes (n_velocity,) and (n_heading,). [m/s], [rad]
    periodic
        Whether the last heading is followed by the first.
    seed
        Of the swarms; each cell has its own stream.
    """

    slope: float
    curvature: float
    velocity: Array
    heading: Array
    periodic: bool
    seed: int


@kernel
def point_of(solver: Solver, column: Column, row: int, cell: int) -> OperatingPoint:
    """Operating point of a cell."""
    model = model_of(solver)
    return operating_point(model, column.slope, column.velocity[row], column.curvature, column.heading[cell])


@inlined
def has_root(cells: Cells, row: int, cell: int) -> bool:
    """Whether a cell has a root, be it one beyond a limit."""
    return row >= 0 and not math.isnan(cells[row, cell].unknowns[0])


@kernel
def store(solver: Solver, cells: Cells, row: int, cell: int, point: OperatingPoint, x: Array) -> None:
    """Note the root just found."""
    cells[row, cell].status = exceeded_limit(model_of(solver), point, x)
    cells[row, cell].residual = largest(solver.work.residual)
    for i in range(3):
        cells[row, cell].unknowns[i] = x[i]
    for i in range(2):
        cells[row, cell].traction[i] = solver.traction[i]


@inlined
def neighbour(column: Column, cell: int, offset: int) -> int:
    """Index of a cell's neighbour in heading, or -1 beyond the end."""
    count = column.heading.size
    index = cell + offset
    if 0 <= index < count:
        return index
    if not column.periodic:
        return -1
    return index - count if index > 0 else index + count


@kernel
def note(solver: Solver, root: Array, known: int) -> int:
    """Add a root to the differences of the `known` before it along the row; how many are known now."""
    d = solver.difference
    for i in range(3):
        latest = root[i]
        for m in range(min(known, MOST_DIFFERENCES) + 1):
            earlier = d[m, i]
            d[m, i] = latest
            latest -= earlier
    return known + 1


@kernel
def predict(solver: Solver, known: int, x: Array) -> None:
    """Start of the next cell of the row: the extrapolation of the order that was best at the last one.

    The m-th backward difference is the error there of the extrapolation from m cells, which is the sum of the
    differences below the m-th.
    """
    d = solver.difference
    order, least = 1, np.inf
    for m in range(1, min(known - 1, MOST_DIFFERENCES) + 1):
        error = d[m, 0] * d[m, 0] + d[m, 1] * d[m, 1] + d[m, 2] * d[m, 2]
        if error < least:
            order, least = m, error
    for i in range(3):
        x[i] = 0.0
        for m in range(order):
            x[i] += d[m, i]


@kernel
def solve_pending(solver: Solver, column: Column, cells: Cells, row: int, cell: int, known: int, x: Array) -> None:
    """Solve a pending cell from the `known` roots before it, or else once from the row below."""
    point = point_of(solver, column, row, cell)
    solved = False
    if known > 0:
        predict(solver, known, x)
        solved = solve_warm(solver, point, x)
    if not solved and math.isnan(cells[row, cell].residual) and has_root(cells, row - 1, cell):
        for i in range(3):
            x[i] = cells[row - 1, cell].unknowns[i]
        solved = solve_warm(solver, point, x)
        cells[row, cell].residual = largest(solver.work.residual)
    if solved:
        store(solver, cells, row, cell, point, x)


@kernel
def sweep(solver: Solver, column: Column, cells: Cells, row: int, first: int, direction: int, x: Array) -> None:
    """Solve the pending cells of a row in the order of travel, from where neighbours or the row below are known.

    Periodic headings are gone round one and a half times.
    """
    count = column.heading.size
    pending = count_pending(cells, row)
    none = int(np.int64(0))  # no literal: numba would compile the loop's kernels for it, too
    known, cell = none, first
    for _ in range(count + count // 2 if column.periodic else count):
        if pending == 0:
            return
        if cells[row, cell].status == PENDING:
            solve_pending(solver, column, cells, row, cell, known, x)
            pending -= cells[row, cell].status != PENDING
        known = note(solver, cells[row, cell].unknowns, known) if has_root(cells, row, cell) else none
        cell = neighbour(column, cell, direction)
        if cell < 0:
            return


@kernel
def count_pending(cells: Cells, row: int) -> int:
    """Number of pending cells of a row."""
    pending = 0
    for cell in range(cells.shape[1]):
        pending += cells[row, cell].status == PENDING
    return pending


@kernel
def sweep_both_ways(solver: Solver, column: Column, cells: Cells, row: int, easiest: int, x: Array) -> None:
    """Sweep a row forwards and backwards, from its easiest cell where headings are periodic."""
    for direction in (1, -1):
        end = 0 if direction > 0 else column.heading.size - 1
        first = easiest if column.periodic else end
        sweep(solver, column, cells, row, first, direction, x)


@kernel
def easiest_heading(column: Column) -> int:
    """The heading nearest to where gravity points to the turning centre."""
    best, cell = -2.0, 0
    side = math.copysign(1.0, column.curvature)
    for k in range(column.heading.size):
        ease = side * math.sin(column.heading[k])
        if ease > best:
            best, cell = ease, k
    return cell


@kernel
def bound_row(solver: Solver, column: Column, cells: Cells, row: int) -> int:
    """Mark the cells of a row that are proven infeasible, the others pending; the number of pending cells."""
    model = model_of(solver)
    centripetal = column.velocity[row] * column.velocity[row] * column.curvature / model.gravity
    proves_nothing = surely_admissible(model, column.slope, centripetal)
    pending = 0
    for cell in range(column.heading.size):
        proven = ADMISSIBLE
        if not proves_nothing:
            proven = proven_infeasible(model, point_of(solver, column, row, cell))
        for i in range(3):
            cells[row, cell].unknowns[i] = np.nan
        for i in range(2):
            cells[row, cell].traction[i] = np.nan
        cells[row, cell].residual = np.nan
        cells[row, cell].status = PENDING if proven == ADMISSIBLE else proven
        pending += proven == ADMISSIBLE
    return pending


@kernel
def reach(solver: Solver, column: Column, cells: Cells, row: int, cell: int, x: Array) -> bool:
    """Follow the branch into a pending cell from neighbours with a root; True if it leads there."""
    point = point_of(solver, column, row, cell)
    for direction in (1, -1):
        beside = neighbour(column, cell, direction)
        if beside >= 0 and has_root(cells, row, beside):
            for i in range(3):
                x[i] = cells[row, beside].unknowns[i]
            way = Way(point_of(solver, column, row, beside), point)
            if follow(solver, way, x) == REACHED and solve_warm(solver, point, x):
                store(solver, cells, row, cell, point, x)
                return True
    return False


@kernel
def reach_next(solver: Solver, column: Column, cells: Cells, row: int, x: Array) -> bool:
    """Reach a pending cell of the row; False if none can be."""
    for cell in range(column.heading.size):
        if cells[row, cell].status == PENDING and reach(solver, column, cells, row, cell, x):
            return True
    return False


@kernel
def fill(solver: Solver, column: Column, cells: Cells, row: int, easiest: int, x: Array) -> None:
    """Solve the pending cells of a row that its roots, or those below, lead to."""
    sweep_both_ways(solver, column, cells, row, easiest, x)
    while reach_next(solver, column, cells, row, x):
        sweep_both_ways(solver, column, cells, row, easiest, x)


@kernel
def decide(solver: Solver, column: Column, cells: Cells, row: int, cell: int, x: Array) -> bool:
    """Decide a pending cell by the branch from level ground, by the swarm if that gets lost; True if it has a root."""
    point = point_of(solver, column, row, cell)
    end = settle(solver, point, x)
    if end == LOST:
        found, _ = search(solver, point, stream(column.seed, row * column.heading.size + cell), x)
        end = REACHED if found else NOT_CONVERGED
    if end == REACHED:
        store(solver, cells, row, cell, point, x)
    else:
        cells[row, cell].status = end
    return end == REACHED


@kernel
def widest_stride(column: Column) -> int:
    """The largest power of two of cells that `SPAN` holds, or 1."""
    step = column.heading[1] - column.heading[0] if column.heading.size > 1 else SPAN
    stride = 1
    while 2 * stride * step <= SPAN:
        stride *= 2
    return stride


@kernel
def lies_between(column: Column, cells: Cells, row: int, cell: int, stride: int, ends: Array) -> bool:
    """Whether the branch ends alike, well before its way's end, for the cells on either side of a pending one."""
    before, after = neighbour(column, cell, -stride), neighbour(column, cell, stride)
    if before < 0 or after < 0:
        return False
    farther = max(ends[before], ends[after]) + CAUTION * abs(ends[before] - ends[after])
    return bool(farther < 1.0 and cells[row, before].status == cells[row, after].status)


@kernel
def reopen(cells: Cells, row: int, ends: Array) -> None:
    """Make the cells pending again that were decided by where the branch from level ground ends."""
    for cell in range(ends.size):
        if not math.isnan(ends[cell]):
            cells[row, cell].status, ends[cell] = PENDING, np.nan


@kernel
def decide_rest(solver: Solver, column: Column, cells: Cells, row: int, easiest: int, ends: Array, x: Array) -> bool:
    """Decide pending cells at ever smaller strides, until one has a root, which may lead into the others; True then."""
    count = column.heading.size
    first = widest_stride(column)
    stride = first
    while stride > 0:
        for k in range(0, count, stride):
            cell = (easiest + k) % count
            if cells[row, cell].status != PENDING:
                continue
            if stride < first and lies_between(column, cells, row, cell, stride, ends):
                beside = neighbour(column, cell, stride)
                cells[row, cell].status, ends[cell] = cells[row, beside].status, ends[beside]
            elif decide(solver, column, cells, row, cell, x):
                reopen(cells, row, ends)
                return True
            else:
                ends[cell] = solver.curve.point[3]
        stride //= 2
    return False


@kernel
def fill_residuals(solver: Solver, column: Column, cells: Cells, row: int, x: Array) -> None:
    """Residual of the cells that were never evaluated, at the nearest root before them, or without slip."""
    near_no_slip(model_of(solver), column.curvature, x)
    for cell in range(column.heading.size):
        if has_root(cells, row, cell):
            for i in range(3):
                x[i] = cells[row, cell].unknowns[i]
        elif math.isnan(cells[row, cell].residual):
            point = point_of(solver, column, row, cell)
            cells[row, cell].residual = residual_at(solver, point, x)


@kernel
def solve_row(solver: Solver, column: Column, cells: Cells, row: int, ends: Array, x: Array) -> None:
    """Decide every cell of a row."""
    if bound_row(solver, column, cells, row) > 0:
        easiest = easiest_heading(column)
        fill(solver, column, cells, row, easiest, x)
        ends[:] = np.nan
        while decide_rest(solver, column, cells, row, easiest, ends, x):
            fill(solver, column, cells, row, easiest, x)
    fill_residuals(solver, column, cells, row, x)


@kernel
def solve_column(memory: NDArray[np.void], column: Column, cells: Cells) -> None:
    """Solve all rows, from low velocity to high. On a straight line the velocity does not matter.

    Parameters
    ----------
    memory
        A solver, see `trackctl.lut.cell.solver`, not shared with another thread.
    column
        What is asked.
    cells
        Receives the answers, shape (n_velocity, n_heading).
    """
    solver = memory[0]
    forget(solver)
    x, ends = np.empty(3), np.empty(column.heading.size)
    for row in range(column.velocity.size):
        if row > 0 and column.curvature == 0.0:
            for cell in range(column.heading.size):
                cells[row, cell] = cells[0, cell]
        else:
            solve_row(solver, column, cells, row, ends, x)


def compile_column() -> None:
    """Compile `solve_column`, or load it."""
    one = np.zeros(1)
    compile_for(solve_column, np.zeros(1, SOLVER), Column(0.0, 0.0, one, one, True, 0), pending_cells((1, 1)))
