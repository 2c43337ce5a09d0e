"""The vehicle under track forces: closed-form motions."""

import math
from dataclasses import replace

import numpy as np
import pytest

from trackctl.simulation.track_force_drive import (
    BodyState,
    ForceHistory,
    TrackForceVehicle,
    drive,
    lateral_friction,
)

VEHICLE = TrackForceVehicle(
    mass=2000.0,
    yaw_inertia=15000.0,
    gauge=3.0,
    length=4.0,
    cog_height=0.6,
    lateral_friction=0.8,
    gravity=9.81,
    slope=0.0,
    uphill_yaw=0.5 * math.pi,
    yaw_rate_scale=1e-6,
)
WEIGHT = 2000.0 * 9.81


def constant(total, difference, duration, start=0.0, count=21):
    time = np.linspace(start, start + duration, count)
    return ForceHistory(time, np.full(count, total), np.full(count, difference))


def test_straight_ahead_is_uniform_acceleration():
    forces = [constant(1000.0, 0.0, 4.0), constant(-500.0, 0.0, 2.0, start=4.0)]
    found = drive(VEHICLE, BodyState(1.0, 2.0, math.pi / 2, 0.5, 0.0, 0.0), forces)
    assert found.forward_velocity[-1] == pytest.approx(0.5 + 0.5 * 4.0 - 0.25 * 2.0)
    assert found.y[20] == pytest.approx(2.0 + 0.5 * 4.0 + 0.25 * 16.0)
    assert found.x == pytest.approx(1.0)


def test_spinning_on_the_spot_stops_after_its_energy_is_spent():
    # the friction moment of pure spinning is mu_t m g L / 4
    moment = 0.8 * WEIGHT * 4.0 / 4.0
    found = drive(VEHICLE, BodyState(0.0, 0.0, 0.0, 0.0, 0.0, 2.0), [constant(0.0, 0.0, 1.0)])
    time = np.linspace(0.0, 1.0, 21)
    assert found.yaw_rate == pytest.approx(2.0 - moment / 15000.0 * time, abs=1e-6)
    long = drive(VEHICLE, BodyState(0.0, 0.0, 0.0, 0.0, 0.0, 2.0), [constant(0.0, 0.0, 4.0)])
    assert long.yaw[-1] == pytest.approx(0.5 * 15000.0 * 4.0 / moment, rel=1e-6)
    assert abs(long.yaw_rate[-1]) < 1e-9


def test_a_steady_turn_stays_one():
    # R = 5 m, v = 4 m/s: the closed form
    beta = math.atan(0.04 * 16.0 / (2.0 * 0.8 * 9.81 / 4.0))
    offset = 5.0 * math.sin(beta)
    total = 2000.0 * 0.2 * 16.0 * math.sin(beta)
    difference = 2.0 / 3.0 * 0.8 * WEIGHT / 4.0 * (4.0 - offset**2)
    start = BodyState(0.0, 0.0, beta, 4.0 * math.cos(beta), -4.0 * math.sin(beta), 0.8)
    found = drive(VEHICLE, start, [constant(total, difference, 5.0)])
    angle = 0.8 * np.linspace(0.0, 5.0, 21)
    assert found.x == pytest.approx(5.0 * np.sin(angle), abs=1e-7)
    assert found.y == pytest.approx(5.0 - 5.0 * np.cos(angle), abs=1e-7)


@pytest.mark.parametrize(("lateral", "yaw_rate"), [(-0.3, 0.5), (0.2, -0.7), (0.9, 0.4), (-2.0, 0.1), (0.1, 0.0)])
@pytest.mark.parametrize(("slope", "heading"), [(0.0, 0.0), (0.3, 0.4), (0.3, 2.5)])
def test_friction_is_the_integral_over_the_tracks(lateral, yaw_rate, slope, heading):
    vehicle = replace(VEHICLE, slope=slope, yaw_rate_scale=1e-9)
    x = np.linspace(-2.0, 2.0, 400001)
    x = 0.5 * (x[1:] + x[:-1])
    shift = -0.6 * math.tan(slope) * math.cos(heading)
    load = WEIGHT * math.cos(slope) / 4.0 * (1.0 + 12.0 * shift * x / 16.0)
    stress = -0.8 * load * np.sign(lateral + yaw_rate * x) * 1e-5
    force, moment = lateral_friction(vehicle, heading, lateral, yaw_rate)
    assert force == pytest.approx(stress.sum(), rel=1e-4)
    if yaw_rate:
        all_one_way = abs(lateral) >= 2.0 * abs(yaw_rate)
        # along one side the load's shift alone turns, which the model leaves out
        assert all_one_way or moment == pytest.approx((stress * x).sum(), abs=0.3)
