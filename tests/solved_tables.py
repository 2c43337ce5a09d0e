"""Small tables, really solved, for the tests of what reads them."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product

import numpy as np

from trackctl.files.profile_yaml import load_terrain, load_vehicle
from trackctl.lut.axes import FULL_CIRCLE, Axes
from trackctl.lut.point import solve_points
from trackctl.lut.table import VARIABLES, Table
from trackctl.mechanics.parameters import STANDARD_GRAVITY, track_model
from trackctl.mechanics.slip import body_speed, slip

VEHICLE, TERRAIN = load_vehicle("utv-61cm"), load_terrain("asphalt")
#: A turn of 0.5 m at 2 m/s is beyond the grip where gravity points away from its centre.
SLOPE = math.radians(12.0)
VELOCITY = np.array([0.5, 1.0, 1.5, 2.0])
CURVATURE = np.array([0.0, 0.05, 0.2, 0.5, 1.0, 2.0])
HEADING = np.arange(12) * FULL_CIRCLE / 12


def solved_table(slopes=(SLOPE,), cog_left=0.0, **attributes):
    """A table of left turns (both ways if the mass centre is off the centreline) in 12 headings."""
    vehicle = replace(VEHICLE, cog_left=cog_left)
    curvature = np.concatenate((-CURVATURE[:0:-1], CURVATURE)) if cog_left else CURVATURE
    axes = Axes(np.array(slopes), VELOCITY, curvature, HEADING, heading_is_periodic=True)
    points = np.array(list(product(axes.slope, axes.velocity, axes.curvature, axes.heading)))
    cells = solve_points(track_model(vehicle, TERRAIN), points)
    left, right, sideslip = cells["unknowns"].T
    values = {"sideslip": sideslip, "residual": cells["residual"]}
    for ratio, side, traction, arm in zip(
        (left, right), ("left", "right"), cells["traction"].T, (0.5, -0.5), strict=True
    ):
        body = body_speed(1.0, points[:, 2], sideslip, arm * vehicle.track_gauge - cog_left)
        values[f"sprocket_rate_{side}"] = ratio * points[:, 1] / vehicle.sprocket_radius
        values[f"slip_{side}"] = slip(ratio, body)
        values[f"traction_{side}"] = traction * vehicle.mass * STANDARD_GRAVITY
    values = {name: values[name].reshape(axes.shape) for name in VARIABLES}
    status = cells["status"].reshape(axes.shape)
    return Table(axes, values, status, vehicle, TERRAIN, STANDARD_GRAVITY, attributes)
