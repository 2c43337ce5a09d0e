"""Where each shoe on the ground has entered it: the memory that shear displacement needs.

A shoe is known by its label xi = sigma + x, where sigma is the way that the track has travelled and x the shoe's place
in the body frame: labels do not change while a shoe lies on the ground. The points of entry along the contact are kept
as a row of pieces in ascending label, one for each time step that laid shoes down, from either end. Within a piece,
parametrised by the time theta in [0, 1] of its step, xi is quadratic and the point of entry cubic.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from trackctl.compiled import inlined, kernel

#: Length of a stretch of memory that is integrated in one, over the least span of its pieces.
PIECES_TOGETHER = 8.0
#: Shoes laid down in a step: labels from `lower` to `upper`; xi = label + rate theta + change theta^2; coefficients in
#: theta, lowest first, of the world point of the contact's end and of the body's forward direction.
ENTRY = np.dtype(
    [
        ("lower", np.float64),
        ("upper", np.float64),
        ("rough_below", np.bool_),  # whether the neighbour there tells nothing of this piece
        ("rough_above", np.bool_),
        ("span", np.float64),  # labels that a step would have laid down that only its error limits
        ("label", np.float64),
        ("rate", np.float64),
        ("change", np.float64),
        ("x", np.float64, 4),
        ("y", np.float64, 4),
        ("forward_x", np.float64, 4),
        ("forward_y", np.float64, 4),
    ],
    align=True,
)
#: One track: way travelled, the ring's first piece and number of pieces, and whether the next shoe follows a rest.
MEMORY = np.dtype([("travel", np.float64), ("first", np.int64), ("count", np.int64), ("fresh", np.bool_)], align=True)

#: A record of the type `MEMORY`, and a ring of `ENTRY`, whose length is a power of two.
Memory = Any
Entries = Any


@inlined
def slot(memory: Memory, entries: Entries, index: int) -> int:
    """Place in the ring of a piece, counted from the rear."""
    return int((memory.first + index) & (entries.size - 1))


@kernel
def push(memory: Memory, entries: Entries, side: float) -> int:
    """Make room for a piece at the front (side 1) or rear (-1) of the contact; its place in the ring."""
    if side < 0.0:
        memory.first -= 1
    memory.count += 1
    return slot(memory, entries, newest(memory, side))


@inlined
def withdraw(memory: Memory, side: float) -> None:
    """Take back what `push` made room for."""
    if side < 0.0:
        memory.first += 1
    memory.count -= 1


@inlined
def newest(memory: Memory, side: float) -> int:
    """Index of the piece next to the front (side 1) or rear (-1)."""
    return int(memory.count - 1) if side > 0.0 else 0


@inlined
def oldest(memory: Memory, side: float) -> int:
    """Index of the piece farthest from the front (side 1) or rear (-1)."""
    return 0 if side > 0.0 else int(memory.count - 1)


@kernel
def forget(memory: Memory, entries: Entries, half_length: float) -> None:
    """Drop what has left the contact at either end."""
    rear, front = memory.travel - half_length, memory.travel + half_length
    while memory.count > 1 and entries[slot(memory, entries, 0)].upper < rear:
        memory.first += 1
        memory.count -= 1
    while memory.count > 1 and entries[slot(memory, entries, memory.count - 1)].lower > front:
        memory.count -= 1
    last, first = slot(memory, entries, memory.count - 1), slot(memory, entries, 0)
    entries[last].upper = min(entries[last].upper, front)
    entries[first].lower = max(entries[first].lower, rear)


@kernel
def panel(memory: Memory, entries: Entries, index: int, side: float) -> float:
    """Label up to which pieces from `index` on, away from the end at `side`, are integrated in one.

    Steps shorten where the motion changes quickly: pieces go together while their steps are of like length.
    """
    step = -1 if side > 0.0 else 1
    piece = entries[slot(memory, entries, index)]
    smallest, length = piece.span, piece.upper - piece.lower
    while 0 <= index + step < memory.count:
        following = entries[slot(memory, entries, index + step)]
        rough = piece.rough_below or following.rough_above if side > 0.0 else piece.rough_above or following.rough_below
        smallest = min(smallest, following.span)
        length += following.upper - following.lower
        if rough or length > PIECES_TOGETHER * smallest:
            break
        index += step
        piece = following
    return float(piece.lower if side > 0.0 else piece.upper)


@kernel
def find(memory: Memory, entries: Entries, label: float, index: int, side: float) -> int:
    """Index of the piece that holds a label, looked for from `index` on, away from the end at `side`."""
    if side > 0.0:
        while index > 0 and label < entries[slot(memory, entries, index)].lower:
            index -= 1
    else:
        while index < memory.count - 1 and label > entries[slot(memory, entries, index)].upper:
            index += 1
    return index
