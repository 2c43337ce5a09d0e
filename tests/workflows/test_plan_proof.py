"""Plans that are looked for again with more room, as long as their simulations touch something."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from planning_cases import level_problem

from trackctl.errors import NoAnswerError
from trackctl.workflows.plan_proof import ROOM, ROUNDS, proved_plan
from trackctl.workflows.plan_verification import Verification

PROBLEM = level_problem(np.zeros((100, 100), bool), (2.0, 2.0, 0.0), (8.0, 8.0, 0.0), clearance=0.1)


def proved(clear_from, deviation=0.2, most=math.inf):
    """With simulations that keep clear from a clearance on, of plans up to another one; the clearances tried."""
    tried = []

    def find(problem):
        if problem.clearance > most:
            raise NoAnswerError("no room")
        tried.append(problem.clearance)
        return SimpleNamespace(notes=("its own",), clearance=problem.clearance)

    def simulate(plan):
        found = Verification(deviation, 0.0, plan.clearance < clear_from, "")
        return found, found

    return proved_plan(PROBLEM, find, simulate), tried


def test_a_plan_that_keeps_clear_is_the_first():
    found, tried = proved(clear_from=0.0)
    assert tried == [0.1]
    assert found.notes == ("its own",)


def test_after_one_that_touches_comes_one_with_room_for_the_deviation():
    found, tried = proved(clear_from=0.3)
    assert tried == pytest.approx([0.1, 0.1 + ROOM * 0.2])
    assert not found.verification.collision
    assert found.notes[0] == "its own"
    assert f"{ROOM * 0.2:.3f} m more" in found.notes[1]
    assert found.planning > 0.0


def test_after_some_the_last_is_handed_out_as_it_is():
    found, tried = proved(clear_from=math.inf)
    assert len(tried) == ROUNDS
    assert found.plan.clearance == tried[-1]
    assert found.verification.collision


def test_where_there_is_no_more_room_the_plan_before_stays():
    found, tried = proved(clear_from=math.inf, most=0.2)
    assert tried == [0.1]
    assert found.verification.collision
    with pytest.raises(NoAnswerError, match="no room"):
        proved(clear_from=0.0, most=0.05)


def test_a_simulation_that_ends_early_is_not_tried_again():
    _, tried = proved(clear_from=math.inf, deviation=math.nan)
    assert tried == [0.1]
