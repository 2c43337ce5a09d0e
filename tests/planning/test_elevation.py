import math

import numpy as np
import pytest

from trackctl.planning.elevation import Elevation, fitted_slopes, footprint_scale
from trackctl.planning.slope_field import gradient_at, plane_slope
from trackctl.profiles.footprint import rectangle


def ground(height, n_rows=30, n_columns=40, spacing=(0.1, 0.2), corner=(5.0, -3.0)):
    """An elevation grid of a function of x and y, with its nodes."""
    x = corner[0] + spacing[0] * np.arange(n_columns)
    y = (corner[1] + spacing[1] * np.arange(n_rows))[:, None]
    return Elevation(height(x, y) + 0.0 * x * y, *spacing, *corner, "hill.asc"), x, y


def plane(x, y):
    return 1700.0 + 0.3 * x - 0.2 * y


def test_a_plane_is_met_exactly_up_to_the_rim():
    slopes = fitted_slopes(ground(plane)[0], 0.25)
    np.testing.assert_allclose(slopes.gradient_x, 0.3, atol=1e-11)
    np.testing.assert_allclose(slopes.gradient_y, -0.2, atol=1e-11)


def test_a_plane_is_met_exactly_beside_unknown_ground():
    elevation, _, _ = ground(plane)
    random = np.random.default_rng(0)
    elevation.height[random.random(elevation.height.shape) < 0.3] = np.nan
    slopes = fitted_slopes(elevation, 0.25)
    np.testing.assert_array_equal(np.isnan(slopes.gradient_x), np.isnan(elevation.height))
    known = ~np.isnan(elevation.height)
    np.testing.assert_allclose(slopes.gradient_x[known], 0.3, atol=1e-11)
    np.testing.assert_allclose(slopes.gradient_y[known], -0.2, atol=1e-11)


def test_known_nodes_on_a_line_tell_no_slope():
    elevation, _, _ = ground(plane)
    elevation.height[:10] = elevation.height[11:] = np.nan
    assert np.isnan(fitted_slopes(elevation, 0.2).gradient_x).all()


@pytest.mark.parametrize("wave_number", [0.5, 1.0, 2.0])
def test_a_wave_is_damped_by_its_length_beside_the_footprint(wave_number):
    """The moments of a Gaussian over sin(k x): a slope of k cos(k x) exp(-(k scale)^2 / 2)."""
    scale = 0.5
    elevation, x, _ = ground(lambda x, y: np.sin(wave_number * x), 40, 200, (0.05, 0.2))
    slopes = fitted_slopes(elevation, scale)
    expected = wave_number * np.cos(wave_number * x) * math.exp(-0.5 * (wave_number * scale) ** 2)
    # Weights beyond four standard deviations, left out, carry 0.1 % of the second moment.
    np.testing.assert_allclose(
        slopes.gradient_x[15:25, 40:-40], expected[None, 40:-40].repeat(10, 0), atol=2e-3 * wave_number
    )
    np.testing.assert_allclose(slopes.gradient_y[15:25, 40:-40], 0.0, atol=1e-11)


def test_the_slope_of_a_smooth_hill_converges_at_second_order():
    errors = []
    for count in (50, 100, 200):
        spacing = 10.0 / count
        elevation, x, _ = ground(
            lambda x, y: 2.0 * np.exp(-((x - 5.0) ** 2 + (y - 5.0) ** 2) / 8.0),
            count,
            count,
            (spacing,) * 2,
            (0.0, 0.0),
        )
        slopes = fitted_slopes(elevation, 0.0)
        exact = -(x - 5.0) / 4.0 * elevation.height
        inside = (slice(5, -5), slice(5, -5))
        errors.append(np.abs(slopes.gradient_x - exact)[inside].max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(orders, 2.0, atol=0.1)


def test_the_hill_turned_by_a_quarter_has_its_slopes_turned():
    random = np.random.default_rng(1)
    height = random.random((20, 30))
    slopes = fitted_slopes(Elevation(height, 0.1, 0.1, 0.0, 0.0, ""), 0.2)
    turned = fitted_slopes(Elevation(np.rot90(height, -1), 0.1, 0.1, 0.0, 0.0, ""), 0.2)
    # Rows run upwards, so that np.rot90 by -1 turns counter-clockwise: x becomes y.
    np.testing.assert_allclose(turned.gradient_y, np.rot90(slopes.gradient_x, -1), atol=1e-12)
    np.testing.assert_allclose(turned.gradient_x, -np.rot90(slopes.gradient_y, -1), atol=1e-12)


def test_the_scale_of_a_footprint_is_the_deviation_of_its_area():
    length, width = 1.2, 0.7
    x, y = np.random.default_rng(0).random((2, 200_000)) - 0.5
    deviation = math.sqrt(0.5 * (np.var(length * x) + np.var(width * y)))
    assert footprint_scale(rectangle(length, width)) == pytest.approx(deviation, rel=0.01)


def test_between_nodes_the_gradient_is_bilinear():
    elevation, x, y = ground(lambda x, y: 0.1 * x * x)
    slopes = fitted_slopes(elevation, 0.2)
    along, across = gradient_at(slopes, x[7] + 0.03, float(y[4, 0]) + 0.05)
    corners = slopes.gradient_x[4:6, 7:9]
    assert along == pytest.approx(np.array([0.75, 0.25]) @ corners @ np.array([0.7, 0.3]), rel=1e-12)
    assert across == pytest.approx(0.0, abs=1e-12)


def test_the_rim_reaches_half_a_spacing_out():
    elevation, _, _ = ground(plane)
    slopes = fitted_slopes(elevation, 0.2)
    left, low, right, high = elevation.bounds
    for x, y in ((left + 1e-9, low + 1e-9), (right - 1e-9, high - 1e-9), (left + 1e-9, high - 1e-9)):
        np.testing.assert_allclose(gradient_at(slopes, x, y), (0.3, -0.2), atol=1e-11)
    for x, y in ((left - 1e-6, low + 0.1), (right + 1e-6, low + 0.1), (left + 0.1, low - 1e-6), (left, high + 1e-6)):
        assert np.isnan(gradient_at(slopes, x, y)).all()
    assert np.isnan(gradient_at(slopes, math.nan, 0.0)).all()


def test_a_plane_has_one_slope_everywhere():
    slopes = plane_slope(math.radians(12.0), math.radians(30.0))
    for x, y in ((0.0, 0.0), (1e5, -1e5)):
        along, across = gradient_at(slopes, x, y)
        assert math.degrees(math.atan(math.hypot(along, across))) == pytest.approx(12.0)
        assert math.degrees(math.atan2(across, along)) == pytest.approx(30.0)
