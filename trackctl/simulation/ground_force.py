"""Force of the ground on a moving track, with or without memory of where its shoes have entered the ground."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import carray, types  # type: ignore[attr-defined]
from numpy.typing import NDArray

from trackctl.compiled import call_by_address, inlined, kernel, procedure
from trackctl.mechanics.contact import Contact, contact
from trackctl.mechanics.elementary_functions import decay
from trackctl.mechanics.equilibrium import split
from trackctl.mechanics.parameters import TrackModel
from trackctl.mechanics.shear import TrackMotion
from trackctl.simulation.contact_memory import ENTRY, MEMORY, Entries, Memory, find, newest, panel
from trackctl.simulation.graded_quadrature import GradedRule
from trackctl.simulation.shoe_displacement import Frame, Track, displacements

Array = NDArray[np.float64]
DOUBLES = types.CPointer(types.float64)
#: Type of `track_force_there`; whole numbers are the count of nodes, whether to remember, that of entries, the track.
TRACK_FORCE = types.void(
    *(DOUBLES, DOUBLES, DOUBLES, types.int64, types.int64),
    *(types.voidptr, types.voidptr, types.int64, types.int64, DOUBLES),
)
call_track_force = call_by_address(TRACK_FORCE)
#: Fields of model, motion and frame, load and pressure centre.
NUMBERS = len(TrackModel._fields) + len(TrackMotion._fields) + len(Frame._fields) + 2

#: Sliding below this [m/s], and this share of the track's speed, has not settled its direction: a vehicle can come to
#: rest, and one that rolls without sliding, as a swing passes through, is not shaken between two directions.
SLIDING_FLOOR, SLIDING_SHARE = 1e-5, 2e-5
#: What is too short to be a stretch of its own or too shallow to be a return, and the step of difference quotients,
#: over the contact's length.
REACH, SHALLOW = 1e-9, 1e-7
DIFFERENCE = 1e-6
#: Gauss-Newton steps towards a shoe that has come back over its point of entry.
RETURN_STEPS = 4


class Force(NamedTuple):
    """Ground force on a track over the weight: forward and left [-], and the integral of x dF_y. [m]"""

    forward: float
    left: float
    moment: float


@inlined
def mirrored(motion: TrackMotion, ground: Contact) -> tuple[TrackMotion, Contact]:
    """The same track with front and rear exchanged."""
    return (
        TrackMotion(-motion.speed, -motion.body_speed, 0.0, motion.lateral_speed, 0.0, -motion.curvature),
        Contact(-ground.front, -ground.rear, 0.0, 0.0, ground.strength, -ground.strength_gradient, 0.0, 0.0),
    )


@kernel
def spread(places: Array, rule: GradedRule, front: float, rear: float) -> None:
    """The nodes of a stretch. [m]"""
    for k in range(places.size):
        places[k] = front - (front - rear) * rule.nodes[k]


@kernel
def deepest_return(j_x: Array, j_y: Array, shallow: float) -> int:
    """Node next to which a shoe has come back over its point of entry: the deepest dip of |j|^2, 0 if there is none."""
    depth, place = shallow, 0
    newer, square = j_x[0] * j_x[0] + j_y[0] * j_y[0], j_x[1] * j_x[1] + j_y[1] * j_y[1]
    for k in range(2, j_x.size):
        older = j_x[k] * j_x[k] + j_y[k] * j_y[k]
        if min(newer, older) - square > depth:
            depth, place = min(newer, older) - square, k - 1
        newer, square = square, older
    return place


@kernel
def return_place(
    track: Track, remember: bool, memory: Memory, entries: Entries, piece: int, work: Array, place: int
) -> float:
    """Where between the neighbours of a node displacement is least: where it vanishes, stress has a kink. [m]"""
    newest_x, x, oldest_x = work[0, place - 1], work[0, place], work[0, place + 1]
    step = DIFFERENCE * (track.ground.front - track.ground.rear)
    # Not a part of `work`: numba would compile everything again for rows with gaps between.
    pair = np.empty((3, 2))
    for _ in range(RETURN_STEPS):
        pair[0, 0], pair[0, 1] = x + 0.5 * step, x - 0.5 * step
        displacements(track, remember, memory, entries, piece, pair[0], pair[1], pair[2])
        d_x, d_y = (pair[1, 0] - pair[1, 1]) / step, (pair[2, 0] - pair[2, 1]) / step
        steepness = d_x * d_x + d_y * d_y
        if steepness > 0.0:
            x -= 0.5 * ((pair[1, 0] + pair[1, 1]) * d_x + (pair[2, 0] + pair[2, 1]) * d_y) / steepness
            x = min(max(x, oldest_x), newest_x)
    return float(x)


@kernel
def stress_sums(track: Track, shear_modulus: float, rule: GradedRule, work: Array) -> tuple[float, float, float]:
    """Integrals of stress over sliding speed, alone, times s_y, and times s_y x, over the stretch's length."""
    motion, ground = track.motion, track.ground
    sx = motion.body_speed - motion.speed
    floor = SLIDING_FLOOR + SLIDING_SHARE * abs(motion.speed)
    sx_square = sx * sx + floor * floor
    K_inverse = 1.0 / shear_modulus
    places, j_x, j_y, weights = work[0], work[1], work[2], rule.weights
    Q_0 = Q_y = Q_xy = 0.0
    for k in range(places.size):
        x = places[k]
        sy = motion.lateral_speed + motion.curvature * x
        strength = ground.strength + ground.strength_gradient * x
        mobilised = 1.0 - decay(math.sqrt(j_x[k] * j_x[k] + j_y[k] * j_y[k]) * K_inverse)
        Q = weights[k] * strength * mobilised / math.sqrt(sx_square + sy * sy)
        Q_0 += Q
        Q_y += Q * sy
        Q_xy += Q * sy * x
    return Q_0, Q_y, Q_xy


@kernel
def stretch_end(
    track: Track, remember: bool, memory: Memory, entries: Entries, piece: int, front: float, middle: float
) -> float:
    """Where a stretch from `front` on ends: with the contact, where lateral sliding vanishes, or at a rough place."""
    rear = track.ground.rear
    if rear < middle < front:
        rear = middle
    if remember:
        end = track.side * (panel(memory, entries, piece, track.side) - memory.travel) - track.unloaded
        if rear < end < front:
            rear = end
    return float(rear)


@kernel
def shear(
    track: Track, shear_modulus: float, rule: GradedRule, remember: bool, memory: Memory, entries: Entries
) -> Force:
    """Shear force of the ground, in the track's own directions.

    The contact is integrated in stretches, which end where lateral sliding vanishes and the sliding direction turns,
    where shoes have come back over their points of entry, and where the memory is rough.
    """
    motion, ground, side = track.motion, track.ground, track.side
    contact_length = ground.front - ground.rear
    middle, _ = split(motion, ground)
    work = np.empty((3, rule.nodes.size))
    piece = newest(memory, side)
    Q_0 = Q_y = Q_xy = 0.0
    front, halved = ground.front, False
    while front > ground.rear:
        if remember:
            label = memory.travel + side * (front + track.unloaded - REACH * contact_length)
            piece = find(memory, entries, label, piece, side)
        rear = stretch_end(track, remember, memory, entries, piece, front, middle)
        looking, halved = not halved, False
        while True:
            spread(work[0], rule, front, rear)
            displacements(track, remember, memory, entries, piece, work[0], work[1], work[2])
            place = deepest_return(work[1], work[2], (SHALLOW * contact_length) ** 2) if looking else 0
            if place == 0:
                break
            rear = return_place(track, remember, memory, entries, piece, work, place)
            looking, halved = False, True
        sum_0, sum_y, sum_xy = stress_sums(track, shear_modulus, rule, work)
        Q_0 += (front - rear) * sum_0
        Q_y += (front - rear) * sum_y
        Q_xy += (front - rear) * sum_xy
        front = rear
    return Force((motion.speed - motion.body_speed) * Q_0, -Q_y, -Q_xy)


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
    rolling = model.resistance * max(load, 0.0) if motion.speed != 0.0 else 0.0
    ground = contact(model, max(load, 0.0), 0.0, pressure_centre, 0.0)
    unloaded = 0.5 * model.length - (ground.front if side > 0.0 else -ground.rear)
    if side < 0.0:
        motion, ground = mirrored(motion, ground)
    track = Track(motion, ground, side, unloaded, frame)
    force = shear(track, model.shear_modulus, rule, remember, memory, entries)
    return Force(side * (force.forward - rolling), force.left, side * force.moment)


@kernel
def pack(
    numbers: Array, model: TrackModel, load: float, pressure_centre: float, motion: TrackMotion, frame: Frame
) -> None:
    """Write down what `track_force_there` needs to know."""
    numbers[0], numbers[1] = load, pressure_centre
    for i, value in enumerate(model):
        numbers[2 + i] = value
    for i, value in enumerate(motion):
        numbers[12 + i] = value
    for i, value in enumerate(frame):
        numbers[18 + i] = value


@procedure(TRACK_FORCE)
def track_force_there(  # type: ignore[no-untyped-def]
    numbers, nodes, weights, node_count, remember, memory, entries, entry_count, track, result
):
    """`track_force` by address: forward, left and moment of one of the two tracks, from what `pack` has written."""
    n = carray(numbers, NUMBERS)
    model = TrackModel(n[2], n[3], n[4], n[5], n[6], n[7], n[8], n[9], n[10], n[11])
    motion = TrackMotion(n[12], n[13], n[14], n[15], n[16], n[17])
    frame = Frame(n[18], n[19], n[20], n[21])
    rule = GradedRule(carray(nodes, node_count), carray(weights, node_count))
    memories, rings = carray(memory, 2, MEMORY), carray(entries, (2, entry_count), ENTRY)
    force = track_force(model, n[0], n[1], motion, rule, remember != 0, frame, memories[track], rings[track])
    found = carray(result, 3)
    found[0], found[1], found[2] = force.forward, force.left, force.moment
