"""Shape functions on one axis of a table: how much each of four neighbouring nodes counts at a point.

On a grid, with a basis and a weight that are products over the axes, moving least squares is the product of
one-dimensional moving least squares. So each method is a set of shape functions on one axis: in the cell from
node 1 to node 2, with t in [0, 1] along it, nodes 0 to 3 count.
"""

from __future__ import annotations

import math
from enum import StrEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import inlined, kernel
from trackctl.lut.axes import FULL_CIRCLE, Array, Axes

Indices = NDArray[np.int64]
#: Unsigned, since compiled code tests signed ones for being negative at each use.
Offsets = NDArray[np.uint64]
Flags = NDArray[np.bool_]
Weights = tuple[float, float, float, float]

#: A point this close to a node, in cells, is at the node: far above rounding, far below a table's error.
SNAP = 1e-9
MOST_BUCKETS = 4096

# Plain numbers: what a compiled kernel compares with an array's entries.
ALL_NODES, NONE_BEFORE, NONE_AFTER, PAIR = range(4)
MLS, LINEAR, CUBIC = range(3)


class Method(StrEnum):
    """How values between nodes are found."""

    MLS = "mls"
    LINEAR = "linear"
    CUBIC = "cubic"

    @property
    def code(self) -> int:
        """The number that kernels know it by."""
        return {Method.MLS: MLS, Method.LINEAR: LINEAR, Method.CUBIC: CUBIC}[self]


class Stencils(NamedTuple):
    """The four nodes about each cell of one axis (a named tuple, since kernels take no dataclass).

    Attributes
    ----------
    lower, upper
        The range of the axis, with `SNAP` of a cell beyond its ends.
    first, buckets_per_unit
        Even buckets start at the first node; there are as many to a unit of the axis.
    cell_of_bucket
        The cell in which each bucket starts, shape (n_buckets,).
    nodes
        Coordinates, shape (n_cells, 4); those of missing nodes are made up and have no effect.
    offset
        What each node adds to the number of a table's cell, shape (n_cells, 4); for missing nodes that of the
        nearest.
    factors
        Of each node, 1 / product of its distances to the three others, shape (n_cells, 4).
    extent
        Which of the nodes there are, shape (n_cells,).
    """

    lower: float
    upper: float
    first: float
    buckets_per_unit: float
    cell_of_bucket: Indices
    nodes: Array
    offset: Offsets
    factors: Array
    extent: Indices


def axis_stencils(axes: Axes) -> tuple[Stencils, Stencils, Stencils, Stencils]:
    """Stencils along slope, velocity, curvature and heading, heading innermost in the numbering of cells.

    None reaches across straight driving: sideslip bends sharply there, and a table of left turns ends there.
    """
    _, velocities, curvatures, headings = axes.shape
    return (
        stencils(axes.slope, headings * curvatures * velocities),
        stencils(axes.velocity, headings * curvatures),
        stencils(axes.curvature, headings, bend=0.0),
        stencils(axes.heading, 1, period=FULL_CIRCLE if axes.heading_is_periodic else None),
    )


def stencils(nodes: Array, stride: int, period: float | None = None, bend: float | None = None) -> Stencils:
    """Stencils of one axis.

    Parameters
    ----------
    nodes
        Ascending, shape (n_nodes,).
    stride
        From one node to the next in the numbering of a table's cells.
    period
        Distance after which the nodes repeat, if they do.
    bend
        A node that no stencil reaches across.
    """
    if nodes.size == 1:
        return _lone_node(float(nodes[0]))
    borders = nodes if period is None else np.append(nodes, nodes[0] + period)
    cells = np.arange(borders.size - 1)
    inner = nodes.size > 2
    wraps = period is not None
    has_before = inner & (wraps | (cells > 0)) & (borders[:-1] != bend)
    has_after = inner & (wraps | (cells < cells[-1])) & (borders[1:] != bend)

    width = np.diff(borders)
    before = borders[:-1] - np.where(has_before, np.roll(width, 1), width)
    after = borders[1:] + np.where(has_after, np.roll(width, -1), width)
    coordinates = np.stack([before, borders[:-1], borders[1:], after], axis=1)
    numbers = np.stack([cells - has_before, cells, cells + 1, cells + 1 + has_after], axis=1) % nodes.size
    extent = np.select([has_before & has_after, has_after, has_before], [ALL_NODES, NONE_BEFORE, NONE_AFTER], PAIR)
    return _with_search(borders, coordinates, (numbers * stride).astype(np.uint64), extent)


def _lone_node(node: float) -> Stencils:
    """An axis of one node, which a point must meet."""
    width = 2.0 * abs(node) or 1.0
    coordinates = node + width * np.array([[-1.0, 0.0, 1.0, 2.0]])
    cell = _with_search(coordinates[0, 1:3], coordinates, np.zeros((1, 4), np.uint64), np.array([PAIR]))
    return cell._replace(lower=node - SNAP * abs(node), upper=node + SNAP * abs(node))


def _with_search(borders: Array, coordinates: Array, offset: Offsets, extent: Indices) -> Stencils:
    """Complete stencils by the search for a point's cell and by the nodes' factors."""
    width = np.diff(borders)
    first, span = float(borders[0]), float(borders[-1] - borders[0])
    bucket_count = min(math.ceil(span / width.min() - SNAP), MOST_BUCKETS)
    starts = first + span / bucket_count * np.arange(bucket_count)
    cell_of_bucket = np.clip(np.searchsorted(borders, starts, side="right") - 1, 0, width.size - 1)
    distance = coordinates[:, :, None] - coordinates[:, None, :] + np.eye(4)
    factors = 1.0 / np.prod(distance, axis=2)
    # Kernels are compiled for read-only arrays and writable ones apart.
    for array in (cell_of_bucket, coordinates, offset, factors, extent):
        array.setflags(write=False)
    return Stencils(
        lower=first - SNAP * float(width[0]),
        upper=first + span + SNAP * float(width[-1]),
        first=first,
        buckets_per_unit=bucket_count / span,
        cell_of_bucket=cell_of_bucket,
        nodes=coordinates,
        offset=offset,
        factors=factors,
        extent=extent,
    )


@kernel
def weigh(stencils: Stencils, method: int, points: Array, weights: Array, offset: Offsets, inside: Flags) -> None:
    """Weights and offsets of the four nodes at many points of one axis.

    Parameters
    ----------
    stencils
        Of the axis.
    method
        Its code.
    points
        Coordinates, shape (n_points,).
    weights, offset
        Results, shape (n_points, 4).
    inside
        Set to False for points outside the axis, shape (n_points,).
    """
    # Taken apart once: an array taken from a tuple counts references, which costs more than the arithmetic.
    lower, upper, first, buckets_per_unit, cell_of_bucket, nodes, offsets, factors, extents = stencils
    for point in range(points.size):
        x = points[point]
        if not lower <= x <= upper:
            inside[point] = False
            continue
        cell = cell_of_bucket[min(int((x - first) * buckets_per_unit), cell_of_bucket.size - 1)]
        while cell + 1 < extents.size and x >= nodes[cell, 2]:
            cell += 1
        four_weights = shape_functions(method, extents[cell], x, four(nodes, cell), four(factors, cell))
        for node in range(4):
            weights[point, node] = four_weights[node]
            offset[point, node] = offsets[cell, node]


@kernel
def shape_functions(method: int, extent: int, x: float, nodes: Weights, factors: Weights) -> Weights:
    """Weights of the four nodes of a cell at x; exactly 0 for nodes that do not count.

    With a_k the factor of node k and c_k the product of the distances from x to the other nodes, a_k c_k are
    Lagrange's cubics, and a_k (c_k - c_j) the parabola that omits node j.
    """
    x0, x1, x2, x3 = nodes
    a0, a1, a2, a3 = factors
    t = (x - x1) / (x2 - x1)
    if t < SNAP:
        return 0.0, 1.0, 0.0, 0.0
    if t > 1.0 - SNAP:
        return 0.0, 0.0, 1.0, 0.0
    if method == LINEAR or extent == PAIR:
        return 0.0, 1.0 - t, t, 0.0
    left, right = (x - x0) * (x - x1), (x - x2) * (x - x3)
    c0, c1, c2, c3 = (x - x1) * right, (x - x0) * right, left * (x - x3), left * (x - x2)
    if extent == NONE_BEFORE:
        return 0.0, a1 * (c1 - c0), a2 * (c2 - c0), a3 * (c3 - c0)
    if extent == NONE_AFTER:
        return a0 * (c0 - c3), a1 * (c1 - c3), a2 * (c2 - c3), 0.0
    mean = 0.0 if method == CUBIC else omission_mean(t, factors, (c0, c1, c2, c3))
    return a0 * (c0 - mean), a1 * (c1 - mean), a2 * (c2 - mean), a3 * (c3 - mean)


@inlined
def four(rows: Array, row: int) -> Weights:
    """One row of four, as numbers."""
    return rows[row, 0], rows[row, 1], rows[row, 2], rows[row, 3]


@inlined
def omission_mean(t: float, a: Weights, c: Weights) -> float:
    """Mean of c over the parabolas that each omit one node, as moving least squares weighs them.

    Four data leave a quadratic least-squares fit one residual, so the fit is the mean of the four parabolas
    through three nodes each, the one omitting node k weighted by a_k^2 / w_k. Here the weight of a node d
    cells away is w = ((2 - d) / d)^2: singular at 0, so that nodes are met exactly, and 0 at 2, where nodes
    come and go. The common factor t (1 - t) (1 + t) (2 - t) keeps all terms finite.
    """
    s, p, q = 1.0 - t, 1.0 + t, 2.0 - t
    e0 = (a[0] * t * p * p * q) ** 2
    e1 = (a[1] * t * t * s * p) ** 2
    e2 = (a[2] * s * s * t * q) ** 2
    e3 = (a[3] * s * q * q * p) ** 2
    return (e0 * c[0] + e1 * c[1] + e2 * c[2] + e3 * c[3]) / (e0 + e1 + e2 + e3)
