import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trackctl.mechanics.slip import body_speed, no_slip_radius, slip

SPEEDS = st.floats(0.01, 10.0)
GAUGE = 0.61
# A few roundings of numbers of order 10.
ROUNDING = 1e-13


def test_body_speed_straight_ahead_is_the_speed_of_both_tracks():
    np.testing.assert_array_equal(body_speed(1.5, 0.0, 0.0, np.array([0.3, -0.3])), [1.5, 1.5])


def test_body_speed_on_a_circle_goes_with_the_distance_from_its_centre():
    speeds = body_speed(2.0, 1.0 / 5.0, 0.0, np.array([0.3, -0.3]))
    np.testing.assert_allclose(speeds, [2.0 * 4.7 / 5.0, 2.0 * 5.3 / 5.0], rtol=ROUNDING)


def test_body_speed_has_the_forward_part_of_a_sideslip():
    assert float(body_speed(1.0, 0.0, math.radians(60.0), 0.3)) == pytest.approx(0.5, abs=ROUNDING)


def test_body_speed_broadcasts():
    assert body_speed(np.ones(3), np.zeros((2, 1)), 0.0, 0.3).shape == (2, 3)


def test_slip_signs():
    assert float(slip(2.0, 1.0)) == 0.5
    assert float(slip(1.0, 2.0)) == -0.5
    assert float(slip(1.0, 0.0)) == 1.0
    assert float(slip(0.0, 1.0)) == -1.0
    assert float(slip(-2.0, -1.0)) == -0.5


def test_slip_at_rest_is_none():
    np.testing.assert_array_equal(slip(np.array([0.0, 1.0]), np.array([0.0, 1.0])), [0.0, 0.0])


def test_slip_of_an_unknown_speed_is_unknown():
    assert np.isnan(slip([np.nan, 1.0], [1.0, np.nan])).all()


@given(SPEEDS, SPEEDS)
def test_slip_is_odd_and_bounded(track, body):
    assert -1.0 <= float(slip(track, body)) <= 1.0
    assert float(slip(body, track)) == -float(slip(track, body))
    assert float(slip(-track, -body)) == -float(slip(track, body))


def test_no_slip_radius_of_the_papers_experiment():
    # Outer 0.5 m/s, inner 0.2567 m/s: 0.948 m, cut off after 3 digits.
    assert float(no_slip_radius(GAUGE, 0.2567, 0.5)) == pytest.approx(0.948, abs=1e-3)
    assert float(no_slip_radius(GAUGE, 0.5, 0.2567)) == pytest.approx(-0.948, abs=1e-3)


def test_no_slip_radius_when_straight_or_unknown():
    np.testing.assert_array_equal(no_slip_radius(GAUGE, [1.0, 0.0, np.nan], [1.0, 0.0, 1.0]), [np.inf, np.inf, np.nan])


@given(st.floats(0.5, 100.0), SPEEDS)
def test_without_slip_the_radius_comes_back(radius, velocity):
    left, right = (body_speed(velocity, 1.0 / radius, 0.0, arm) for arm in (0.5 * GAUGE, -0.5 * GAUGE))
    # The difference of the speeds loses radius / gauge of the digits.
    assert float(no_slip_radius(GAUGE, left, right)) == pytest.approx(radius, rel=1e-11)
