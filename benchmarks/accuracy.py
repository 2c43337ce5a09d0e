"""How far a table's track speeds lie from those of finer quadratures.

The references are plain Gauss-Legendre with 48 nodes on each side of the point where the lateral sliding vanishes, and
the tests' oracle, which is written from the equations a second time and has 96 nodes a part.
Run from the repository: ``python benchmarks/accuracy.py``.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).parents[1] / "tests"))

import oracle
from tables import SolvedTable, benchmark_table, default_table, points_of, print_machine, solve_table

from trackctl.lut.axes import Array
from trackctl.mechanics.equilibrium import balance
from trackctl.mechanics.operating_point import operating_point
from trackctl.mechanics.quadrature import rules

SAMPLE = 3000
QUANTILES = (0.5, 0.9, 0.99, 1.0)
NEWTON_STEPS = 8
#: Residual that a reference solution must reach; rounding leaves about 1e-15.
REFERENCE_RESIDUAL = 1e-13

#: From a table, operating points and the table's answers to reference answers and their residuals.
Reference = Callable[[SolvedTable, Array, Array], tuple[Array, Array]]


def by_48_nodes(table: SolvedTable, points: Array, unknowns: Array) -> tuple[Array, Array]:
    """Newton's method from the table's answers on the balance with 48 nodes on each side of the split."""
    model, rule = table.request.model, rules((48,))
    residual, jacobian, traction = np.empty(3), np.empty((3, 3)), np.empty(2)
    solved, remaining = unknowns.copy(), np.empty(len(points))
    for i, (x, point) in enumerate(zip(solved, points, strict=True)):
        asked = operating_point(model, *point)
        for _ in range(NEWTON_STEPS):
            balance(model, asked, rule, x, residual, jacobian, traction)
            remaining[i] = np.abs(residual).max()
            if remaining[i] < REFERENCE_RESIDUAL:
                break
            x -= np.linalg.solve(jacobian, residual)
    return solved, remaining


def by_oracle(table: SolvedTable, points: Array, unknowns: Array) -> tuple[Array, Array]:
    """The oracle's Levenberg-Marquardt from the table's answers."""
    pairs = zip(points, unknowns, strict=True)
    ends = [
        oracle.search(oracle_point(table, point), x[None, :], 0.1 * REFERENCE_RESIDUAL, oracle.NODES)
        for point, x in pairs
    ]
    return np.concatenate([end for end, _ in ends]), np.concatenate([norm for _, norm in ends])


def oracle_roots(table: SolvedTable, point: Array) -> list[tuple[float, float, float]]:
    """The oracle's track speeds [m/s] and sideslip [rad] at a cell, the answer first."""
    return oracle.roots(oracle_point(table, point))


def oracle_point(table: SolvedTable, point: Array) -> oracle.OraclePoint:
    """A cell as the oracle's operating point."""
    vehicle, terrain = table.request.vehicle, table.request.terrain
    slope, velocity, curvature, heading = (float(value) for value in point)
    return oracle.OraclePoint(
        mass=vehicle.mass,
        gauge=vehicle.track_gauge,
        width=vehicle.track_width,
        length=vehicle.contact_length,
        cog_height=vehicle.cog_height,
        cog_forward=vehicle.cog_forward,
        cog_left=vehicle.cog_left,
        friction=terrain.friction_coefficient,
        shear_modulus=terrain.shear_deformation_modulus,
        cohesion=terrain.cohesion,
        resistance=terrain.motion_resistance_coefficient,
        gravity=table.request.gravity,
        slope=slope,
        velocity=velocity,
        curvature=curvature,
        heading=heading,
    )


def compare(table: SolvedTable, name: str, reference: Reference) -> None:
    """Print quantiles of the relative difference of the worse track's speed on a sample of cells."""
    random = np.random.default_rng(0)
    cells = random.choice(np.flatnonzero(table.converged), SAMPLE, replace=False)
    points, unknowns = points_of(table.request.sweep, cells), table.unknowns.reshape(-1, 3)[cells]
    expected, residual = reference(table, points, unknowns)
    known = residual < REFERENCE_RESIDUAL
    difference = np.abs(unknowns / expected - 1.0)[known, :2].max(axis=1)
    quantiles = "".join(f"{value:10.1e}" for value in np.quantile(difference, QUANTILES))
    print(f"{table.name:22}{name:10}{known.sum():>7}{quantiles}{(difference > 1e-6).sum():>8}{(~known).sum():>10}")


def main() -> None:
    print_machine()
    print("relative difference of the worse track's speed from a reference solution")
    heads = "".join(f"{'max' if q == 1 else f'{q:.0%}':>10}" for q in QUANTILES)
    print(f"{'table':22}{'reference':10}{'cells':>7}{heads}{'> 1e-6':>8}{'unknown':>10}")
    for request, _ in (benchmark_table(), default_table()):
        table = solve_table(request)
        compare(table, "48 nodes", by_48_nodes)
        compare(table, "oracle", by_oracle)
        print(f"{table.name:22}largest stored residual {table.residual[table.converged].max():.1e}")


if __name__ == "__main__":
    main()
