"""Paths of linear curvature, piece by piece: straights, arcs and clothoids."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackctl.geometry.gauss import unit_rule
from trackctl.geometry.path import PathPoints

Array = NDArray[np.float64]

#: Gauss points a panel; a panel turns by at most `PANEL_TURN`, where so many points err by less than rounding. [rad]
POINTS = 10
PANEL_TURN = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class ClothoidPath:
    """A path from the origin along the x axis, its curvature linear on each piece.

    Attributes
    ----------
    ends
        Arc lengths of the ends of the pieces, from 0, shape (n + 1,). [m]
    first, last
        Curvature at the start and the end of each piece, shape (n,). [1/m]
    jumps
        See `Path`. [m]
    """

    ends: Array
    first: Array
    last: Array
    jumps: Array

    @property
    def length(self) -> float:
        """See `Path`."""
        return float(self.ends[-1])

    @property
    def kinks(self) -> Array:
        """See `Path`."""
        return self.ends[1:-1]

    def at(self, arc_length: Array) -> PathPoints:
        """See `Path`."""
        panels = self._panels()
        middles = 0.5 * (panels[:-1] + panels[1:])
        whole = np.concatenate(([0.0], np.cumsum(self._steps(self._piece(middles), panels[:-1], np.diff(panels)))))
        panel = np.clip(np.searchsorted(panels, arc_length, side="right") - 1, 0, panels.size - 2)
        piece, start = self._piece(arc_length), panels[panel]
        place = whole[panel] + self._steps(piece, start, arc_length - start)
        curvature = self.first[piece] + self._slopes()[piece] * (arc_length - self.ends[piece])
        tangent = self._tangents(piece, arc_length)
        return PathPoints(place.real, place.imag, tangent, curvature, self._slopes()[piece])

    def _panels(self) -> Array:
        turns = np.maximum(abs(self.first), abs(self.last)) * np.diff(self.ends)
        counts = np.ceil(turns / PANEL_TURN).astype(int) + 1
        pieces = zip(self.ends[:-1], self.ends[1:], counts, strict=True)
        parts = [np.linspace(start, end, count, endpoint=False) for start, end, count in pieces]
        return np.concatenate((*parts, self.ends[-1:]))

    def _piece(self, arc_length: Array) -> NDArray[np.intp]:
        return np.clip(np.searchsorted(self.ends, arc_length, side="right") - 1, 0, self.first.size - 1)

    def _slopes(self) -> Array:
        return np.asarray((self.last - self.first) / np.diff(self.ends))

    def _steps(self, piece: NDArray[np.intp], start: Array, length: Array) -> NDArray[np.complex128]:
        """Ways from starts to so far behind them, all within a panel of their pieces."""
        fractions, shares = unit_rule(POINTS)
        tangents = self._tangents(piece[:, None], start[:, None] + length[:, None] * fractions)
        return np.asarray(length * (np.exp(1j * tangents) @ shares))

    def _tangents(self, piece: NDArray[np.intp], arc_length: Array) -> Array:
        starts = np.concatenate(([0.0], np.cumsum(0.5 * (self.first + self.last) * np.diff(self.ends))))
        offset = arc_length - self.ends[piece]
        return np.asarray(starts[piece] + offset * (self.first[piece] + 0.5 * self._slopes()[piece] * offset))


def arc(radius: float, angle: float) -> ClothoidPath:
    """An arc of a circle.

    Parameters
    ----------
    radius
        Negative to the right. [m]
    angle
        That the tangent turns through, positive; may be several turns. [rad]
    """
    curvature = np.array([1.0 / radius])
    return ClothoidPath(np.array([0.0, abs(radius) * angle]), curvature, curvature, np.empty(0))


def clothoid_arc_clothoid(radius: float, entry: float, middle: float, exit_length: float) -> ClothoidPath:
    """A curve between two straights: a clothoid, an arc, and a clothoid back; each may have no length. [m]

    Where a clothoid has none the curvature jumps. `radius` is negative to the right.
    """
    curvature = 1.0 / radius
    lengths = np.array([entry, middle, exit_length])
    first, last = np.array([0.0, curvature, curvature]), np.array([curvature, curvature, 0.0])
    there = lengths > 0.0
    ends = np.concatenate(([0.0], np.cumsum(lengths[there])))
    jumps = [place for place, length in ((0.0, entry), (math.fsum(lengths), exit_length)) if length == 0.0]
    return ClothoidPath(ends, first[there], last[there], np.array(jumps))
