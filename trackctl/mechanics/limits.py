"""Where no equilibrium can be, and where an equilibrium is none of the model's.

The codes are those of `trackctl.lut.table.Status`.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import inlined, kernel
from trackctl.mechanics.contact import loads
from trackctl.mechanics.operating_point import OperatingPoint
from trackctl.mechanics.parameters import TrackModel

Array = NDArray[np.float64]

ADMISSIBLE = 0
GRIP = 1
LIFTOFF = 2
PITCHOVER = 3
OUTSIDE_MODEL = 4

#: The physical box: track speeds in units of the vehicle's speed [-], and sideslip. [rad]
SLOWEST_TRACK = 0.01
FASTEST_TRACK = 6.0
LARGEST_SIDESLIP = math.radians(60.0)


@kernel
def missing_grip(model: TrackModel, point: OperatingPoint) -> float:
    """Least force on the ground over all sideslip angles, |g - a|, less the most that the ground can give. [-]

    a = v^2 kappa (-sin(beta), cos(beta)) lies on an arc; the ground gives mu W + c A + f_r W at most. A positive result
    proves that there is no equilibrium.
    """
    side = math.copysign(1.0, point.centripetal)
    # Angle of gravity from the leftward axis, in which a stands at beta.
    angle = math.atan2(-point.gravity_forward * side, point.gravity_left * side)
    beta = min(max(angle, -LARGEST_SIDESLIP), LARGEST_SIDESLIP)
    demand = math.hypot(
        point.gravity_forward + point.centripetal * math.sin(beta),
        point.gravity_left - point.centripetal * math.cos(beta),
    )
    supply = (model.friction + model.resistance) * point.normal + 2.0 * model.adhesion * model.length
    return demand - supply


@inlined
def surely_admissible(model: TrackModel, slope: float, centripetal: float) -> bool:
    """Whether `proven_infeasible` can prove nothing at any heading, by the triangle inequality."""
    lateral, normal = math.sin(slope) + abs(centripetal), math.cos(slope)
    transfer = model.cog_height * lateral
    return (
        lateral < (model.friction + model.resistance) * normal
        and transfer < normal * (0.5 * model.gauge - abs(model.cog_left))
        and transfer < normal * (0.5 * model.length - abs(model.cog_forward))
    )


@kernel
def proven_infeasible(model: TrackModel, point: OperatingPoint) -> int:
    """The limit that every sideslip angle in the box exceeds, or `ADMISSIBLE` where none is proven."""
    if missing_grip(model, point) > 0.0:
        return GRIP
    straight = loads(model, point, 0.0)
    turned = loads(model, point, LARGEST_SIDESLIP)
    # The loads depend on cos(beta), the centre of pressure on sin(beta): the ends of the box bound both.
    if max(straight.left, turned.left) <= 0.0 or max(straight.right, turned.right) <= 0.0:
        return LIFTOFF
    other = loads(model, point, -LARGEST_SIDESLIP)
    nearest = min(turned.pressure_centre, other.pressure_centre)
    farthest = max(turned.pressure_centre, other.pressure_centre)
    if nearest >= 0.5 * model.length or farthest <= -0.5 * model.length:
        return PITCHOVER
    return ADMISSIBLE


@kernel
def exceeded_limit(model: TrackModel, point: OperatingPoint, unknowns: Array) -> int:
    """The limit that an equilibrium exceeds, or `ADMISSIBLE`.

    A track must carry load, the centre of pressure must lie within the contact, and a shoe must turn by less than half
    a turn while it is on the ground, |r| L < pi V.
    """
    weighing = loads(model, point, unknowns[2])
    if weighing.left <= 0.0 or weighing.right <= 0.0:
        return LIFTOFF
    if abs(weighing.pressure_centre) >= 0.5 * model.length:
        return PITCHOVER
    if abs(point.curvature) * model.length >= math.pi * min(unknowns[0], unknowns[1]):
        return OUTSIDE_MODEL
    return ADMISSIBLE


@inlined
def outside_box(unknowns: Array) -> bool:
    """Whether the unknowns lie outside the physical box."""
    return bool(
        min(unknowns[0], unknowns[1]) <= SLOWEST_TRACK
        or max(unknowns[0], unknowns[1]) >= FASTEST_TRACK
        or abs(unknowns[2]) >= LARGEST_SIDESLIP
    )
