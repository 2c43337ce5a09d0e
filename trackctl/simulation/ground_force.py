"""Force of the ground on a moving track, with or without memory of where its shoes have entered the ground."""

from __future__ import annotations

import math
from typing import NamedTuple

from trackctl.compiled import kernel
from trackctl.mechanics.contact import Contact, contact
from trackctl.mechanics.elementary_functions import LARGEST_HALF_ANGLE, cosine, decay, sinc
from trackctl.mechanics.equilibrium import split
from trackctl.mechanics.parameters import TrackModel
from trackctl.mechanics.shear import TrackMotion
from trackctl.simulation.contact_memory import Entries, Memory, cubic, entry_time, find, newest, panel, slot
from trackctl.simulation.graded_quadrature import GradedRule

#: Sliding below this has not settled its direction, so that a vehicle can come to rest. [m/s]
SLIDING_FLOOR = 1e-5
#: What is too short to be a stretch of its own, and the step of difference quotients, over the contact's length.
REACH = 1e-9
DIFFERENCE = 1e-6
#: Gauss-Newton steps towards a shoe that has come back over its point of entry.
RETURN_STEPS = 4
#: A track slower than this counts as so fast in the time that its shoes have been on the ground. [m/s]
SLOWEST_TRACK = 1e-6


class Frame(NamedTuple):
    """Where the contact centre of a track is in the world [m], and the body's forward direction. [-]"""

    x: float
    y: float
    forward_x: float
    forward_y: float


class Force(NamedTuple):
    """Ground force on a track over the weight: forward and left [-], and the integral of x dF_y. [m]"""

    forward: float
    left: float
    moment: float


@kernel
def mirrored(motion: TrackMotion, ground: Contact) -> tuple[TrackMotion, Contact]:
    """The same track with front and rear exchanged."""
    return (
        TrackMotion(-motion.speed, -motion.body_speed, 0.0, motion.lateral_speed, 0.0, -motion.curvature),
        Contact(-ground.front, -ground.rear, 0.0, 0.0, ground.strength, -ground.strength_gradient, 0.0, 0.0),
    )


class Track(NamedTuple):
    """A track at an instant, its front being the end where shoes enter.

    Attributes
    ----------
    motion
        With speeds in m/s and the yaw rate, in rad/s, as curvature; the track's speed is positive.
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
def present_displacement(track: Track, x: float) -> tuple[float, float]:
    """Shear displacement [m] of the shoe at x if the present motion has lasted since its entry.

    In axes that have turned by half as much as the shoe. See `trackctl.mechanics.shear.shear_force`.
    """
    motion, ground = track.motion, track.ground
    travel, sy = ground.front - x, motion.lateral_speed + motion.curvature * x
    tau = travel / motion.speed
    most_turn = LARGEST_HALF_ANGLE * motion.speed / (ground.front - ground.rear)
    turn = min(max(0.5 * motion.curvature, -most_turn), most_turn)
    z = turn * turn * tau * tau
    chord, half_cos = tau * sinc(z), cosine(z)
    half_sin = turn * chord
    wx_half = motion.body_speed * half_cos - sy * half_sin
    wy_half = motion.body_speed * half_sin + sy * half_cos
    return chord * wx_half - travel, chord * wy_half


@kernel
def displacement(
    track: Track, remember: bool, memory: Memory, entries: Entries, piece: int, x: float
) -> tuple[float, float, int]:
    """Shear displacement of the shoe at x [m], and its piece of memory, looked for from `piece` on."""
    if not remember:
        j_x, j_y = present_displacement(track, x)
        return j_x, j_y, piece
    side, frame = track.side, track.frame
    label = memory.travel + side * (x + track.unloaded)
    piece = find(memory, entries, label, piece, side)
    entry = entries[slot(memory, entries, piece)]
    theta = entry_time(entry, label)
    j_x = frame.x + side * x * frame.forward_x - cubic(entry.x, theta)
    j_y = frame.y + side * x * frame.forward_y - cubic(entry.y, theta)
    if track.unloaded > 0.0:
        j_x += side * track.unloaded * cubic(entry.forward_x, theta)
        j_y += side * track.unloaded * cubic(entry.forward_y, theta)
    return j_x, j_y, piece


@kernel
def return_place(
    track: Track,
    rule: GradedRule,
    remember: bool,
    memory: Memory,
    entries: Entries,
    piece: int,
    front: float,
    rear: float,
) -> float:
    """Where a shoe between `front` and `rear` has come back next to its point of entry, or else `rear`. [m]

    Displacement is least there; where it vanishes, stress has a kink. Of several places, the deepest.
    """
    length = front - rear
    before = least = math.inf
    depth, place, walking = 0.0, 0, piece
    for k in range(rule.samples.size):
        j_x, j_y, walking = displacement(track, remember, memory, entries, walking, front - length * rule.samples[k])
        square = j_x * j_x + j_y * j_y
        if k > 1 and min(before, square) - least > depth:
            depth, place = min(before, square) - least, k - 1
        before, least = least, square
    if place == 0:
        return rear
    newest_x, oldest_x = front - length * rule.samples[place - 1], front - length * rule.samples[place + 1]
    x, step = front - length * rule.samples[place], DIFFERENCE * length
    for _ in range(RETURN_STEPS):
        a_x, a_y, _ = displacement(track, remember, memory, entries, piece, x + 0.5 * step)
        b_x, b_y, _ = displacement(track, remember, memory, entries, piece, x - 0.5 * step)
        d_x, d_y = (a_x - b_x) / step, (a_y - b_y) / step
        steepness = d_x * d_x + d_y * d_y
        if steepness > 0.0:
            x -= 0.5 * ((a_x + b_x) * d_x + (a_y + b_y) * d_y) / steepness
            x = min(max(x, oldest_x), newest_x)
    return float(x)


@kernel
def track_force(
    model: TrackModel,
    load: float,
    pressure_centre: float,
    motion: TrackMotion,
    rule: GradedRule,
    remember: bool,
    frame: Frame,
    memory: Memory,
    entries: Entries,
) -> Force:
    """Shear force and motion resistance of one track.

    The contact is integrated in stretches, which end where lateral sliding vanishes and the sliding direction turns,
    where shoes have come back over their points of entry, and where the memory is rough.

    Parameters
    ----------
    model
        Vehicle on its terrain.
    load, pressure_centre
        Load over the weight [-], and centre of pressure ahead of the contact centre. [m]
    motion
        Of the track, with speeds in m/s and the yaw rate, in rad/s, as curvature.
    rule
        Quadrature of a stretch.
    remember
        Whether the points of entry come from the memory, or from the present motion.
    frame, memory, entries
        Where the track is, and what it remembers.
    """
    side = -1.0 if motion.speed < 0.0 else 1.0
    ground = contact(model, max(load, 0.0), 0.0, pressure_centre, 0.0)
    unloaded = 0.5 * model.length - (ground.front if side > 0.0 else -ground.rear)
    if side < 0.0:
        motion, ground = mirrored(motion, ground)
    moving = TrackMotion(
        max(motion.speed, SLOWEST_TRACK), motion.body_speed, 0.0, motion.lateral_speed, 0.0, motion.curvature
    )
    track = Track(moving, ground, side, unloaded, frame)
    middle, _ = split(moving, ground)
    sx = motion.body_speed - motion.speed
    sx_square = sx * sx + SLIDING_FLOOR * SLIDING_FLOOR
    short = REACH * (ground.front - ground.rear)
    piece = newest(memory, side)
    Q_0 = Q_y = Q_xy = 0.0
    front, halved = ground.front, False
    while front > ground.rear:
        rear = ground.rear
        if rear < middle < front:
            rear = middle
        if remember:
            piece = find(memory, entries, memory.travel + side * (front + unloaded - short), piece, side)
            end = side * (panel(memory, entries, piece, side) - memory.travel) - unloaded
            if rear < end < front:
                rear = end
        limit = rear
        if not halved:
            rear = return_place(track, rule, remember, memory, entries, piece, front, limit)
        halved = rear > limit
        length = front - rear
        for k in range(rule.nodes.size):
            x = front - length * rule.nodes[k]
            j_x, j_y, piece = displacement(track, remember, memory, entries, piece, x)
            sy = motion.lateral_speed + motion.curvature * x
            strength = ground.strength + ground.strength_gradient * x
            mobilised = 1.0 - decay(math.sqrt(j_x * j_x + j_y * j_y) / model.shear_modulus)
            Q = length * rule.weights[k] * strength * mobilised / math.sqrt(sx_square + sy * sy)
            Q_0 += Q
            Q_y += Q * sy
            Q_xy += Q * sy * x
        front = rear
    rolling = model.resistance * max(load, 0.0) if motion.speed != 0.0 else 0.0
    return Force(side * (-sx * Q_0 - rolling), -Q_y, -side * Q_xy)
