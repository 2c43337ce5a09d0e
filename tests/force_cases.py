"""The paper's vehicle and circle, as the tests of nominal forces use them."""

import math

import numpy as np

from trackctl.forces.model import ForceModel
from trackctl.forces.nominal import nominal_forces
from trackctl.forces.reference import Reference
from trackctl.forces.sideslip_spline import solve_spline
from trackctl.geometry.clothoid_path import ClothoidPath, arc

MODEL = ForceModel(
    mass=2000.0,
    yaw_inertia=15000.0,
    gauge=3.0,
    length=4.0,
    cog_height=0.6,
    lateral_friction=0.8,
    longitudinal_friction=0.8,
    gravity=9.81,
)
CIRCLE = arc(5.0, 2.0 * math.pi)


def straight(length):
    return ClothoidPath(np.array([0.0, length]), np.zeros(1), np.zeros(1), np.empty(0))


def solved(path, speed, model=MODEL, count=301, intervals=None):
    """Reference, solution, and forces at even stations."""
    reference = Reference(path, speed)
    solution = solve_spline(model, reference, intervals)
    stations = np.linspace(0.0, path.length, count)
    return reference, solution, nominal_forces(model, reference, solution.yaw, stations)
