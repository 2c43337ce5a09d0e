"""Maps, vehicles and independent checks that the tests of planning share."""

from __future__ import annotations

import math

import numpy as np
from scipy import ndimage

from trackctl.planning.collision_grid import CollisionGrid
from trackctl.planning.search import Problem
from trackctl.planning.slope_field import SlopeField
from trackctl.planning.steering_limits import SteeringLimits

RECTANGLE = np.array([[0.5, 0.35], [-0.5, 0.35], [-0.5, -0.35], [0.5, -0.35]])
RADIUS = 1.5


def grid_of(blocked, resolution=0.1, x=0.0, y=0.0, yaw=0.0):
    walled = np.pad(np.asarray(blocked, bool), 1, constant_values=True)
    distance = ndimage.distance_transform_edt(~walled)[1:-1, 1:-1] * resolution
    return CollisionGrid(walled[1:-1, 1:-1], distance, resolution, x, y, math.cos(yaw), math.sin(yaw))


def plane(slope=0.0, uphill=0.5 * math.pi):
    steepness = math.tan(slope)
    return SlopeField(
        np.array([[steepness * math.cos(uphill)]]), np.array([[steepness * math.sin(uphill)]]), 1.0, 1.0, 0.0, 0.0
    )


def level_limits(radius=RADIUS, speed=1.0):
    ones = np.ones((1, 3, 1))
    return SteeringLimits(
        np.zeros(1), np.array([-1.0, 0.0, 1.0]) / radius, np.zeros(1), speed * ones, 0.0 * ones, 0.0 * ones, ones
    )


def level_problem(blocked, start, goal, resolution=0.1, **others):
    return Problem(grid_of(blocked, resolution), plane(), RECTANGLE, start, goal, level_limits(), **others)


def driven(start, pieces, step=0.02):
    """Poses along pieces (curvature, length, pivot), by formulas other than the package's; shape (n, 3)."""
    poses = [tuple(start)]
    for curvature, length, pivot in pieces:
        x, y, tangent = poses[-1]
        for share in np.linspace(0.0, 1.0, max(2, math.ceil(abs(length) / step) + 1))[1:]:
            at = length * share
            if curvature == 0.0:
                poses.append((x + at * math.cos(tangent), y + at * math.sin(tangent), tangent))
            else:
                turned = tangent + curvature * at
                dx, dy = math.sin(turned) - math.sin(tangent), math.cos(tangent) - math.cos(turned)
                poses.append((x + dx / curvature, y + dy / curvature, turned))
        x, y, tangent = poses[-1]
        turns = math.ceil(abs(pivot) / 0.05)
        poses.extend((x, y, tangent + pivot * (k + 1) / turns) for k in range(turns))
    return np.array(poses)


def route_poses(route, step=0.02):
    return driven(route.start, zip(route.curvature, route.length, route.pivot, strict=True), step)


def laid_down(polygon, x, y, yaw):
    """A polygon of the body in the world."""
    cos_yaw, sin_yaw = math.cos(yaw), math.sin(yaw)
    turn = np.array([[cos_yaw, -sin_yaw], [sin_yaw, cos_yaw]])
    return np.asarray(polygon) @ turn.T + np.array([x, y])


def contains(polygon, points):
    """Whether a simple polygon contains points, by the even-odd rule; shape (n,)."""
    inside = np.zeros(len(points), bool)
    for (ax, ay), (bx, by) in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        between = (ay > points[:, 1]) != (by > points[:, 1])
        with np.errstate(divide="ignore", invalid="ignore"):
            crossing = ax + (points[:, 1] - ay) * (bx - ax) / (by - ay)
        inside ^= between & (points[:, 0] < crossing)
    return inside


def hits(grid, polygon, poses):
    """Whether at each pose a blocked cell has its centre in the polygon, or a corner reaches out of the grid."""
    rows, columns = np.nonzero(grid.blocked)
    centres = (np.stack((columns, rows), axis=1) + 0.5) * grid.resolution
    turn = np.array([[grid.cos_yaw, -grid.sin_yaw], [grid.sin_yaw, grid.cos_yaw]])
    world = centres @ turn.T + (grid.x, grid.y)
    size = np.array(grid.blocked.shape[::-1]) * grid.resolution
    found = []
    for pose in poses:
        outline = laid_down(polygon, *pose)
        local = (outline - (grid.x, grid.y)) @ turn
        outside = bool((local < 0.0).any() or (local > size).any())
        found.append(outside or bool(contains(outline, world).any()))
    return np.array(found)


def pose_error(pose, wanted):
    return max(*np.abs(np.subtract(pose, wanted)[:2]), abs(math.remainder(pose[2] - wanted[2], 2.0 * math.pi)))
