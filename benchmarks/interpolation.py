"""Time and error of `look_up` beside scipy's interpolators, on the same table and queries in one run.

Run from the repository: ``python benchmarks/interpolation.py``.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import partial
from time import perf_counter

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import NdBSpline, RegularGridInterpolator, make_interp_spline

from trackctl.lut.axes import FULL_CIRCLE, Axes
from trackctl.lut.interpolation import LookupResult, interpolant, look_up
from trackctl.lut.shape_functions import Method
from trackctl.lut.table import Table
from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import VehicleProfile

Array = NDArray[np.float64]
#: From slope, velocity, curvature, heading to left and right track speed over speed and sideslip.
Truth = Callable[[Array, Array, Array, Array], tuple[Array, Array, Array]]
#: From points, shape (4, n), to the same three, shape (n, 3), or more.
Answerer = Callable[[Array], LookupResult | Array]

QUERIES = 1_000_000
SPLINE_QUERIES = 50_000
ROUNDS = 3
PADDING = 12


def closed_form(slope: Array, velocity: Array, curvature: Array, heading: Array) -> tuple[Array, Array, Array]:
    """What a table looks like: a rounded bend at straight driving, growth towards the grip limit."""
    up, across = np.sin(slope) * np.cos(heading), np.sin(slope) * np.sin(heading)
    bend = np.hypot(curvature, 0.03)
    demand = np.tanh(0.1 * velocity**2 * curvature - 0.5 * across)
    left, right = (
        1.0 - side * (0.95 * curvature + 0.3 * across * bend) + 0.05 * up * (2.0 + np.exp(demand))
        for side in (1.0, -1.0)
    )
    return left, right, 0.3 * across * (1.0 + bend) - 0.1 * demand


def synthetic_table(truth: Truth) -> Table:
    """A table of one slope, 16 velocities, 49 curvatures and 360 headings, converged everywhere."""
    vehicle = VehicleProfile(
        name="benchmark",
        description="",
        source="",
        mass=2000.0,
        yaw_inertia=3000.0,
        track_gauge=1.8,
        track_width=0.3,
        contact_length=2.5,
        cog_height=0.7,
        sprocket_radius=0.25,
        max_speed=8.0,
        max_acceleration=2.0,
        max_sprocket_rate=1000.0,
        max_sprocket_acceleration=100.0,
        footprint=((1.5, 1.0), (-1.5, 1.0), (-1.5, -1.0), (1.5, -1.0)),
    )
    terrain = TerrainProfile(
        name="benchmark",
        description="",
        source="",
        friction_coefficient=0.6,
        shear_deformation_modulus=0.02,
        motion_resistance_coefficient=0.05,
    )
    axes = Axes(
        slope=np.array([0.2]),
        velocity=np.linspace(0.5, 8.0, 16),
        curvature=np.append(0.0, 1.0 / np.arange(50.0, 2.0, -1.0)),
        heading=np.arange(360.0) * (FULL_CIRCLE / 360),
        heading_is_periodic=True,
    )
    left, right, sideslip = truth(*np.meshgrid(axes.slope, axes.velocity, axes.curvature, axes.heading, indexing="ij"))
    rate = axes.velocity[:, None, None] / vehicle.sprocket_radius
    values = {"sprocket_rate_left": left * rate, "sprocket_rate_right": right * rate, "sideslip": sideslip}
    return Table(axes, values, np.zeros(axes.shape, np.uint8), vehicle, terrain, 9.80665)


def random_points(axes: Axes, count: int) -> Array:
    """Points all over a table of one slope, even in velocity, turn radius and heading, shape (4, count)."""
    generator = np.random.default_rng(0)
    return np.stack(
        [
            np.full(count, axes.slope[0]),
            generator.uniform(axes.velocity[0], axes.velocity[-1], count),
            1.0 / generator.uniform(1.0 / axes.curvature[-1], 1.5 / axes.curvature[1], count),
            generator.uniform(0.0, FULL_CIRCLE, count),
        ]
    )


def our_answerers(table: Table) -> dict[str, Answerer]:
    """Each method, on one thread and on all."""
    packed = interpolant(table)

    def answer(points: Array, method: Method, jobs: int) -> LookupResult:
        slope, velocity, curvature, heading = points
        return look_up(packed, slope, velocity, curvature, heading, method, jobs)

    return {
        f"{method}, {jobs} thread{'s'[: jobs > 1]}": partial(answer, method=method, jobs=jobs)
        for method in Method
        for jobs in dict.fromkeys((1, os.cpu_count() or 1))
    }


def ratios(answer: LookupResult | Array, points: Array) -> Array:
    """Left and right track speed over speed and sideslip, shape (n, 3)."""
    if isinstance(answer, LookupResult):
        velocity = points[1]
        columns = answer.track_speed_left / velocity, answer.track_speed_right / velocity, answer.sideslip
        return np.stack(columns, axis=1)
    return answer


def scipy_answerers(table: Table) -> dict[str, Answerer]:
    """Interpolators of scipy over velocity, curvature and heading, the heading periodic by padding."""
    axes = table.axes
    columns = np.arange(-PADDING, axes.heading.size + PADDING + 1)
    turns, wrapped = np.divmod(columns, axes.heading.size)
    nodes = (axes.velocity, axes.curvature, axes.heading[wrapped] + turns * FULL_CIRCLE)
    speed_ratio = table.vehicle.sprocket_radius / axes.velocity[:, None, None]
    values = np.stack(
        [
            table.values["sprocket_rate_left"][0] * speed_ratio,
            table.values["sprocket_rate_right"][0] * speed_ratio,
            table.values["sideslip"][0],
        ],
        axis=-1,
    )[:, :, wrapped]
    spline = tensor_spline(nodes, values)
    linear = RegularGridInterpolator(nodes, values, "linear")
    cubic = RegularGridInterpolator(nodes, values, "cubic")
    return {
        "scipy RegularGridInterpolator linear": lambda points: linear(points[1:].T),
        "scipy RegularGridInterpolator cubic": lambda points: cubic(points[1:].T),
        "scipy NdBSpline cubic": lambda points: spline(points[1:].T),
    }


def tensor_spline(nodes: tuple[Array, ...], values: Array) -> NdBSpline:
    """Cubic spline through all values, made axis by axis."""
    knots, coefficients = [], values
    for axis, coordinates in enumerate(nodes):
        spline = make_interp_spline(coordinates, coefficients, k=3, axis=axis)
        knots.append(spline.t)
        coefficients = np.moveaxis(spline.c, 0, axis)
    return NdBSpline(tuple(knots), coefficients, 3)


def nanoseconds(answerers: dict[str, Answerer], points: dict[str, Array]) -> dict[str, float]:
    """Best time a query of `ROUNDS`, all in turn in each round, so that a busy machine hits them alike."""
    best = dict.fromkeys(answerers, np.inf)
    for _ in range(ROUNDS):
        for name, answer in answerers.items():
            start = perf_counter()
            answer(points[name])
            best[name] = min(best[name], (perf_counter() - start) * 1e9 / points[name].shape[1])
    return best


def compare(table: Table, truth: Truth) -> None:
    """Print time and error of every interpolator on a table of one slope."""
    ours, others = our_answerers(table), scipy_answerers(table)
    answerers = ours | others
    few, many = random_points(table.axes, SPLINE_QUERIES), random_points(table.axes, QUERIES)
    expected = np.stack(truth(*few), axis=1)
    errors = {name: np.abs(ratios(answer(few), few) - expected) for name, answer in answerers.items()}
    times = nanoseconds(answerers, {name: many if name in ours else few for name in answerers})
    reference = times[f"{Method.MLS}, 1 thread"]
    print(f"table {table.axes.shape}, {QUERIES} random queries (scipy {SPLINE_QUERIES}), best of {ROUNDS}")
    print("error of track speeds over speed and of sideslip [rad], at radii of the table and beyond the largest")
    print(f"{'':38}{'ns/query':>10}{'ratio':>8}{'arcs: max':>12}{'RMS':>9}{'straight: max':>16}{'RMS':>9}")
    arc = few[2] > table.axes.curvature[1]
    for name, error in errors.items():
        columns = f"{name:38}{times[name]:10.0f}{times[name] / reference:8.2f}"
        for part, width in ((error[arc], 12), (error[~arc], 16)):
            columns += f"{part.max():{width}.1e}{np.sqrt(np.mean(part**2)):9.1e}"
        print(columns)


if __name__ == "__main__":
    compare(synthetic_table(closed_form), closed_form)
