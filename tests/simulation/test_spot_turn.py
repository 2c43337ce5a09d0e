"""Turns on the spot: the balance of rigid-plastic ground in closed form, mirror images, limits."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from simulation.driving import ASPHALT, BIG, BIG_GROUND, SMALL, slope_scene

from trackctl.simulation.following import deviation
from trackctl.simulation.motion import State, sample, simulate
from trackctl.simulation.path import Path
from trackctl.simulation.spot_turn import SpotDrive, spot_drive, spot_rate, spot_turn
from trackctl.simulation.track_speeds import TrackSpeeds

DRIVE = SpotDrive(0.3, 1.0)
LEVEL = slope_scene(0)


def rigid_ratio(model):
    """Yaw rate over that without slip where every point slides and friction is full.

    A point x of a track slides along it with e and across it with r x. With a = e/r the tracks drive the turn with
    (B/2) (2 a asinh(L/(2 a)) - f_r L/mu), and (L/2) sqrt(L^2/4 + a^2) - a^2 asinh(L/(2 a)) holds against it.
    """
    half, B = 0.5 * model.length, model.gauge

    def missing(a):
        reach = math.asinh(half / a)
        drive = 0.5 * B * (2.0 * a * reach - 2.0 * model.resistance * half / model.friction)
        return drive - (half * math.hypot(half, a) - a * a * reach)

    return 1.0 / (1.0 + 2.0 * brentq(missing, 1e-9, 1e3, xtol=1e-14) / B)


def test_stiff_ground_turns_the_body_as_the_balance_of_friction_says():
    """The error is that of the ground's give: proportional to K."""
    errors = []
    for K in (2e-3, 1e-3):
        ground = slope_scene(0, SMALL, replace(ASPHALT, shear_deformation_modulus=K))
        turn = spot_turn(ground, DRIVE, 3.0)
        middle = turn.time.size // 2
        ratio = 0.5 * ground.model.gauge * turn.yaw_rate[middle] / turn.track_speed_right[middle]
        errors.append(ratio / rigid_ratio(ground.model) - 1.0)
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.1)
    assert 2.0 * errors[1] - errors[0] == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize(("vehicle", "terrain"), [(SMALL, ASPHALT), (BIG, BIG_GROUND)], ids=["small", "big"])
@pytest.mark.parametrize("angle", [0.05, 1.0, math.pi])
def test_the_commands_turn_the_body_by_the_angle_from_rest_to_rest(vehicle, terrain, angle):
    ground = slope_scene(0, vehicle, terrain)
    drive = spot_drive(ground, vehicle, vehicle.max_speed)
    turn = spot_turn(ground, drive, angle)
    assert (turn.yaw[0], turn.yaw_rate[0]) == (0.0, 0.0)
    assert turn.yaw[-1] == pytest.approx(angle, abs=3e-6)
    assert abs(turn.yaw_rate[-1]) < 1e-9
    at_rest = turn.track_speed_left == 0.0
    assert (turn.slip_left[at_rest] == 0.0).all()
    assert (turn.slip_left[~at_rest] * turn.slip_right[~at_rest] < 0.0).all()
    assert np.abs(turn.track_speed_left).max() <= drive.speed
    assert np.abs(np.diff(turn.track_speed_left) / np.diff(turn.time)).max() <= drive.acceleration * (1.0 + 1e-9)
    # Longer at rest than the turn asks for, more closely, and where the mass centre gets.
    speeds = TrackSpeeds(
        np.append(turn.time, turn.time[-1] + 1.0),
        *(np.append(values, 0.0) for values in (turn.track_speed_left, turn.track_speed_right)),
    )
    simulation, _ = simulate(ground, speeds, State(), 1e-8)
    after = sample(simulation, 1.0, speeds.time[-1:])
    assert after.yaw[0] == pytest.approx(angle, abs=2e-5)
    assert np.hypot(after.x[0], after.y[0]) < 1e-9


def test_a_turn_to_the_right_is_the_mirror_image():
    left, right = (spot_turn(LEVEL, DRIVE, angle) for angle in (0.7, -0.7))
    assert right.yaw == pytest.approx(-left.yaw, abs=1e-9)
    assert right.track_speed_left == pytest.approx(left.track_speed_right, abs=1e-9)
    assert right.slip_right[1:-5] == pytest.approx(left.slip_left[1:-5], abs=1e-6)


def test_a_drive_that_gives_less_than_merritts_moment_cannot_turn():
    """(mu W L/4) / B on either track, and motion resistance."""
    model = LEVEL.model
    weight = SMALL.mass * model.gravity
    needed = weight * (model.friction * model.length / (4.0 * model.gauge) + 0.5 * model.resistance) / 0.97
    for factor, can in ((0.99, False), (1.01, True)):
        vehicle = replace(SMALL, max_track_force=factor * needed)
        assert (spot_drive(LEVEL, vehicle, 2.0) is not None) is can


@pytest.mark.parametrize(("gauge", "length", "resistance"), [(0.61, 0.8, 0.03), (0.3, 5.0, 0.0), (2.5, 0.4, 0.6)])
def test_the_rate_on_stiff_ground_is_that_of_the_balance_of_friction(gauge, length, resistance):
    vehicle = replace(SMALL, track_gauge=gauge, contact_length=length)
    model = slope_scene(0, vehicle, replace(ASPHALT, motion_resistance_coefficient=resistance)).model
    expected = rigid_ratio(model) * DRIVE.speed / (0.5 * gauge)
    assert spot_rate(model, DRIVE) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("change", [{"cog_forward": 0.05}, {"cog_left": -0.02}, {"min_turn_radius": 1.5}])
def test_a_mass_centre_that_would_move_or_a_least_radius_forbids_turns(change):
    vehicle = replace(SMALL, **change)
    assert spot_drive(slope_scene(0, vehicle), vehicle, 2.0) is None


def test_speeds_are_kept():
    assert spot_drive(LEVEL, SMALL, 0.1).speed < 0.1
    weak = replace(SMALL, max_sprocket_rate=2.0, max_sprocket_acceleration=1.0)
    drive = spot_drive(LEVEL, weak, 2.0)
    assert drive.speed < 2.0 * weak.sprocket_radius
    assert drive.acceleration < 1.0 * weak.sprocket_radius


def test_tracks_that_only_spin_give_no_turn():
    soft = slope_scene(0, SMALL, replace(ASPHALT, shear_deformation_modulus=0.3))
    assert spot_turn(soft, DRIVE, 0.01) is None


def test_where_a_path_stands_the_distance_to_what_follows_counts():
    """Points beside the straights before and after a long stop, nearer to the stop than to any other sample."""
    x = np.concatenate((np.linspace(0.0, 1.0, 11), np.ones(50), np.linspace(1.0, 2.0, 11)))
    nothing = np.zeros_like(x)
    path = Path(nothing, x, nothing, nothing, nothing, nothing)
    away = deviation(path, np.array([0.97, 1.0, 1.03]), np.array([0.01, -0.02, 0.03]))
    assert away == pytest.approx([0.01, 0.02, 0.03], abs=1e-12)
    standing = Path(*(np.ones((6, 4)) * np.array([0.0, 1.0, 2.0, 0.0, 0.0, 0.0])[:, None]))
    assert deviation(standing, np.array([1.0]), np.array([5.0])) == pytest.approx([3.0])
