"""A line on the map laid on the ground: slope along it, and its way in the plane of the ground.

On an elevation grid x and y are horizontal. Along a line the ground is unrolled into a plane, where lengths and turns
are those that the vehicle drives: arc length on the ground, and geodesic curvature, the turn about the ground's normal.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel
from trackctl.planning.ground import Ground, Motion, rate_at
from trackctl.planning.slope_field import SlopeField, gradient_at

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceLine:
    """Samples of a line on the ground, arrays of shape (n,).

    Attributes
    ----------
    arc_length
        On the ground. [m]
    direction
        Of travel in the unrolled plane, at first that on the map. [rad]
    curvature
        In the ground's plane, left positive. [1/m]
    slope
        Angle of the ground. [rad]
    uphill
        Direction of up-slope in the unrolled plane, without jumps. [rad]
    map_uphill
        The same on the map. [rad]
    """

    arc_length: Array
    direction: Array
    curvature: Array
    slope: Array
    uphill: Array
    map_uphill: Array


@kernel
def gradients_along(field: SlopeField, x: Array, y: Array) -> tuple[Array, Array]:
    """Derivatives of the height at points of the map."""
    along_x, along_y = np.empty(x.size), np.empty(x.size)
    for i in range(x.size):
        along_x[i], along_y[i] = gradient_at(field, x[i], y[i])
    return along_x, along_y


def slope_and_uphill(field: SlopeField, gradient_x: Array, gradient_y: Array) -> tuple[Array, Array]:
    """Angle of the slope and direction of up-slope on the map of gradients of the height. [rad]"""
    steepness = np.hypot(gradient_x, gradient_y)
    uphill = np.where(steepness == 0.0, field.level_uphill, np.arctan2(gradient_y, gradient_x))
    return np.arctan(steepness), uphill


def is_plane(field: SlopeField) -> bool:
    """Whether a slope is one everywhere; x and y then lie in its plane."""
    return field.gradient_x.size == 1


def on_ground(angle: Array, slope: Array) -> Array:
    """Angle from up-slope in the ground's plane, of one on the map: what leads uphill is longer by 1/cos(slope)."""
    return np.asarray(np.arctan2(np.sin(angle) * np.cos(slope), np.cos(angle)))


def on_map(angle: Array, slope: Array) -> Array:
    """The inverse of `on_ground`."""
    return np.asarray(np.arctan2(np.sin(angle), np.cos(angle) * np.cos(slope)))


def integral(values: Array, places: Array) -> Array:
    """Integral from the first of some places to each, by the trapezoidal rule."""
    return np.concatenate(([0.0], np.cumsum(np.diff(places) * (values[1:] + values[:-1]) / 2.0)))


def surface_line(
    field: SlopeField, arc_length: Array, pose: tuple[Array, Array, Array], curvature: Array
) -> SurfaceLine:
    """Lay a line of the map on the ground.

    Parameters
    ----------
    field
        The slope, known all along.
    arc_length
        Of the samples on the map, even but for rounding. [m]
    pose
        x, y [m] and direction of travel [rad] there.
    curvature
        On the map. [1/m]
    """
    x, y, direction = pose
    g_x, g_y = gradients_along(field, np.ascontiguousarray(x), np.ascontiguousarray(y))
    slope, map_uphill = slope_and_uphill(field, g_x, g_y)
    map_uphill = np.unwrap(map_uphill)
    if is_plane(field):
        return SurfaceLine(arc_length, direction, curvature, slope, map_uphill, map_uphill)
    rise = g_x * np.cos(direction) + g_y * np.sin(direction)
    stretch = np.sqrt(1.0 + rise**2)
    length = arc_length[0] + integral(stretch, arc_length)
    tangent = np.stack((np.cos(direction), np.sin(direction), rise)) / stretch
    normal = np.stack((-g_x, -g_y, np.ones_like(g_x))) * np.cos(slope)
    bend = np.gradient(tangent, length, axis=1)
    geodesic = np.einsum("in,in->n", normal, np.cross(tangent, bend, axis=0))
    unrolled = direction[0] + integral(geodesic, length)
    uphill = unrolled - on_ground(direction - map_uphill, slope)
    return SurfaceLine(length, unrolled, geodesic, slope, np.unwrap(uphill), map_uphill)


@kernel
def rates_along(
    ground: Ground, motion: Motion, x: Array, y: Array, tangent: Array, curvature: Array
) -> tuple[Array, Array]:
    """`rate_at` at the samples of a path, arrays of shape (n,)."""
    rate, sideslip = np.empty(x.size), np.empty(x.size)
    for i in range(x.size):
        rate[i], sideslip[i] = rate_at(ground, motion, x[i], y[i], tangent[i], curvature[i])
    return rate, sideslip
