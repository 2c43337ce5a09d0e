"""Families of trajectories from a pose to a point: C (an arc), CS (an arc, a straight) and CC (two opposite arcs).

They span the trajectory parameter space of Blanco, Bellone, Gimenez-Fernandez, TP-space RRT, 2015,
doi:10.5772/59908: the shape is the arc's curvature (C) or angle (CS, CC), the other parameter the length. A point is
mapped back to them in closed form, so no grid of shapes is needed: obstacles cut the one member that is asked for.
"""

from __future__ import annotations

import math

import numpy as np

from trackctl.compiled import kernel
from trackctl.planning.dubins import seen_from
from trackctl.planning.pieces import Way

FULL_CIRCLE = 2.0 * math.pi
#: Below this offset to the side, over the distance, a point lies straight ahead.
STRAIGHT = 1e-9


@kernel
def _turned(angle: float) -> float:
    """The angle's equal in [0, 2 pi). [rad]"""
    return angle - FULL_CIRCLE * math.floor(angle / FULL_CIRCLE)


@kernel
def single_arc(x: float, y: float) -> tuple[float, float]:
    """Curvature and length of the arc through the origin, along x there, and a point. [1/m], [m]"""
    squared = x * x + y * y
    curvature = 2.0 * y / squared
    if abs(y) < STRAIGHT * abs(x):
        return 0.0, x
    return curvature, 2.0 * math.atan2(y, x) / curvature


@kernel
def arc_and_straight(x: float, y: float, side: float) -> tuple[float, float]:
    """Turned angle and length of the straight to a point, lengths in radii; infinite inside the turning circle.

    Parameters
    ----------
    x, y
        The point in the pose's frame, in turning radii.
    side
        1 for a left turn, -1 for a right turn.
    """
    squared = x * x + (y - side) * (y - side) - 1.0
    if squared < 0.0:
        return np.inf, np.inf
    straight = math.sqrt(squared)
    heading = math.atan2(y - side, x) + side * math.atan2(1.0, straight)
    return _turned(side * heading), straight


@kernel
def two_arcs(x: float, y: float, side: float) -> tuple[float, float]:
    """Angles of an arc and an opposite one to a point; infinite where it is out of reach.

    The second circle touches the first and goes through the point: its centre is two radii from the first's and one
    from the point. Of the two such circles the one with the shorter way counts.

    Parameters
    ----------
    x, y
        The point in the pose's frame, in turning radii.
    side
        1: left, then right; -1: right, then left.
    """
    across = y - side
    distance = math.hypot(x, across)
    if distance > 3.0 or distance < 1.0:
        return np.inf, np.inf
    bearing = math.atan2(across, x)
    opening = math.acos((distance * distance + 3.0) / (4.0 * distance))
    best, found = np.inf, (np.inf, np.inf)
    for sign in (-1.0, 1.0):
        towards = bearing + sign * opening
        first = _turned(side * towards + 0.5 * math.pi)
        centre_x, centre_y = 2.0 * math.cos(towards), side + 2.0 * math.sin(towards)
        last = _turned(side * (towards + math.pi - math.atan2(y - centre_y, x - centre_x)))
        if first + last < best:
            best, found = first + last, (first, last)
    return found


@kernel
def arc_to_point(local_x: float, local_y: float, radius: float, way: Way) -> int:
    """The member of C to a point seen in turning radii, if that is not too tight; the number of pieces."""
    if local_x * local_x + local_y * local_y == 0.0:
        return 0
    curvature, length = single_arc(local_x, local_y)
    if abs(curvature) > 1.0:
        return 0
    way.curvature[0], way.length[0], way.pivot[0] = curvature / radius, length * radius, 0.0
    return 1


@kernel
def way_to_point(local_x: float, local_y: float, radius: float, way: Way) -> int:
    """The shortest of CS and CC to a point.

    Parameters
    ----------
    local_x, local_y
        The point seen from the start, in turning radii.
    radius
        [m]
    way
        Is given the pieces.

    Returns
    -------
    int
        Their number, 0 where no member leads to the point.
    """
    shortest, count = np.inf, 0
    way.pivot[:2] = 0.0
    for side in (-1.0, 1.0):
        first, straight = arc_and_straight(local_x, local_y, side)
        if first + straight < shortest:
            shortest, count = first + straight, 2
            way.curvature[0], way.length[0] = side / radius, first * radius
            way.curvature[1], way.length[1] = 0.0, straight * radius
        first, last = two_arcs(local_x, local_y, side)
        if first + last < shortest:
            shortest, count = first + last, 2
            way.curvature[0], way.length[0] = side / radius, first * radius
            way.curvature[1], way.length[1] = -side / radius, last * radius
    return count


@kernel
def distance_to_point(x: float, y: float, tangent: float, point_x: float, point_y: float, radius: float) -> float:
    """Length of the shortest of CS and CC to a point. [m]"""
    local_x, local_y, _ = seen_from(x, y, tangent, point_x, point_y, 0.0, radius)
    side = 1.0 if local_y >= 0.0 else -1.0
    first, straight = arc_and_straight(local_x, local_y, side)
    if straight < np.inf:
        return (first + straight) * radius
    first, last = two_arcs(local_x, local_y, -side)
    return (first + last) * radius
