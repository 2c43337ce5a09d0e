"""Plans that keep clear in their simulation, too: where one touches something, another keeps farther away."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

from trackctl.errors import NoAnswerError
from trackctl.planning.search import Problem
from trackctl.workflows.plan_attempts import DrivenPlan
from trackctl.workflows.plan_verification import Verification

#: Plans that are simulated at most.
ROUNDS = 3
#: Room that is added after a plan that touches, over its deviation.
ROOM = 1.25


@dataclass(frozen=True, slots=True, eq=False)
class ProvedPlan:
    """A plan and what its simulation comes to.

    Attributes
    ----------
    plan
        As it is driven.
    planning
        Time that searching and driving took, of the plans before, too. [s]
    verification, no_slip
        Of its commands, and of such that would drive it without slip; None: not simulated.
    notes
        What the user should know, as sentences.
    """

    plan: DrivenPlan
    planning: float
    verification: Verification | None
    no_slip: Verification | None
    notes: tuple[str, ...]


def proved_plan(
    problem: Problem,
    find: Callable[[Problem], DrivenPlan],
    simulate: Callable[[DrivenPlan], tuple[Verification, Verification]] | None,
) -> ProvedPlan:
    """A plan whose simulation touches nothing, or the last one that was tried.

    Parameters
    ----------
    problem
        What to find a plan for.
    find
        Finds it.
    simulate
        What a plan and its twin without slip come to; None: the first plan will do.

    Raises
    ------
    NoAnswerError
        If there is no plan at all.
    """

    def attempt(room: float) -> ProvedPlan:
        begin = time.perf_counter()
        plan = find(replace(problem, clearance=problem.clearance + room))
        planning = time.perf_counter() - begin
        verification, no_slip = (None, None) if simulate is None else simulate(plan)
        notes = (*plan.notes, room_note(room)) if room else plan.notes
        return ProvedPlan(plan, planning, verification, no_slip, notes)

    best, room = attempt(0.0), 0.0
    for _ in range(ROUNDS - 1):
        found = best.verification
        if found is None or not found.collision or not math.isfinite(found.max_deviation):
            break
        room += ROOM * found.max_deviation
        try:
            roomier = attempt(room)
        except NoAnswerError:
            break
        best = replace(roomier, planning=best.planning + roomier.planning)
    return best


def room_note(room: float) -> str:
    """What the user should know of a plan that keeps farther away."""
    return f"a plan touched an obstacle in its simulation; this one keeps {room:.3f} m more away from obstacles"
