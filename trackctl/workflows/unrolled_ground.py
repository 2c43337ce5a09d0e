"""Ground of changing slope under a plan, unrolled along it into a plane, and back to the map.

A simulation runs in a plane. Along a plan the ground is unrolled, with its slope at each nominal time: what a vehicle
that has left the plan stands on is taken to be the ground under the plan, which holds as far as the slope changes
little over the deviation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackctl.planning.surface_line import on_map
from trackctl.simulation.slopes import Slopes

Array = NDArray[np.float64]

#: Slopes and directions of up-slope that differ by less are one. [rad]
SAME = 1e-7


@dataclass(frozen=True, slots=True, eq=False)
class PlannedGround:
    """A plan and the slope under it, arrays of shape (n,).

    Attributes
    ----------
    time
        Ascending. [s]
    x, y, yaw
        On the map, the yaw without jumps. [m], [rad]
    velocity
        Negative backwards. [m/s]
    curvature
        In the plane of the ground: turn per metre travelled forwards. [1/m]
    slope, heading
        Of the ground; from up-slope to the body, in its plane. [rad]
    sideslip
        In its plane. [rad]
    """

    time: Array
    x: Array
    y: Array
    yaw: Array
    velocity: Array
    curvature: Array
    slope: Array
    heading: Array
    sideslip: Array

    @property
    def is_plane(self) -> bool:
        """Whether it is all one plane, in which x and y lie."""
        turned = np.mod(self.yaw - self.heading - (self.yaw[0] - self.heading[0]) + np.pi, 2.0 * np.pi) - np.pi
        level = self.slope.max() < SAME
        return bool(np.ptp(self.slope) < SAME and (level or np.abs(turned).max() < SAME))


@dataclass(frozen=True, slots=True, eq=False)
class Unrolled:
    """A plan in the unrolled plane, and what leads back from there; arrays of shape (n,).

    Attributes
    ----------
    ground
        The plan on the map.
    x, y, yaw
        In the unrolled plane, as on the map at the start. [m], [rad]
    slopes
        Over time.
    map_uphill
        Direction of up-slope on the map. [rad]
    """

    ground: PlannedGround
    x: Array
    y: Array
    yaw: Array
    slopes: Slopes
    map_uphill: Array

    def to_map(self, time: Array, x: Array, y: Array, yaw: Array) -> tuple[Array, Array, Array]:
        """Poses of the unrolled plane at some times, on the map."""
        at = {
            name: np.interp(time, self.slopes.time, values)
            for name, values in {
                "x": self.x,
                "y": self.y,
                "map_x": self.ground.x,
                "map_y": self.ground.y,
                "slope": self.slopes.slope,
                "uphill": self.slopes.uphill_yaw,
                "map_uphill": self.map_uphill,
            }.items()
        }
        off_x, off_y = x - at["x"], y - at["y"]
        cos, sin = np.cos(at["uphill"]), np.sin(at["uphill"])
        up, left = (cos * off_x + sin * off_y) * np.cos(at["slope"]), cos * off_y - sin * off_x
        map_cos, map_sin = np.cos(at["map_uphill"]), np.sin(at["map_uphill"])
        angle = yaw - at["uphill"]
        turned = at["map_uphill"] + angle + wrapped(on_map(angle, at["slope"]) - angle)
        return at["map_x"] + map_cos * up - map_sin * left, at["map_y"] + map_sin * up + map_cos * left, turned


def wrapped(angle: Array) -> Array:
    """Angles between -pi and pi. [rad]"""
    return np.asarray(np.mod(angle + np.pi, 2.0 * np.pi) - np.pi)


def unrolled(ground: PlannedGround) -> Unrolled:
    """Unroll the ground along a plan.

    Up-slope turns by what the path turns in the plane of the ground, less what it turns from up-slope. Where the
    vehicle changes its direction, and its sideslip at once, up-slope turns as on the map.
    """
    heading = np.unwrap(ground.heading)
    map_uphill = np.unwrap(ground.yaw - on_map(heading, ground.slope))
    step = np.diff(ground.time)
    way = 0.5 * (ground.velocity[1:] + ground.velocity[:-1]) * step
    turned = 0.5 * (ground.curvature[1:] + ground.curvature[:-1]) * way
    change = turned - np.diff(heading + ground.sideslip)
    at_rest = ground.velocity == 0.0
    change = np.where(at_rest[:-1], np.diff(map_uphill), change)
    uphill = map_uphill[0] + np.concatenate(([0.0], np.cumsum(change)))
    yaw = uphill + heading
    tangent = yaw + ground.sideslip
    middle = 0.5 * (tangent[1:] + tangent[:-1])
    chord = way * np.sinc(0.5 * turned / np.pi)
    x = ground.x[0] + np.concatenate(([0.0], np.cumsum(chord * np.cos(middle))))
    y = ground.y[0] + np.concatenate(([0.0], np.cumsum(chord * np.sin(middle))))
    return Unrolled(ground, x, y, yaw, Slopes(ground.time, ground.slope, uphill), map_uphill)
