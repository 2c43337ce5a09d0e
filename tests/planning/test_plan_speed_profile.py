import numpy as np
import pytest

from trackctl.planning.speed_profile import fastest_speed

S = np.linspace(0.0, 10.0, 1001)


def limits(speed, acceleration):
    return np.full_like(S, speed), np.full_like(S, acceleration)


def test_from_rest_to_rest_by_constant_acceleration():
    speed = fastest_speed(S, *limits(2.0, 0.5), 0.0, 0.0)
    assert speed == pytest.approx(np.minimum(2.0, np.sqrt(np.minimum(S, 10.0 - S))), abs=1e-12)


def test_too_short_for_the_top_speed():
    assert fastest_speed(S, *limits(9.0, 0.5), 0.0, 0.0).max() == pytest.approx(np.sqrt(5.0), abs=1e-12)


def test_a_slow_place_is_approached_and_left_in_time():
    most, acceleration = limits(3.0, 1.0)
    most[400:501] = 1.0
    speed = fastest_speed(S, most, acceleration, 3.0, 3.0)
    assert speed == pytest.approx(np.minimum(3.0, np.sqrt(1.0 + 2.0 * np.maximum(0.0, np.maximum(4.0 - S, S - 5.0)))))


def test_limits_hold_at_every_sample_and_none_is_wasted():
    random = np.random.default_rng(3)
    most, acceleration = random.uniform(0.5, 2.0, S.size), random.uniform(0.2, 1.0, S.size)
    speed = fastest_speed(S, most, acceleration, 0.0, 0.3)
    change = 0.5 * np.abs(np.diff(speed**2)) / np.diff(S)
    allowed = np.minimum(acceleration[1:], acceleration[:-1])
    assert (speed <= most + 1e-12).all()
    assert (change <= allowed + 1e-9).all()
    assert speed[-1] <= 0.3 + 1e-12
    # Each sample is at its limit, or bound by the change to a neighbour.
    bound = np.isclose(change, allowed)
    at_limit = np.isclose(speed, most)
    assert (at_limit[1:-1] | bound[1:] | bound[:-1]).all()
