"""Ways whose curvature does not jump: the arcs of a route blended into each other, with the same ends.

The curvature of a route is averaged over a moving window of the blend's length: every jump becomes a ramp of that
length, turns keep their angles, and pieces shorter than the window are rounded off. The curvature is 0 at both ends of
a stretch, which is longer than its pieces by one blend, half of it at either end: a route is best searched between
poses half a blend ahead of the start and short of the goal. What then is missing to the goal, little, is shared out
among lengths and curvatures of the pieces, with the least change.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from trackctl.planning.route import Route

Array = NDArray[np.float64]
Pose = tuple[float, float, float]

#: Of the quadrature between two knots; turns of up to a circle are exact to rounding.
NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)
#: Length of a ramp that stands for a jump. [m]
JUMP = 1e-4
#: Curvatures so close are one. [1/m]
SAME_CURVATURE = 1e-9
#: The goal is met to this. [m], [rad]
MET = 1e-11
NEWTON_STEPS = 30
#: Largest change of a step, over the scales of the unknowns.
LARGEST_CHANGE = 1.0
#: Scale of a change of curvature, over the sharpest allowed; that of lengths is a blend.
CURVATURE_SHARE = 0.1
#: Pieces longer than so many blends are cut, into parts up to so many.
LONG, MOST_PARTS = 4.0, 3


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """Arcs and straights driven without a stop, arrays of shape (n,).

    Attributes
    ----------
    backwards
        Whether the vehicle drives backwards.
    curvature
        Of each piece, in the direction of travel, left positive. [1/m]
    length
        Of each piece, not negative. [m]
    """

    backwards: bool
    curvature: Array
    length: Array


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """A line of piecewise linear curvature, driven one way; arrays of shape (n,).

    Attributes
    ----------
    backwards
        Whether the vehicle drives backwards.
    start
        x, y [m] and the direction of travel. [rad]
    knots
        Arc length, ascending from 0. [m]
    curvature
        At the knots, in the direction of travel, left positive. [1/m]
    """

    backwards: bool
    start: Pose
    knots: Array
    curvature: Array

    @property
    def length(self) -> float:
        """[m]"""
        return float(self.knots[-1])

    @property
    def end(self) -> Pose:
        """Position [m] and direction of travel at the end. [rad]"""
        x, y, direction = (float(values[0]) for values in self.at(self.knots[-1:]))
        return x, y, direction

    def at(self, arc_length: Array) -> tuple[Array, Array, Array]:
        """x, y [m] and direction of travel [rad] at arc lengths, exact to rounding."""
        grid = np.union1d(self.knots, arc_length)
        curvature = np.interp(grid, self.knots, self.curvature)
        step = np.diff(grid)
        bend = np.diff(curvature) / np.where(step > 0.0, step, 1.0)
        direction = self.start[2] + np.concatenate(([0.0], np.cumsum(0.5 * step * (curvature[1:] + curvature[:-1]))))
        inside = 0.5 * step[:, None] * (1.0 + NODES)
        angle = direction[:-1, None] + inside * (curvature[:-1, None] + 0.5 * bend[:, None] * inside)
        x = self.start[0] + np.concatenate(([0.0], np.cumsum(0.5 * step * (np.cos(angle) @ WEIGHTS))))
        y = self.start[1] + np.concatenate(([0.0], np.cumsum(0.5 * step * (np.sin(angle) @ WEIGHTS))))
        place = np.searchsorted(grid, arc_length)
        return x[place], y[place], direction[place]

    def curvature_at(self, arc_length: Array) -> Array:
        """In the direction of travel. [1/m]"""
        return np.interp(arc_length, self.knots, self.curvature)


#: Makes a line of a stretch, from a start, with ramps of a length. [m]
Shape = Callable[[Stretch, Pose, float], Line]


def stretches_of(route: Route) -> list[Stretch]:
    """The stretches of a route without turns on the spot; pieces of one curvature that follow each other are one."""
    found: list[Stretch] = []
    for curvature, length in zip(route.curvature.tolist(), route.length.tolist(), strict=True):
        if length == 0.0:
            continue
        backwards = length < 0.0
        curvature = -curvature if backwards else curvature
        if not found or found[-1].backwards is not backwards:
            found.append(Stretch(backwards, np.array([curvature]), np.array([abs(length)])))
            continue
        last = found[-1]
        if abs(curvature - last.curvature[-1]) < SAME_CURVATURE:
            last.length[-1] += abs(length)
        else:
            found[-1] = Stretch(backwards, np.append(last.curvature, curvature), np.append(last.length, abs(length)))
    return found


def blended(stretch: Stretch, start: Pose, blend: float) -> Line:
    """A stretch with its curvature averaged over a window of the length `blend` [m], from a start."""
    joints = np.concatenate(([0.0], np.cumsum(stretch.length)))
    jumps = np.diff(stretch.curvature, prepend=0.0, append=0.0)
    knots = np.union1d(joints, joints + blend)
    shares = np.clip((knots[:, None] - joints) / blend, 0.0, 1.0)
    return Line(stretch.backwards, start, knots, shares @ jumps)


def rounded(stretch: Stretch, start: Pose, window: float) -> Line:
    """A stretch of the same length with its curvature averaged over a window [m], at its ends continued as there."""
    length = float(stretch.length.sum())
    joints = np.cumsum(stretch.length)[:-1]
    begins = joints - 0.5 * window
    knots = np.unique(np.clip(np.concatenate(([0.0, length], begins, begins + window)), 0.0, length))
    shares = np.clip((knots[:, None] - begins) / window, 0.0, 1.0)
    return Line(stretch.backwards, start, knots, stretch.curvature[0] + shares @ np.diff(stretch.curvature))


def chained(
    stretches: Sequence[Stretch], start: Pose, blend: float, kinks: Sequence[float], shaped: Shape = blended
) -> list[Line]:
    """Blended stretches one after the other; the direction of travel turns round between them.

    Parameters
    ----------
    stretches
        At least one.
    start
        x, y [m] and tangent, which is the direction of travel forwards and its reverse backwards. [rad]
    blend
        [m]
    kinks
        Turn of the tangent before each stretch but the first. [rad]
    shaped
        What makes lines of stretches: `blended` or `rounded`.
    """
    lines: list[Line] = []
    x, y, tangent = start
    for stretch, kink in zip(stretches, (0.0, *kinks), strict=True):
        tangent += kink
        direction = tangent + math.pi if stretch.backwards else tangent
        lines.append(shaped(stretch, (x, y, direction), blend))
        x, y, direction = lines[-1].end
        tangent = direction - math.pi if stretch.backwards else direction
    return lines


def goal_of(lines: Sequence[Line]) -> Array:
    """x, y [m] and tangent [rad] at the end of lines that follow each other."""
    x, y, direction = lines[-1].end
    return np.array([x, y, direction - math.pi if lines[-1].backwards else direction])


def divided(stretch: Stretch, blend: float, least: int) -> Stretch:
    """The same stretch with long pieces cut, so that a small change of course can be made within them."""
    parts = np.clip(np.ceil(stretch.length / (LONG * blend)).astype(int), least, MOST_PARTS)
    return replace(
        stretch, curvature=np.repeat(stretch.curvature, parts), length=np.repeat(stretch.length / parts, parts)
    )


def blended_route(
    route: Route, start: Pose, goal: Pose, blend: float, sharpest: float, kinks: Sequence[float] | None = None
) -> list[Line] | None:
    """Lines of continuous curvature along a route from start to goal, both exact.

    Parameters
    ----------
    route
        Without turns on the spot; best from half a blend ahead of the start to half a blend short of the goal.
    start, goal
        x, y [m] and tangent. [rad]
    blend
        Length of a ramp of curvature. [m]
    sharpest
        Largest curvature either way. [1/m]
    kinks
        Turn of the tangent where the direction of travel changes, as the body keeps its yaw and its sideslip changes;
        None for none. [rad]

    Returns
    -------
    list of Line
        None where lengths that are not negative and curvatures up to the sharpest do not reach the goal.
    """
    stretches = stretches_of(route)
    pieces = sum(stretch.length.size for stretch in stretches)
    stretches = [divided(stretch, blend, MOST_PARTS if pieces < MOST_PARTS else 1) for stretch in stretches]
    kinks = [0.0] * (len(stretches) - 1) if kinks is None else kinks
    adjustment = Adjustment(stretches, kinks, start, goal, blend, sharpest)
    found = met(adjustment)
    return None if found is None else adjustment.lines(found)


def jumping_route(
    route: Route, start: Pose, goal: Pose, blend: float, sharpest: float, kinks: Sequence[float]
) -> tuple[list[Line], list[Line]] | None:
    """A route with its jumps of curvature, from start to goal, both exact, and its blended twin; see `blended_route`.

    Returns
    -------
    tuple of list of Line
        The jumps are ramps of `JUMP`. The twin, of the same arc lengths, has ramps of a blend about the middles of the
        jumps, cut at the ends of stretches; it begins at the start and misses the goal. None as of `blended_route`.
    """
    stretches = stretches_of(route)
    adjustment = Adjustment(stretches, kinks, start, goal, blend, sharpest, JUMP)
    if (found := met(adjustment)) is None:
        return None
    twin = chained(adjustment.changed(found), start, blend, kinks, rounded)
    return adjustment.lines(found), twin


def met(adjustment: Adjustment) -> Array | None:
    """Lengths and curvatures with which the goal is met; None without."""
    unknowns: Array = np.clip(adjustment.first, adjustment.lower, adjustment.upper)
    for _ in range(NEWTON_STEPS):
        lines = adjustment.lines(unknowns)
        gap = adjustment.gap(lines)
        if np.abs(gap).max() <= MET:
            return unknowns
        unknowns = adjustment.step(unknowns, gap, adjustment.slopes(unknowns, lines))
    return None


def end_slopes(stretch: Stretch, line: Line, blend: float) -> Array:
    """Derivatives of the end of a blended stretch by its lengths, then by its curvatures, shape (3, 2 n)."""
    step = 0.5 * np.diff(line.knots)
    places = (line.knots[:-1, None] + step[:, None] * (1.0 + NODES)).ravel()
    weights = (step[:, None] * WEIGHTS).ravel()
    direction, (_, _, last) = line.at(places)[2], line.end
    joints = np.concatenate(([0.0], np.cumsum(stretch.length)))
    shares = np.clip((places[:, None] - joints) / blend, 0.0, 1.0)
    risen = 0.5 * blend * shares**2 + np.maximum(places[:, None] - joints - blend, 0.0)
    jumps = np.diff(stretch.curvature, prepend=0.0, append=0.0)
    # A longer piece shifts the jumps behind it; a sharper one turns all that comes after.
    shifted = -np.cumsum((shares * jumps)[:, :0:-1], axis=1)[:, ::-1]
    turned = np.hstack((shifted, risen[:, :-1] - risen[:, 1:]))
    slopes = np.stack((-(weights * np.sin(direction)) @ turned, (weights * np.cos(direction)) @ turned))
    slopes[:, : stretch.length.size] += [[math.cos(last)], [math.sin(last)]]
    return np.vstack((slopes, np.concatenate((stretch.curvature, stretch.length))))


class Adjustment:
    """The search for lengths and curvatures of pieces that end at a goal; see `blended_route`, or `jumping_route`
    where ramps are no longer than a jump.

    Attributes
    ----------
    first
        Lengths and curvatures at first, stretch by stretch, shape (n,). [m], [1/m]
    lower, upper
        Their bounds.
    """

    def __init__(
        self,
        stretches: Sequence[Stretch],
        kinks: Sequence[float],
        start: Pose,
        goal: Pose,
        blend: float,
        sharpest: float,
        jump: float | None = None,
    ) -> None:
        self._shape = (blended, blend) if jump is None else (rounded, jump)
        self._stretches, self._kinks, self._start = stretches, kinks, start
        self._goal = np.array(goal)
        self._cuts = np.cumsum([2 * stretch.length.size for stretch in stretches])[:-1]
        self.first = np.concatenate([part for each in stretches for part in (each.length, each.curvature)])
        is_length = np.concatenate([np.repeat([True, False], each.length.size) for each in stretches])
        self.lower, self.upper = np.where(is_length, 0.0, -sharpest), np.where(is_length, np.inf, sharpest)
        self._scale = np.where(is_length, blend, CURVATURE_SHARE * sharpest)

    def changed(self, unknowns: Array) -> list[Stretch]:
        """The stretches with lengths and curvatures."""
        parts = [np.split(part, 2) for part in np.split(unknowns, self._cuts)]
        return [
            replace(stretch, length=length, curvature=curvature)
            for stretch, (length, curvature) in zip(self._stretches, parts, strict=True)
        ]

    def lines(self, unknowns: Array) -> list[Line]:
        """The lines of lengths and curvatures."""
        shaped, ramp = self._shape
        return chained(self.changed(unknowns), self._start, ramp, self._kinks, shaped)

    def gap(self, lines: Sequence[Line]) -> Array:
        """What is missing to the goal, x, y [m] and tangent [rad], shape (3,)."""
        missing = self._goal - goal_of(lines)
        missing[2] = math.remainder(missing[2], 2.0 * math.pi)
        return missing

    def slopes(self, unknowns: Array, lines: Sequence[Line]) -> Array:
        """Derivatives of the end of the lines by the unknowns, shape (3, n): what follows a stretch moves with it.

        Those of rounded stretches are off by a share as small as their ramps.
        """
        x, y, _ = lines[-1].end
        found = []
        for stretch, line in zip(self.changed(unknowns), lines, strict=True):
            slopes, (from_x, from_y, _) = end_slopes(stretch, line, self._shape[1]), line.end
            slopes[:2] += np.array([[from_y - y], [x - from_x]]) * slopes[2]
            found.append(slopes)
        return np.hstack(found)

    def step(self, unknowns: Array, gap: Array, slopes: Array) -> Array:
        """Unknowns a Newton step of least scaled length ahead; those that it would take out of bounds end there."""
        free = np.ones(unknowns.size, np.bool_)
        found = unknowns.copy()
        while free.any():
            left = gap - slopes @ (found - unknowns)
            change = np.linalg.lstsq(slopes[:, free] * self._scale[free], left, rcond=1e-12)[0]
            change *= min(1.0, LARGEST_CHANGE / max(np.abs(change).max(), 1e-300))
            trial = found.copy()
            trial[free] += change * self._scale[free]
            outside = (trial < self.lower) | (trial > self.upper)
            if not outside.any():
                return trial
            found[outside] = np.clip(trial, self.lower, self.upper)[outside]
            free &= ~outside
        return found
