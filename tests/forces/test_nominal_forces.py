"""Nominal forces against closed-form cases, brute force, and the figures of the derivation."""

import math
from dataclasses import fields, replace
from time import thread_time

import numpy as np
import pytest
from force_cases import CIRCLE, MODEL, solved, straight
from scipy.integrate import solve_ivp

from trackctl.forces import speed_profile
from trackctl.forces.nominal import limits, nominal_forces, required_friction
from trackctl.forces.reference import Reference
from trackctl.forces.sideslip_spline import solve_spline
from trackctl.forces.yaw_polynomial import solve_polynomial
from trackctl.geometry.clothoid_path import arc, clothoid_arc_clothoid

# R = 5 m, v = 4 m/s, g = 9.81 m/s2
EXACT = {
    "sideslip": -0.1616753206,
    "zero_slide_offset": 0.8048595221,
    "total": 1030.220188,
    "difference": 8769.358207,
}


def polynomial(path, speed, order):
    reference = Reference(path, speed)
    yaw = solve_polynomial(MODEL, reference, order).yaw
    return nominal_forces(MODEL, reference, yaw, np.linspace(0.0, path.length, 301))


def test_constant_speed_on_a_circle_is_exact():
    speed = speed_profile.constant(CIRCLE.length, 4.0)
    for forces in (solved(CIRCLE, speed)[2], polynomial(CIRCLE, speed, 3)):
        for name, value in EXACT.items():
            # ten digits are printed
            assert getattr(forces, name) == pytest.approx(value, rel=5e-10)
        assert abs(forces.residual).max() < 1e-12


@pytest.mark.parametrize("velocity", [0.2, 1.0, 4.0, 6.5])
@pytest.mark.parametrize("radius", [5.0, -8.0])
def test_circles_agree_with_the_closed_form(radius, velocity):
    path = arc(radius, 2.0)
    forces = solved(path, speed_profile.constant(path.length, velocity))[2]
    kappa, c = 1.0 / radius, 2.0 * 0.8 * 9.81 / 4.0
    beta = math.atan(kappa * abs(kappa) * velocity**2 / c)
    offset = math.sin(abs(beta)) / abs(kappa)
    assert forces.sideslip == pytest.approx(-beta, rel=1e-9)
    assert forces.zero_slide_offset == pytest.approx(offset, rel=1e-9)
    assert forces.total == pytest.approx(2000.0 * abs(kappa) * velocity**2 * math.sin(abs(beta)), rel=1e-9)
    turning = math.copysign(2.0 / 3.0 * 0.8 * 2000.0 * 9.81 / 4.0 * (4.0 - offset**2), kappa)
    assert forces.difference == pytest.approx(turning, rel=1e-9)
    assert forces.friction_moment == pytest.approx(-1.5 * turning, rel=1e-9)
    assert forces.time[-1] == pytest.approx(path.length / velocity)


def test_the_forces_drive_the_motion_asked_for():
    """Newton's law in the world frame, from differences of the motion itself."""
    path = clothoid_arc_clothoid(6.0, 8.0, 5.0, 8.0)
    forces = solved(path, speed_profile.smooth(path.length, 0.5, 2.5), count=4001)[2]
    velocity, rate = (
        np.gradient(forces.x + 1j * forces.y, forces.time, edge_order=2),
        np.gradient(forces.yaw, forces.time, edge_order=2),
    )
    acceleration = np.gradient(velocity, forces.time) * np.exp(-1j * forces.yaw)
    inner = slice(20, -20)
    assert 2000.0 * acceleration.real[inner] == pytest.approx(forces.total[inner], abs=2.0)
    lateral = 2.0 * 0.8 * 9.81 / 4.0 * forces.zero_slide_offset * np.sign(forces.yaw_rate)
    assert acceleration.imag[inner] == pytest.approx(lateral[inner], abs=2e-3)
    turning = 15000.0 * np.gradient(rate, forces.time) - 1.5 * forces.difference - forces.friction_moment
    smooth = np.ones(4001, bool)
    for kink in path.kinks:  # where differences straddle a jump
        smooth &= abs(forces.arc_length - kink) > 0.1
    assert abs(turning[inner][smooth[inner]]).max() < 30.0


def test_the_sideslip_is_that_of_a_stiff_integration_backwards():
    speed = speed_profile.smooth(CIRCLE.length, 0.2, 3.0)
    reference, solution, _ = solved(CIRCLE, speed, intervals=160)
    c = MODEL.grip

    def slope(s, sideslip):
        points = reference.at(np.array([s]))
        z, a = points.squared_speed[0], points.acceleration[0]
        beta = -sideslip[0]
        return [0.2 - c * math.sin(beta) / (0.2 * z * math.cos(beta) - a * math.sin(beta))]

    length = CIRCLE.length
    stations = np.linspace(length, 0.0, 41)
    end = solution.yaw.at(stations[:1], reference.at(stations[:1])).sideslip
    found = solve_ivp(slope, (length, 0.0), end, "LSODA", t_eval=stations, rtol=1e-12, atol=1e-14)
    sideslip = solution.yaw.at(stations, reference.at(stations)).sideslip
    assert sideslip == pytest.approx(found.y[0], abs=1e-10)


def test_residual_falls_with_the_order_of_the_spline():
    speed = speed_profile.smooth(CIRCLE.length, 1.0, 4.0)
    largest = [abs(solved(CIRCLE, speed, intervals=n)[2].residual).max() for n in (20, 40, 80)]
    # the derivative of a quintic spline is of fifth order
    assert np.log2(np.array(largest[:-1]) / largest[1:]).min() > 4.4


def test_a_smooth_profile_has_a_residual_of_1e_8():
    _, _, forces = solved(CIRCLE, speed_profile.smooth(CIRCLE.length, 0.2, 3.0), intervals=20)
    assert abs(forces.residual).max() < 1e-8


def test_triangular_speed_gives_the_yaw_gradient_of_the_derivation():
    speed = speed_profile.triangular(CIRCLE.length, 0.2, 3.0)
    _, _, forces = solved(CIRCLE, speed)
    first, second = forces.yaw_gradient[20:90], forces.yaw_gradient[-90:-20]
    assert first == pytest.approx(0.2059, abs=1e-4)
    assert second == pytest.approx(0.1943, abs=1e-4)


def test_even_orders_equal_the_odd_one_below():
    speed = speed_profile.triangular(CIRCLE.length, 0.2, 3.0)
    odd, even, next_odd = (polynomial(CIRCLE, speed, order).yaw_gradient for order in (3, 4, 5))
    assert abs(even - odd).max() < 0.2 * abs(next_odd - odd).max()
    # antisymmetric about the middle but for c + a |theta_s|, which differs between both halves by 7 %
    assert abs(odd + odd[::-1] - 0.4).max() < 0.15 * abs(odd - 0.2).max()


def test_high_orders_stay_well_conditioned():
    speed = speed_profile.smooth(CIRCLE.length, 0.2, 3.0)
    residuals = [abs(polynomial(CIRCLE, speed, order).residual).max() for order in (3, 9, 25)]
    assert residuals[0] > 20.0 * residuals[1] > 400.0 * residuals[2]


def test_left_and_right_mirror():
    speed = speed_profile.smooth(20.0, 0.3, 2.0)
    left, right = (solved(clothoid_arc_clothoid(r, 6.0, 8.0, 6.0), speed)[2] for r in (7.0, -7.0))
    for name, sign in (("y", -1.0), ("sideslip", -1.0), ("zero_slide_offset", 1.0), ("total", 1.0)):
        assert getattr(right, name) == pytest.approx(sign * getattr(left, name), rel=1e-9, abs=1e-9)
    assert right.left == pytest.approx(left.right, rel=1e-9, abs=1e-6)


def test_straight_ahead_needs_no_difference():
    _, _, forces = solved(straight(20.0), speed_profile.triangular(20.0, 0.0, 2.0))
    assert (forces.difference == 0.0).all()
    assert forces.total == pytest.approx(np.where(forces.arc_length < 10.0, 400.0, -400.0))
    assert forces.time[-1] == pytest.approx(20.0)


def test_a_straight_up_the_slope():
    model = replace(MODEL, slope=0.2, uphill_yaw=0.0)
    _, _, forces = solved(straight(20.0), speed_profile.constant(20.0, 1.0), model)
    assert forces.total == pytest.approx(2000.0 * 9.81 * math.sin(0.2))
    assert forces.difference == pytest.approx(0.0, abs=1e-6)


def test_a_straight_across_the_slope_loads_the_lower_track():
    model = replace(MODEL, slope=0.2)  # uphill to the left
    _, _, forces = solved(straight(20.0), speed_profile.constant(20.0, 1.0), model)
    weight = 2000.0 * 9.81
    assert forces.load_left + forces.load_right == pytest.approx(weight * math.cos(0.2))
    moved = weight * math.sin(0.2) * 0.6 / 3.0
    assert forces.load_right - forces.load_left == pytest.approx(2.0 * moved)
    assert forces.sideslip == pytest.approx(0.0, abs=1e-6)


def test_a_slope_tends_to_level_ground():
    path = clothoid_arc_clothoid(6.0, 8.0, 5.0, 8.0)
    speed = speed_profile.smooth(path.length, 0.5, 2.5)
    level = solved(path, speed)[2]
    changes = []
    for slope in (1e-3, 1e-4):
        steep = solved(path, speed, replace(MODEL, slope=slope))[2]
        changes.append(abs(steep.difference - level.difference)[5:-5].max())
    assert changes[0] < 20.0
    assert changes[1] == pytest.approx(0.1 * changes[0], rel=0.2)


def test_limits_are_told_apart():
    length = CIRCLE.length
    for velocity, broken in ((6.54, set()), (6.55, {"beyond_contact"}), (20.0, {"beyond_contact", "beyond_grip"})):
        reference, _, forces = solved(CIRCLE, speed_profile.constant(length, velocity))
        found = limits(MODEL, reference, forces)
        assert {field.name for field in fields(found) if getattr(found, field.name).any()} == broken
        assert found.feasible.all() == (not broken)
    weak = replace(MODEL, max_track_force=4000.0)
    reference, _, forces = solved(CIRCLE, speed_profile.constant(length, 4.0))
    assert limits(weak, reference, forces).beyond_drive.all()


def test_slow_turning_needs_the_friction_of_the_closed_form():
    _, _, forces = solved(CIRCLE, speed_profile.constant(CIRCLE.length, 0.01))
    assert required_friction(forces) == pytest.approx(0.8 * 4.0 / (2.0 * 3.0), rel=1e-5)


def test_a_jump_of_curvature_is_not_drivable():
    path = clothoid_arc_clothoid(8.0, 0.0, 10.0, 8.0)
    reference, _, forces = solved(path, speed_profile.constant(path.length, 1.0))
    assert np.flatnonzero(limits(MODEL, reference, forces).curvature_jump).tolist() == [0]


def test_160_intervals_are_solved_in_20_ms():
    reference = Reference(CIRCLE, speed_profile.smooth(CIRCLE.length, 0.2, 3.0))
    taken = []
    for _ in range(20):
        started = thread_time()
        solution = solve_spline(MODEL, reference, 160)
        taken.append(thread_time() - started)
    assert solution.mesh.size == 161
    assert solution.iterations <= 4
    assert min(taken) < 0.02  # of this thread, as other jobs share the wall clock
