"""What follows from the track speeds: speed of the body at each track, slip, and the no-slip radius."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Numbers = float | Array


def body_speed(velocity: Numbers, curvature: Numbers, sideslip: Numbers, arm: Numbers) -> Array:
    """Forward speed of the body at a track, v (cos(beta) - kappa arm): that of the track if it did not slip.

    Parameters
    ----------
    velocity : float or ndarray
        Speed of the mass centre. [m/s], or any unit of speed
    curvature : float or ndarray
        Yaw rate over speed, left positive. [1/m]
    sideslip : float or ndarray
        From the body's x axis to the velocity of the mass centre, counter-clockwise. [rad]
    arm : float or ndarray
        y_i - c_l: how far left of the mass centre the track is; B/2 - c_l or -B/2 - c_l. [m]

    Returns
    -------
    ndarray
        Of the arguments' broadcast shape, in the unit of `velocity`; negative where the body moves backwards.
    """
    return np.asarray(velocity * (np.cos(sideslip) - curvature * arm), np.float64)


def slip(track_speed: Numbers, body_speed: Numbers) -> Array:
    """Slip of a track, (V_track - V_body) / max(abs(V_track), abs(V_body)).

    Positive driving, negative braking; in [-1, 1] while both speeds have one sign, and 0 where track and body
    stand still.

    Parameters
    ----------
    track_speed : float or ndarray
        Of the track over the hull. [m/s], or any unit of speed
    body_speed : float or ndarray
        Of the hull over the ground, in the same unit.
    """
    track, body = np.asarray(track_speed, np.float64), np.asarray(body_speed, np.float64)
    larger = np.maximum(np.abs(track), np.abs(body))
    return np.asarray((track - body) / np.where(larger == 0.0, 1.0, larger))


def no_slip_radius(track_gauge: float, track_speed_left: Numbers, track_speed_right: Numbers) -> Array:
    """Turn radius that the track speeds would give without slip, (B/2) (V_r + V_l) / (V_r - V_l).

    Parameters
    ----------
    track_gauge
        B, between the centre lines of the tracks. [m]
    track_speed_left, track_speed_right : float or ndarray
        Over the hull, in one unit.

    Returns
    -------
    ndarray
        Positive to the left, inf where the speeds are equal. [m]
    """
    left, right = np.asarray(track_speed_left, np.float64), np.asarray(track_speed_right, np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        radius = 0.5 * track_gauge * (right + left) / (right - left)
    return np.where(left == right, np.inf, radius)
