"""Time and error of `look_up` on real tables, and beside scipy's interpolators where every cell has an answer.

Run from the repository: ``python benchmarks/lookup.py``.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from accuracy import by_oracle
from interpolation import QUERIES, ROUNDS, compare, nanoseconds, our_answerers, ratios
from tables import THREADS, SolvedTable, benchmark_table, default_table, print_machine, solve_table

from trackctl.lut.axes import Array, Axes
from trackctl.lut.certificate import random_arcs, random_near_straight
from trackctl.lut.interpolation import interpolant, look_up
from trackctl.lut.point import solve_points
from trackctl.lut.shape_functions import Method
from trackctl.lut.table import Status, Table

ERROR_POINTS = 20_000
#: As high as a profile allows: limits of the actuators are out of the way. [rad/s]
NO_LIMIT = 1e4


def as_table(solved: SolvedTable) -> Table:
    """The solved cells as a table, as far as interpolation reads it."""
    vehicle = replace(solved.request.vehicle, max_sprocket_rate=NO_LIMIT)
    axes = solved.request.axes
    rate = axes.velocity[:, None, None] / vehicle.sprocket_radius
    unknowns = np.where(solved.converged[..., None], solved.unknowns, np.nan)
    values = {
        "sprocket_rate_left": unknowns[..., 0] * rate,
        "sprocket_rate_right": unknowns[..., 1] * rate,
        "sideslip": unknowns[..., 2],
    }
    return Table(axes, values, solved.status, vehicle, solved.request.terrain, solved.request.gravity)


def feasible_box(table: Table) -> Table:
    """The largest part of a table, from its slowest speed and straight driving on, whose cells are all solved."""
    solved = np.all(table.status == Status.CONVERGED, axis=(0, 3))
    whole = np.logical_and.accumulate(np.logical_and.accumulate(solved, axis=0), axis=1)
    speeds, turns = np.arange(1, solved.shape[0] + 1), np.arange(1, solved.shape[1] + 1)
    rows, columns = np.unravel_index(np.argmax(whole * speeds[:, None] * turns), solved.shape)
    box = np.s_[:, : rows + 1, : columns + 1]
    old = table.axes
    axes = Axes(old.slope, old.velocity[box[1]], old.curvature[box[2]], old.heading, old.heading_is_periodic)
    values = {name: value[box] for name, value in table.values.items()}
    return replace(table, axes=axes, values=values, status=table.status[box])


def print_whole_table(solved: SolvedTable, table: Table) -> None:
    """Print time and error of each method over all of a table, infeasible cells included."""
    random = np.random.default_rng(0)
    many = np.ascontiguousarray(random_arcs(table.axes, QUERIES, random).T)
    kinds = {
        "arcs": random_arcs(table.axes, ERROR_POINTS, random),
        "near straight": random_near_straight(table.axes, ERROR_POINTS, random),
    }
    answerers = our_answerers(table)
    times = nanoseconds(answerers, dict.fromkeys(answerers, many))
    print(f"\n{solved.name}, {table.axes.shape} cells, {solved.converged.mean():.1%} with an answer; {QUERIES} queries")
    print(f"{'':20}{'ns/query':>9}  {'points':14}{'answered':>9}{'max':>9}{'99 %':>9}{'RMS':>9}")
    exact = {kind: solve_points(solved.request.model, points, jobs=THREADS) for kind, points in kinds.items()}
    for name, answer in answerers.items():
        head = f"{name:20}{times[name]:9.0f}"
        for kind, points in kinds.items():
            feasible = exact[kind]["status"] == Status.CONVERGED
            found = ratios(answer(np.ascontiguousarray(points.T)), points.T)[feasible, :2]
            error = np.abs(found - exact[kind]["unknowns"][feasible, :2]).max(axis=1)
            known = error[np.isfinite(error)]
            largest, most, rms = known.max(), np.quantile(known, 0.99), np.sqrt(np.mean(known**2))
            print(f"{head:29}  {kind:14}{known.size / error.size:9.1%}{largest:9.1e}{most:9.1e}{rms:9.1e}")
            head = ""


def exact_answers(solved: SolvedTable, table: Table, points: Array) -> Array:
    """Direct solves inside a table without infeasible cells, shape (n, 3).

    Where `solve_points` has no answer, the oracle's from the interpolated one.
    """
    answers = np.array(solve_points(solved.request.model, points, jobs=THREADS)["unknowns"])
    missing = np.flatnonzero(np.isnan(answers[:, 0]))
    print(f"{missing.size} of {len(points)} direct solves have no answer: the oracle's in their place")
    if missing.size:
        slope, velocity, curvature, heading = points[missing].T
        found = look_up(interpolant(table), slope, velocity, curvature, heading, Method.LINEAR)
        answers[missing], _ = by_oracle(solved, points[missing], ratios(found, points[missing].T))
    return answers


def main() -> None:
    print_machine()
    print(f"error: of the worse track's speed over the vehicle's, against direct solves; times: best of {ROUNDS}")
    for request, _ in (default_table(), benchmark_table()):
        solved = solve_table(request)
        table = as_table(solved)
        print_whole_table(solved, table)
        box = feasible_box(table)

        def truth(*coordinates: Array, solved: SolvedTable = solved, box: Table = box) -> tuple[Array, Array, Array]:
            left, right, sideslip = exact_answers(solved, box, np.stack(coordinates, axis=-1)).T
            return left, right, sideslip

        print(f"its part without infeasible cells, up to {box.axes.velocity[-1]:g} m/s and {box.axes.radius[-1]:g} m:")
        compare(box, truth)


if __name__ == "__main__":
    main()
