"""How the weight rests on the two tracks: loads, centre of pressure, pressure along a track."""

from __future__ import annotations

import math
from typing import NamedTuple

from trackctl.compiled import kernel
from trackctl.mechanics.operating_point import OperatingPoint
from trackctl.mechanics.parameters import TrackModel

#: Shortest contact that the pressure triangle is drawn for, as a share of the contact length; a state beyond it has
#: pitched over, and the floor only keeps the balance finite there.
SHORTEST_CONTACT = 1e-3


class Loads(NamedTuple):
    """Track loads and centre of pressure, with their derivatives by the sideslip angle.

    Attributes
    ----------
    left, right
        Normal load of each track over the weight m g; not positive where the track lifts. [-]
    left_slope
        d left / d beta = -d right / d beta. [1/rad]
    pressure_centre
        Centre of pressure ahead of the contact centre, the same for both tracks. [m]
    pressure_centre_slope
        Its derivative by beta. [m/rad]
    """

    left: float
    right: float
    left_slope: float
    pressure_centre: float
    pressure_centre_slope: float


class Contact(NamedTuple):
    """Stretch of a track on the ground and the strength of the ground along it, linear in x.

    The shear strength per length is `strength + strength_gradient * x`, over the weight; names in `_slope` are
    derivatives by the sideslip angle.
    """

    rear: float
    front: float
    rear_slope: float
    front_slope: float
    strength: float
    strength_gradient: float
    strength_slope: float
    strength_gradient_slope: float


@kernel
def loads(model: TrackModel, point: OperatingPoint, sideslip: float) -> Loads:
    """Load transfer by the slope and by the centripetal acceleration.

    N_left = W (1/2 + c_l/B) + (h/B) m (g_y - a_y) and x_cp = c_f + h (g_x - a_x) / (g cos(theta)) with
    a = v r (-sin(beta), cos(beta)).
    """
    sin_beta, cos_beta = math.sin(sideslip), math.cos(sideslip)
    arm = model.cog_height / model.gauge
    left = (
        point.normal * (0.5 + model.cog_left / model.gauge)
        + arm * (point.gravity_left - point.centripetal * cos_beta)
    )  # fmt: skip
    lever = model.cog_height / point.normal
    return Loads(
        left,
        point.normal - left,
        arm * point.centripetal * sin_beta,
        model.cog_forward + lever * (point.gravity_forward + point.centripetal * sin_beta),
        lever * point.centripetal * cos_beta,
    )


@kernel
def contact(
    model: TrackModel, load: float, load_slope: float, pressure_centre: float, pressure_centre_slope: float
) -> Contact:
    """Pressure of one track: a trapezium while |x_cp| <= L/6, else a triangle at the loaded end.

    Full contact: p = N/(b L) (1 + 12 x_cp x / L^2). Partial: a triangle of length 3 (L/2 - |x_cp|).
    """
    length, mu = model.length, model.friction
    half = 0.5 * length
    if abs(pressure_centre) <= length / 6.0:
        mean, mean_slope = mu * load / length, mu * load_slope / length
        tilt, tilt_slope = 12.0 * pressure_centre / length**2, 12.0 * pressure_centre_slope / length**2
        return Contact(
            -half, half, 0.0, 0.0,
            model.adhesion + mean, mean * tilt,
            mean_slope, mean_slope * tilt + mean * tilt_slope,
        )  # fmt: skip
    side = math.copysign(1.0, pressure_centre)
    stretch = 3.0 * (half - abs(pressure_centre))
    stretch_slope = -3.0 * side * pressure_centre_slope
    if stretch < SHORTEST_CONTACT * length:
        stretch, stretch_slope = SHORTEST_CONTACT * length, 0.0
    tip, tip_slope = side * (half - stretch), -side * stretch_slope
    gradient = 2.0 * side * mu * load / stretch**2
    gradient_slope = 2.0 * side * mu * (load_slope - 2.0 * load * stretch_slope / stretch) / stretch**2
    rear, rear_slope = (tip, tip_slope) if side > 0.0 else (-half, 0.0)
    front, front_slope = (half, 0.0) if side > 0.0 else (tip, tip_slope)
    return Contact(
        rear, front, rear_slope, front_slope,
        model.adhesion - gradient * tip, gradient,
        -gradient_slope * tip - gradient * tip_slope, gradient_slope,
    )  # fmt: skip
