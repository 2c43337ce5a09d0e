"""The planar tracked vehicle of Shiller, Serate and Hua, on level ground or on a slope.

Coulomb friction sideways, spread over the tracks as the load is; driving forces do not weaken it. Symbols of [1]_:
s arc length, theta_s yaw gradient (yaw per arc length), z squared speed, a acceleration along the path, kappa
curvature. Where the paper has the slip angle beta there is the sideslip -beta = path tangent - yaw.

A slope adds gravity's components in the plane, less weight on the ground, and the standing vehicle's shift of load
by ``cog_height``. The load that driving shifts is left out, as in the paper, and a mass centre off the contact centre.

References
----------
.. [1] Z. Shiller, W. Serate, M. Hua, Trajectory planning of tracked vehicles, ICRA 1993.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Yaw rate within which friction passes smoothly from one direction to the other. [rad/s]
YAW_RATE_SCALE = 1e-6
#: Below this speed the smoothing is that of this speed, so that it does not hide the start from rest. [m/s]
SLOWEST = 1e-3
NEWTON_STEPS = 4


@dataclass(frozen=True, slots=True, kw_only=True)
class ForceModel:
    """A vehicle on its ground.

    Attributes
    ----------
    mass, yaw_inertia
        [kg], [kg m2]
    gauge, length, cog_height
        Between the track centre lines, of the ground contact, of the mass centre above the ground. [m]
    lateral_friction, longitudinal_friction
        mu_t, mu_f: friction over load sideways, and the most that a track can drive or brake with. [1]
    gravity
        [m/s2]
    slope, uphill_yaw
        Angle of the ground, and the yaw of its steepest ascent. [rad]
    max_track_force
        That the drive can put on one track. [N]
    """

    mass: float
    yaw_inertia: float
    gauge: float
    length: float
    cog_height: float
    lateral_friction: float
    longitudinal_friction: float
    gravity: float
    slope: float = 0.0
    uphill_yaw: float = 0.5 * math.pi
    max_track_force: float = math.inf

    @property
    def load(self) -> float:
        """N, on both tracks. [N]"""
        return self.mass * self.gravity * math.cos(self.slope)

    @property
    def grip(self) -> float:
        """The c = 2 mu_t N / (m L) of the paper: lateral friction over mass, per length of zero-slide offset. [1/s2]"""
        return 2.0 * self.lateral_friction * self.load / (self.mass * self.length)


@dataclass(frozen=True, slots=True, eq=False)
class Gravity:
    """Gravity in the plane and what it does to the load, each with its derivative by yaw; arrays of shape (n,).

    Attributes
    ----------
    forward, left
        Components along and across the body. [m/s2]
    load_offset, load_offset_by_yaw
        Centre of the load ahead of the mass centre. [m], [m/rad]
    """

    forward: Array
    left: Array
    load_offset: Array
    load_offset_by_yaw: Array


def gravity_in_body(model: ForceModel, yaw: Array) -> Gravity:
    """Gravity's pull down the slope on a vehicle that stands at a yaw; its derivative by yaw is (left, -forward)."""
    heading = yaw - model.uphill_yaw
    pull, shift = model.gravity * math.sin(model.slope), model.cog_height * math.tan(model.slope)
    along, across = np.cos(heading), np.sin(heading)
    return Gravity(-pull * along, pull * across, -shift * along, shift * across)


@dataclass(frozen=True, slots=True, eq=False)
class Residual:
    """The constraint and its derivatives, arrays of shape (n,).

    Attributes
    ----------
    value
        Lateral balance times abs(theta_s) / (c m). [1]
    by_sideslip, by_yaw_gradient
        [1], [m]
    """

    value: Array
    by_sideslip: Array
    by_yaw_gradient: Array


@dataclass(frozen=True, slots=True, eq=False)
class ReferencePoints:
    """What the vehicle is asked to do at points of its path, arrays of shape (n,).

    Attributes
    ----------
    x, y, tangent, curvature, curvature_gradient
        Of the path, as in `PathPoints`.
    squared_speed, acceleration
        z = v^2 and a = z'/2 of the mass centre along the path. [m2/s2], [m/s2]
    """

    x: Array
    y: Array
    tangent: Array
    curvature: Array
    curvature_gradient: Array
    squared_speed: Array
    acceleration: Array

    @property
    def speed(self) -> Array:
        """Of the mass centre. [m/s]"""
        return np.asarray(np.sqrt(self.squared_speed))


def smooth_magnitude(yaw_gradient: Array, reference: ReferencePoints) -> Array:
    """sqrt(omega^2 + eps^2) / v, in place of abs(theta_s). [1/m]"""
    return np.hypot(yaw_gradient, YAW_RATE_SCALE / np.maximum(reference.speed, SLOWEST))


def constraint(model: ForceModel, reference: ReferencePoints, sideslip: Array, yaw_gradient: Array) -> Residual:
    """The lateral balance of forces, in a form that is regular at rest, on straights and through inflections.

    On level ground (26) of the paper times -abs(theta_s) / c,

        r = [(c + a |theta_s|) sin(beta) - kappa z |theta_s| cos(beta)] / c .

    On a slope, with x_p the offset of the load and g_y the pull of gravity to the left,

        r = sin(beta) - x_p theta_s (3/2 - 6 D^2 / L^2) - |theta_s| (kappa z cos(beta) - a sin(beta) - g_y) / c .

    Parameters
    ----------
    model
        The vehicle.
    reference
        Path and speed.
    sideslip, yaw_gradient : ndarray, shape (n,)
        -beta and theta_s. [rad], [1/m]
    """
    sine, cosine = np.sin(sideslip), np.cos(sideslip)
    gravity = gravity_in_body(model, reference.tangent - sideslip)
    magnitude = smooth_magnitude(yaw_gradient, reference)
    sign = yaw_gradient / magnitude
    centripetal = reference.curvature * reference.squared_speed
    lateral = centripetal * cosine + reference.acceleration * sine - gravity.left
    lateral_by_sideslip = reference.acceleration * cosine - centripetal * sine - gravity.forward
    offset = np.clip(sine / magnitude, -0.5 * model.length, 0.5 * model.length)
    inside = np.abs(offset) < 0.5 * model.length
    share = 1.5 - 6.0 * (offset / model.length) ** 2
    share_by_offset = np.where(inside, -12.0 * offset / model.length**2, 0.0)
    shift, shift_by_yaw = gravity.load_offset, gravity.load_offset_by_yaw
    return Residual(
        -sine - shift * yaw_gradient * share - magnitude * lateral / model.grip,
        -cosine
        - shift * sign * share_by_offset * cosine
        + shift_by_yaw * yaw_gradient * share
        - magnitude * lateral_by_sideslip / model.grip,
        -shift * (share - sign**2 * offset * share_by_offset) - sign * lateral / model.grip,
    )


def steady_sideslip(model: ForceModel, reference: ReferencePoints, yaw_gradient: Array) -> Array:
    """Sideslip at which the constraint holds with a given yaw gradient, shape (n,). [rad]

    On level ground tan(beta) = kappa |theta_s| z / (c + a |theta_s|); on a slope Newton's method goes on from there.
    """
    bend = np.abs(yaw_gradient)
    gravity = gravity_in_body(model, reference.tangent)
    lateral = reference.curvature * reference.squared_speed - gravity.left
    sideslip = -np.arctan2(bend * lateral, np.maximum(model.grip + reference.acceleration * bend, 0.1 * model.grip))
    for _ in range(NEWTON_STEPS if model.slope else 0):
        residual = constraint(model, reference, sideslip, yaw_gradient)
        sideslip = sideslip - residual.value / residual.by_sideslip
    return sideslip
