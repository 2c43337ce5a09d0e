import math

import numpy as np
import pytest
from scipy.integrate import trapezoid

from trackctl.planning.blending import JUMP, Adjustment, Line, blended_route, jumping_route, stretches_of
from trackctl.planning.pose import advanced
from trackctl.planning.route import Route

BLEND, RADIUS = 0.85, 1.5
SHARPEST = 1.0 / (0.92 * RADIUS)
START = (1.0, 2.0, 0.3)
ROUTES = {
    "arc": ([1 / RADIUS], [3.0]),
    "straight": ([0.0], [4.0]),
    "left, straight, right": ([1 / RADIUS, 0.0, -1 / RADIUS], [2.0, 5.0, 2.5]),
    "short pieces": ([1 / RADIUS, -1 / RADIUS, 0.0, 0.3], [0.3, 0.2, 0.1, 1.0]),
    "there and back": ([1 / RADIUS, -1 / RADIUS, 0.0], [1.5, -2.0, 1.0]),
}


def ended(start, curvature, length):
    for piece in zip(curvature, length, strict=True):
        start = advanced(*start, *piece)
    return start


def ahead(pose, way):
    return pose[0] + way * math.cos(pose[2]), pose[1] + way * math.sin(pose[2]), pose[2]


def blended(name, **more):
    """A route, and its lines from half a blend before it to half a blend behind."""
    curvature, length = (np.array(values) for values in ROUTES[name])
    goal = ended(START, curvature, length)
    ends = (
        ahead(START, -math.copysign(0.5 * BLEND, length[0])),
        ahead(goal, math.copysign(0.5 * BLEND, length[-1])),
    )
    route = Route(START, curvature, length, np.zeros_like(length))
    return route, ends, blended_route(route, *ends, BLEND, SHARPEST, **more)


@pytest.mark.parametrize("name", ROUTES)
def test_start_and_goal_are_met_exactly(name):
    _, (start, goal), found = blended(name)
    assert found.lines[0].start[:2] == start[:2]
    gap = found.goal - goal
    assert np.abs(gap[:2]).max() <= 1e-10
    assert math.remainder(gap[2], 2 * math.pi) == pytest.approx(0.0, abs=1e-10)


@pytest.mark.parametrize("name", ROUTES)
def test_the_end_changes_with_lengths_and_curvatures_as_told(name):
    route, (start, goal), at_first = blended(name)
    stretches, turns = stretches_of(route)
    turns[[0, -1]] = 0.3, -0.4
    kinks = (len(at_first.lines) - 1) * [0.2]
    adjustment = Adjustment(stretches, turns, kinks, start, goal, BLEND, SHARPEST)
    found = adjustment.slopes(adjustment.first, adjustment.blended(adjustment.first))
    for k, column in enumerate(found.T):
        beside = np.zeros_like(adjustment.first)
        beside[k] = 1e-5
        lower, upper = (adjustment.blended(adjustment.first + sign * beside).goal for sign in (-1, 1))
        np.testing.assert_allclose(column, (upper - lower) / 2e-5, atol=1e-8)


@pytest.mark.parametrize("name", ROUTES)
def test_curvature_has_no_jumps_and_ends_straight(name):
    _, _, found = blended(name)
    for line in found.lines:
        assert line.curvature[0] == 0.0
        assert line.curvature[-1] == pytest.approx(0.0, abs=1e-12)
        assert np.abs(line.curvature).max() <= SHARPEST + 1e-12
        # The steepest ramp is from one sharpest curvature to the other within a blend.
        steps = np.diff(line.knots)
        slopes = np.diff(line.curvature)[steps > 1e-9] / steps[steps > 1e-9]
        assert np.abs(slopes).max() <= 2.0 * SHARPEST / BLEND * (1.0 + 1e-6)


def test_turns_keep_their_angles():
    """A moving mean leaves the integral as it is; the adjustment changes little."""
    route, _, found = blended("left, straight, right")
    (line,) = found.lines
    turned = trapezoid(line.curvature, line.knots)
    assert turned == pytest.approx(float((route.curvature * route.length).sum()), abs=1e-10)
    assert line.length == pytest.approx(float(route.length.sum()) + BLEND, rel=0.02)


def test_a_blend_stays_beside_the_route():
    """Inside an arc by curvature blend^2 / 24, the second moment of the window."""
    _, _, found = blended("arc")
    (line,) = found.lines
    middle = line.at(np.array([0.5 * line.length]))
    curvature, length = ROUTES["arc"]
    on_arc = advanced(*START, curvature[0], 0.5 * length[0])
    away = math.hypot(middle[0][0] - on_arc[0], middle[1][0] - on_arc[1])
    assert away <= 4.0 * curvature[0] * BLEND**2 / 24.0


def test_lines_follow_each_other_when_the_gear_changes():
    _, _, found = blended("there and back")
    there, back, _ = found.lines
    assert (there.backwards, back.backwards) == (False, True)
    assert back.start[:2] == pytest.approx(there.end[:2], abs=1e-12)
    assert math.remainder(back.start[2] - there.end[2] - math.pi, 2 * math.pi) == pytest.approx(0.0, abs=1e-12)


def test_a_kink_turns_the_tangent_where_the_gear_changes():
    _, _, found = blended("there and back", kinks=[0.05, -0.02])
    lines = found.lines
    turned = lines[1].start[2] - lines[0].end[2] - math.pi
    assert math.remainder(turned, 2 * math.pi) == pytest.approx(0.05, abs=1e-12)


def test_a_goal_out_of_reach_has_no_lines():
    route = Route(START, np.array([0.0]), np.array([2.0]), np.zeros(1))
    assert blended_route(route, START, ahead(START, -3.0), BLEND, SHARPEST) is None


def test_pieces_of_one_curvature_become_one():
    route = Route(START, np.array([0.5, 0.5, 0.0, 0.2]), np.array([1.0, 2.0, 0.0, -1.0]), np.zeros(4))
    (forward, backward), turns = stretches_of(route)
    assert turns.tolist() == [0.0, 0.0, 0.0]
    assert forward.length.tolist() == [3.0]
    assert (backward.backwards, backward.curvature.tolist(), backward.length.tolist()) == (True, [-0.2], [1.0])


def test_turns_on_the_spot_cut_a_route_and_give_way_for_the_goal():
    """A straight between two turns, and a goal somewhat beside: the turns take up what is missing."""
    route = Route(START, np.zeros(3), np.array([0.0, 4.0, 0.0]), np.array([1.2, 0.0, -0.7]))
    x, y, _ = advanced(START[0], START[1], START[2] + 1.2, 0.0, 4.0)
    goal = (x + 0.1, y - 0.2, START[2] + 0.5)
    found = blended_route(route, START, goal, BLEND, SHARPEST)
    (line,) = found.lines
    assert found.goal == pytest.approx(goal, abs=1e-10)
    assert line.start == pytest.approx((*START[:2], START[2] + found.turns[0]), abs=1e-12)
    # No curve comes near the least change: the straight turns as a whole.
    assert found.turns == pytest.approx([1.2, -0.7], abs=0.1)
    assert line.length == pytest.approx(math.dist(START[:2], goal[:2]), abs=0.01)


def test_a_turn_between_two_lines_turns_the_tangent():
    curvature, length, pivot = np.array([0.0, 0.0, 0.5]), np.array([2.0, 0.0, 2.0]), np.array([0.0, -1.0, 0.0])
    route = Route(START, curvature, length, pivot)
    (first, second), turns = stretches_of(route)
    assert turns.tolist() == [0.0, -1.0, 0.0]
    assert (first.length.tolist(), second.length.tolist()) == ([2.0], [2.0])
    x, y, tangent = ended(START, curvature[:1], length[:1])
    end = advanced(x, y, tangent - 1.0, 0.5, 2.0)
    found = blended_route(route, START, ahead(end, BLEND), BLEND, SHARPEST)
    before, after = found.lines
    assert after.start[:2] == pytest.approx(before.end[:2], abs=1e-12)
    assert after.start[2] - before.end[2] == pytest.approx(found.turns[1], abs=1e-12)
    assert found.turns[1] == pytest.approx(-1.0, abs=0.2)


def test_a_turn_alone_has_no_lines():
    route = Route(START, np.zeros(1), np.zeros(1), np.array([2.0]))
    found = blended_route(route, START, (*START[:2], START[2] + 2.0), BLEND, SHARPEST)
    assert (found.lines, found.turns.tolist()) == ((), [2.0])
    assert blended_route(route, START, ahead(START, 1.0), BLEND, SHARPEST) is None


def test_a_line_of_constant_curvature_is_a_circle():
    line = Line(False, (1.0, -2.0, 0.4), np.array([0.0, 3.0, 9.0]), np.full(3, 0.7))
    s = np.linspace(0.0, 9.0, 7)
    x, y, direction = line.at(s)
    assert direction == pytest.approx(0.4 + 0.7 * s, abs=1e-13)
    assert x == pytest.approx(1.0 + (np.sin(0.4 + 0.7 * s) - math.sin(0.4)) / 0.7, abs=1e-12)
    assert y == pytest.approx(-2.0 - (np.cos(0.4 + 0.7 * s) - math.cos(0.4)) / 0.7, abs=1e-12)


def test_a_clothoid_is_that_of_fresnel():
    from scipy.special import fresnel

    # kappa = pi s: tangent pi s^2 / 2, the argument of the Fresnel integrals.
    line = Line(False, (0.0, 0.0, 0.0), np.array([0.0, 1.5]), np.array([0.0, 1.5 * math.pi]))
    s = np.array([0.3, 0.9, 1.5])
    x, y, _ = line.at(s)
    sine, cosine = fresnel(s)
    assert x == pytest.approx(cosine, abs=1e-12)
    assert y == pytest.approx(sine, abs=1e-12)


def jumping(name):
    curvature, length = (np.array(values) for values in ROUTES[name])
    goal = ended(START, curvature, length)
    route = Route(START, curvature, length, np.zeros_like(length))
    return route, goal, jumping_route(route, START, goal, BLEND, SHARPEST)


@pytest.mark.parametrize("name", ROUTES)
def test_jumps_are_kept_where_nothing_is_blended(name):
    route, goal, (found, twins) = jumping(name)
    assert found.goal == pytest.approx(goal, abs=1e-9)
    assert [line.length for line in found.lines] == pytest.approx([line.length for line in twins.lines], abs=1e-12)
    assert sum(line.length for line in found.lines) == pytest.approx(np.abs(route.length).sum(), abs=JUMP)
    for line, stretch in zip(found.lines, stretches_of(route)[0], strict=True):
        middles = np.cumsum(stretch.length) - 0.5 * stretch.length
        assert line.curvature_at(middles) == pytest.approx(stretch.curvature, abs=1e-6)


def test_a_twin_runs_beside_its_route_by_each_jump_s_share():
    """A ramp in place of a jump moves what follows sideways by jump window^2 / 24, to the first order in the angle."""
    left, right, window = 0.05, -0.05, 0.8
    route = Route(START, np.array([left, right]), np.array([2.0, 2.0]), np.zeros(2))
    goal = ended(START, route.curvature, route.length)
    _, twin = jumping_route(route, START, goal, window, SHARPEST)
    x, y, direction = twin.goal
    across = START[2] + left * 2.0
    aside = -math.sin(across) * (x - goal[0]) + math.cos(across) * (y - goal[1])
    assert direction == pytest.approx(goal[2], abs=1e-9)
    assert aside == pytest.approx((right - left) * window**2 / 24.0, rel=1e-3)
    assert math.hypot(x - goal[0], y - goal[1]) == pytest.approx(abs(aside), rel=1e-3)
