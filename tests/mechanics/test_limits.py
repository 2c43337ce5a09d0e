"""What is proven infeasible has no equilibrium, by brute force and by the oracle; limits lie where statics has them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from model_cases import (
    DOCUMENTED,
    REFERENCE,
    SMALL,
    Array,
    evaluate,
    model_of,
    operating_point_of,
    random_points,
)
from oracle import OraclePoint, roots
from scipy.optimize import brentq

from trackctl.lut.table import Status
from trackctl.mechanics.limits import (
    ADMISSIBLE,
    FASTEST_TRACK,
    GRIP,
    LARGEST_SIDESLIP,
    LIFTOFF,
    OUTSIDE_MODEL,
    PITCHOVER,
    SLOWEST_TRACK,
    exceeded_limit,
    outside_box,
    proven_infeasible,
    surely_admissible,
)

SIDESLIPS = np.linspace(-LARGEST_SIDESLIP, LARGEST_SIDESLIP, 2001)
TALL = replace(SMALL, cog_height=0.9)


def proven(point: OraclePoint) -> int:
    return proven_infeasible(model_of(point), operating_point_of(point))


def exceeded(point: OraclePoint, left: float, right: float, sideslip: float) -> int:
    unknowns = np.array([left, right, sideslip])
    return exceeded_limit(model_of(point), operating_point_of(point), unknowns)


def demands(point: OraclePoint) -> tuple[Array, Array]:
    """g - a at every sideslip, over g."""
    steepness, inertia = math.sin(point.slope), point.velocity**2 * point.curvature / point.gravity
    forward = -steepness * math.cos(point.heading) + inertia * np.sin(SIDESLIPS)
    return forward, steepness * math.sin(point.heading) - inertia * np.cos(SIDESLIPS)


def missing_grip(point: OraclePoint) -> float:
    """Least demand over the sideslips less the most that the ground gives, over the weight."""
    area, weight = 2.0 * point.length * point.width, point.mass * point.gravity
    supply = (point.friction + point.resistance) * math.cos(point.slope) + point.cohesion * area / weight
    return float(np.hypot(*demands(point)).min()) - supply


def lifts(point: OraclePoint) -> bool:
    """Whether one track lifts at every sideslip."""
    _, leftward = demands(point)
    half, normal = 0.5 * point.gauge, math.cos(point.slope)
    centre = point.cog_left + point.cog_height * leftward / normal
    return bool((centre >= half).all() or (centre <= -half).all())


def pitches_over(point: OraclePoint) -> bool:
    """Whether the weight rests beyond one end at every sideslip."""
    forward, _ = demands(point)
    half, normal = 0.5 * point.length, math.cos(point.slope)
    centre = point.cog_forward + point.cog_height * forward / normal
    return bool((centre >= half).all() or (centre <= -half).all())


def steep_points() -> list[OraclePoint]:
    """Fast, steep and tall: a good part of them beyond one limit or another."""
    return [
        replace(point, velocity=1.5 * point.velocity, slope=point.slope + 0.15, cog_height=1.5 * point.cog_height)
        for point in random_points(400, 21)
    ]


def test_codes_are_those_of_the_table() -> None:
    assert ADMISSIBLE == Status.CONVERGED
    assert GRIP == Status.INFEASIBLE_GRIP
    assert LIFTOFF == Status.INFEASIBLE_LIFTOFF
    assert PITCHOVER == Status.INFEASIBLE_PITCHOVER
    assert OUTSIDE_MODEL == Status.OUTSIDE_MODEL


def test_bounds_are_those_found_by_trying_every_sideslip() -> None:
    count = dict.fromkeys((ADMISSIBLE, GRIP, LIFTOFF, PITCHOVER), 0)
    for point in steep_points():
        missing = missing_grip(point)
        if abs(missing) < 1e-5:
            continue  # What a step of 1e-3 rad between the sideslips may hide.
        expected = (
            GRIP if missing > 0.0 else LIFTOFF if lifts(point) else PITCHOVER if pitches_over(point) else ADMISSIBLE
        )
        assert proven(point) == expected, point
        count[expected] += 1
    assert min(count.values()) > 0


def test_where_the_triangle_inequality_holds_nothing_is_proven() -> None:
    sure = 0
    for point in random_points(400, 23):
        if surely_admissible(model_of(point), point.slope, operating_point_of(point).centripetal):
            sure += 1
            for heading in np.linspace(0.0, 2 * math.pi, 12).tolist():
                assert proven(replace(point, heading=heading)) == ADMISSIBLE
    assert sure > 50


def test_points_just_beyond_the_grip_bound_have_no_equilibrium() -> None:
    near = [point for point in steep_points() if 0.0 < missing_grip(point) < 0.1][:20]
    for point in near:
        assert proven(point) == GRIP
        assert roots(point, 32) == []


def test_points_with_an_equilibrium_are_never_excluded() -> None:
    near = [point for point in random_points(700, 22) if -0.1 < missing_grip(point) < 0.0][:25]
    solvable = [point for point in near if roots(point, 32)]
    assert len(solvable) > 3
    assert all(proven(point) == ADMISSIBLE for point in solvable)


@pytest.mark.parametrize("cohesion", [0.0, 2000.0])
@pytest.mark.parametrize("speed", [0.5, 0.1, 0.011])
def test_braking_straight_downhill_has_an_equilibrium_up_to_the_bound(speed: float, cohesion: float) -> None:
    # Uniform pressure: the share of the strength that tracks at a speed ratio mobilise is 1 - (1 - exp(-a)) / a.
    point = replace(SMALL, curvature=0.0, heading=math.pi, cog_height=0.0, cohesion=cohesion)
    a = (1.0 - speed) * point.length / (speed * point.shear_modulus)
    share = 1.0 - (1.0 - math.exp(-a)) / a
    sticking = share * cohesion * 2.0 * point.length * point.width / (point.mass * point.gravity)

    def excess(slope: float) -> float:
        return math.sin(slope) - (share * point.friction + point.resistance) * math.cos(slope) - sticking

    steepest = replace(point, slope=brentq(excess, 0.0, 1.5, xtol=1e-15))
    residual = evaluate(steepest, np.array([speed, speed, 0.0]), REFERENCE)[0]
    # 48 nodes in a boundary layer of exponent 7900, where the track all but stands.
    assert np.abs(residual).max() < 2e-4
    assert proven(steepest) == ADMISSIBLE
    # The bound lies beyond it by the share that is not mobilised.
    assert -missing_grip(steepest) == pytest.approx(
        (1.0 - share) * (point.friction * math.cos(steepest.slope) + sticking / share), rel=1e-6
    )


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_side_slope_lifts_the_upper_track_where_its_load_vanishes(side: float) -> None:
    # On a straight line across the slope: h tan(theta) = B/2.
    across = replace(TALL, curvature=0.0, friction=2.0, heading=side * math.pi / 2)
    tipping = math.atan(across.gauge / (2.0 * across.cog_height))
    assert proven(replace(across, slope=tipping - 1e-9)) == ADMISSIBLE
    assert proven(replace(across, slope=tipping + 1e-9)) == LIFTOFF
    assert exceeded(replace(across, slope=tipping - 1e-9), 1.0, 1.0, 0.0) == ADMISSIBLE
    assert exceeded(replace(across, slope=tipping + 1e-9), 1.0, 1.0, 0.0) == LIFTOFF


@pytest.mark.parametrize("heading", [0.0, math.pi])
def test_uphill_slope_pitches_it_over_where_the_load_reaches_the_end(heading: float) -> None:
    # h tan(theta) = L/2.
    uphill = replace(TALL, curvature=0.0, friction=2.0, heading=heading)
    tipping = math.atan(uphill.length / (2.0 * uphill.cog_height))
    assert proven(replace(uphill, slope=tipping - 1e-9)) == ADMISSIBLE
    assert proven(replace(uphill, slope=tipping + 1e-9)) == PITCHOVER
    assert exceeded(replace(uphill, slope=tipping + 1e-9), 1.0, 1.0, 0.0) == PITCHOVER


def test_half_a_turn_on_the_ground_ends_the_model() -> None:
    slowest = SMALL.curvature * SMALL.length / math.pi
    for left, right in ((1.0, slowest), (slowest, 1.0)):
        assert exceeded(SMALL, left, right, 0.0) == OUTSIDE_MODEL
        assert exceeded(SMALL, max(left, 1.001 * slowest), max(right, 1.001 * slowest), 0.0) == ADMISSIBLE
    assert exceeded(replace(SMALL, curvature=-SMALL.curvature), 1.0, slowest, 0.0) == OUTSIDE_MODEL
    assert exceeded(replace(SMALL, curvature=0.0), SLOWEST_TRACK, 1.0, 0.0) == ADMISSIBLE


@pytest.mark.parametrize(
    ("unknowns", "outside"),
    [
        ([1.0, 1.0, 0.0], False),
        ([1.01 * SLOWEST_TRACK, 0.99 * FASTEST_TRACK, 0.99 * LARGEST_SIDESLIP], False),
        ([0.99 * SLOWEST_TRACK, 1.0, 0.0], True),
        ([1.0, 1.01 * FASTEST_TRACK, 0.0], True),
        ([1.0, 1.0, -1.01 * LARGEST_SIDESLIP], True),
    ],
)
def test_box(unknowns: Array, outside: bool) -> None:
    assert outside_box(np.array(unknowns)) == outside


def test_mirrored_points_have_the_same_limits() -> None:
    for point in steep_points():
        mirrored = replace(point, curvature=-point.curvature, heading=-point.heading, cog_left=-point.cog_left)
        assert proven(mirrored) == proven(point)


def test_documented_vehicle_is_within_all_limits() -> None:
    assert proven(DOCUMENTED) == ADMISSIBLE
