"""Track speeds over time, as pieces that are linear in time and in which no track changes its direction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackctl.simulation.run_state import PIECE, Pieces

Array = NDArray[np.float64]

#: In place of a zero at one end of a piece, over the speed at the other, so that the piece has one direction.
BARELY_MOVING = 1e-9

#: What lasts no longer is no piece: in so short a step rounding outweighs the forces. [s]
SHORTEST = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class TrackSpeeds:
    """Speeds of the left and right track over time, linear between samples, shape (n,). [s, m/s]"""

    time: Array
    left: Array
    right: Array

    def until(self, end: float) -> TrackSpeeds:
        """The same speeds up to a time, the last ones held if it is later."""
        time = np.append(self.time[self.time < end], end)
        return TrackSpeeds(time, np.interp(time, self.time, self.left), np.interp(time, self.time, self.right))


def constant_speeds(left: float, right: float, duration: float) -> TrackSpeeds:
    """Speeds that do not change, from time 0."""
    return TrackSpeeds(np.array([0.0, duration]), np.full(2, left), np.full(2, right))


def speed_pieces(speeds: TrackSpeeds) -> Pieces:
    """Pieces for the integrator, cut where a track changes its direction; those of no length are left out."""
    crossings = [crossing_times(speeds.time, values) for values in (speeds.left, speeds.right)]
    time = np.unique(np.concatenate([speeds.time, *crossings]))
    pieces = np.zeros(time.size - 1, PIECE)
    pieces["start"], pieces["end"] = time[:-1], time[1:]
    for side, values, zeros in zip(("left", "right"), (speeds.left, speeds.right), crossings, strict=True):
        at_cuts = np.where(np.isin(time, zeros), 0.0, np.interp(time, speeds.time, values))
        start, end = at_cuts[:-1], at_cuts[1:]
        pieces[side][:, 0] = np.where(start == 0.0, BARELY_MOVING * end, start)
        pieces[side][:, 1] = np.where(end == 0.0, BARELY_MOVING * start, end)
    return pieces[pieces["end"] - pieces["start"] > SHORTEST]


def ramp(start: float, end: float, before: Array, after: Array) -> Pieces:
    """Pieces between two times at which the tracks have the speeds `before` and `after`, left and right, shape (2,)."""
    if not (before * after > 0.0).all():
        return speed_pieces(TrackSpeeds(np.array([start, end]), *np.stack((before, after), axis=1)))
    piece = np.empty(1, PIECE)
    piece[0] = (start, end, (before[0], after[0]), (before[1], after[1]))
    return piece


def crossing_times(time: Array, values: Array) -> Array:
    """Times between samples at which linearly interpolated values change their sign."""
    changes = np.flatnonzero(values[:-1] * values[1:] < 0.0)
    share = values[changes] / (values[changes] - values[changes + 1])
    return np.asarray(time[changes] + share * (time[changes + 1] - time[changes]))
