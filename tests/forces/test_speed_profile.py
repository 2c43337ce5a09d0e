import numpy as np
import pytest

from trackctl.forces import speed_profile
from trackctl.geometry.bspline import Spline, SplineSpace, clamped_knots

S = np.linspace(0.0, 10.0, 201)
PROFILES = {
    "constant": speed_profile.constant(10.0, 2.0),
    "triangular": speed_profile.triangular(10.0, 0.5, 2.0),
    "trapezoidal": speed_profile.trapezoidal(10.0, 0.5, 2.0),
    "smooth": speed_profile.smooth(10.0, 0.5, 2.0),
}


@pytest.mark.parametrize("name", PROFILES)
def test_acceleration_is_half_the_slope_of_the_squared_speed(name):
    profile, h = PROFILES[name], 1e-6
    inner = S[1:-1] + 0.001
    slope = (profile.squared(inner + h) - profile.squared(inner - h)) / (2.0 * h)
    assert profile.acceleration(inner) == pytest.approx(0.5 * slope, abs=1e-8)
    assert np.sqrt(profile.squared(S).max()) == pytest.approx(2.0)


def test_accelerations_jump_where_they_say():
    assert PROFILES["constant"].jumps.size == PROFILES["smooth"].jumps.size == 0
    assert PROFILES["triangular"].jumps == pytest.approx([5.0])
    assert PROFILES["trapezoidal"].jumps == pytest.approx([2.5, 7.5])


@pytest.mark.parametrize("ends", [0.0, 1e-6, 0.5])
def test_time_of_a_triangle_is_that_of_constant_acceleration(ends):
    stations = np.linspace(0.0, 10.0, 41)
    taken = speed_profile.times(speed_profile.triangular(10.0, ends, 2.0), stations)
    # 1/v is not smooth next to an end almost at rest
    assert taken[-1] == pytest.approx(2.0 * 10.0 / (2.0 + ends), rel=1e-8 if ends != 1e-6 else 1e-5)
    assert (np.diff(taken) > 0.0).all()


def test_a_spline_may_touch_rest_but_not_go_below():
    space = SplineSpace(clamped_knots(np.array([0.0, 10.0]), 3), 3)
    profile = speed_profile.from_spline(Spline(space, np.array([-1e-12, 1.0, 1.0, 0.0])))
    assert profile.squared(S).min() == 0.0
