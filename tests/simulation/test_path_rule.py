import math
from dataclasses import replace

import numpy as np
import pytest
from simulation.driving import (
    ASPHALT,
    SIZES,
    SMALL,
    blended_arcs,
    deviation_percent,
    lap,
    s_curve,
    slope_scene,
    speed_ramp,
    traverse,
)

from trackctl.lut.point import solve_points
from trackctl.simulation.path import Path, circle, path_of_curvature
from trackctl.simulation.path_rule import Ground, naive_commands, no_slip_commands, path_commands, resampled

#: What the path rule is known to reach, in percent of the way: with contact memory, and without.
FIGURES = [
    (lap, 12, "small", 0.09, 0.002),
    (lap, 12, "big", 0.07, 0.004),
    (lap, 18, "small", 0.07, 0.02),
    (lap, 18, "big", 0.73, 0.03),
    (traverse, 12, "small", 0.0, 0.0),
    (traverse, 12, "big", 0.0, 0.0),
    (s_curve, 12, "small", 0.25, 0.005),
    (s_curve, 12, "big", 0.19, 0.015),
    (speed_ramp, 12, "small", 0.05, 0.008),
    (blended_arcs, 12, "small", 0.65, 0.004),
    (blended_arcs, 12, "big", 0.73, 0.02),
]
# The figures are rounded: 0 stands for less than 0.001 %.
LEAST_FIGURE, MARGIN = 0.001, 1.5


def scene_of(size, degrees, remember=True):
    vehicle, terrain, _, _ = SIZES[size]
    return slope_scene(degrees, vehicle, terrain, remember=remember)


@pytest.mark.parametrize(("path_of", "degrees", "size", "with_memory", "without"), FIGURES)
def test_path_rule_reaches_its_figures(path_of, degrees, size, with_memory, without):
    path = path_of(size)
    for remember, figure in ((True, with_memory), (False, without)):
        ground = scene_of(size, degrees, remember)
        commands = path_commands(ground, path)
        assert commands.residual.max() <= 1e-10
        assert deviation_percent(ground, commands, path) <= MARGIN * max(figure, LEAST_FIGURE)


@pytest.mark.parametrize("factor", [0.8, 1.25])
@pytest.mark.parametrize(
    ("degrees", "size", "figure"), [(12, "small", 0.09), (12, "big", 0.07), (18, "small", 0.07), (18, "big", 0.73)]
)
def test_circles_reach_their_figures_at_other_radii(degrees, size, figure, factor):
    """The figures name no radius: `benchmarks/path_rule.py` has the other rows."""
    _, _, radius, speed = SIZES[size]
    path, ground = circle(factor * radius, speed, 1.0, (0.0, 0.0, 0.0)), scene_of(size, degrees)
    assert deviation_percent(ground, path_commands(ground, path), path) <= MARGIN * figure


@pytest.mark.parametrize(("size", "naive"), [("small", 3.3), ("big", 3.5)])
def test_the_naive_reading_misses_a_circle_by_what_is_known(size, naive):
    ground, path = scene_of(size, 12), lap(size)
    # One digit of the known figures, and a vehicle that is not quite the same, leave a quarter.
    assert deviation_percent(ground, naive_commands(ground, path), path) == pytest.approx(naive, rel=0.25)


def test_commands_without_slip_miss_a_circle_by_what_is_known():
    ground, path = scene_of("small", 12), lap("small")
    assert deviation_percent(ground, no_slip_commands(ground, path), path) == pytest.approx(12.0, rel=0.25)


def test_path_rule_is_ten_times_better_than_the_naive_reading_on_a_circle():
    ground, path = scene_of("small", 12), lap("small")
    rule = deviation_percent(ground, path_commands(ground, path), path)
    assert deviation_percent(ground, naive_commands(ground, path), path) >= 10.0 * rule


def test_level_ground_needs_no_rule():
    """A circle at constant speed is a steady turn there."""
    ground, path = scene_of("small", 0), lap("small")
    rule, naive = path_commands(ground, path), naive_commands(ground, path)
    for name in ("track_speed_left", "track_speed_right", "sideslip"):
        assert getattr(rule, name) == pytest.approx(getattr(naive, name), abs=1e-9)


def test_naive_commands_are_those_of_the_table():
    ground, path = scene_of("small", 12), lap("small")
    commands = naive_commands(ground, path)
    some = slice(None, None, 40)
    heading = commands.path.tangent - commands.sideslip - ground.uphill_yaw
    points = np.stack((np.full_like(heading, ground.slope), commands.path.speed, commands.path.curvature, heading), 1)
    left, right, sideslip = solve_points(ground.model, points[some])["unknowns"].T
    # Both are solved to 1e-10 of the weight.
    assert commands.track_speed_left[some] == pytest.approx(left * commands.path.speed[some], abs=1e-8)
    assert commands.track_speed_right[some] == pytest.approx(right * commands.path.speed[some], abs=1e-8)
    assert commands.sideslip[some] == pytest.approx(sideslip, abs=1e-8)


def test_right_turns_mirror_left_turns():
    left = path_commands(slope_scene(12, uphill_yaw=0.4), circle(2.0, 0.5, 0.5, (0.0, 0.0, 0.0)))
    right = path_commands(slope_scene(12, uphill_yaw=-0.4), circle(-2.0, 0.5, 0.5, (0.0, 0.0, 0.0)))
    assert right.track_speed_right == pytest.approx(left.track_speed_left, abs=1e-9)
    assert right.sideslip == pytest.approx(-left.sideslip, abs=1e-9)


def test_yaw_rate_is_the_heading_s_own():
    """The yaw is tangent - sideslip, and its derivative over time is what the commands say."""
    commands = path_commands(scene_of("small", 12), lap("small"))
    yaw = commands.path.tangent - commands.sideslip
    inner = slice(5, -5)
    # Second-order differences of a smoothed derivative.
    assert np.gradient(yaw, commands.time)[inner] == pytest.approx(commands.yaw_rate[inner], rel=2e-3)


def test_acceleration_needs_traction():
    """On a level straight the tracks push with m a more than at constant speed: their slip grows."""
    ground = slope_scene(0, SMALL, replace(ASPHALT, motion_resistance_coefficient=0.0))
    s = np.linspace(0.0, 4.0, 161)
    path = path_of_curvature(s, 0.0 * s, np.sqrt(0.25 + 2.0 * 0.5 * s), (0.0, 0.0, 0.0))
    commands = path_commands(ground, path)
    middle = commands.slip_left.size // 2
    slip, K, L = commands.slip_left[middle], ASPHALT.shear_deformation_modulus, SMALL.contact_length
    reach = slip * L / K
    traction = ASPHALT.friction_coefficient * (1.0 - (1.0 - math.exp(-reach)) / reach)
    # Load moves rearward, where shoes have slid farthest: a per cent.
    assert traction == pytest.approx(0.5 / ground.model.gravity, rel=0.05)


def test_a_slope_too_steep_is_told_by_the_residual():
    commands = path_commands(slope_scene(44), lap("small"))
    assert commands.residual.max() > 1e-3


def test_ground_of_one_slope_is_the_plane():
    scene, path = slope_scene(12, uphill_yaw=0.4), circle(2.0, 0.5, 0.5, (0.0, 0.0, 0.0))
    level = slope_scene(0, uphill_yaw=1.0)
    ground = Ground(path.arc_length, np.full_like(path.x, math.radians(12)), np.full_like(path.x, 0.4))
    plane, along = path_commands(scene, path), path_commands(level, path, ground)
    assert along.track_speed_left == pytest.approx(plane.track_speed_left, abs=1e-9)
    assert along.sideslip == pytest.approx(plane.sideslip, abs=1e-9)


def test_up_slope_that_turns_with_the_path_makes_a_steady_turn():
    """Heading from up-slope stays: the sideslip is constant, as on a cone that is driven round."""
    path = circle(2.0, 0.5, 0.5, (0.0, 0.0, 0.0))
    ground = Ground(path.arc_length, np.full_like(path.x, math.radians(12)), path.tangent - 1.0)
    commands = path_commands(slope_scene(0), path, ground)
    inner = slice(70, -70)
    assert commands.residual.max() <= 1e-10
    assert np.ptp(commands.sideslip[inner]) < 1e-6


def test_tractions_balance_weight_resistance_and_acceleration():
    """Up, down and along a slope with an acceleration: the sum is what the motion along the tangent takes."""
    for uphill_yaw in (0.0, 1.0, math.pi):
        ground = slope_scene(12, uphill_yaw=uphill_yaw)
        s = np.linspace(0.0, 4.0, 161)
        path = path_of_curvature(s, 0.0 * s, np.sqrt(0.25 + 2.0 * 0.3 * s), (0.0, 0.0, 0.0))
        commands = path_commands(ground, path)
        slope, resistance = math.radians(12), ASPHALT.motion_resistance_coefficient
        taken = math.sin(slope) * math.cos(uphill_yaw) + 0.3 / ground.model.gravity
        sideways = math.sin(slope) * math.sin(uphill_yaw)
        # Along the body, which the sideslip turns against the tangent.
        beta = commands.sideslip
        total = taken * np.cos(beta) - sideways * np.sin(beta) + resistance * math.cos(slope)
        inner = slice(5, -5)
        assert (commands.traction_left + commands.traction_right)[inner] == pytest.approx(total[inner], abs=1e-8)


def test_without_a_balance_there_are_no_tractions():
    assert np.isnan(no_slip_commands(scene_of("small", 12), lap("small")).traction_left).all()


def test_a_resampled_path_ends_where_it_ends():
    """At rest, too, for whatever length: the square root of a rounding error is none."""
    for length in np.random.default_rng(0).uniform(1.0, 30.0, 200):
        place, zeros = np.linspace(0.0, length, 50), np.zeros(50)
        path = Path(place, place, zeros, zeros, zeros, np.sqrt(place * (length - place)))
        fine, inner = resampled(path, 0.61)
        assert fine.arc_length[inner][-1] == length
        assert fine.speed[inner][0] == fine.speed[inner][-1] == 0.0
