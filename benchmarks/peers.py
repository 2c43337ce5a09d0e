"""What a user would write, beside trackctl, on the same cells and the same residual.

Run from the repository: ``python benchmarks/peers.py`` (needs the ``bench`` extra).
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

import numpy as np
from accuracy import oracle_roots
from scipy.optimize import least_squares, root
from tables import SolvedTable, benchmark_table, points_of, print_machine, solve_table

from trackctl.compiled import kernel
from trackctl.lut.axes import Array
from trackctl.lut.crew import solve_columns, threads
from trackctl.lut.point import solve_points
from trackctl.lut.sweep import Sweep
from trackctl.mechanics.equilibrium import balance
from trackctl.mechanics.limits import FASTEST_TRACK, LARGEST_SIDESLIP, SLOWEST_TRACK
from trackctl.mechanics.operating_point import OperatingPoint, operating_point
from trackctl.mechanics.parameters import TrackModel
from trackctl.mechanics.quadrature import Rule, rules

SAMPLE = 500
SWARM_SAMPLE = 60
REPEATS = 3
PARTICLES, ITERATIONS = 30, 50
#: Coefficients of the pyswarms documentation.
SWARM_OPTIONS = {"c1": 0.5, "c2": 0.3, "w": 0.9}
LOWER = np.array([SLOWEST_TRACK, SLOWEST_TRACK, -LARGEST_SIDESLIP])
UPPER = np.array([FASTEST_TRACK, FASTEST_TRACK, LARGEST_SIDESLIP])
RULE = rules()
#: Track speed ratios and sideslip within this of the oracle's are the right root; its quadrature differs, see
#: `accuracy.py`.
SAME_ROOT = 2e-3

#: From operating points, shape (n, 4), to track speed ratios and sideslip, shape (n, 3).
Solver = Callable[[Array], Array]


@dataclass(frozen=True, slots=True)
class Row:
    """One line of the comparison: cells a second, and share of the feasible cells on the right branch."""

    name: str
    cells: int
    rate: float
    solved: float


@kernel
def residuals(model: TrackModel, point: OperatingPoint, rule: Rule, unknowns: Array) -> Array:
    """The balance at each row of unknowns, shape (n, 3)."""
    values, jacobian, traction = np.empty(unknowns.shape), np.empty((3, 3)), np.empty(2)
    for i in range(unknowns.shape[0]):
        balance(model, point, rule, unknowns[i], values[i], jacobian, traction)
    return values


def no_slip(model: TrackModel, curvature: float) -> Array:
    """Track speed ratios of rolling without slip, and no sideslip."""
    return np.array([1.0 - 0.5 * model.gauge * curvature, 1.0 + 0.5 * model.gauge * curvature, 0.0])


def by_hybrid(model: TrackModel, points: Array) -> Array:
    """`scipy.optimize.root` with Powell's hybrid method from the no-slip speeds, cell by cell."""
    answers = np.empty((len(points), 3))
    for i, row in enumerate(points):
        point = operating_point(model, *row)

        def imbalance(x: Array, point: OperatingPoint = point) -> Array:
            return residuals(model, point, RULE, x[None, :])[0]

        found = root(imbalance, no_slip(model, row[2]), method="hybr", tol=1e-12)
        answers[i] = found.x
    return answers


def by_pyswarms(model: TrackModel, points: Array) -> Array:
    """Pyswarms' global-best swarm, then `scipy.optimize.least_squares`, cell by cell."""
    from pyswarms.single import GlobalBestPSO

    np.random.seed(0)  # noqa: NPY002 - pyswarms draws from numpy's global stream
    answers = np.empty((len(points), 3))
    for i, row in enumerate(points):
        point = operating_point(model, *row)

        def cost(swarm: Array, point: OperatingPoint = point) -> Array:
            return np.sum(residuals(model, point, RULE, swarm) ** 2, axis=1)

        def imbalance(x: Array, point: OperatingPoint = point) -> Array:
            return residuals(model, point, RULE, x[None, :])[0]

        flock = GlobalBestPSO(PARTICLES, 3, SWARM_OPTIONS, bounds=(LOWER, UPPER))
        _, best = flock.optimize(cost, ITERATIONS, verbose=False)
        start = np.clip(best, LOWER + 1e-9, UPPER - 1e-9)
        found = least_squares(imbalance, start, bounds=(LOWER, UPPER), xtol=1e-15, ftol=1e-15, gtol=1e-15)
        answers[i] = found.x
    return answers


@contextmanager
def quiet_pyswarms() -> Iterator[None]:
    """Keep pyswarms from writing a ``report.log`` to the working folder: it takes its logging from ``LOG_CFG``."""
    with TemporaryDirectory() as folder:
        settings = Path(folder) / "logging.yaml"
        settings.write_text("version: 1\n")
        os.environ["LOG_CFG"] = str(settings)
        try:
            yield
        finally:
            del os.environ["LOG_CFG"]


def by_trackctl(model: TrackModel, points: Array) -> Array:
    """trackctl, each cell on its own."""
    return np.asarray(solve_points(model, points)["unknowns"])


def true_answers(table: SolvedTable, points: Array) -> Array:
    """The oracle's root of least sideslip, NaN where it finds none."""
    found = [oracle_roots(table, point) for point in points]
    ratios = [np.array(roots[0]) if roots else np.full(3, np.nan) for roots in found]
    return np.stack(ratios) / np.column_stack((points[:, 1], points[:, 1], np.ones(len(points))))


def share_right(answers: Array, truth: Array) -> float:
    """Share of the feasible cells that are answered with the right root."""
    feasible = np.isfinite(truth[:, 0])
    return float(np.mean(np.abs(answers - truth)[feasible].max(axis=1) < SAME_ROOT))


def timed(name: str, solve: Solver, points: Array, truth: Array, repeats: int = REPEATS) -> Row:
    """Solve the points some times, compiled code ready."""
    solve(points[:2])
    times = []
    for _ in range(repeats):
        started = perf_counter()
        answers = solve(points)
        times.append(perf_counter() - started)
    return Row(name, len(points), len(points) / min(times), share_right(answers, truth))


def timed_table(sweep: Sweep, solved: float, jobs: int) -> Row:
    """Solve the whole table some times."""
    times = []
    with threads(jobs) as crew:
        for _ in range(REPEATS):
            started = perf_counter()
            for _done in solve_columns(sweep, range(sweep.column_count), crew):
                pass
            times.append(perf_counter() - started)
    name = f"trackctl table, {jobs} thread{'s'[: jobs > 1]}"
    return Row(name, sweep.axes.size, sweep.axes.size / min(times), solved)


def main() -> None:
    request, _ = benchmark_table()
    model, sweep = request.model, request.sweep
    table = solve_table(request)
    cells = np.random.default_rng(0).choice(sweep.axes.size, SAMPLE, replace=False)
    points = points_of(sweep, cells)
    truth = true_answers(table, points)
    right = share_right(np.where(table.converged[..., None], table.unknowns, np.nan).reshape(-1, 3)[cells], truth)
    few = slice(SWARM_SAMPLE)
    with quiet_pyswarms():
        swarm = timed(
            "pyswarms + least_squares", lambda rows: by_pyswarms(model, rows), points[few], truth[few], repeats=1
        )
    rows = [
        swarm,
        timed("scipy root(hybr)", lambda rows: by_hybrid(model, rows), points, truth),
        timed("trackctl solve_points", lambda rows: by_trackctl(model, rows), points, truth),
        timed_table(sweep, right, 1),
        timed_table(sweep, right, 2),
    ]
    print_machine()
    print(f"{table.name}: {np.isfinite(truth[:, 0]).sum()} of the sample's {SAMPLE} cells feasible (oracle)")
    print(f"{'':28}{'cells':>8}{'cells/s':>10}{'right root':>12}{'over pyswarms':>15}{'over hybr':>11}")
    for row in rows:
        over = f"{row.rate / rows[0].rate:15,.1f}{row.rate / rows[1].rate:11,.2f}"
        print(f"{row.name:28}{row.cells:>8}{row.rate:>10,.0f}{row.solved:>12.1%}{over}")


if __name__ == "__main__":
    main()
