"""How far the shoes of a track have slid since they entered the ground: their shear displacement."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackctl.compiled import kernel
from trackctl.mechanics.contact import Contact
from trackctl.mechanics.elementary_functions import LARGEST_HALF_ANGLE, cosine, sinc
from trackctl.mechanics.shear import TrackMotion
from trackctl.simulation.contact_memory import Entries, Memory, find, oldest, slot

Array = NDArray[np.float64]

#: A track slower than this counts as so fast in the time that its shoes have been on the ground. [m/s]
SLOWEST_TRACK = 1e-6


class Frame(NamedTuple):
    """Where the contact centre of a track is in the world [m], and the body's forward direction. [-]"""

    x: float
    y: float
    forward_x: float
    forward_y: float


class Track(NamedTuple):
    """A track at an instant, its front being the end where shoes enter.

    Attributes
    ----------
    motion
        With speeds in m/s and the yaw rate, in rad/s, as curvature; the track's speed is not negative.
    ground
        Where it touches the ground, and the strength of the ground.
    side
        1 if the front is the vehicle's, -1 if it is the vehicle's rear.
    unloaded
        How far the ground begins behind the end of the track. [m]
    frame
        Where it is in the world.
    """

    motion: TrackMotion
    ground: Contact
    side: float
    unloaded: float
    frame: Frame


@kernel
def displacements(
    track: Track, remember: bool, memory: Memory, entries: Entries, piece: int, places: Array, j_x: Array, j_y: Array
) -> None:
    """Shear displacements of shoes.

    Parameters
    ----------
    track
        At this instant.
    remember
        Whether the points of entry come from the memory, or from the present motion.
    memory, entries, piece
        What the track remembers, and the piece to look for the shoes' from.
    places
        Of the shoes ahead of the contact centre, from the front on. [m]
    j_x, j_y
        Receive the displacements, in axes that are of no account. [m]
    """
    if remember:
        remembered_displacements(track, memory, entries, piece, places, j_x, j_y)
    else:
        present_displacements(track, places, j_x, j_y)


@kernel
def present_displacements(track: Track, places: Array, j_x: Array, j_y: Array) -> None:
    """Shear displacements if the present motion has lasted since the shoes' entry; see `displacements`.

    In axes that have turned by half as much as a shoe. See `trackctl.mechanics.shear.shear_force`.
    """
    motion, front, rear = track.motion, track.ground.front, track.ground.rear
    speed_inverse = 1.0 / max(motion.speed, SLOWEST_TRACK)
    most_turn = LARGEST_HALF_ANGLE / (speed_inverse * (front - rear))
    turn = min(max(0.5 * motion.curvature, -most_turn), most_turn)
    for k in range(places.size):
        travel, sy = front - places[k], motion.lateral_speed + motion.curvature * places[k]
        tau = travel * speed_inverse
        z = turn * turn * tau * tau
        chord, half_cos = tau * sinc(z), cosine(z)
        half_sin = turn * chord
        j_x[k] = chord * (motion.body_speed * half_cos - sy * half_sin) - travel
        j_y[k] = chord * (motion.body_speed * half_sin + sy * half_cos)


@kernel
def remembered_displacements(
    track: Track, memory: Memory, entries: Entries, piece: int, places: Array, j_x: Array, j_y: Array
) -> None:
    """Shear displacements from the points of entry; see `displacements`."""
    side = track.side
    first = int(np.int64(0))  # no literal: numba would compile `since_entry` for it, too
    while first < places.size:
        label = memory.travel + side * (places[first] + track.unloaded)
        piece = find(memory, entries, label, piece, side)
        entry = entries[slot(memory, entries, piece)]
        end = side * ((entry.lower if side > 0.0 else entry.upper) - memory.travel) - track.unloaded
        if piece == oldest(memory, side):
            end = -math.inf
        last = first + 1
        while last < places.size and places[last] >= end:
            last += 1
        since_entry(track, memory.travel, entry, first, last, places, j_x, j_y)
        first = last


@kernel
def since_entry(
    track: Track, travel: float, entry: Entries, first: int, last: int, places: Array, j_x: Array, j_y: Array
) -> None:
    """Shear displacements of those shoes that a piece of memory holds, from `first` to before `last`."""
    side, unloaded, frame = track.side, track.unloaded, track.frame
    label, rate, change = entry.label, entry.rate, entry.change
    sign = math.copysign(1.0, rate)
    x_0, x_1, x_2, x_3 = entry.x[0], entry.x[1], entry.x[2], entry.x[3]
    y_0, y_1, y_2, y_3 = entry.y[0], entry.y[1], entry.y[2], entry.y[3]
    if unloaded > 0.0:
        shift, u, v = side * unloaded, entry.forward_x, entry.forward_y
        x_0, x_1, x_2, x_3 = x_0 - shift * u[0], x_1 - shift * u[1], x_2 - shift * u[2], x_3 - shift * u[3]
        y_0, y_1, y_2, y_3 = y_0 - shift * v[0], y_1 - shift * v[1], y_2 - shift * v[2], y_3 - shift * v[3]
    for k in range(first, last):
        # The time at which the shoe was laid down, from its label, which is quadratic in it.
        gone = travel + side * (places[k] + unloaded) - label
        total = rate + sign * math.sqrt(max(rate * rate + 4.0 * change * gone, 0.0))
        theta = 2.0 * gone / total if total != 0.0 else 0.0
        x, y = frame.x + side * places[k] * frame.forward_x, frame.y + side * places[k] * frame.forward_y
        j_x[k] = x - (x_0 + theta * (x_1 + theta * (x_2 + theta * x_3)))
        j_y[k] = y - (y_0 + theta * (y_1 + theta * (y_2 + theta * y_3)))
