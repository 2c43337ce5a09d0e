"""The constraint and its derivatives, on level ground and on a slope."""

from dataclasses import replace

import numpy as np
import pytest
from force_cases import MODEL

from trackctl.forces.model import ReferencePoints, constraint, gravity_in_body, steady_sideslip

COUNT = 200


def random_points(seed):
    random = np.random.default_rng(seed)
    values = {
        "x": np.zeros(COUNT),
        "y": np.zeros(COUNT),
        "tangent": random.uniform(-4.0, 4.0, COUNT),
        "curvature": random.uniform(-0.3, 0.3, COUNT),
        "curvature_gradient": random.uniform(-0.1, 0.1, COUNT),
        "squared_speed": random.uniform(0.0, 20.0, COUNT),
        "acceleration": random.uniform(-2.0, 2.0, COUNT),
    }
    # sideslips at which the tracks slide both ways, as they do where a vehicle can go
    gradient = random.uniform(0.02, 0.3, COUNT) * random.choice([-1.0, 1.0], COUNT)
    sideslip = random.uniform(-0.9, 0.9, COUNT) * np.arcsin(np.abs(gradient) * 2.0)
    return ReferencePoints(**values), sideslip, gradient


def test_it_is_the_papers_on_level_ground():
    points, sideslip, gradient = random_points(0)
    beta, bend, c = -sideslip, np.abs(gradient), 2.0 * 0.8 * 9.81 / 4.0
    z, a, kappa = points.squared_speed, points.acceleration, points.curvature
    expected = ((c + a * bend) * np.sin(beta) - kappa * z * bend * np.cos(beta)) / c
    assert constraint(MODEL, points, sideslip, gradient).value == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize("slope", [0.0, 0.2])
def test_derivatives_are_those_of_differences(slope):
    model = replace(MODEL, slope=slope, uphill_yaw=0.7)
    points, sideslip, gradient = random_points(1)
    residual, h = constraint(model, points, sideslip, gradient), 1e-6
    by_sideslip, by_gradient = (
        (constraint(model, points, *above).value - constraint(model, points, *below).value) / (2.0 * h)
        for above, below in (
            ((sideslip + h, gradient), (sideslip - h, gradient)),
            ((sideslip, gradient + h), (sideslip, gradient - h)),
        )
    )
    assert residual.by_sideslip == pytest.approx(by_sideslip, abs=1e-6)
    assert residual.by_yaw_gradient == pytest.approx(by_gradient, abs=1e-6)


@pytest.mark.parametrize("slope", [0.0, 0.15])
def test_the_steady_sideslip_meets_it(slope):
    model = replace(MODEL, slope=slope, cog_height=0.3)
    points, _, gradient = random_points(2)
    slow = replace(points, squared_speed=0.1 * points.squared_speed, acceleration=0.1 * points.acceleration)
    sideslip = steady_sideslip(model, slow, gradient)
    assert constraint(model, slow, sideslip, gradient).value == pytest.approx(0.0, abs=1e-9)


def test_left_and_right_mirror():
    points, sideslip, gradient = random_points(3)
    mirrored = replace(points, tangent=-points.tangent, curvature=-points.curvature)
    model = replace(MODEL, slope=0.2, uphill_yaw=0.0)
    left, right = constraint(model, points, sideslip, gradient), constraint(model, mirrored, -sideslip, -gradient)
    assert right.value == pytest.approx(-left.value, abs=1e-14)


def test_gravity_pulls_down_the_slope():
    model = replace(MODEL, slope=0.3, uphill_yaw=0.5)
    up, left_of_up = gravity_in_body(model, np.array([0.5])), gravity_in_body(model, np.array([0.5 + np.pi / 2]))
    assert (up.forward[0], up.left[0]) == pytest.approx((-9.81 * np.sin(0.3), 0.0))
    assert (left_of_up.forward[0], left_of_up.left[0]) == pytest.approx((0.0, 9.81 * np.sin(0.3)))
    assert up.load_offset[0] == pytest.approx(-0.6 * np.tan(0.3))


def test_it_is_finite_at_rest_and_on_straights():
    still = np.zeros(4)
    points = ReferencePoints(still, still, still, still, still, np.array([0.0, 0.0, 1.0, 1.0]), np.ones(4))
    residual = constraint(MODEL, points, still, np.array([0.0, 0.1, 0.0, 0.1]))
    assert (residual.value == 0.0).all()
    assert np.isfinite([residual.by_sideslip, residual.by_yaw_gradient]).all()
