"""Shape functions, tested from their laws: partition of unity, reproduction, continuity, order."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from trackctl.lut.shape_functions import MOST_BUCKETS, SNAP, Method, Stencils, stencils, weigh

Array = NDArray[np.float64]

RADII = np.arange(50.0, 2.5, -1.0)
AXES = {
    "uniform": stencils(np.linspace(0.5, 8.0, 16), 1),
    "left turns": stencils(np.append(0.0, 1.0 / RADII), 1, bend=0.0),
    "both turns": stencils(np.concatenate([-1.0 / RADII[::-1], [0.0], 1.0 / RADII]), 1, bend=0.0),
    "periodic": stencils(np.arange(24) * (2.0 * np.pi / 24), 1, period=2.0 * np.pi),
    "three": stencils(np.array([0.1, 0.2, 0.5]), 1),
    "two": stencils(np.array([0.1, 0.5]), 1),
    "one": stencils(np.array([0.2]), 1),
    "two periodic": stencils(np.array([0.0, np.pi]), 1, period=2.0 * np.pi),
}
DEGREES = {Method.LINEAR: 1, Method.MLS: 2, Method.CUBIC: 3}
# The widest cell of the curvature axis is 49 times its neighbour: weights there reach 25 and lose that much.
ROUNDING = 1e-13


def weights_at(axis: Stencils, method: Method, points: Array) -> tuple[Array, NDArray[np.int64], NDArray[np.bool_]]:
    """Weights, node numbers and the inside flag of each point."""
    weights = np.zeros((points.size, 4))
    numbers = np.zeros((points.size, 4), np.uint64)
    inside = np.ones(points.size, np.bool_)
    weigh(axis, method.code, np.array(points), weights, numbers, inside)
    return weights, numbers.astype(np.int64), inside


def interpolated(axis: Stencils, method: Method, points: Array, values: Array) -> Array:
    """Values at the points from values at the nodes."""
    weights, numbers, inside = weights_at(axis, method, points)
    assert inside.all()
    return np.sum(weights * values[numbers], axis=1)


def node_coordinates(axis: Stencils) -> Array:
    """The nodes between the axis' cells, a periodic one's first again at the end."""
    return np.append(axis.nodes[:, 1], axis.nodes[-1, 2])


def points_within(axis: Stencils, per_cell: int = 7) -> Array:
    """Points inside each cell."""
    start, end = axis.nodes[:, 1, None], axis.nodes[:, 2, None]
    points: Array = (start + (end - start) * (np.arange(per_cell) + 0.5) / per_cell).ravel()
    return points


several = pytest.mark.parametrize("axis", [pytest.param(AXES[n], id=n) for n in AXES if n != "one"])
methods = pytest.mark.parametrize("method", list(Method))


@methods
@several
def test_nodes_are_met_exactly(axis: Stencils, method: Method) -> None:
    nodes = node_coordinates(axis)
    weights, numbers, inside = weights_at(axis, method, nodes)
    assert inside.all()
    assert np.array_equal(np.sort(weights, axis=1), np.tile([0.0, 0.0, 0.0, 1.0], (nodes.size, 1)))
    node_count = numbers.max() + 1
    assert np.array_equal(numbers[weights == 1.0], np.arange(nodes.size) % node_count)


@methods
@several
def test_points_within_snap_of_a_node_are_at_it(axis: Stencils, method: Method) -> None:
    start, end = axis.nodes[:, 1], axis.nodes[:, 2]
    for points in (start + 0.5 * SNAP * (end - start), end - 0.5 * SNAP * (end - start)):
        weights, _, _ = weights_at(axis, method, points)
        assert np.array_equal(weights.max(axis=1), np.ones(points.size))


@methods
@several
def test_weights_add_up_to_one(axis: Stencils, method: Method) -> None:
    weights, _, _ = weights_at(axis, method, points_within(axis))
    assert np.abs(weights.sum(axis=1) - 1.0).max() < ROUNDING


@methods
@pytest.mark.parametrize("name", ["uniform", "left turns", "both turns", "three"])
def test_polynomials_are_reproduced(name: str, method: Method) -> None:
    axis = AXES[name]
    points = points_within(axis)
    nodes = node_coordinates(axis)
    scale = np.abs(nodes).max()
    # Where a neighbour is missing, cubic is the parabola through three nodes.
    at_ends = np.repeat(axis.extent != 0, 7)
    for degree in range(DEGREES[method] + 1):
        error = np.abs(interpolated(axis, method, points, (nodes / scale) ** degree) - (points / scale) ** degree)
        assert error[~at_ends if degree == 3 else slice(None)].max(initial=0.0) < ROUNDING


def test_moving_least_squares_is_the_weighted_least_squares_fit() -> None:
    axis = AXES["left turns"]
    values = np.cos(40.0 * node_coordinates(axis))
    for cell, t in ((1, 0.3), (20, 0.5), (40, 0.85)):
        nodes = axis.nodes[cell]
        x = nodes[1] + t * (nodes[2] - nodes[1])
        distance = np.array([1.0 + t, t, 1.0 - t, 2.0 - t])
        root_weight = (2.0 - distance) / distance
        basis = np.vander((nodes - x) / (nodes[2] - nodes[1]), 3, increasing=True)
        data = values[axis.offset[cell]]
        fit = np.linalg.lstsq(root_weight[:, None] * basis, root_weight * data, rcond=None)[0][0]
        found = interpolated(axis, Method.MLS, np.array([x]), values)[0]
        assert found == pytest.approx(fit, abs=1e-13)  # rounding of a well-conditioned 4 x 3 fit


@methods
@pytest.mark.parametrize("name", ["uniform", "left turns", "both turns", "periodic"])
def test_values_are_continuous_across_cells(name: str, method: Method) -> None:
    axis = AXES[name]
    values = np.cos(np.arange(axis.offset.max() + 1.0))
    width = (axis.nodes[:, 2] - axis.nodes[:, 1]) * 1e-7
    for points, node in ((axis.nodes[:, 1] + width, 1), (axis.nodes[:, 2] - width, 2)):
        jump = interpolated(axis, method, points, values) - values[axis.offset[:, node]]
        # Slopes of a cell's interpolant are below 60 values a cell, in the widest curvature cell.
        assert np.abs(jump).max() < 60.0 * 1e-7 * 2.0


@pytest.mark.parametrize("name", ["uniform", "left turns", "periodic"])
def test_moving_least_squares_has_a_continuous_slope(name: str) -> None:
    axis = AXES[name]
    values = np.cos(np.arange(axis.offset.max() + 1.0))
    width = axis.nodes[:, 2] - axis.nodes[:, 1]
    step = 1e-5
    after = interpolated(axis, Method.MLS, axis.nodes[:, 1] + step * width, values) - values[axis.offset[:, 1]]
    before = values[axis.offset[:, 2]] - interpolated(axis, Method.MLS, axis.nodes[:, 2] - step * width, values)
    slope_after, slope_before = after / (step * width), before / (step * width)
    jump = np.abs(slope_after[1:] - slope_before[:-1]) * np.minimum(width[1:], width[:-1])
    # Differences over 1e-5 of a cell see second derivatives of order 1 in cells; ten times that.
    assert jump.max() < 1e-4
    linear = interpolated(axis, Method.LINEAR, axis.nodes[:, 1] + step * width, values)
    assert np.ptp((linear - values[axis.offset[:, 1]]) / step) > 0.1


@methods
def test_rotating_a_periodic_axis_rotates_the_answer(method: Method) -> None:
    axis = AXES["periodic"]
    values = np.random.default_rng(1).normal(size=24)
    points = np.random.default_rng(2).uniform(0.0, 2.0 * np.pi, 200)
    turned = (points + 5 * 2.0 * np.pi / 24) % (2.0 * np.pi)
    expected = interpolated(axis, method, points, values)
    # t of a point moves by a few 1e-15 in cells with the turn; values change by up to 5 in a cell.
    assert np.abs(interpolated(axis, method, turned, np.roll(values, 5)) - expected).max() < 1e-12


@pytest.mark.parametrize(("method", "order"), [(Method.LINEAR, 2.0), (Method.MLS, 3.0), (Method.CUBIC, 4.0)])
@pytest.mark.parametrize("warp", [0.0, 0.3], ids=["uniform", "not uniform"])
def test_order_of_convergence(method: Method, order: float, warp: float) -> None:
    counts = np.array([32, 64, 128, 256])
    errors = []
    for count in counts:
        even = np.linspace(0.0, 1.0, count + 1)
        axis = stencils(even + warp * even**2, 1)
        nodes = node_coordinates(axis)
        points = points_within(axis, 11)
        # Cells at the ends have three nodes, so cubic has order 3 there.
        inner = (points > nodes[1]) & (points < nodes[-2])
        found = interpolated(axis, method, points, np.sin(5.0 * nodes))
        errors.append(np.abs(found - np.sin(5.0 * points))[inner].max())
    fitted = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert fitted == pytest.approx(order, abs=0.15)


def test_stencils_stop_at_straight_driving() -> None:
    axis = AXES["both turns"]
    straight = RADII.size
    for method in Method:
        weights, numbers, _ = weights_at(axis, method, points_within(axis))
        used = np.where(weights != 0.0, numbers, straight)
        assert ((used >= straight).all(axis=1) | (used <= straight).all(axis=1)).all()


@methods
def test_missing_nodes_count_exactly_nothing(method: Method) -> None:
    axis = AXES["uniform"]
    weights, _, _ = weights_at(axis, method, points_within(axis))
    assert (weights[:7, 0] == 0.0).all()
    assert (weights[-7:, 3] == 0.0).all()
    inner = weights[7:-7, [0, 3]]
    assert (inner == 0.0).all() if method is Method.LINEAR else (inner != 0.0).all()


@methods
def test_two_nodes_are_linear(method: Method) -> None:
    assert interpolated(AXES["two"], method, np.array([0.2]), np.array([1.0, 5.0]))[0] == pytest.approx(2.0)
    turned = interpolated(AXES["two periodic"], method, np.array([0.25, 1.75]) * np.pi, np.array([1.0, 5.0]))
    assert turned == pytest.approx([2.0, 2.0])


@methods
def test_one_node_is_met_or_missed(method: Method) -> None:
    points = np.array([0.2, 0.2 * (1.0 + 0.9 * SNAP), 0.2 * (1.0 + 1.1 * SNAP), 0.2 * (1.0 - 1.1 * SNAP), 0.0])
    weights, numbers, inside = weights_at(AXES["one"], method, points)
    assert inside.tolist() == [True, True, False, False, False]
    assert weights[:2].sum(axis=1).tolist() == [1.0, 1.0]
    assert not numbers.any()


def test_one_node_at_zero() -> None:
    _, _, inside = weights_at(stencils(np.array([0.0]), 1), Method.MLS, np.array([0.0, -0.0, 1e-6]))
    assert inside.tolist() == [True, True, False]


def test_points_beyond_the_ends_and_nan_are_outside() -> None:
    points = np.array([0.5 - 1e-9, 0.5, 8.0, 8.0 + 1e-9, -1.0, np.nan, np.inf, -np.inf])
    _, _, inside = weights_at(AXES["uniform"], Method.MLS, points)
    assert inside.tolist() == [False, True, True, False, False, False, False, False]


@pytest.mark.parametrize("smallest", [1e-2, 1e-7], ids=["buckets as fine as cells", "buckets coarser than cells"])
def test_cells_are_found_on_irregular_axes(smallest: float) -> None:
    generator = np.random.default_rng(3)
    nodes = np.cumsum(np.geomspace(smallest, 1.0, 40)[generator.permutation(40)])
    axis = stencils(nodes, 1)
    assert (axis.cell_of_bucket.size == MOST_BUCKETS) == (smallest == 1e-7)
    points = generator.uniform(nodes[0], nodes[-1], 2000)
    _, numbers, inside = weights_at(axis, Method.LINEAR, points)
    assert inside.all()
    assert np.array_equal(numbers[:, 1], np.searchsorted(nodes, points, side="right") - 1)


def test_stride_scales_offsets() -> None:
    single, tripled = stencils(np.linspace(0.0, 1.0, 5), 1), stencils(np.linspace(0.0, 1.0, 5), 3)
    assert np.array_equal(3 * single.offset, tripled.offset)
