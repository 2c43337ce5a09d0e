"""Force of the ground on a moving track, with or without memory of where its shoes have entered the ground."""

from __future__ import annotations

import math
from typing import NamedTuple

from trackctl.compiled import kernel
from trackctl.mechanics.contact import Contact, contact
from trackctl.mechanics.elementary_functions import LARGEST_HALF_ANGLE, cosine, decay, sinc
from trackctl.mechanics.equilibrium import sharpness, split
from trackctl.mechanics.parameters import TrackModel
from trackctl.mechanics.quadrature import Rule, choose
from trackctl.mechanics.shear import Stretch, TrackMotion, boundary_layer, singularities
from trackctl.simulation.contact_memory import Entries, Memory, cubic, entry_time, find, newest, panel, slot

#: Sliding below this has not settled its direction, so that a vehicle can come to rest. [m/s]
SLIDING_FLOOR = 1e-5
#: What is too short to be a stretch of its own, over the contact's length.
REACH = 1e-9
#: Nodes that a stretch of memory has more than pieces.
NODES_BESIDE_PIECES = 3
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


@kernel
def present_displacement(motion: TrackMotion, travel: float, sy: float, longest: float) -> float:
    """Shear displacement of a shoe if the present motion has lasted since its entry, `travel` ahead. [m]

    See `trackctl.mechanics.shear.shear_force`.
    """
    tau = travel / motion.speed
    most_turn = LARGEST_HALF_ANGLE * motion.speed / longest
    turn = min(max(0.5 * motion.curvature, -most_turn), most_turn)
    z = turn * turn * tau * tau
    chord, half_cos = tau * sinc(z), cosine(z)
    half_sin = turn * chord
    wx_half = motion.body_speed * half_cos - sy * half_sin
    wy_half = motion.body_speed * half_sin + sy * half_cos
    j_x, j_y = chord * wx_half - travel, chord * wy_half
    return math.sqrt(j_x * j_x + j_y * j_y)


@kernel
def track_force(
    model: TrackModel,
    load: float,
    pressure_centre: float,
    motion: TrackMotion,
    rule: Rule,
    remember: bool,
    frame: Frame,
    memory: Memory,
    entries: Entries,
) -> Force:
    """Shear force and motion resistance of one track.

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
    # How far the ground begins behind the end of the track.
    unloaded = 0.5 * model.length - (ground.front if side > 0.0 else -ground.rear)
    if side < 0.0:
        motion, ground = mirrored(motion, ground)
    moving = TrackMotion(
        max(motion.speed, SLOWEST_TRACK), motion.body_speed, 0.0, motion.lateral_speed, 0.0, motion.curvature
    )
    middle, _ = split(moving, ground)
    near = singularities(moving, ground)
    sx = motion.body_speed - motion.speed
    sx_square = sx * sx + SLIDING_FLOOR * SLIDING_FLOOR
    length = ground.front - ground.rear
    piece = newest(memory, side)
    Q_0 = Q_y = Q_xy = 0.0
    least = 0
    front = ground.front
    while front > ground.rear:
        rear = ground.rear
        if rear < middle < front:
            rear = middle
        if remember:
            piece = find(memory, entries, memory.travel + side * (front + unloaded - REACH * length), piece, side)
            label, pieces = panel(memory, entries, piece, side)
            least = pieces + NODES_BESIDE_PIECES
            end = side * (label - memory.travel) - unloaded
            if rear < end < front:
                rear = end
        part = Stretch(rear, front)
        row = choose(rule, sharpness(near, part), boundary_layer(moving, model.shear_modulus, part))
        while rule.counts[row] < least and row < rule.counts.size - 1:
            row += 1
        for k in range(rule.counts[row]):
            x = front - (front - rear) * rule.nodes[row, k]
            sy = motion.lateral_speed + motion.curvature * x
            if remember:
                label = memory.travel + side * (x + unloaded)
                piece = find(memory, entries, label, piece, side)
                entry = entries[slot(memory, entries, piece)]
                theta = entry_time(entry, label)
                j_x = frame.x + side * x * frame.forward_x - cubic(entry.x, theta)
                j_y = frame.y + side * x * frame.forward_y - cubic(entry.y, theta)
                if unloaded > 0.0:
                    j_x += side * unloaded * cubic(entry.forward_x, theta)
                    j_y += side * unloaded * cubic(entry.forward_y, theta)
                j = math.sqrt(j_x * j_x + j_y * j_y)
            else:
                j = present_displacement(moving, ground.front - x, sy, length)
            strength = ground.strength + ground.strength_gradient * x
            mobilised = strength * (1.0 - decay(j / model.shear_modulus)) / math.sqrt(sx_square + sy * sy)
            Q = (front - rear) * rule.weights[row, k] * mobilised
            Q_0 += Q
            Q_y += Q * sy
            Q_xy += Q * sy * x
        front = rear
    rolling = model.resistance * max(load, 0.0) if motion.speed != 0.0 else 0.0
    return Force(side * (-sx * Q_0 - rolling), -Q_y, -side * Q_xy)
