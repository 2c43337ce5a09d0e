"""The model's constants, and the operating point in the body's axes."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from model_cases import DOCUMENTED, model_of, operating_point_of

angles = st.floats(-10.0, 10.0)


def test_model_holds_the_profiles_values() -> None:
    model = model_of(DOCUMENTED)
    assert (model.gauge, model.length, model.cog_height) == (1.72, 2.35, 0.72)
    assert (model.cog_forward, model.cog_left) == (0.11, -0.06)
    assert (model.friction, model.resistance, model.shear_modulus) == (0.52, 0.09, 0.018)
    assert model.gravity == 9.80665


def test_adhesion_is_the_cohesive_strength_of_a_metre_of_track_over_the_weight() -> None:
    assert model_of(DOCUMENTED).adhesion == pytest.approx(1600 * 0.34 / (3400 * 9.80665), rel=1e-15)
    assert model_of(replace(DOCUMENTED, cohesion=0)).adhesion == 0.0


def test_lunar_gravity_makes_adhesion_stronger_by_its_ratio() -> None:
    moon = replace(DOCUMENTED, gravity=1.62)
    assert model_of(moon).gravity == 1.62
    ratio = model_of(moon).adhesion / model_of(DOCUMENTED).adhesion
    assert ratio == pytest.approx(9.80665 / 1.62, rel=1e-15)


@pytest.mark.parametrize(
    ("heading_deg", "forward", "left"),
    [(0.0, -1.0, 0.0), (90.0, 0.0, 1.0), (180.0, 1.0, 0.0), (270.0, 0.0, -1.0)],
    ids=["up-slope", "to the left of it", "down-slope", "to the right"],
)
def test_gravity_pulls_down_the_slope(heading_deg: float, forward: float, left: float) -> None:
    point = operating_point_of(replace(DOCUMENTED, heading=math.radians(heading_deg)))
    steepness = math.sin(DOCUMENTED.slope)
    assert point.gravity_forward == pytest.approx(forward * steepness, abs=1e-16)
    assert point.gravity_left == pytest.approx(left * steepness, abs=1e-16)
    assert point.normal == pytest.approx(math.cos(DOCUMENTED.slope), rel=1e-15)


@given(slope=st.floats(0.0, 0.78), heading=angles, turned=angles)
def test_gravity_is_one_vector_in_whatever_axes(slope: float, heading: float, turned: float) -> None:
    # Body axes turned by an angle see gravity turned back by it: only the heading relative to the slope matters.
    before = operating_point_of(replace(DOCUMENTED, slope=slope, heading=heading))
    after = operating_point_of(replace(DOCUMENTED, slope=slope, heading=heading + turned))
    rotated = complex(before.gravity_forward, before.gravity_left) * complex(math.cos(turned), -math.sin(turned))
    assert after.gravity_forward == pytest.approx(rotated.real, abs=1e-14)
    assert after.gravity_left == pytest.approx(rotated.imag, abs=1e-14)
    assert math.hypot(abs(rotated), after.normal) == pytest.approx(1.0, rel=1e-14)


@given(heading=angles)
def test_a_full_turn_changes_nothing(heading: float) -> None:
    before = operating_point_of(replace(DOCUMENTED, heading=heading))
    after = operating_point_of(replace(DOCUMENTED, heading=heading + 2 * math.pi))
    assert after == pytest.approx(before, abs=1e-14)


def test_centripetal_acceleration_points_into_the_turn() -> None:
    left = operating_point_of(replace(DOCUMENTED, velocity=3.0, curvature=0.2))
    right = operating_point_of(replace(DOCUMENTED, velocity=3.0, curvature=-0.2))
    assert left.centripetal == pytest.approx(9.0 * 0.2 / 9.80665, rel=1e-15)
    assert right.centripetal == -left.centripetal
    assert operating_point_of(replace(DOCUMENTED, curvature=0.0)).centripetal == 0.0
