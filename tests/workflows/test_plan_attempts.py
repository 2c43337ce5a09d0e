"""How attempts share the time, counted by a clock of its own: a reading takes a millisecond, a drive longer."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from planning_cases import level_limits, level_problem

from trackctl.errors import NoAnswerError
from trackctl.planning.search import Search, Settings, search
from trackctl.planning.simplification import MOST_LOSS
from trackctl.workflows import plan_attempts
from trackctl.workflows.plan_attempts import LONG_BLENDS, driven_plan
from trackctl.workflows.plan_model import UndrivableError

READING, DRIVE, LIMIT = 0.001, 0.02, 0.6
BLOCKED = np.zeros((120, 120), bool)
BLOCKED[40:80, 55:65] = True
#: One for each attempt: their starts tell them apart.
STARTS = (1.0, 1.1, 1.2, 1.3)
PROBLEM = level_problem(BLOCKED, (STARTS[0], 6.0, 0.0), (10.0, 6.0, 0.0))


class World:
    """Attempts of which some can be driven, and the clock."""

    def __init__(self, drivable):
        self.now, self.drivable, self.drives, self.told, self.gears = 0.0, drivable, [], [], None

    def elapsed(self):
        self.now += READING
        return self.now

    def drive(self, model, route, start, goal, longer):
        self.now += DRIVE
        attempt = STARTS.index(route.start[0])
        self.drives.append((attempt, longer, self.now))
        if not self.drivable(attempt, longer, self.now):
            raise UndrivableError("not this one")
        return route

    def drive_jumps(self, model, route, start, goal):
        self.now += DRIVE
        raise UndrivableError("nor this")

    def choose(self, attempts, gears):
        self.gears = gears
        return attempts

    def tell(self, done, total):
        self.told.append((done, total))


@pytest.fixture
def plan(monkeypatch):
    def planned(drivable, attempts=None, problem=PROBLEM, **settings):
        world = World(drivable)
        chosen = attempts or [replace(PROBLEM, start=(x, 6.0, 0.0)) for x in STARTS]
        monkeypatch.setattr(plan_attempts, "attempts", lambda model, problem, pivot, gears: world.choose(chosen, gears))
        monkeypatch.setattr(plan_attempts, "drive_route", world.drive)
        monkeypatch.setattr(plan_attempts, "drive_jumps", world.drive_jumps)
        monkeypatch.setattr(plan_attempts, "rows_of", rows_of)
        try:
            found = driven_plan(None, problem, Settings(**settings), world.tell, elapsed=world.elapsed)
        except NoAnswerError as error:
            found = str(error)
        return world, found

    return planned


def rows_of(model, route):
    length = np.abs(route.length).sum()
    return SimpleNamespace(time=np.array([0.0, length]), length=length)


@pytest.mark.parametrize("which", range(4))
def test_an_attempt_that_cannot_be_driven_leaves_time_to_the_others(plan, which):
    world, found = plan(lambda attempt, longer, now: attempt == which, time_limit=LIMIT)
    assert found.lines.start[0] == STARTS[which]
    assert world.now <= LIMIT + DRIVE + 10 * READING
    # All the rest is for the one that can be driven.
    assert {attempt for attempt, _, _ in world.drives} == set(range(which + 1))
    assert found.search.result().elapsed == pytest.approx(LIMIT, abs=3 * DRIVE)
    assert found.search.improvements[0].elapsed == min(each.elapsed for each in found.search.improvements)


def test_the_limit_is_kept_without_an_answer_too(plan):
    world, found = plan(lambda attempt, longer, now: False, time_limit=LIMIT)
    words = "a way was found but cannot be driven: not this one; nor without blends: nor this; more time may help"
    assert found == words
    assert LIMIT <= world.now <= LIMIT + (len(LONG_BLENDS) + 2) * DRIVE + 10 * READING


def test_nothing_found_is_told_once_the_time_is_up(plan):
    """A lane too narrow to turn round in: no search knows that there is no way."""
    lane = np.ones((120, 120), bool)
    lane[52:68] = False
    nowhere = level_problem(lane, (8.0, 6.0, 0.0), (3.0, 6.0, math.pi))
    world, found = plan(lambda attempt, longer, now: True, [nowhere] * 2, time_limit=LIMIT)
    assert "goal not reached: no connection in" in found
    assert found.endswith("more time may help")
    assert LIMIT <= world.now <= LIMIT + 10 * READING


def test_attempts_have_a_second_turn_when_time_is_left(plan):
    half = 0.9 * LIMIT
    world, found = plan(lambda attempt, longer, now: attempt == 0 and now > half, time_limit=LIMIT)
    assert found.lines.start[0] == STARTS[0]
    assert world.drives[-1][2] > half


def test_an_attempt_that_gives_up_passes_its_time_on(plan):
    in_the_wall = replace(PROBLEM, start=(6.0, 6.0, 0.0))
    others = [in_the_wall] * 3 + [PROBLEM]
    world, found = plan(lambda attempt, longer, now: True, others, time_limit=LIMIT)
    first = world.drives[0][2] - DRIVE
    assert first == pytest.approx(plan_attempts.SHARE * LIMIT, abs=0.05 * LIMIT)
    assert found.search.improvements


@pytest.mark.parametrize("limit", [0.005, 0.01, 0.02, 0.04])
def test_searches_without_a_route_go_on_while_there_is_time(plan, limit):
    walled = BLOCKED.copy()
    walled[:, 55:65] = True
    closed = level_problem(walled, PROBLEM.start, PROBLEM.goal)
    world, found = plan(lambda attempt, longer, now: True, [closed] * 2, time_limit=limit)
    assert found.startswith("goal not reachable: obstacles close off the start")
    assert world.drives == []


def test_the_best_that_can_be_driven_is_handed_out(plan):
    """Later routes are better, but only the first drives go well."""
    world, found = plan(lambda attempt, longer, now: now < 0.4 * LIMIT, time_limit=LIMIT)
    driven = [now for _, _, now in world.drives if now < 0.4 * LIMIT]
    assert driven
    assert found.improvement.elapsed < driven[-1]
    assert found.cost == pytest.approx(found.improvement.cost)


def test_a_long_limit_has_stops(plan):
    """The time that a plan takes to drive is the measure: at half of what is left, as long as it is much shorter."""
    world, _ = plan(lambda attempt, longer, now: True, time_limit=2.0)
    assert len({now for _, _, now in world.drives}) == len(world.drives) <= 6
    assert world.now <= 2.0 + DRIVE + 10 * READING


def test_long_blends_are_tried_on_all_attempts_before_short_ones(plan):
    world, found = plan(lambda attempt, longer, now: longer == 1.0, iterations=200)
    assert [drive[:2] for drive in world.drives] == [*((k, long) for k in range(4) for long in LONG_BLENDS), (0, 1.0)]
    assert found.search.iterations == 200


def test_the_best_route_is_driven_with_fewer_pieces_and_then_as_it_was_found(plan):
    tried = []

    def second_of_the_first(attempt, longer, now):
        tried.append(attempt == 0 and longer == 1.0)
        return sum(tried) == 2

    first = plan(lambda attempt, longer, now: True, iterations=600)[1]
    second = plan(second_of_the_first, iterations=600)[1]
    best = first.search.improvements[-1]
    assert first.improvement.route.length.size < best.route.length.size
    assert first.improvement.cost == pytest.approx(best.cost, rel=MOST_LOSS)
    assert second.improvement is second.search.improvements[-1]


def test_progress_runs_once(plan):
    for settings, most in (({"time_limit": LIMIT}, LIMIT), ({"iterations": 200}, 800)):
        world, _ = plan(lambda attempt, longer, now: attempt == 3, **settings)
        done, total = np.array(world.told).T
        assert (np.diff(done) >= 0.0).all()
        assert (total == most).all()
        assert done[-1] == pytest.approx(most)


@pytest.mark.parametrize("settings", [{"time_limit": LIMIT}, {"iterations": 200}])
def test_the_gears_of_the_ends_are_found_in_a_share_of_the_same_time(plan, settings):
    """There is a wall between the ends, so the vehicle goes on as it has begun: backwards."""
    turned = replace(PROBLEM, start=(1.0, 6.0, np.pi), goal=(10.0, 6.0, np.pi), backward=level_limits())
    world = plan(lambda attempt, longer, now: True, problem=turned, **settings)[0]
    assert world.gears == (-1, -1)
    done, total = np.array(world.told).T
    assert (np.diff(done) >= 0.0).all()
    assert done[-1] <= total[-1] == total[0]
    if "time_limit" in settings:
        probed, share = plan_attempts.PROBED * LIMIT, (1.0 - plan_attempts.PROBED) * plan_attempts.SHARE * LIMIT
        assert world.drives[0][2] - DRIVE == pytest.approx(probed + share, abs=10 * READING)
        assert world.now <= LIMIT + DRIVE + 10 * READING


def test_ends_that_no_route_is_known_for_may_have_any_gear(plan):
    walled = PROBLEM.grid.blocked.copy()
    walled[:, 55:65] = True
    closed = level_problem(walled, PROBLEM.start, PROBLEM.goal, backward=level_limits())
    assert plan(lambda attempt, longer, now: True, problem=closed, iterations=40)[0].gears == (0, 0)
    assert plan(lambda attempt, longer, now: True, iterations=40)[0].gears == (1, 1)


def test_a_search_that_is_left_after_every_step_finds_the_same():
    whole, parts = search(PROBLEM, Settings(iterations=1280)), Search(PROBLEM, Settings())
    while parts.iterations < 1280:
        parts.go_on(None, 0.0)
    costs = [[(each.iteration, each.cost) for each in one.improvements] for one in (whole, parts)]
    # The last step of the one with a number of iterations may have been cut.
    assert len(costs[0]) > 3
    assert costs[1][: len(costs[0]) - 1] == costs[0][:-1]
