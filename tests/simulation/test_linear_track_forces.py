import math

import numpy as np
import pytest

from trackctl.simulation.track_force_drive import (
    BodyState,
    TrackForces,
    TrackForceVehicle,
    drive_linear,
    lateral_friction,
)

VEHICLE = TrackForceVehicle(
    mass=2000.0, yaw_inertia=15000.0, gauge=3.0, length=4.0, cog_height=0.6, lateral_friction=0.8, gravity=9.81
)
# Exact at constant speed on a circle of 5 m at 4 m/s.
SPEED, RADIUS, SLIP = 4.0, 5.0, 0.1616753206
TOGETHER, DIFFERENCE, LATERAL = 1030.220188, 8769.358207, 6316.537530


def test_friction_of_the_exact_turn():
    r, v_y = SPEED / RADIUS, -SPEED * math.sin(SLIP)
    force, moment = lateral_friction(VEHICLE, 0.0, v_y, r)
    # The figures have ten digits; the floor of the yaw rate is 1e-6 of it.
    assert force == pytest.approx(LATERAL, rel=1e-9)
    assert moment == pytest.approx(-0.5 * VEHICLE.gauge * DIFFERENCE, rel=1e-9)


def test_friction_saturates_and_rests():
    assert lateral_friction(VEHICLE, 0.0, 3.0, 0.0) == pytest.approx((-0.8 * 2000.0 * 9.81, 0.0))
    assert lateral_friction(VEHICLE, 0.0, 0.0, 0.0) == (0.0, 0.0)


def test_exact_forces_drive_the_circle():
    time = np.linspace(0.0, 3.0, 31)
    left, right = 0.5 * (TOGETHER - DIFFERENCE), 0.5 * (TOGETHER + DIFFERENCE)
    forces = TrackForces(time, np.full(31, left), np.full(31, right))
    start = BodyState(0.0, 0.0, SLIP, SPEED * math.cos(SLIP), -SPEED * math.sin(SLIP), SPEED / RADIUS)
    motion = drive_linear(VEHICLE, start, forces, time, 1e-9)
    turned = SPEED / RADIUS * time
    # Ten digits, in an unstable motion.
    assert motion.x == pytest.approx(RADIUS * np.sin(turned), abs=1e-5)
    assert motion.y == pytest.approx(RADIUS * (1.0 - np.cos(turned)), abs=1e-5)


def test_equal_forces_accelerate_straight_ahead():
    forces = TrackForces(np.array([0.0, 2.0]), np.array([0.0, 400.0]), np.array([0.0, 400.0]))
    motion = drive_linear(VEHICLE, BodyState(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), forces, np.array([0.0, 2.0]), 1e-9)
    assert motion.forward_velocity[-1] == pytest.approx(0.5 * 800.0 * 2.0 / 2000.0, rel=1e-7)
    assert [motion.y[-1], motion.yaw[-1]] == pytest.approx([0.0, 0.0], abs=1e-12)
