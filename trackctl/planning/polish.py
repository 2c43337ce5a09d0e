"""Making a found way better: stretches of it replaced by exact connections, direct or past a point beside the way."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import inlined, kernel
from trackctl.planning.connection import connect
from trackctl.planning.pieces import Task, Way, drive_cost, gear_of, lent, lent_task, lent_way, new_way, pivot_cost
from trackctl.planning.pose import advanced
from trackctl.planning.random_numbers import Stream, between, normal, uniform
from trackctl.planning.target import End, Target, copy_end, draw_beside, is_exact, lent_end, new_end

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Pose = tuple[float, float, float]

#: Pieces of a path at most; a replacement that would need more is not made.
CAPACITY = 400
#: Least gain of a replacement, over the path's cost: below it lies rounding.
GAIN = 1e-9
#: By how much a connection may seem to cost more than the stretch: within a piece that is not known exactly.
COARSE_COST = 1.001
#: Shortest stretch to replace, in smallest radii.
SHORTEST = 0.2
#: Share of replacements of the whole path.
WHOLE_SHARE = 0.05
#: Share of replacements up to the end, and of those that move it, where the goal has a tolerance.
END_SHARE, MOVED_SHARE = 0.3, 0.8
#: Share of replacements past a point beside the way.
BESIDE_SHARE = 0.7
#: Decades over which the point's offset is spread, below the length of the stretch.
DECADES = 3.5
#: Share of replacements with turns of the smallest radius, and with that one of the task's radii; others draw one up
#: to `WIDEST` times the smallest.
TIGHT_SHARE, LISTED_SHARE = 0.4, 0.7
WIDEST = 20.0


class Path(NamedTuple):
    """A way as pieces one after the other, with space for `CAPACITY`.

    Attributes
    ----------
    pieces
        What is driven.
    x, y, tangent, gear
        Where each piece begins, shape (CAPACITY + 1,). [m], [rad]
    position
        Driven before each piece. [m]
    cost
        Before each piece.
    piece_count
        Shape (1,).
    end
        Where it ends.
    moved
        Work space: where it might end.
    first, second
        Work space: ways to and from a point beside the path.
    spare
        Work space: the pieces of a changed path.
    """

    pieces: Way
    x: Array
    y: Array
    tangent: Array
    gear: Indices
    position: Array
    cost: Array
    piece_count: Indices
    end: End
    moved: End
    first: Way
    second: Way
    spare: Way


def new_path() -> Path:
    """An empty path."""
    x, y, tangent, position, cost = (np.zeros(CAPACITY + 1) for _ in range(5))
    gear, count = np.zeros(CAPACITY + 1, np.int64), np.zeros(1, np.int64)
    ways = (new_way(CAPACITY), new_way(), new_way(), new_way(CAPACITY))
    return Path(ways[0], x, y, tangent, gear, position, cost, count, new_end(), new_end(), *ways[1:])


@kernel
def lent_path(path: Path) -> Path:
    """A path, its arrays lent."""
    return Path(
        lent_way(path.pieces),
        lent(path.x),
        lent(path.y),
        lent(path.tangent),
        lent(path.gear),
        lent(path.position),
        lent(path.cost),
        lent(path.piece_count),
        lent_end(path.end),
        lent_end(path.moved),
        lent_way(path.first),
        lent_way(path.second),
        lent_way(path.spare),
    )


@kernel
def measure(task: Task, path: Path, start: Pose) -> float:
    """Fill in poses, positions and costs of a path's pieces; its cost."""
    path.x[0], path.y[0], path.tangent[0] = start
    path.gear[0], path.position[0], path.cost[0] = task.first_gear, 0.0, 0.0
    pieces = path.pieces
    for i in range(path.piece_count[0]):
        x, y, tangent = advanced(path.x[i], path.y[i], path.tangent[i], pieces.curvature[i], pieces.length[i])
        path.x[i + 1], path.y[i + 1], path.tangent[i + 1] = x, y, tangent + pieces.pivot[i]
        path.gear[i + 1] = gear_of(pieces.length[i], path.gear[i])
        path.position[i + 1] = path.position[i] + abs(pieces.length[i])
        path.cost[i + 1] = path.cost[i] + _piece_cost(task, path, i)
    count = path.piece_count[0]
    if path.gear[count] * task.last_gear < 0:
        path.cost[count] += task.gear_change
    return float(path.cost[count])


@inlined
def _piece_cost(task: Task, path: Path, i: int) -> float:
    """Cost of a piece, with that of a gear change before it."""
    length = path.pieces.length[i]
    if length == 0.0:
        return pivot_cost(task, path.pieces.pivot[i]) if path.pieces.pivot[i] != 0.0 else 0.0
    change = task.gear_change if path.gear[i] * length < 0.0 else 0.0
    return change + drive_cost(task, path.x[i], path.y[i], path.tangent[i], path.pieces.curvature[i], length)


@kernel
def _piece_at(path: Path, position: float) -> int:
    """The driven piece that a position lies on."""
    low, high = 0, path.piece_count[0]
    while high - low > 1:
        middle = (low + high) // 2
        if path.position[middle] <= position:
            low = middle
        else:
            high = middle
    return low


@kernel
def _cost_at(path: Path, position: float) -> float:
    """Cost up to a position, as if all of a piece cost alike."""
    i = _piece_at(path, position)
    length = path.position[i + 1] - path.position[i]
    share = (position - path.position[i]) / length if length > 0.0 else 1.0
    return float(path.cost[i] + share * (path.cost[i + 1] - path.cost[i]))


@inlined
def _pose_at(path: Path, piece: int, position: float) -> tuple[float, float, float]:
    length = math.copysign(position - path.position[piece], path.pieces.length[piece])
    return advanced(path.x[piece], path.y[piece], path.tangent[piece], path.pieces.curvature[piece], length)


@kernel
def _append(way: Way, count: int, curvature: float, length: float, pivot: float) -> int:
    """Add a piece to a way, joined to the one before if it goes on alike; the number of pieces, `CAPACITY` at most."""
    if (length == 0.0 and pivot == 0.0) or count >= CAPACITY:
        return count
    if count > 0 and length * way.length[count - 1] > 0.0 and curvature == way.curvature[count - 1]:
        way.length[count - 1] += length
        return count
    way.curvature[count], way.length[count], way.pivot[count] = curvature, length, pivot
    return count + 1


@kernel
def _append_all(way: Way, count: int, more: Way, first: int, last: int) -> int:
    for i in range(first, last):
        count = _append(way, count, more.curvature[i], more.length[i], more.pivot[i])
    return count


@kernel
def replace_stretch(path: Path, begin: float, end: float, counts: tuple[int, int]) -> int:
    """Write the path with a stretch replaced by the first and the second way into the spare; its number of pieces."""
    i, j = _piece_at(path, begin), _piece_at(path, end)
    pieces, spare = path.pieces, path.spare
    count = _append_all(spare, 0, pieces, 0, i)
    head = math.copysign(begin - path.position[i], pieces.length[i])
    count = _append(spare, count, pieces.curvature[i], head, 0.0)
    count = _append_all(spare, count, path.first, 0, counts[0])
    count = _append_all(spare, count, path.second, 0, counts[1])
    if end < path.position[path.piece_count[0]]:
        rest = math.copysign(path.position[j + 1] - end, pieces.length[j])
        count = _append(spare, count, pieces.curvature[j], rest, 0.0)
        count = _append_all(spare, count, pieces, j + 1, path.piece_count[0])
    return count


@kernel
def swap(path: Path, count: int) -> None:
    """Exchange the path's pieces for the spare ones."""
    for i in range(max(count, path.piece_count[0])):
        curvature, length, pivot = path.pieces.curvature[i], path.pieces.length[i], path.pieces.pivot[i]
        path.pieces.curvature[i], path.pieces.length[i] = path.spare.curvature[i], path.spare.length[i]
        path.pieces.pivot[i] = path.spare.pivot[i]
        path.spare.curvature[i], path.spare.length[i], path.spare.pivot[i] = curvature, length, pivot


@kernel
def _detour(
    task: Task, path: Path, stream: Stream, begin: float, end: float, goal: Pose, radius: float, bound: float
) -> tuple[int, int]:
    """Connect the ends of a stretch, past a point beside it or directly; the numbers of pieces, 0 without success."""
    i = _piece_at(path, begin)
    x, y, tangent = _pose_at(path, i, begin)
    start = x, y, tangent, path.gear[i + 1]
    if end < path.position[path.piece_count[0]]:
        goal = _pose_at(path, _piece_at(path, end), end)
    if uniform(stream) >= BESIDE_SHARE:
        return connect(task, start, goal, radius, bound, path.first)[1], 0
    middle = begin + (end - begin) * between(stream, 0.2, 0.8)
    x, y, tangent = _pose_at(path, _piece_at(path, middle), middle)
    spread = 10.0 ** (-DECADES * uniform(stream))
    offset = 0.3 * (end - begin) * spread
    past = x + offset * normal(stream), y + offset * normal(stream), tangent + spread * normal(stream)
    cost, count = connect(task, start, past, radius, bound, path.first)
    if count == 0:
        return 0, 0
    gear = start[3]
    for k in range(count):
        gear = gear_of(path.first.length[k], gear)
    more = connect(task, (past[0], past[1], past[2], gear), goal, radius, bound - cost, path.second)[1]
    return (count if more else 0), more


@kernel
def _draw_radius(task: Task, stream: Stream) -> float:
    """The smallest turning radius, another one of the task's, or any. [m]"""
    kind = uniform(stream)
    if kind < TIGHT_SHARE:
        return float(task.radii[0])
    if kind < LISTED_SHARE:
        return float(task.radii[int(uniform(stream) * task.radii.size)])
    return float(task.radii[0] * WIDEST ** uniform(stream))


@kernel
def _draw_goal(task: Task, target: Target, path: Path, stream: Stream, is_last: bool) -> Pose:
    """Where a stretch is to end if it is the last: the path's end, or one near it, which is written to `moved`."""
    moves = is_last and not is_exact(target) and uniform(stream) < MOVED_SHARE
    if not (moves and draw_beside(task, target, path.end, stream, path.moved)):
        copy_end(path.end, path.moved)
    return path.moved.route[0], path.moved.route[1], path.moved.route[2]


@kernel
def polish(task: Task, path: Path, stream: Stream, target: Target, iterations: int) -> float:
    """Try to replace random stretches of a path by cheaper ones.

    Parameters
    ----------
    task
        Obstacles and costs.
    path
        Changed for the better; measured.
    stream
        Random numbers.
    target
        Goal and tolerance: within it, the path's end may be moved.
    iterations
        Number of replacements tried.

    Returns
    -------
    float
        The path's cost.
    """
    task, path, stream = lent_task(task), lent_path(path), lent(stream)
    start = path.x[0], path.y[0], path.tangent[0]
    for _ in range(iterations):
        count, total = path.piece_count[0], path.position[path.piece_count[0]]
        cost = path.cost[count]
        shortest = min(total, SHORTEST * task.radii[0])
        span = shortest * (total / shortest) ** uniform(stream)
        middle = total * uniform(stream)
        begin, end = max(0.0, middle - 0.5 * span), min(total, middle + 0.5 * span)
        if uniform(stream) < WHOLE_SHARE:
            begin, end = 0.0, total
        elif not is_exact(target) and uniform(stream) < END_SHARE:
            begin, end = max(0.0, total - span), total
        goal = _draw_goal(task, target, path, stream, end == total)
        radius = _draw_radius(task, stream)
        bound = COARSE_COST * (_cost_at(path, end) - _cost_at(path, begin))
        counts = _detour(task, path, stream, begin, end, goal, radius, bound)
        if counts[0] == 0:
            continue
        changed = replace_stretch(path, begin, end, counts)
        if changed >= CAPACITY:
            continue
        swap(path, changed)
        path.piece_count[0] = changed
        if not measure(task, path, start) < cost * (1.0 - GAIN):
            swap(path, max(changed, count))
            path.piece_count[0] = count
            measure(task, path, start)
        else:
            copy_end(path.moved, path.end)
    return float(path.cost[path.piece_count[0]])
