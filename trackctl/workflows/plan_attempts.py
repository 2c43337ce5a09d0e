"""From a problem to a driven plan: searches that leave room for blends and drift, until a route can be driven."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from trackctl.errors import NoAnswerError
from trackctl.planning.ground import Cost
from trackctl.planning.search import Improvement, Problem, Search, Settings, stopwatch
from trackctl.planning.slope_field import SlopeField
from trackctl.workflows.plan_drive import Driven, drive_route
from trackctl.workflows.plan_jumps import drive_jumps, jumps_note
from trackctl.workflows.plan_leads import in_gears, led_in
from trackctl.workflows.plan_line import DrivenLine
from trackctl.workflows.plan_model import (
    LONG_BLENDS,
    MUCH_MORE_SLIP,
    DriveModel,
    SlippingError,
    UndrivableError,
    blend_length,
    slopes_at,
)
from trackctl.workflows.plan_rows import Rows, rows_of
from trackctl.workflows.plan_turn import pivot_speed

Progress = Callable[[float, float], None]

#: How far a vehicle may leave its plan open loop, over the way from start to goal and the tangent of the slope.
DEVIATION = 0.05
#: Blends move a path by more than they cut where its pieces are many; then so many times the room is tried.
MORE_ROOM = (3.0, 9.0)
#: Of the time that is left, or of the iterations, what the search for the gears at the ends of a plan has.
PROBED = 0.25
#: Routes that are tried to drive, the best first.
MOST_ROUTES = 8
#: Of the time that is left, what an attempt has until a route of one can be driven.
SHARE = 0.25
#: A plan is driven anew, half way to the end of the time, as long as so many of its drives would fit into the rest.
STOPS = 10.0


def slope_range(field: SlopeField) -> tuple[float, float]:
    """Least and largest slope of a map. [rad]"""
    slopes = np.arctan(np.hypot(field.gradient_x, field.gradient_y))
    return float(np.nanmin(slopes)), float(np.nanmax(slopes))


@dataclass(frozen=True, slots=True, eq=False)
class DrivenPlan:
    """A route that can be driven.

    Attributes
    ----------
    search
        That found it.
    improvement
        The route.
    lines, rows
        As it is driven.
    cost
        Duration [s] or length [m] as driven; of work [J] and slip [m] that of the route, blends and stops left aside.
    notes
        What the user should know, as sentences.
    """

    search: Search
    improvement: Improvement
    lines: list[Driven]
    rows: Rows
    cost: float
    notes: tuple[str, ...] = ()


def driven_plan(
    model: DriveModel,
    problem: Problem,
    settings: Settings,
    progress: Progress,
    pivot: bool | None = None,
    elapsed: Callable[[], float] | None = None,
) -> DrivenPlan:
    """Search, and drive the best route that can be driven.

    The attempts share the time: each has a part of what is left, until a route of one can be driven; that one has all
    the rest. Of iterations each attempt has the full number.

    Parameters
    ----------
    model, problem
        Vehicle and map.
    settings
        How to search, and how long.
    progress
        Told what is done, and all.
    pivot
        Whether turns on the spot may be planned; None: only where there is no other way.
    elapsed
        Tells the seconds since the start; None: since now.

    Raises
    ------
    NoAnswerError
        If there is none.
    """
    allowance = Allowance(settings, progress, elapsed or stopwatch())
    planned = attempts(model, problem, pivot, end_gears(problem, settings, allowance))
    allowance.expect(len(planned))
    driving = Driving(model, problem, settings.cost, allowance)
    searches: list[Search] = []
    for attempt in planned:
        if searches and (driving.best is not None or allowance.is_used_up):
            break
        searches.append(Search(attempt, settings, allowance.elapsed))
        allowance.let(searches[-1], SHARE)
        best = driving.routes(searches[-1])[:1]
        driving.drive_one(searches[-1], [(each, long) for each in best for long in LONG_BLENDS])
    for search in searches:
        if driving.best is None and not allowance.is_used_up:
            driving.drive_one(search, [(each, 1.0) for each in driving.routes(search)[:MOST_ROUTES]])
    while allowance.is_timed and not allowance.is_used_up and (hopeful := driving.worth_going_on(searches)):
        for search in hopeful:
            allowance.let(search, driving.share)
            routes = driving.routes(search)
            long_blends = [(each, long) for each in routes[:1] for long in LONG_BLENDS]
            driving.drive_one(search, [*long_blends, *((each, 1.0) for each in routes[:2])])
    if driving.best is None:
        driving.drive_slipping()
    for attempt, search in zip(planned, searches, strict=False):
        if driving.best is None and (attempt.start, attempt.goal_lead) == (problem.start, 0.0):
            driving.drive_with_jumps(search)
    if driving.best is None:
        raise NoAnswerError(driving.reason(searches))
    return driving.best


class Allowance:
    """Time or iterations that the searches of a plan may take together.

    Attributes
    ----------
    is_timed
        Whether the clock decides.
    elapsed
        Tells the seconds since the start.
    """

    def __init__(self, settings: Settings, progress: Progress, elapsed: Callable[[], float]) -> None:
        self.is_timed = settings.iterations is None
        self.elapsed = elapsed
        self._iterations, self._limit = settings.iterations, settings.time_limit
        self._progress, self._done, self._total = progress, 0, 0

    @property
    def left(self) -> float:
        """Of the time limit, infinite without one. [s]"""
        return self._limit - self.elapsed() if self.is_timed else math.inf

    @property
    def is_used_up(self) -> bool:
        """Whether the time limit is over."""
        return self.left <= 0.0

    def expect(self, searches: int) -> None:
        """Take the iterations of so many searches for all that there is to do."""
        self._total = searches * (self._iterations or 0)

    def let(self, search: Search, share: float) -> None:
        """Let a search go on for a share of the time that is left, or for all its iterations."""
        search.go_on(self._iterations, self._until(share), self._tell)

    def probe(self, search: Search, share: float) -> None:
        """Let a search besides those that are expected go on for a share of the time that is left, or of iterations."""
        if self._iterations is None:
            search.go_on(None, self._until(share), self._tell)
        else:
            search.go_on(max(int(share * self._iterations), 1), None)

    def _until(self, share: float) -> float | None:
        return self._limit - (1.0 - share) * self.left if self.is_timed else None

    def _tell(self, iterations: int) -> None:
        self._done += iterations
        if self.is_timed:
            self._progress(min(self.elapsed(), self._limit), self._limit)
        else:
            self._progress(self._done, self._total)


class Driving:
    """What has come of driving routes.

    Attributes
    ----------
    best
        The best plan so far, None without one.
    """

    def __init__(self, model: DriveModel, problem: Problem, cost: Cost, allowance: Allowance) -> None:
        self.best: DrivenPlan | None = None
        self._model, self._problem, self._cost, self._allowance = model, problem, cost, allowance
        self._tried: set[tuple[Improvement, float]] = set()
        self._with_fewer_pieces: dict[Improvement, Improvement] = {}
        self._reasons: list[str] = []
        self._without_blends: list[str] = []
        self._slipping: list[tuple[Search, Improvement, float]] = []
        self._seconds = 0.0

    def routes(self, search: Search) -> list[Improvement]:
        """The best route of a search with fewer pieces, sooner blended and better driven, and all, the best first."""
        if not search.improvements:
            return []
        best = search.improvements[-1]
        if best not in self._with_fewer_pieces:
            self._with_fewer_pieces[best] = search.with_fewer_pieces(best)
        return list(dict.fromkeys((self._with_fewer_pieces[best], *search.improvements[::-1])))

    def drive_one(self, search: Search, candidates: Sequence[tuple[Improvement, float]]) -> None:
        """Drive the first of a search's routes, each with its blends over the least, that can be driven.

        Once the time is used up, no further route is tried; one that was tried before is not tried again.
        """
        for improvement, longer in candidates:
            if self.best is not None and self.best.improvement is improvement:
                return
            if improvement is not candidates[0][0] and self._allowance.is_used_up:
                return
            if (improvement, longer) not in self._tried and self._drive(search, improvement, longer):
                return

    def _drive(self, search: Search, improvement: Improvement, longer: float) -> bool:
        """Whether a route can be driven; if it can, it may be the best."""
        self._tried.add((improvement, longer))
        begin = self._allowance.elapsed()
        try:
            route = in_gears(improvement.route, search.problem.gears)
            lines = drive_route(self._model, route, self._problem.start, improvement.goal, longer)
        except UndrivableError as error:
            self._reasons.append(f"a way was found but cannot be driven: {error}")
            if isinstance(error, SlippingError):
                self._slipping.append((search, improvement, longer))
            return False
        self._seconds = self._allowance.elapsed() - begin
        self._take(search, improvement, lines)
        return True

    def drive_slipping(self) -> None:
        """Drive the first route of those that ask for much slip that can be driven with it."""
        patient = replace(self._model, more_slip=MUCH_MORE_SLIP) if self._slipping else self._model
        for search, improvement, longer in self._slipping[:MOST_ROUTES]:
            try:
                route = in_gears(improvement.route, search.problem.gears)
                lines = drive_route(patient, route, self._problem.start, improvement.goal, longer)
            except UndrivableError:
                if self._allowance.is_used_up:
                    return
            else:
                self._take(search, improvement, lines, (slip_note(lines),))
                return

    def drive_with_jumps(self, search: Search) -> None:
        """Drive the best route of a search from pose to pose that can be driven with its jumps of curvature."""
        for improvement in self.routes(search)[:MOST_ROUTES]:
            try:
                lines = drive_jumps(self._model, improvement.route, self._problem.start, improvement.goal)
            except UndrivableError as error:
                self._without_blends.append(f"nor without blends: {error}")
            else:
                self._take(search, improvement, lines, (jumps_note(improvement.route, lines),))
                return
            if self._allowance.is_used_up:
                return

    def _take(self, search: Search, improvement: Improvement, lines: list[Driven], notes: tuple[str, ...] = ()) -> None:
        """Keep what can be driven if it is the best."""
        rows = rows_of(self._model, lines)
        cost = driven_cost(self._cost, rows, improvement.cost)
        if self.best is None or cost < self.best.cost:
            self.best = DrivenPlan(search, improvement, lines, rows, cost, notes)

    def worth_going_on(self, searches: Sequence[Search]) -> list[Search]:
        """The search of the best plan; without one, all that may find a route."""
        return [search for search in searches if not search.reason] if self.best is None else [self.best.search]

    @property
    def share(self) -> float:
        """Of the time that is left, what a search is to take next: with a plan all, but for stops to drive it."""
        if self.best is None:
            return SHARE
        return 0.5 if self._allowance.left > STOPS * self._seconds else 1.0

    def reason(self, searches: Sequence[Search]) -> str:
        """Why there is no plan: of the search with the least extra room, where no route was found."""
        found = self._reasons[0] if self._reasons else searches[-1].result().reason
        found = "; ".join((found, *self._without_blends[-1:]))
        return f"{found}; more time may help" if self.worth_going_on(searches) and self._allowance.is_used_up else found


def slip_note(driven: Sequence[Driven]) -> str:
    """What the user should know of a plan that slips much."""
    commands = [each.commands for each in driven if isinstance(each, DrivenLine)]
    most = max(float(np.abs(slip).max()) for each in commands for slip in (each.slip_left, each.slip_right))
    return f"the ground gives way in a turn, and no other way was found: the tracks slip by up to {most:.2f}"


def driven_cost(cost: Cost, rows: Rows, searched_cost: float) -> float:
    """What a plan costs: the search knows neither blends nor stops."""
    match cost:
        case Cost.TIME:
            return float(rows.time[-1])
        case Cost.LENGTH:
            return rows.length
        case _:
            return searched_cost


def end_gears(problem: Problem, settings: Settings, allowance: Allowance) -> tuple[int, int]:
    """Gears at start and goal of a route that a short search finds; 0 if they may be either."""
    if problem.backward is None:
        return 1, 1
    probe = Search(problem, settings, allowance.elapsed)
    allowance.probe(probe, PROBED)
    route = probe.result().route
    if route is None:
        return 0, 0
    driven = np.sign(route.length[route.length != 0.0]).astype(int)
    return (int(driven[0]), int(driven[-1])) if driven.size else (0, 0)


def attempts(model: DriveModel, problem: Problem, pivot: bool | None, gears: tuple[int, int]) -> list[Problem]:
    """Searches to be made until a route can be driven, turns on the spot as of `driven_plan`, gears as of `end_gears`.

    Those with turns start and end at the poses themselves: a turn needs no lead.
    """
    moving = moving_attempts(model, problem, gears)
    if pivot is False or (speed := pivot_speed(model)) == 0.0:
        return moving
    rooms = (cut_of(model, problem), 0.0)
    turning = [replace(problem, pivot_speed=speed, clearance=problem.clearance + room) for room in rooms]
    return [*turning, *moving] if pivot else [*moving, *turning]


def first_blend(model: DriveModel, problem: Problem) -> float:
    """The least blend of the sharpest turn at the start. [m]"""
    slope = float(slopes_at(model, *(np.array([value]) for value in problem.start[:2]))[0])
    return blend_length(model, slope, model.sharpest)


def cut_of(model: DriveModel, problem: Problem) -> float:
    """By how much blends cut corners: up to curvature blend^2 / 24. [m]"""
    return model.sharpest * (min(LONG_BLENDS) * first_blend(model, problem)) ** 2 / 24.0


def moving_attempts(model: DriveModel, problem: Problem, gears: tuple[int, int]) -> list[Problem]:
    """Searches to be made until a route without turns on the spot can be driven.

    Blends cut corners, and on a slope the vehicle leaves its plan: the first searches
    keep that much farther away (for the slope only where no clearance was asked for), the next no more than they must.
    They start and end half a blend from the poses themselves, in given gears, unless those are not known; the last one
    at the poses, or the first where the goal is so near that the blends at both ends would overlap. Where there are two
    gears the given ones may be those of a way that cannot be blended: after each search there is one between the poses.
    """
    away = DEVIATION * math.tan(slope_range(problem.field)[1]) * math.dist(problem.start[:2], problem.goal[:2])
    cut = cut_of(model, problem)
    led = led_in(model, problem, gears) if all(gears) else problem
    preferred = () if away == 0.0 or problem.clearance > 0.0 else (cut + away, cut + away / 3.0)
    rooms = (*preferred, cut, *(factor * cut for factor in MORE_ROOM), 0.0)
    found = [replace(led, clearance=problem.clearance + room) for room in rooms]
    if led is problem:
        return found
    is_near = math.dist(problem.start[:2], problem.goal[:2]) < max(LONG_BLENDS) * first_blend(model, problem)
    if problem.backward is None:
        return [problem, *found] if is_near else [*found, problem]
    exact = [replace(problem, clearance=problem.clearance + room) for room in rooms]
    pairs = zip(exact, found, strict=True) if is_near else zip(found, exact, strict=True)
    return [each for pair in pairs for each in pair]
