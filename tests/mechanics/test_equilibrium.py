"""The balance against closed forms, finer quadrature, differences and the oracle."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from model_cases import (
    ADAPTIVE,
    DOCUMENTED,
    REFERENCE,
    SMALL,
    VARIETY,
    Array,
    evaluate,
    model_of,
    no_slip,
    operating_point_of,
    random_points,
)
from oracle import OraclePoint
from oracle import balance as oracle_balance
from oracle import contact as oracle_contact
from oracle import loads as oracle_loads
from scipy.optimize import brentq

from trackctl.mechanics.quadrature import Rule, rules

FINER = rules((96,))
# The split of a track is a third of a millimetre behind the entry: the shear builds up beside it, not at it.
SPLIT_BESIDE_ENTRY = replace(
    DOCUMENTED,
    mass=9918.0,
    gauge=2.298,
    width=0.345,
    length=2.698,
    cog_height=0.4485,
    cog_forward=0.197,
    cog_left=-0.0987,
    friction=0.421,
    shear_modulus=0.02383,
    cohesion=4000.0,
    resistance=0.1117,
    slope=0.5182,
    velocity=1.0,
    curvature=0.0847,
    heading=math.radians(195.0),
)


def states(point: OraclePoint, number: int, seed: int = 5) -> list[Array]:
    """Unknowns about rolling without slip: any, not only equilibria."""
    generator = np.random.default_rng(seed)
    factors = generator.uniform(0.8, 1.3, (number, 2))
    sideslips = generator.uniform(-0.4, 0.4, number)
    return [np.append(no_slip(point)[:2] * f, beta) for f, beta in zip(factors, sideslips.tolist(), strict=True)]


def is_within_model(point: OraclePoint, unknowns: Array) -> bool:
    left, right, centre = oracle_loads(point.symbols, float(unknowns[2]))
    turned = abs(point.curvature) * point.length
    slowest = float(unknowns[:2].min())
    return min(left, right) > 0.0 and abs(centre) < 0.5 * point.length and turned < math.pi * slowest


def sampled_states(number: int, seed: int) -> list[tuple[OraclePoint, Array]]:
    """Random vehicles in random motion near their no-slip speeds, within the model."""
    pairs = [(point, states(point, 1, k)[0]) for k, point in enumerate(random_points(number, seed))]
    return [pair for pair in pairs if is_within_model(*pair)]


def is_resolved(point: OraclePoint, unknowns: Array) -> bool:
    """Whether twice the nodes change nothing: no kink beside the split."""
    fine, finer = (evaluate(point, unknowns, rule)[0] for rule in (REFERENCE, FINER))
    return bool(np.abs(fine - finer).max() < 1e-9)


def solved(point: OraclePoint, start: Array, rule: Rule) -> Array:
    """Root beside a start, by Newton's method; NaN where that does not get there."""
    unknowns = start.copy()
    for _ in range(20):
        residual, jacobian, _ = evaluate(point, unknowns, rule)
        if np.abs(residual).max() < 1e-13:
            return unknowns
        if not np.linalg.cond(jacobian) < 1e10:
            break
        unknowns = unknowns - np.linalg.solve(jacobian, residual)
    return np.full(3, np.nan)


def straight_force(point: OraclePoint, load: float, centre: float, speed: float, beta: float) -> Array:
    """Force and moment of one track on a straight line over the weight: integrals of powers times 1 - exp(-a u).

    Sliding has one direction and j grows linearly from the front: u = (front - x), j/K = a u.
    """
    rear, front = oracle_contact(point.symbols, centre)
    stretch = front - rear
    s_x, s_y = math.cos(beta) - speed, math.sin(beta)
    sliding = math.hypot(s_x, s_y)
    a = sliding / (speed * point.shear_modulus)
    decayed = math.exp(-a * stretch)
    powers = [
        stretch - (1 - decayed) / a,
        stretch**2 / 2 - (1 - (1 + a * stretch) * decayed) / a**2,
        stretch**3 / 3 - (2 - (2 + 2 * a * stretch + (a * stretch) ** 2) * decayed) / a**3,
    ]
    # Pressure as a line in u through its integral and first moment.
    mean, tilt = load / stretch, 12 * load * (centre - (rear + front) / 2) / stretch**3
    at_front, gradient = mean + tilt * stretch / 2, -tilt
    adhesion = point.cohesion * point.width / (point.mass * point.gravity)
    strength = point.friction * at_front + adhesion, point.friction * gradient
    force = strength[0] * powers[0] + strength[1] * powers[1]
    first_moment = front * force - strength[0] * powers[1] - strength[1] * powers[2]
    direction = -np.array([s_x, s_y]) / sliding
    return np.array([force * direction[0], force * direction[1], first_moment * direction[1]])


def straight_residual(point: OraclePoint, unknowns: Array) -> Array:
    """The balance on a straight line in closed form."""
    operating, weight = operating_point_of(point), point.mass * point.gravity
    left, right, centre = oracle_loads(point.symbols, float(unknowns[2]))
    total = np.array([operating.gravity_forward, operating.gravity_left, 0.0])
    for load, speed, y in ((left, unknowns[0], point.gauge / 2), (right, unknowns[1], -point.gauge / 2)):
        load /= weight
        forward, leftward, first_moment = straight_force(point, load, centre, float(speed), float(unknowns[2]))
        forward -= point.resistance * load
        moment = first_moment - point.cog_forward * leftward - (y - point.cog_left) * forward
        total += [forward, leftward, moment / point.length]
    return total


STRAIGHT = replace(DOCUMENTED, curvature=0.0)


@pytest.mark.parametrize("heading_deg", [0.0, 90.0, 180.0, 270.0, 40.0])
@pytest.mark.parametrize(
    "point",
    [
        STRAIGHT,
        replace(STRAIGHT, cohesion=0.0),
        replace(STRAIGHT, slope=0.0),
        replace(STRAIGHT, cog_forward=0.35, cog_height=0.4),
        replace(STRAIGHT, cog_forward=-0.6, cog_height=0.4),
    ],
    ids=["cohesion", "no cohesion", "level", "front loaded", "rear loaded"],
)
def test_straight_line_has_its_closed_form(point: OraclePoint, heading_deg: float) -> None:
    point = replace(point, heading=math.radians(heading_deg))
    for unknowns in states(point, 5):
        expected = straight_residual(point, unknowns)
        # exp(-a u) with a up to 200/m is the hardest; 48 nodes leave rounding.
        np.testing.assert_allclose(evaluate(point, unknowns, REFERENCE)[0], expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("heading", [0.0, math.pi])
def test_straight_up_and_down_the_slope_both_tracks_slip_alike(heading: float) -> None:
    point = replace(SMALL, curvature=0.0, cog_height=0.0, heading=heading)
    demand = math.sin(point.slope) * math.cos(heading) + point.resistance * math.cos(point.slope)

    def excess(speed: float) -> float:
        a = abs(1.0 - speed) * point.length / (speed * point.shear_modulus)
        return point.friction * math.cos(point.slope) * (1.0 - (1.0 - math.exp(-a)) / a) - abs(demand)

    bracket = (1.0001, 2.0) if demand > 0.0 else (0.5, 0.9999)
    speed = brentq(excess, *bracket, xtol=1e-15)
    residual, _, traction = evaluate(point, np.array([speed, speed, 0.0]), REFERENCE)
    # The slope of the force by the speed is about 20, that of brentq's error is below 1e-15.
    assert np.abs(residual).max() < 1e-13
    assert traction == pytest.approx([demand / 2.0] * 2, abs=1e-13)


@pytest.mark.parametrize("heading", [math.pi / 2, -math.pi / 2])
def test_straight_across_the_slope_it_creeps_down(heading: float) -> None:
    point = replace(SMALL, curvature=0.0, heading=heading)
    root = solved(point, np.array([1.01, 1.01, 0.02 * math.sin(heading)]), REFERENCE)
    assert root[2] * math.sin(heading) > 0.0
    traction = evaluate(point, root, REFERENCE)[2]
    assert traction.sum() == pytest.approx(point.resistance * math.cos(point.slope), abs=1e-12)


def test_heading_does_not_matter_on_level_ground() -> None:
    level = replace(DOCUMENTED, slope=0.0)
    for unknowns in states(level, 3):
        expected = evaluate(level, unknowns)[0]
        for heading in (1.0, 3.0, -2.0):
            np.testing.assert_array_equal(evaluate(replace(level, heading=heading), unknowns)[0], expected)


def test_without_cohesion_forces_grow_with_friction() -> None:
    slippery, rough = replace(SMALL, friction=0.4), replace(SMALL, friction=0.8)
    for unknowns in states(SMALL, 3):
        # What is left of the balance without friction: gravity, inertia and rolling resistance.
        without = evaluate(replace(SMALL, friction=1e-300), unknowns)[0]
        shear = evaluate(slippery, unknowns)[0] - without
        np.testing.assert_allclose(evaluate(rough, unknowns)[0] - without, 2.0 * shear, rtol=0, atol=1e-15)


@pytest.mark.parametrize("point", VARIETY.values(), ids=VARIETY.keys())
def test_traction_is_what_balances_slope_inertia_and_resistance(point: OraclePoint) -> None:
    operating = operating_point_of(point)
    for unknowns in states(point, 3):
        residual, _, traction = evaluate(point, unknowns)
        inertia = operating.centripetal * math.sin(unknowns[2])
        rest = operating.gravity_forward + inertia - point.resistance * operating.normal
        assert residual[0] == pytest.approx(rest + traction.sum(), abs=1e-15)


def test_balance_is_the_oracles() -> None:
    pairs = [pair for pair in sampled_states(400, 11) if is_resolved(*pair)]
    # Nearly all: beside the split, a shoe that comes back over its point of entry makes a second kink.
    assert len(pairs) > 350
    for point, unknowns in pairs:
        speeds = unknowns[:2] * point.velocity
        expected = oracle_balance(point, speeds[0], speeds[1], unknowns[2])
        # What 48 and 96 nodes may differ by.
        np.testing.assert_allclose(evaluate(point, unknowns, REFERENCE)[0], expected, rtol=0, atol=1e-9)


def test_adaptive_rule_keeps_to_the_reference_rule() -> None:
    pairs = [pair for pair in sampled_states(1500, 12) if is_resolved(*pair)]
    errors = [
        np.abs(evaluate(point, unknowns)[0] - evaluate(point, unknowns, REFERENCE)[0]).max()
        for point, unknowns in pairs
    ]
    # 1e-7 of the weight is what the rules are chosen for; singularities are known to third order only.
    assert np.quantile(errors, 0.99) < 1e-7
    assert max(errors) < 1e-5


def test_adaptive_rule_sees_a_boundary_layer_beside_the_split() -> None:
    unknowns = np.array([0.345, 0.934, -0.0977])
    # A layer of exponent 200 on eight nodes is off by 1e-3.
    difference = evaluate(SPLIT_BESIDE_ENTRY, unknowns)[0] - evaluate(SPLIT_BESIDE_ENTRY, unknowns, REFERENCE)[0]
    assert np.abs(difference).max() < 1e-6


def test_track_speeds_by_the_adaptive_rule_are_the_reference_rules() -> None:
    compared = 0
    for point in random_points(700, 13):
        start = solved(point, no_slip(point) + np.array([1e-3, 2e-3, 1e-3]), REFERENCE)
        if not (np.isfinite(start).all() and abs(start[2]) < 1.0 and is_within_model(point, start)):
            continue
        compared += 1
        adaptive = solved(point, start, ADAPTIVE)
        # The accuracy of a table.
        np.testing.assert_allclose(adaptive[:2], start[:2], rtol=1e-6, atol=0, err_msg=str(point))
    assert compared > 250


@pytest.mark.parametrize("point", VARIETY.values(), ids=VARIETY.keys())
def test_jacobian_is_the_derivative(point: OraclePoint) -> None:
    step = 1e-6
    for unknowns in states(point, 6):
        jacobian = evaluate(point, unknowns, REFERENCE)[1]
        for k, change in enumerate(step * np.eye(3)):
            ahead = evaluate(point, unknowns + change, REFERENCE)[0]
            behind = evaluate(point, unknowns - change, REFERENCE)[0]
            # Rounding over the step is 1e-10, third derivatives of up to 1e4 leave 1e-9.
            np.testing.assert_allclose(jacobian[:, k], (ahead - behind) / (2 * step), rtol=0, atol=1e-7)


def test_jacobian_is_the_derivative_for_random_vehicles() -> None:
    step = 1e-6
    for point, unknowns in sampled_states(300, 14):
        if not is_resolved(point, unknowns):
            continue
        jacobian = evaluate(point, unknowns, REFERENCE)[1]
        changes = [
            (evaluate(point, unknowns + change, REFERENCE)[0] - evaluate(point, unknowns - change, REFERENCE)[0])
            / (2 * step)
            for change in step * np.eye(3)
        ]
        scale = max(1.0, float(np.abs(jacobian).max()))
        np.testing.assert_allclose(jacobian, np.array(changes).T, rtol=0, atol=1e-6 * scale)


@pytest.mark.parametrize("step", [1e-4, 1e-5])
def test_difference_of_the_residual_converges_to_the_jacobian_quadratically(step: float) -> None:
    unknowns, direction = np.array([0.85, 1.3, -0.1]), np.array([0.3, -0.2, 0.4])
    slope = evaluate(DOCUMENTED, unknowns, REFERENCE)[1] @ direction

    def error(h: float) -> float:
        ahead = evaluate(DOCUMENTED, unknowns + h * direction, REFERENCE)[0]
        behind = evaluate(DOCUMENTED, unknowns - h * direction, REFERENCE)[0]
        return float(np.abs((ahead - behind) / (2 * h) - slope).max())

    order = math.log10(error(10 * step) / error(step))
    assert order == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("point", VARIETY.values(), ids=VARIETY.keys())
def test_mirrored_vehicle_has_a_mirrored_balance(point: OraclePoint) -> None:
    mirrored = replace(point, curvature=-point.curvature, heading=-point.heading, cog_left=-point.cog_left)
    for unknowns in states(point, 4):
        residual, jacobian, traction = evaluate(point, unknowns)
        swapped = unknowns[[1, 0, 2]] * [1.0, 1.0, -1.0]
        other, other_jacobian, other_traction = evaluate(mirrored, swapped)
        # Rounding alone separates them.
        np.testing.assert_allclose(other, residual * [1, -1, -1], rtol=0, atol=1e-12)
        np.testing.assert_allclose(other_traction, traction[::-1], rtol=0, atol=1e-12)
        turned = jacobian[:, [1, 0, 2]] * np.outer([1, -1, -1], [1, 1, -1])
        np.testing.assert_allclose(other_jacobian, turned, rtol=0, atol=1e-10)


def test_model_is_made_of_what_the_balance_needs() -> None:
    # Mass and track width enter through the adhesion only, gravity through that and the centripetal acceleration.
    heavy = replace(SMALL, mass=10 * SMALL.mass, width=2 * SMALL.width)
    assert model_of(heavy) == model_of(SMALL)
    for unknowns in states(SMALL, 2):
        np.testing.assert_array_equal(evaluate(heavy, unknowns)[0], evaluate(SMALL, unknowns)[0])
