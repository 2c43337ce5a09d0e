"""The swing of a vehicle on its shear springs, which contact memory brings about."""

import cmath
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq, least_squares
from simulation.driving import ASPHALT, SMALL, State, drive, drive_along, slope_scene

from trackctl.simulation.motion import sample

LOW = replace(SMALL, cog_height=0.0)
HEAVY_GOING = replace(ASPHALT, motion_resistance_coefficient=0.3)
MU, K, L = HEAVY_GOING.friction_coefficient, HEAVY_GOING.shear_deformation_modulus, LOW.contact_length
SPEED = 0.5


def steady_slip():
    """mu (1 - (1 - exp(-i L/K)) K/(i L)) = f_r."""

    def missing(i):
        reach = i * L / K
        return MU * (1.0 - (1.0 - math.exp(-reach)) / reach) - HEAVY_GOING.motion_resistance_coefficient

    return brentq(missing, 1e-6, 0.5)


def swing(slip, gravity):
    """Damping and frequency of small swings about steady driving, as a complex rate.

    A shoe that has been on the ground for tau has been displaced by the way gone meanwhile, x(t) - x(t - tau) more
    than steadily, and the stress exp(-i V tau/K) mu p/K per displacement draws back:
    z^2 = -(mu g/K) mean over tau in [0, T] of exp(-a tau) (1 - exp(-z tau)), with a = i V/K and T = L/V.
    Without the exp(-z tau) of the shoes' entry it is z = +- i sqrt(k/m). What is lost is the energy of the springs that
    leave the contact: it goes with 1/(2 T), not with friction.
    """
    a, T, square = slip * SPEED / K, L / SPEED, MU * gravity / K

    def mean(rate):
        return (1.0 - cmath.exp(-rate * T)) / (rate * T)

    spring = math.sqrt(square * mean(a).real)
    z = 1j * spring - 0.5 / T
    for _ in range(50):
        step = 1e-6
        f, ahead = (y * y + square * (mean(a) - mean(a + y)) for y in (z, z + step))
        z -= f * step / (ahead - f)
    return z, spring


def test_a_swing_has_the_frequency_and_the_loss_of_springs_that_are_laid_down_and_left():
    ground, slip = slope_scene(0, LOW, HEAVY_GOING), steady_slip()
    expected, spring = swing(slip, ground.model.gravity)
    start = State(forward_velocity=SPEED * (1.0 - 1.01 * slip))
    simulation, _ = drive(ground, SPEED, SPEED, 8.0, start, tolerance=1e-9, steady_start=True)
    # Faster modes have died away.
    time = np.linspace(5.0, 8.0, 601)
    speed = sample(simulation, 1.0, time).forward_velocity

    def misfit(p):
        return p[0] + np.exp(p[1] * (time - 5.0)) * (p[2] * np.cos(p[3] * time) + p[4] * np.sin(p[3] * time)) - speed

    guess = [SPEED * (1.0 - slip), expected.real, 0.0, expected.imag, 2e-5]
    found = least_squares(misfit, guess, x_scale=[1e-4, 0.1, 1e-5, 0.1, 1e-5], xtol=1e-14, ftol=1e-14).x
    assert found[3] == pytest.approx(expected.imag, rel=1e-3)
    assert found[1] == pytest.approx(expected.real, rel=0.05)
    # To a few per cent the springs of steady driving, and a loss of the order of 1/(2 T).
    assert found[3] == pytest.approx(spring, rel=0.03)


def test_rolling_without_sliding_is_passed_through_in_few_steps():
    """Speeding up on level ground, the swing takes the sliding through zero: its direction must not chatter there.

    With a floor of the sliding speed that does not grow with that of the track it took 7 times the evaluations.
    """
    simulation, _ = drive_along(slope_scene(0), [0.0, 2.0, 4.0], [0.0, 2.0, 2.0], [0.0, 2.0, 2.0], tolerance=1e-5)
    assert simulation.time == 4.0
    assert simulation.run["evaluations"][0] < 16_000
