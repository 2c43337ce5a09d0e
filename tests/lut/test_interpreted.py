"""Look-ups that are interpreted against the same ones compiled."""

import math

import numpy as np
import pytest
from solved_tables import solved_table

from trackctl.compiled import interpreted
from trackctl.lut.interpolation import interpolant, look_up
from trackctl.lut.shape_functions import Method

EDGES = (0.0, -0.0, 1e-300, -1e-300, 1e300, -1e300, math.inf, -math.inf, math.nan, 5e-324)
NAMES = ("track_speed_left", "sprocket_rate_right", "sideslip", "slip_left", "slip_right")


def points(table):
    """Slope, velocity, curvature and heading of points in and about the table, and odd ones, shape (4, n)."""
    random, axes = np.random.default_rng(7), table.axes
    ends = [(nodes[0], nodes[-1]) for nodes in (axes.slope, axes.velocity, axes.curvature, axes.heading)]
    inside = np.array([random.uniform(low, high, 60) for low, high in ends])
    odd = np.repeat(inside[:, :4], 4 * len(EDGES) // 4, axis=1)
    for i in range(odd.shape[1]):
        odd[i % 4, i] = EDGES[i // 4]
    odd[3, np.abs(odd[3]) == 1e300] = 1e3  # so large a heading is nothing but rounding
    nodes = np.array([[low, high] for low, high in ends])
    return np.hstack((inside, odd, nodes))


@pytest.mark.parametrize("method", Method)
def test_answers_differ_by_rounding_alone(method):
    table = solved_table()
    packed, asked = interpolant(table), points(table)
    compiled = look_up(packed, *asked, method)
    with interpreted():
        plain = look_up(packed, *asked, method)
    np.testing.assert_array_equal(plain.status, compiled.status)
    assert np.any(compiled.status == 0)
    for name in NAMES:
        np.testing.assert_allclose(getattr(plain, name), getattr(compiled, name), rtol=1e-10, atol=1e-13)
