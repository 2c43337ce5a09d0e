"""How finely a table is divided along each axis, given how much each axis matters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import floor, prod

from trackctl.errors import UsageError
from trackctl.sensitivity.pawn import PawnIndex, Statistic

#: Number of nodes of an axis with so many divisions.
NodeCount = Callable[[int], int]


def both_ends(divisions: int) -> int:
    """Nodes of an axis that holds both ends of its range."""
    return divisions + 1


def full_circle(divisions: int) -> int:
    """Nodes of a periodic axis, whose last division ends on the first node."""
    return divisions


def axis_indices(
    indices: Sequence[PawnIndex], inputs: Sequence[str], statistic: Statistic = Statistic.MEDIAN
) -> tuple[float, ...]:
    """Largest index of each input over the outputs, and no less than its dummy threshold.

    One table serves all outputs, so that the one that varies most along an axis decides. An index below the threshold
    says no more than that: the axis may still matter that much.
    """
    return tuple(
        max(max(found.index, found.dummy) for found in indices if found.input == name and found.statistic is statistic)
        for name in inputs
    )


def divisions_from_indices(
    indices: Sequence[float], budget: int, minimum: Sequence[int], nodes: Sequence[NodeCount]
) -> tuple[int, ...]:
    """Divisions per axis in proportion to the sensitivity indices, as many as the cell budget allows.

    The rule of [1]_: an axis that matters twice as much gets steps half as long, relative to its range. In
    integers this is D'Hondt's apportionment: each further division goes to the axis with the largest index /
    (divisions + 1) among those where it still fits the budget, until it fits nowhere. An axis of index 0
    stays at its minimum.

    Parameters
    ----------
    indices
        Index of each axis, non-negative (`axis_indices`).
    budget
        Largest number of cells.
    minimum
        Least number of divisions of each axis.
    nodes
        Number of nodes of each axis by its divisions, increasing, such as `both_ends` or `full_circle`.

    Returns
    -------
    tuple of int
        The product of the nodes is at most `budget`, and one more division on any axis of positive index
        would exceed it.

    Raises
    ------
    UsageError
        If the least table does not fit the budget.

    References
    ----------
    .. [1] Zhang et al., Slope-steering motion planning for unmanned tracked vehicles based on SSTP-RRT, 2023.
    """

    def cells(divisions: Sequence[int]) -> int:
        return prod(count(n) for count, n in zip(nodes, divisions, strict=True))

    if cells(minimum) > budget:
        raise UsageError("--budget", budget, f"at least {cells(minimum)} cells")
    sensitive = [axis for axis, index in enumerate(indices) if index > 0.0]
    divisions = proportional_start(indices, budget, minimum, cells)
    while fitting := [axis for axis in sensitive if cells(with_one_more(divisions, axis)) <= budget]:
        divisions = with_one_more(divisions, max(fitting, key=lambda a: indices[a] / (divisions[a] + 1)))
    return divisions


def with_one_more(divisions: tuple[int, ...], axis: int) -> tuple[int, ...]:
    """The divisions with one added on an axis."""
    return *divisions[:axis], divisions[axis] + 1, *divisions[axis + 1 :]


def proportional_start(
    indices: Sequence[float], budget: int, minimum: Sequence[int], cells: Callable[[Sequence[int]], int]
) -> tuple[int, ...]:
    """Largest multiple of the indices, rounded down and raised to the minimum, that fits the budget."""

    def multiple(scale: float) -> tuple[int, ...]:
        return tuple(max(least, floor(scale * index)) for index, least in zip(indices, minimum, strict=True))

    fits, too_large = 0.0, (budget + 1) / max(indices) if any(indices) else 0.0
    while (middle := 0.5 * (fits + too_large)) not in (fits, too_large):
        fits, too_large = (middle, too_large) if cells(multiple(middle)) <= budget else (fits, middle)
    return multiple(fits)
