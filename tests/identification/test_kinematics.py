import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from slip_simulation import twist

from trackctl.identification.kinematics import (
    FARTHEST,
    LEAST_DISTANCE,
    arc,
    icr_positions,
    icr_stds,
    twist_of,
    twist_slopes,
)

GAUGE = 0.6
speeds = st.floats(-2.0, 2.0)
parameters = st.lists(st.floats(-0.05, 0.05), min_size=11, max_size=11).map(np.array)


@given(speeds, speeds)
def test_without_slip_the_twist_is_that_of_a_differential_drive(left, right):
    expected = (0.5 * (left + right), 0.0, (right - left) / GAUGE)
    assert twist_of(np.zeros(11), GAUGE, left, right) == pytest.approx(expected, abs=1e-12)


@given(parameters, speeds, speeds)
def test_twist_is_that_of_the_document(p, left, right):
    assert twist_of(p, GAUGE, left, right) == pytest.approx(twist(p, GAUGE, left, right), abs=1e-12)


@given(parameters, speeds, speeds)
def test_icrs_are_where_the_tracks_stand_still_on_the_ground(p, left, right):
    p[9:] = 0.0
    icrs, u = icr_positions(p, GAUGE, left, right), twist_of(p, GAUGE, left, right)
    assert u.forward - u.turn * icrs.left == pytest.approx(left, abs=1e-12)
    assert u.forward - u.turn * icrs.right == pytest.approx(right, abs=1e-12)
    assert u.left + u.turn * icrs.x == pytest.approx(0.0, abs=1e-12)


@given(parameters, speeds)
def test_straight_driving_is_straight(p, speed):
    p[9:] = 0.0
    assert twist_of(p, GAUGE, speed, speed) == pytest.approx((speed, 0.0, 0.0), abs=1e-12)


@given(parameters, speeds, speeds)
def test_mirror(p, left, right):
    mirrored = np.array([p[2], p[3], p[0], p[1], p[4], p[5], -p[7], -p[6], p[8], p[10], p[9]])
    here, there = twist_of(p, GAUGE, left, right), twist_of(mirrored, GAUGE, right, left)
    assert there == pytest.approx((here.forward, -here.left, -here.turn), abs=1e-12)


@given(parameters, speeds, speeds)
def test_slopes_are_derivatives(p, left, right):
    """By y_l, y_r and x as p7 to p9 move them, and by the speeds as p10 and p11 do."""
    slopes = np.zeros((5, 3))
    twist_slopes(p, GAUGE, left, right, slopes)
    h = 1e-6
    for row, (index, factor) in enumerate([(6, 1.0), (7, 1.0), (8, 1.0), (9, left), (10, right)]):
        up, down = p.copy(), p.copy()
        up[index] += h
        down[index] -= h
        numeric = (np.array(twist_of(up, GAUGE, left, right)) - twist_of(down, GAUGE, left, right)) / (2 * h)
        assert factor * slopes[row] == pytest.approx(numeric, abs=2e-7)  # a difference quotient's error


@given(parameters, speeds, speeds, st.integers(0, 2**32 - 1))
def test_spread_of_the_icrs_is_that_of_the_parameters(p, left, right, seed):
    """h P h' with h from differences; the positions are linear in p within their bounds."""
    root = np.random.default_rng(seed).standard_normal((11, 11))
    base, small = 0.01 * p, 1e-3
    slopes = np.empty((3, 11))
    for i, step in enumerate(small * np.eye(11)):
        up, down = icr_positions(base + step, GAUGE, left, right), icr_positions(base - step, GAUGE, left, right)
        slopes[:, i] = (np.array(up) - np.array(down)) / (2.0 * small)
    covariance = root @ root.T
    expected = np.sqrt(np.diag(slopes @ covariance @ slopes.T))
    assert icr_stds(covariance, GAUGE, left, right) == pytest.approx(expected, rel=1e-6)


def test_icrs_stay_apart_and_in_reach():
    p = np.zeros(11)
    p[6], p[7], p[8] = -1.0, 1.0, 100.0
    icrs = icr_positions(p, GAUGE, 1.0, 2.0)
    assert icrs.left - icrs.right == pytest.approx(LEAST_DISTANCE * GAUGE)
    assert icrs.x == FARTHEST * GAUGE
    for far in (-100.0, 100.0):
        p[6:8] = far
        icrs = icr_positions(p, GAUGE, 1.0, 2.0)
        assert icrs.left - icrs.right == pytest.approx(LEAST_DISTANCE * GAUGE)
        assert max(icrs.left, -icrs.right) == pytest.approx(FARTHEST * GAUGE)


def test_turning_on_the_spot_and_rest_are_bounded():
    p = np.full(11, 0.1)
    for left, right in ((-1.0, 1.0), (0.0, 0.0), (1e-9, -1e-9)):
        assert np.isfinite(twist_of(p, GAUGE, left, right)).all()


@pytest.mark.parametrize("angle", [0.0, 1e-9, -9.9e-5, 1.01e-4, -0.3, 2.0, 7.0])
def test_arc_and_its_derivatives(angle):
    exact = (np.sinc(angle / np.pi), 2 * np.sin(angle / 2) ** 2 / angle if angle else 0.0)
    here, h = arc(angle), 1e-5
    assert (here.sine, here.cosine) == pytest.approx(exact, abs=1e-12)
    up, down = arc(angle + h), arc(angle - h)
    assert here.sine_slope == pytest.approx((up.sine - down.sine) / (2 * h), abs=1e-6)
    assert here.cosine_slope == pytest.approx((up.cosine - down.cosine) / (2 * h), abs=1e-6)
