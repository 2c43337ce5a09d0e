"""Growing the tree: families towards random points, exact connections to the goal."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import inlined, kernel
from trackctl.planning.collision import cell_position, free_radius
from trackctl.planning.connection import connect
from trackctl.planning.dubins import seen_from
from trackctl.planning.families import arc_to_point, way_to_point
from trackctl.planning.pieces import Task, Way, free_length, lent_task, pivot_is_free, way_cost
from trackctl.planning.pose import advanced, wrapped
from trackctl.planning.random_numbers import Stream, between, normal, uniform
from trackctl.planning.target import End, Target, copy_end, draw_end, is_exact
from trackctl.planning.tree import Tree, add_node, nearest

Array = NDArray[np.float64]

#: Share of samples drawn about the goal.
GOAL_SHARE = 0.1
#: Share of samples drawn about the guide, and the decades over which their distances from it are spread.
GUIDE_SHARE, GUIDE_DECADES = 0.5, 2.0
#: Share of these that is drawn where the tree might get on along the guide.
FRONTIER_SHARE = 0.7
#: Tries to draw a point that is not blocked.
TRIES = 100
#: Share of extensions by a single arc, where that is not too tight.
ARC_SHARE = 0.3
#: Shortest extension worth a node, over the smallest radius.
SHORTEST = 0.1
#: An extension that obstacles cut keeps back this share of its last piece: from a wall there is no way on.
KEPT_BACK = 0.15


class Growth(NamedTuple):
    """State of a search besides its tree, for kernels.

    Attributes
    ----------
    stream
        Random numbers.
    target
        Goal and tolerance.
    surest
        The end that is closest to the goal and will do.
    slack
        No end is farther from the surest one. [m]
    reach
        Longest extension. [m]
    way, shot
        Work space: an extension, and a connection to the goal.
    best
        Cost of the best solution of this tree, shape (1,).
    bound
        Cost that a node's way to the goal must be able to stay below, shape (1,).
    guide
        Points to grow by, shape (n, 2), none at first: the way of a disc, where the first tree takes long. [m]
    frontier
        Index of the guide's point that the tree has come to, and the number of points that are drawn next.
    last
        Node that the best solution leaves the tree at, -1 without one, and the number of pieces from there.
    solution
        Those pieces.
    aimed, end
        Ends: the one that is aimed at now, and that of the best solution.
    """

    stream: Stream
    target: Target
    surest: End
    slack: float
    reach: float
    way: Way
    shot: Way
    best: Array
    bound: Array
    guide: Array
    frontier: NDArray[np.int64]
    last: NDArray[np.int64]
    solution: Way
    aimed: End
    end: End


@kernel
def _guide_point(growth: Growth) -> int:
    """Index of any point of the guide, or of one about the frontier."""
    stream, last = growth.stream, growth.guide.shape[0] - 1
    if uniform(stream) >= FRONTIER_SHARE:
        return int(uniform(stream) * (last + 1))
    ahead = int(growth.frontier[1] * between(stream, -1.0, 0.5))
    return int(min(last, max(0, growth.frontier[0] + ahead)))


@kernel
def _advance(task: Task, tree: Tree, growth: Growth, node: int) -> None:
    """Move the frontier on to the farthest point of the guide that a node has come near to."""
    frontier = growth.frontier[0]
    for i in range(max(0, frontier - growth.frontier[1]), frontier):
        if math.hypot(growth.guide[i, 0] - tree.x[node], growth.guide[i, 1] - tree.y[node]) < task.radii[0]:
            growth.frontier[0] = i
            break


@kernel
def _draw_point(task: Task, tree: Tree, growth: Growth) -> tuple[float, float]:
    """A point that the mass centre might be at, on a way straight to it and on that is short enough."""
    obstacles, stream, goal = task.obstacles, growth.stream, growth.surest.route
    n_rows, n_columns = obstacles.distance.shape
    longest = growth.bound[0] / task.least_rate + growth.slack
    x, y = goal[0], goal[1]
    if growth.guide.shape[0] > 0 and uniform(stream) < GUIDE_SHARE:
        i = _guide_point(growth)
        spread = growth.reach * 10.0 ** (-GUIDE_DECADES * uniform(stream))
        return growth.guide[i, 0] + spread * normal(stream), growth.guide[i, 1] + spread * normal(stream)
    about_goal = uniform(stream) < GOAL_SHARE
    for _ in range(TRIES):
        if about_goal:
            x, y = (
                goal[0] + growth.reach * between(stream, -1.0, 1.0),
                goal[1] + growth.reach * between(stream, -1.0, 1.0),
            )
        else:
            column = n_columns * uniform(stream) * obstacles.resolution
            row = n_rows * uniform(stream) * obstacles.resolution
            x = obstacles.x + obstacles.cos_yaw * column - obstacles.sin_yaw * row
            y = obstacles.y + obstacles.sin_yaw * column + obstacles.cos_yaw * row
        if math.hypot(x - tree.x[0], y - tree.y[0]) + math.hypot(x - goal[0], y - goal[1]) > longest:
            continue
        at_column, at_row = cell_position(obstacles, x, y)
        if free_radius(obstacles, at_column, at_row) > 0.0:
            break
    return x, y


@kernel
def _aim(task: Task, tree: Tree, growth: Growth, x: float, y: float) -> tuple[int, int]:
    """Write the way of a family from the nearest node to a point: the node and the number of pieces, 0 without one.

    With a reverse gear, half of the ways are driven backwards; where the vehicle can turn on the spot, half of them
    turn first and go straight.
    """
    way, stream = growth.way, growth.stream
    radius = task.radii[min(int(uniform(stream) * task.radii.size), task.radii.size - 1)]
    turned = math.pi if task.can_reverse and uniform(stream) < 0.5 else 0.0
    node = nearest(tree, x, y, radius, turned)
    if node < 0:
        return node, 0
    from_x, from_y, direction = tree.x[node], tree.y[node], tree.tangent[node] + turned
    if task.pivot_rate < np.inf and uniform(stream) < 0.5:
        way.curvature[:2], way.pivot[1], way.length[0] = 0.0, 0.0, 0.0
        way.pivot[0] = wrapped(math.atan2(y - from_y, x - from_x) - direction)
        way.length[1], count = math.hypot(x - from_x, y - from_y), 2
    else:
        local_x, local_y, _ = seen_from(from_x, from_y, direction, x, y, 0.0, radius)
        count = arc_to_point(local_x, local_y, radius, way) if uniform(stream) < ARC_SHARE else 0
        if count == 0:
            count = way_to_point(local_x, local_y, radius, way)
    if turned > 0.0:
        for i in range(count):
            way.curvature[i], way.length[i] = -way.curvature[i], -way.length[i]
    return node, count


@kernel
def _cut(task: Task, tree: Tree, node: int, way: Way, count: int, reach: float) -> tuple[float, int]:
    """Shorten pieces from a node to what is free and to a length in all; that length and what is left of the pieces."""
    x, y, tangent = tree.x[node], tree.y[node], tree.tangent[node]
    total = 0.0
    for i in range(count):
        if way.pivot[i] != 0.0 and not pivot_is_free(task, x, y, tangent, way.pivot[i]):
            return total, i
        wanted = min(abs(way.length[i]), reach - total)
        sense = 1.0 if way.length[i] >= 0.0 else -1.0
        free = free_length(task, x, y, tangent + way.pivot[i], way.curvature[i], sense * wanted)
        length = wanted if free >= wanted else (1.0 - KEPT_BACK) * free
        way.length[i] = sense * length
        total += length
        if free < wanted or total >= reach:
            return total, i + 1
        x, y, tangent = advanced(x, y, tangent, way.curvature[i], way.length[i])
        tangent += way.pivot[i]
    return total, count


@kernel
def extend(task: Task, tree: Tree, growth: Growth, x: float, y: float) -> int:
    """Add a node on the way from the nearest one to a point; -1 if there is no way."""
    node, count = _aim(task, tree, growth, x, y)
    if count == 0:
        return -1
    length, count = _cut(task, tree, node, growth.way, count, growth.reach)
    if length < SHORTEST * task.radii[0]:
        return -1
    start = tree.x[node], tree.y[node], tree.tangent[node]
    cost = way_cost(task, start[0], start[1], start[2], tree.gear[node], growth.way, count, np.inf)
    if not tree.cost[node] + cost < growth.bound[0]:
        return -1
    added = add_node(tree, node, growth.way, count, cost)
    if added > 0:
        _advance(task, tree, growth, added)
    return added


@inlined
def least_cost(task: Task, tree: Tree, growth: Growth, node: int) -> float:
    """Bound of the cost from start to goal past a node: straight on from there."""
    goal = growth.surest.route
    distance = max(0.0, math.hypot(goal[0] - tree.x[node], goal[1] - tree.y[node]) - growth.slack)
    return float(tree.cost[node] + distance * task.least_rate)


@kernel
def shoot(task: Task, tree: Tree, growth: Growth, node: int) -> bool:
    """Connect a node to an end exactly, if that makes a better solution: by the smallest radius and another one."""
    found = False
    start = tree.x[node], tree.y[node], tree.tangent[node], tree.gear[node]
    other = task.radii[1 + int(uniform(growth.stream) * (task.radii.size - 1))]
    for radius in (task.radii[0], other):
        bound = min(growth.best[0], growth.bound[0]) - tree.cost[node]
        if not is_exact(growth.target):
            draw_end(task, growth.target, growth.surest, growth.stream, growth.aimed)
        goal = growth.aimed.route[0], growth.aimed.route[1], growth.aimed.route[2]
        cost, count = connect(task, start, goal, radius, bound, growth.shot)
        if cost < bound:
            found = True
            growth.best[0] = tree.cost[node] + cost
            growth.last[0], growth.last[1] = node, count
            copy_end(growth.aimed, growth.end)
            for i in range(count):
                growth.solution.curvature[i] = growth.shot.curvature[i]
                growth.solution.length[i] = growth.shot.length[i]
                growth.solution.pivot[i] = growth.shot.pivot[i]
    return found


@kernel
def grow(task: Task, tree: Tree, growth: Growth, iterations: int) -> tuple[int, bool]:
    """Grow the tree until there is a better solution.

    Returns
    -------
    tuple
        Iterations done, and whether the last one found a better solution.
    """
    task = lent_task(task)
    if tree.size[0] == 1 and growth.bound[0] == np.inf and shoot(task, tree, growth, tree.size[0] - 1):
        return 1, True
    for iteration in range(iterations):
        x, y = _draw_point(task, tree, growth)
        node = extend(task, tree, growth, x, y)
        if node < 0:
            continue
        if least_cost(task, tree, growth, node) >= growth.bound[0]:
            tree.size[0] -= 1
        elif shoot(task, tree, growth, node):
            return iteration + 1, True
    return iterations, False
