"""Footprint of a vehicle as a collision check reads it: convex parts, and discs that cover them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Discs to a convex part, at most: more of them answer no faster.
MOST_DISCS = 4


class Footprint(NamedTuple):
    """Convex parts of a polygon in the body's frame, for kernels; its origin is the mass centre.

    Attributes
    ----------
    vertices
        Of all parts, counter-clockwise, shape (n_vertices, 2). [m]
    edges
        From each vertex to the next of its part: outward normal x, y [-] and offset [m]; inside is
        normal . p <= offset. Shape (n_vertices, 3).
    first
        Index of each part's first vertex, and the number of vertices; shape (n_parts + 1,).
    discs
        Centre x, y and radius; together they cover the polygon. Shape (n_discs, 3). [m]
    reach
        From the mass centre to the farthest vertex. [m]
    """

    vertices: Array
    edges: Array
    first: NDArray[np.int64]
    discs: Array
    reach: float


def footprint_of(polygon: Array) -> Footprint:
    """Cut a polygon into convex parts, unless it is convex.

    Parameters
    ----------
    polygon : ndarray, shape (n, 2)
        Simple, in either sense of rotation, about the mass centre. [m]
    """
    outline = counter_clockwise(np.asarray(polygon, dtype=np.float64))
    parts = [outline] if _is_convex(outline) else _triangles(outline)
    return Footprint(
        vertices=np.concatenate(parts),
        edges=np.concatenate([_edges(part) for part in parts]),
        first=np.cumsum([0, *map(len, parts)]),
        discs=np.concatenate([_covering_discs(part) for part in parts]),
        reach=float(np.hypot(*outline.T).max()),
    )


def counter_clockwise(polygon: Array) -> Array:
    """The polygon, its vertices turned round if they run clockwise."""
    x, y = polygon.T
    twice_area = float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))
    return polygon if twice_area > 0.0 else polygon[::-1]


def _corners(polygon: Array) -> Array:
    """Cross product of the edges before and after each vertex: negative where it is re-entrant."""
    before, after = polygon - np.roll(polygon, 1, axis=0), np.roll(polygon, -1, axis=0) - polygon
    return before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]


def _is_convex(polygon: Array) -> bool:
    return bool((_corners(polygon) >= 0.0).all())


def _triangles(polygon: Array) -> list[Array]:
    """Cut off ears, one after the other."""
    rest, triangles = polygon, []
    while len(rest) > 3:
        ear = next(index for index in np.argsort(-_corners(rest)) if _is_ear(rest, int(index)))
        triangles.append(rest.take(range(ear - 1, ear + 2), axis=0, mode="wrap"))
        rest = np.delete(rest, ear, axis=0)
    return [triangle for triangle in (*triangles, rest) if _corners(triangle)[0] > 0.0]


def _is_ear(polygon: Array, index: int) -> bool:
    """Whether the vertex and its neighbours span a triangle with no other vertex in it."""
    triangle = polygon.take(range(index - 1, index + 2), axis=0, mode="wrap")
    others = np.array([p for p in polygon if not (p == triangle).all(axis=1).any()]).reshape(-1, 2)
    edges = _edges(triangle)
    outside = (others @ edges[:, :2].T > edges[:, 2]).any(axis=1)
    return bool(_corners(polygon)[index] >= 0.0 and outside.all())


def _edges(part: Array) -> Array:
    along = np.roll(part, -1, axis=0) - part
    normals = np.stack((along[:, 1], -along[:, 0]), axis=1) / np.hypot(*along.T)[:, None]
    return np.column_stack((normals, (normals * part).sum(axis=1)))


def _covering_discs(part: Array) -> Array:
    """Discs around equal slices of the part's bounding box, cut across its longer side."""
    low, high = part.min(axis=0), part.max(axis=0)
    sides = high - low
    longer = int(np.argmax(sides))
    count = min(MOST_DISCS, max(1, round(2.0 * sides[longer] / max(sides[1 - longer], 1e-9))))
    slice_length = sides[longer] / count
    centres = np.tile(0.5 * (low + high), (count, 1))
    centres[:, longer] = low[longer] + slice_length * (np.arange(count) + 0.5)
    radius = 0.5 * math.hypot(slice_length, sides[1 - longer])
    return np.column_stack((centres, np.full(count, radius)))
