from itertools import pairwise
from math import prod

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from trackctl.errors import UsageError
from trackctl.sensitivity.pawn import PawnIndex, Statistic
from trackctl.sensitivity.steps import axis_indices, both_ends, divisions_from_indices, full_circle

NODES = (both_ends, both_ends, full_circle)


def cells(divisions, nodes=NODES):
    return prod(count(n) for count, n in zip(nodes, divisions, strict=True))


def test_twice_the_index_gets_twice_the_divisions():
    """Zhang et al.: velocity more than twice as sensitive as radius and heading, half the step."""
    divisions = divisions_from_indices((0.5, 0.25, 0.25), 21 * 11 * 10, (1, 1, 1), NODES)
    assert divisions == (20, 10, 10)


@given(
    indices=st.tuples(*[st.floats(0.0, 1.0)] * 3),
    minimum=st.tuples(*[st.integers(1, 12)] * 3),
    spare=st.integers(0, 50_000),
)
def test_the_budget_is_kept_and_leaves_no_room_for_another_division(indices, minimum, spare):
    budget = cells(minimum) + spare
    divisions = divisions_from_indices(indices, budget, minimum, NODES)
    assert cells(divisions) <= budget
    for axis, index in enumerate(indices):
        assert divisions[axis] >= minimum[axis]
        one_more = [n + (other == axis) for other, n in enumerate(divisions)]
        if index > 0.0:
            assert cells(one_more) > budget
        else:
            assert divisions[axis] == minimum[axis]


@given(
    indices=st.tuples(*[st.floats(0.05, 1.0)] * 3),
    minimum=st.tuples(*[st.integers(1, 5)] * 3),
    budget=st.integers(180, 5000),
)
def test_the_divisions_are_those_of_division_by_division_apportionment(indices, minimum, budget):
    expected = list(minimum)
    while True:
        claims = {axis: indices[axis] / (expected[axis] + 1) for axis in range(3)}
        first = sorted(claims, key=claims.__getitem__, reverse=True)
        # Of claims that are equal up to rounding either may come first.
        assume(all(claims[after] < (1.0 - 1e-12) * claims[before] for before, after in pairwise(first)))
        fits = [a for a in first if cells([n + (b == a) for b, n in enumerate(expected)]) <= budget]
        if not fits:
            break
        expected[fits[0]] += 1
    assert divisions_from_indices(indices, budget, minimum, NODES) == tuple(expected)


def test_an_axis_without_influence_stays_at_its_minimum():
    assert divisions_from_indices((0.4, 0.0, 0.0), 1000, (1, 4, 8), NODES) == (24, 4, 8)
    assert divisions_from_indices((0.0, 0.0, 0.0), 1000, (3, 4, 8), NODES) == (3, 4, 8)


def test_nodes_count_as_the_axis_says():
    """Both signs of curvature and the straight line between them: 2 (divisions + 1) + 1 nodes."""
    assert divisions_from_indices((1.0,), 22, (1,), (lambda divisions: 2 * (divisions + 1) + 1,)) == (9,)


def test_a_huge_budget_for_one_axis_takes_no_counting():
    assert divisions_from_indices((0.5, 0.0, 0.0), 10**12, (1, 1, 1), NODES) == (10**12 // 2 - 1, 1, 1)


def test_a_budget_below_the_least_table_is_refused():
    with pytest.raises(UsageError, match=r"--budget: 79 .* at least 80 cells"):
        divisions_from_indices((0.5, 0.2, 0.2), 79, (1, 4, 8), NODES)


def test_an_axis_takes_the_largest_index_and_no_less_than_its_dummy():
    def found(output, name, statistic, index):
        return PawnIndex(output, name, statistic, index, 0.0, 1.0, dummy=0.1)

    indices = [
        found("left", "velocity", Statistic.MEDIAN, 0.5),
        found("right", "velocity", Statistic.MEDIAN, 0.6),
        found("left", "velocity", Statistic.MAX, 0.9),
        found("left", "heading", Statistic.MEDIAN, 0.1),
        found("right", "heading", Statistic.MEDIAN, 0.05),
        found("right", "heading", Statistic.MAX, 0.2),
    ]
    assert axis_indices(indices, ("heading", "velocity")) == (0.1, 0.6)
    assert axis_indices(indices, ("velocity", "heading"), Statistic.MAX) == (0.9, 0.2)
