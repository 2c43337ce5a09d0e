"""Answers under changes that the physics does not notice: mirror images, other units, full turns, a vanishing turn."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from model_cases import VARIETY, model_of, random_points, row_of
from oracle import OraclePoint

from trackctl.lut.point import solve_points
from trackctl.lut.table import Status

POINTS = [*VARIETY.values(), *random_points(60, 51)]
LENGTHS = ("gauge", "width", "length", "cog_height", "cog_forward", "cog_left", "shear_modulus")
# Both solve the same equations, to a residual of 1e-10 each.
SAME_ANSWER = 1e-8


def solve(point: OraclePoint) -> Any:
    return solve_points(model_of(point), np.array([row_of(point)]))[0]


def assert_same_answer(point: OraclePoint, changed: OraclePoint) -> None:
    """Speeds over the vehicle's speed, sideslip, traction over weight and status are those of the other point."""
    cell, other = solve(point), solve(changed)
    assert cell["status"] == other["status"], point
    np.testing.assert_allclose(other["unknowns"], cell["unknowns"], rtol=0, atol=SAME_ANSWER)
    np.testing.assert_allclose(other["traction"], cell["traction"], rtol=0, atol=SAME_ANSWER)


def test_right_turns_of_a_mirrored_vehicle_mirror_left_turns() -> None:
    for point in POINTS:
        mirrored = replace(point, curvature=-point.curvature, heading=-point.heading, cog_left=-point.cog_left)
        cell, other = solve(point), solve(mirrored)
        assert cell["status"] == other["status"], point
        swapped = other["unknowns"][[1, 0, 2]] * [1.0, 1.0, -1.0]
        np.testing.assert_allclose(swapped, cell["unknowns"], rtol=0, atol=SAME_ANSWER)
        np.testing.assert_allclose(other["traction"][::-1], cell["traction"], rtol=0, atol=SAME_ANSWER)


def test_off_centre_mass_breaks_the_mirror() -> None:
    point = VARIETY["offset mass, cohesion"]
    same_vehicle = replace(point, curvature=-point.curvature, heading=-point.heading)
    swapped = solve(same_vehicle)["unknowns"][[1, 0, 2]] * [1.0, 1.0, -1.0]
    assert np.abs(swapped - solve(point)["unknowns"]).max() > 1e-3


@pytest.mark.parametrize("scale", [0.2, 2.0])
def test_a_larger_vehicle_does_the_same_at_the_speed_that_froude_gives(scale: float) -> None:
    for point in POINTS:
        # Lengths by the scale, masses by its cube, stresses by itself, speeds by its root.
        larger = replace(
            point,
            mass=scale**3 * point.mass,
            cohesion=scale * point.cohesion,
            velocity=math.sqrt(scale) * point.velocity,
            curvature=point.curvature / scale,
            **{name: scale * getattr(point, name) for name in LENGTHS},
        )
        assert_same_answer(point, larger)


@pytest.mark.parametrize("ratio", [1.62 / 9.80665, 2.5])
def test_weaker_gravity_is_slower_motion(ratio: float) -> None:
    for point in POINTS[:40]:
        elsewhere = replace(
            point,
            gravity=ratio * point.gravity,
            cohesion=ratio * point.cohesion,
            velocity=math.sqrt(ratio) * point.velocity,
        )
        assert_same_answer(point, elsewhere)


def test_mass_and_track_width_matter_through_cohesion_only() -> None:
    for point in POINTS[:40]:
        assert_same_answer(point, replace(point, mass=2.0 * point.mass, cohesion=2.0 * point.cohesion))
        assert_same_answer(point, replace(point, width=0.5 * point.width, cohesion=2.0 * point.cohesion))


@pytest.mark.parametrize("turns", [-1, 1, 3])
def test_full_turns_of_the_heading_change_nothing(turns: int) -> None:
    for point in POINTS[:40]:
        assert_same_answer(point, replace(point, heading=point.heading + 2.0 * math.pi * turns))


@pytest.mark.parametrize("curvature", [1e-9, -1e-9, 1e-13])
def test_a_vanishing_turn_is_a_straight_line(curvature: float) -> None:
    for point in [replace(point, curvature=0.0, velocity=1.0) for point in POINTS[:40]]:
        cell, other = solve(point), solve(replace(point, curvature=curvature))
        assert cell["status"] == other["status"], point
        if cell["status"] == Status.CONVERGED:
            # The sideslip changes over curvatures of 4 K / L^2, 1e-3 or more.
            np.testing.assert_allclose(other["unknowns"], cell["unknowns"], rtol=0, atol=1e-5)
