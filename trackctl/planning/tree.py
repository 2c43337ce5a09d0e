"""Tree of poses that a search grows, as arrays that kernels fill."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel
from trackctl.planning.families import distance_to_point
from trackctl.planning.pieces import MOST_PIECES, Way, gear_of
from trackctl.planning.pose import advanced

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


class Tree(NamedTuple):
    """Poses and the pieces that lead to each from its parent; node 0 is the start.

    Attributes
    ----------
    x, y, tangent
        Of the nodes, shape (n,). [m], [rad]
    cost
        From the start, shape (n,).
    gear
        That a node is reached in: 1, -1, or 0 at the start.
    parent
        Index, -1 for the start.
    pieces
        Arrays of shape (n, MOST_PIECES), the first `piece_count` of each row used.
    piece_count
        Of each row.
    size
        Number of nodes, shape (1,).
    """

    x: Array
    y: Array
    tangent: Array
    cost: Array
    gear: Indices
    parent: Indices
    pieces: Way
    piece_count: Indices
    size: Indices


def new_tree(capacity: int, start: tuple[float, float, float]) -> Tree:
    """A tree of the start alone."""
    x, y, tangent, cost = (np.zeros(capacity) for _ in range(4))
    gear, parent, piece_count = (np.zeros(capacity, np.int64) for _ in range(3))
    pieces = Way(*(np.zeros((capacity, MOST_PIECES)) for _ in range(3)))
    tree = Tree(x, y, tangent, cost, gear, parent, pieces, piece_count, np.ones(1, np.int64))
    tree.x[0], tree.y[0], tree.tangent[0] = start
    tree.parent[0] = -1
    return tree


@kernel
def add_node(tree: Tree, parent: int, way: Way, count: int, cost: float) -> int:
    """Append a node at the end of some pieces; -1 if the tree is full."""
    node = int(tree.size[0])
    if node == tree.x.size:
        return -1
    x, y, tangent, gear = tree.x[parent], tree.y[parent], tree.tangent[parent], tree.gear[parent]
    for i in range(count):
        x, y, tangent = advanced(x, y, tangent, way.curvature[i], way.length[i])
        tangent += way.pivot[i]
        gear = gear_of(way.length[i], gear)
    tree.x[node], tree.y[node], tree.tangent[node], tree.gear[node] = x, y, tangent, gear
    set_parent(tree, node, parent, way, count, cost)
    tree.size[0] += 1
    return node


@kernel
def set_parent(tree: Tree, node: int, parent: int, way: Way, count: int, cost: float) -> None:
    """Let a node be reached from another by some pieces."""
    tree.parent[node], tree.piece_count[node] = parent, count
    tree.cost[node] = tree.cost[parent] + cost
    for i in range(count):
        tree.pieces.curvature[node, i] = way.curvature[i]
        tree.pieces.length[node, i] = way.length[i]
        tree.pieces.pivot[node, i] = way.pivot[i]


@kernel
def nearest(tree: Tree, x: float, y: float, radius: float, turned: float) -> int:
    """The node from which the families lead to a point on the shortest way; -1 if from none.

    Parameters
    ----------
    tree
        Of the nodes.
    x, y
        Of the point. [m]
    radius
        Of the turns. [m]
    turned
        From a node's tangent to the direction of travel: 0 or, backwards, pi. [rad]
    """
    best, found = np.inf, -1
    for node in range(tree.size[0]):
        dx, dy = x - tree.x[node], y - tree.y[node]
        if dx * dx + dy * dy < best * best:
            length = distance_to_point(tree.x[node], tree.y[node], tree.tangent[node] + turned, x, y, radius)
            if length < best:
                best, found = length, node
    return found
