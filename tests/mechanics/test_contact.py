"""Loads and pressure against statics: what carries the weight, where it rests, how it changes with the sideslip."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from model_cases import DOCUMENTED, SMALL, model_of, operating_point_of
from oracle import OraclePoint
from oracle import loads as oracle_loads

from trackctl.mechanics.contact import Contact, Loads, contact, loads

LENGTH, LOAD = DOCUMENTED.length, 0.4
# Contact centres of every kind: full, at the edge of the core, partial either way, almost on edge.
CENTRES = [0.0, 0.2, -0.3, LENGTH / 6, -LENGTH / 6, 0.45, -0.7, 1.1, -1.17]
STEP = 1e-6


def loads_of(point: OraclePoint, sideslip: float = 0.0) -> Loads:
    return loads(model_of(point), operating_point_of(point), sideslip)


def contact_at(centre: float, load: float = LOAD, load_slope: float = 0.0, centre_slope: float = 0.0) -> Contact:
    return contact(model_of(DOCUMENTED), load, load_slope, centre, centre_slope)


def pressure_integrals(ground: Contact) -> tuple[float, float]:
    """Integrals over the contact of the frictional strength and of its moment."""
    adhesion = model_of(DOCUMENTED).adhesion
    x, weights = np.polynomial.legendre.leggauss(2)  # Exact for a linear pressure and its moment.
    half = 0.5 * (ground.front - ground.rear)
    x = ground.rear + half * (x + 1.0)
    strength = ground.strength + ground.strength_gradient * x - adhesion
    return float(half * weights @ strength), float(half * weights @ (x * strength))


def test_level_ground_loads_both_tracks_alike() -> None:
    weighing = loads_of(replace(SMALL, slope=0.0, curvature=0.0))
    assert weighing == Loads(0.5, 0.5, 0.0, 0.0, 0.0)


def test_mass_off_the_centre_loads_the_nearer_track() -> None:
    weighing = loads_of(replace(SMALL, slope=0.0, curvature=0.0, cog_left=0.1, cog_forward=-0.05))
    assert weighing.left == pytest.approx(0.5 + 0.1 / 0.61, rel=1e-15)
    assert weighing.pressure_centre == -0.05


def test_outer_and_lower_track_carry_more() -> None:
    turning = loads_of(replace(SMALL, slope=0.0, velocity=1.0))
    assert turning.right > turning.left
    across = loads_of(replace(SMALL, curvature=0.0, heading=math.pi / 2))
    assert across.left > across.right  # Up-slope is to the right of the vehicle.
    uphill = loads_of(replace(SMALL, curvature=0.0, heading=0.0))
    assert uphill.pressure_centre == pytest.approx(-0.25 * math.tan(SMALL.slope), rel=1e-14)


@given(slope=st.floats(0, 0.7), heading=st.floats(-4, 4), velocity=st.floats(0, 6), sideslip=st.floats(-1, 1))
def test_loads_carry_the_weight_and_balance_its_moments(
    slope: float, heading: float, velocity: float, sideslip: float
) -> None:
    point = replace(DOCUMENTED, slope=slope, heading=heading, velocity=velocity)
    weighing, operating = loads_of(point, sideslip), operating_point_of(point)
    inertia_forward = operating.gravity_forward + operating.centripetal * math.sin(sideslip)
    inertia_left = operating.gravity_left - operating.centripetal * math.cos(sideslip)
    roll = 0.5 * point.gauge * (weighing.left - weighing.right) - point.cog_left * operating.normal
    pitch = (weighing.pressure_centre - point.cog_forward) * operating.normal
    assert weighing.left + weighing.right == pytest.approx(operating.normal, rel=1e-14)
    assert roll == pytest.approx(point.cog_height * inertia_left, abs=1e-13)
    assert pitch == pytest.approx(point.cog_height * inertia_forward, abs=1e-13)


@pytest.mark.parametrize("sideslip", [-0.9, 0.0, 0.4])
def test_loads_are_the_oracles(sideslip: float) -> None:
    left, right, centre = oracle_loads(DOCUMENTED.symbols, sideslip)
    weight = DOCUMENTED.mass * DOCUMENTED.gravity
    weighing = loads_of(DOCUMENTED, sideslip)
    found = weighing.left * weight, weighing.right * weight, weighing.pressure_centre
    assert found == pytest.approx((left, right, centre), rel=1e-13)


@pytest.mark.parametrize("sideslip", [-0.8, 0.0, 0.3])
def test_derivatives_of_the_loads(sideslip: float) -> None:
    ahead, behind = loads_of(DOCUMENTED, sideslip + STEP), loads_of(DOCUMENTED, sideslip - STEP)
    weighing = loads_of(DOCUMENTED, sideslip)
    # Central differences of a sine: truncation and rounding are both near 1e-10.
    assert weighing.left_slope == pytest.approx((ahead.left - behind.left) / (2 * STEP), abs=1e-9)
    centre_slope = (ahead.pressure_centre - behind.pressure_centre) / (2 * STEP)
    assert weighing.pressure_centre_slope == pytest.approx(centre_slope, abs=1e-9)


@pytest.mark.parametrize("centre", CENTRES)
def test_pressure_adds_up_to_the_load_at_its_centre(centre: float) -> None:
    ground = contact_at(centre)
    total, moment = pressure_integrals(ground)
    assert total == pytest.approx(DOCUMENTED.friction * LOAD, rel=1e-12)
    assert moment == pytest.approx(DOCUMENTED.friction * LOAD * centre, abs=1e-12)


@pytest.mark.parametrize("centre", CENTRES)
def test_pressure_is_nowhere_negative(centre: float) -> None:
    ground, adhesion = contact_at(centre), model_of(DOCUMENTED).adhesion
    for x in (ground.rear, ground.front):
        # A triangle's tip is a difference of numbers of order 10.
        assert ground.strength + ground.strength_gradient * x - adhesion >= -1e-13


@pytest.mark.parametrize("centre", [0.0, 0.2, -0.3])
def test_contact_is_full_while_the_load_is_in_the_middle_third(centre: float) -> None:
    ground = contact_at(centre)
    assert (ground.rear, ground.front) == (-LENGTH / 2, LENGTH / 2)


@pytest.mark.parametrize("centre", [0.45, -0.7, 1.1])
def test_beyond_it_a_triangle_rests_on_the_loaded_end(centre: float) -> None:
    ground = contact_at(centre)
    assert ground.front - ground.rear == pytest.approx(3 * (LENGTH / 2 - abs(centre)), rel=1e-13)
    loaded, tip = (ground.front, ground.rear) if centre > 0 else (ground.rear, ground.front)
    assert loaded == math.copysign(LENGTH / 2, centre)
    at_tip = ground.strength + ground.strength_gradient * tip
    assert at_tip == pytest.approx(model_of(DOCUMENTED).adhesion, abs=1e-13)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_both_shapes_meet_where_the_contact_becomes_partial(side: float) -> None:
    edge, change = LENGTH / 6, 1e-9
    inside, outside = contact_at(side * (edge - change)), contact_at(side * (edge + change))
    for name in ("rear", "front", "strength", "strength_gradient"):
        # The values change at rates of order 1.
        assert getattr(inside, name) == pytest.approx(getattr(outside, name), abs=1e-7)


@pytest.mark.parametrize("centre", [0.0, 0.2, -0.3, 0.45, -0.7, 1.1])
def test_derivatives_of_the_contact(centre: float) -> None:
    load_slope, centre_slope = 0.3, -0.2

    def beside(change: float) -> Contact:
        return contact_at(centre + change * centre_slope, LOAD + change * load_slope)

    ground = contact_at(centre, LOAD, load_slope, centre_slope)
    ahead, behind = beside(STEP), beside(-STEP)
    for name in ("rear", "front", "strength", "strength_gradient"):
        difference = (getattr(ahead, name) - getattr(behind, name)) / (2 * STEP)
        # Rounding of values of order 10 over the step.
        assert getattr(ground, f"{name}_slope") == pytest.approx(difference, abs=1e-7, rel=1e-7)


@pytest.mark.parametrize("centre", [LENGTH / 2, -LENGTH / 2, 3.0, -3.0])
def test_a_vehicle_that_has_pitched_over_keeps_finite_numbers(centre: float) -> None:
    ground = contact_at(centre, LOAD, 0.1, 0.1)
    assert np.isfinite(ground).all()
    assert ground.front > ground.rear
