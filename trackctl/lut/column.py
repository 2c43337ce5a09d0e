"""A column of a table: all velocities and headings at one slope and curvature, solved by continuation.

A column depends on no other, so a table's cells do not depend on how columns are dealt to workers. Within it a row is
one velocity. The first row starts from swarms at a few headings; a row goes round the headings both ways, each cell
started by extrapolating its neighbours, or from the row below. Where the branch ends between two cells, it is followed to
the fold or limit that ends it: that is the evidence that the cells beyond are infeasible. Only where there is none, the
swarm decides.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel
from trackctl.lut.branch import REACHED, Way, follow
from trackctl.lut.cell import Solver, model_of, residual_at, solve_warm
from trackctl.lut.cells import PENDING, Cells
from trackctl.lut.point import CLEARLY_UNBALANCED, NOT_CONVERGED
from trackctl.lut.swarm_search import no_slip, search
from trackctl.mechanics.limits import ADMISSIBLE, GRIP, exceeded_limit, proven_infeasible
from trackctl.mechanics.operating_point import OperatingPoint, operating_point
from trackctl.solvers.levenberg_marquardt import largest
from trackctl.solvers.random_stream import stream

Array = NDArray[np.float64]

#: Most neighbours that a start is extrapolated from; coefficients of row m - 1 go with m of them, nearest first.
MOST_NEIGHBOURS = 6
EXTRAPOLATION = np.array(
    [
        [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [2.0, -1.0, 0.0, 0.0, 0.0, 0.0],
        [3.0, -3.0, 1.0, 0.0, 0.0, 0.0],
        [4.0, -6.0, 4.0, -1.0, 0.0, 0.0],
        [5.0, -10.0, 10.0, -5.0, 1.0, 0.0],
        [6.0, -15.0, 20.0, -15.0, 6.0, -1.0],
    ]
)
#: Headings of the first row that start from a swarm.
SEEDS = 4


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


@kernel
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


@kernel
def neighbour(column: Column, cell: int, offset: int) -> int:
    """Index of a cell's neighbour in heading, or -1 beyond the end."""
    count = column.heading.size
    index = cell + offset
    if column.periodic:
        return index % count
    return index if 0 <= index < count else -1


@kernel
def extrapolate(
    column: Column, cells: Cells, row: int, cell: int, direction: int, known: int, x: Array
) -> None:
    """Start of a cell from the `known` cells before it in the direction of travel."""
    for i in range(3):
        x[i] = 0.0
    for k in range(known):
        before = neighbour(column, cell, -direction * (k + 1))
        weight = EXTRAPOLATION[known - 1, k]
        for i in range(3):
            x[i] += weight * cells[row, before].unknowns[i]


@kernel
def sweep(
    solver: Solver, column: Column, cells: Cells, row: int, first: int, direction: int, count: int, x: Array
) -> None:
    """Solve the pending cells of a row in the order of travel, from where neighbours or the row below are known."""
    known = 0
    cell = first
    for _ in range(count):
        if cells[row, cell].status == PENDING:
            point = point_of(solver, column, row, cell)
            solved = False
            if known > 0:
                extrapolate(column, cells, row, cell, direction, min(known, MOST_NEIGHBOURS), x)
                solved = solve_warm(solver, point, x)
            if not solved and has_root(cells, row - 1, cell):
                for i in range(3):
                    x[i] = cells[row - 1, cell].unknowns[i]
                solved = solve_warm(solver, point, x)
            if solved:
                store(solver, cells, row, cell, point, x)
        known = known + 1 if has_root(cells, row, cell) else 0
        cell = neighbour(column, cell, direction)
        if cell < 0:
            return


@kernel
def sweep_both_ways(solver: Solver, column: Column, cells: Cells, row: int, first: int, x: Array) -> None:
    """Sweep a row forwards and backwards from a cell, twice round where headings are periodic."""
    count = column.heading.size
    sweep(solver, column, cells, row, first, 1, count + count // 2 if column.periodic else count, x)
    last = first if column.periodic else count - 1
    sweep(solver, column, cells, row, last, -1, count + count // 2 if column.periodic else count, x)


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
def seed(solver: Solver, column: Column, cells: Cells, row: int, cell: int, x: Array) -> bool:
    """Solve a pending cell by the swarm; False if it finds no root."""
    point = point_of(solver, column, row, cell)
    found, least = search(solver, point, stream(column.seed, row * column.heading.size + cell), x)
    if found:
        store(solver, cells, row, cell, point, x)
    else:
        cells[row, cell].residual = least
    return found


@kernel
def bound_row(solver: Solver, column: Column, cells: Cells, row: int) -> int:
    """Mark the cells of a row that are proven infeasible, the others pending; the number of pending cells."""
    pending = 0
    for cell in range(column.heading.size):
        point = point_of(solver, column, row, cell)
        proven = proven_infeasible(model_of(solver), point)
        for i in range(3):
            cells[row, cell].unknowns[i] = np.nan
        for i in range(2):
            cells[row, cell].traction[i] = np.nan
        cells[row, cell].residual = np.nan
        cells[row, cell].status = PENDING if proven == ADMISSIBLE else proven
        pending += proven == ADMISSIBLE
    return pending


@kernel
def follow_into(
    solver: Solver, column: Column, cells: Cells, row: int, cell: int, from_row: int, from_cell: int, x: Array
) -> int:
    """Follow the branch from a solved cell into a pending one: solve that, or return the limit that ends the branch."""
    here, there = column.heading[from_cell], column.heading[cell]
    if there - here > math.pi:
        there -= 2.0 * math.pi
    elif here - there > math.pi:
        there += 2.0 * math.pi
    for i in range(3):
        x[i] = cells[from_row, from_cell].unknowns[i]
    way = Way(column.slope, column.curvature, column.velocity[from_row], column.velocity[row], here, there)
    end = follow(solver, way, x)
    point = point_of(solver, column, row, cell)
    if end == REACHED and solve_warm(solver, point, x):
        store(solver, cells, row, cell, point, x)
    return end


@kernel
def spread(column: Column, cells: Cells, row: int, cell: int, direction: int, limit: int) -> None:
    """Give a limit to a run of pending cells, up to its middle seen from this end."""
    length = 0
    here = cell
    while here >= 0 and length < column.heading.size and cells[row, here].status == PENDING:
        length += 1
        here = neighbour(column, here, direction)
    closed = here >= 0 and has_root(cells, row, here)
    for _ in range((length + 1) // 2 if closed else length):
        cells[row, cell].status = limit
        cell = neighbour(column, cell, direction)


@kernel
def close_gaps(solver: Solver, column: Column, cells: Cells, row: int, x: Array) -> bool:
    """Follow the branch from solved cells into pending neighbours; True if that solved a cell.

    Neighbours are those in heading and the cell of the row below.
    """
    for cell in range(column.heading.size):
        for direction in (1, -1):
            before = neighbour(column, cell, -direction)
            if cells[row, cell].status != PENDING or before < 0 or not has_root(cells, row, before):
                continue
            end = follow_into(solver, column, cells, row, cell, row, before, x)
            if has_root(cells, row, cell):
                return True
            if end > 0:
                spread(column, cells, row, cell, direction, end)
    for cell in range(column.heading.size):
        if cells[row, cell].status == PENDING and has_root(cells, row - 1, cell):
            end = follow_into(solver, column, cells, row, cell, row - 1, cell, x)
            if has_root(cells, row, cell):
                return True
            if end > 0:
                cells[row, cell].status = end
    return False


@kernel
def decide_rest(solver: Solver, column: Column, cells: Cells, row: int, x: Array) -> bool:
    """Decide one cell that no branch leads to; True if there was one.

    A branch that ended at a lower velocity stays ended; else the swarm searches.
    """
    for cell in range(column.heading.size):
        if cells[row, cell].status != PENDING:
            continue
        below = cells[row - 1, cell].status if row > 0 else PENDING
        if (
            below != PENDING
            and below != ADMISSIBLE
            and below != NOT_CONVERGED
            and not has_root(cells, row - 1, cell)
        ):
            cells[row, cell].status = below
        elif not seed(solver, column, cells, row, cell, x):
            unbalanced = cells[row, cell].residual > CLEARLY_UNBALANCED
            cells[row, cell].status = GRIP if unbalanced else NOT_CONVERGED
        return True
    return False


@kernel
def fill_residuals(solver: Solver, column: Column, cells: Cells, row: int, x: Array) -> None:
    """Residual of the cells that were never evaluated, at the nearest root before them, or without slip."""
    no_slip(model_of(solver), column.curvature, x)
    for cell in range(column.heading.size):
        if has_root(cells, row, cell):
            for i in range(3):
                x[i] = cells[row, cell].unknowns[i]
        elif math.isnan(cells[row, cell].residual):
            point = point_of(solver, column, row, cell)
            cells[row, cell].residual = residual_at(solver, point, x)


@kernel
def solve_row(solver: Solver, column: Column, cells: Cells, row: int, x: Array) -> None:
    """Decide every cell of a row."""
    count = column.heading.size
    if bound_row(solver, column, cells, row) > 0:
        easiest = easiest_heading(column)
        if row == 0:
            for k in range(SEEDS):
                cell = (easiest + k * count // SEEDS) % count
                if cells[row, cell].status == PENDING:
                    seed(solver, column, cells, row, cell, x)
        sweep_both_ways(solver, column, cells, row, easiest, x)
        if cells[row, easiest].status == PENDING and not has_root(cells, row - 1, easiest):
            if seed(solver, column, cells, row, easiest, x):
                sweep_both_ways(solver, column, cells, row, easiest, x)
        while close_gaps(solver, column, cells, row, x):
            sweep_both_ways(solver, column, cells, row, easiest, x)
        while decide_rest(solver, column, cells, row, x):
            pass
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
    x = np.empty(3)
    for row in range(column.velocity.size):
        if row > 0 and column.curvature == 0.0:
            for cell in range(column.heading.size):
                cells[row, cell] = cells[0, cell]
        else:
            solve_row(solver, column, cells, row, x)
