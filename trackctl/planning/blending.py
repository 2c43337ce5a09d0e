"""Ways whose curvature does not jump: the arcs of a route blended into each other, with the same ends.

The curvature of a route is averaged over a moving window of the blend's length: every jump becomes a ramp of that
length, turns keep their angles, and pieces shorter than the window are rounded off. The curvature is 0 at both ends of
a stretch, which is longer than its pieces by one blend, half of it at either end: a route is best searched between
poses half a blend ahead of the start and short of the goal. What then is missing to the goal, little, is shared out
among lengths and curvatures of the pieces, and turns on the spot where there are some, with the least change.
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
#: Scale of a change of curvature, over the sharpest allowed, and of a turn on the spot [rad]; that of lengths is a
#: blend.
CURVATURE_SHARE, TURN_SCALE = 0.1, 0.1
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


@dataclass(frozen=True, slots=True, eq=False)
class Blended:
    """What a route is blended into.

    Attributes
    ----------
    lines
        One after the other, with a stop between them.
    turns
        On the spot: before each line and after the last, shape (n + 1,); 0 for none. [rad]
    """

    lines: tuple[Line, ...]
    turns: Array

    @property
    def goal(self) -> Array:
        """x, y [m] and tangent [rad] at the end; of one line at least."""
        x, y, direction = self.lines[-1].end
        return np.array([x, y, (direction - math.pi if self.lines[-1].backwards else direction) + self.turns[-1]])


def stretches_of(route: Route) -> tuple[list[Stretch], Array]:
    """The stretches of a route, and the turns on the spot before each and after the last. [rad]

    Pieces of one curvature that follow each other are one.
    """
    found: list[Stretch] = []
    turns = [0.0]
    pieces = (part.tolist() for part in (route.curvature, route.length, route.pivot))
    for curvature, length, turn in zip(*pieces, strict=True):
        turns[-1] += turn
        if length == 0.0:
            continue
        backwards = length < 0.0
        curvature = -curvature if backwards else curvature
        if not found or found[-1].backwards is not backwards or turns[-1] != 0.0:
            found.append(Stretch(backwards, np.array([curvature]), np.array([abs(length)])))
            turns.append(0.0)
            continue
        last = found[-1]
        if abs(curvature - last.curvature[-1]) < SAME_CURVATURE:
            last.length[-1] += abs(length)
        else:
            found[-1] = Stretch(backwards, np.append(last.curvature, curvature), np.append(last.length, abs(length)))
    return found, np.array(turns)


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


def chained(stretches: Sequence[Stretch], start: Pose, ramp: float, kinks: Array, shape: Shape) -> list[Line]:
    """Shaped stretches one after the other; the direction of travel turns round where the gear changes.

    Parameters
    ----------
    stretches
        At least one.
    start
        x, y [m] and tangent, which is the direction of travel forwards and its reverse backwards. [rad]
    ramp
        Length of a ramp of curvature. [m]
    kinks
        Turn of the tangent before each stretch but the first, shape (n - 1,). [rad]
    shape
        What makes lines of stretches: `blended` or `rounded`.
    """
    lines: list[Line] = []
    x, y, tangent = start
    for stretch, kink in zip(stretches, (0.0, *kinks), strict=True):
        tangent += kink
        direction = tangent + math.pi if stretch.backwards else tangent
        lines.append(shape(stretch, (x, y, direction), ramp))
        x, y, direction = lines[-1].end
        tangent = direction - math.pi if stretch.backwards else direction
    return lines


def divided(stretch: Stretch, blend: float, least: int) -> Stretch:
    """The same stretch with long pieces cut, so that a small change of course can be made within them."""
    parts = np.clip(np.ceil(stretch.length / (LONG * blend)).astype(int), least, MOST_PARTS)
    return replace(
        stretch, curvature=np.repeat(stretch.curvature, parts), length=np.repeat(stretch.length / parts, parts)
    )


def blended_route(
    route: Route, start: Pose, goal: Pose, blend: float, sharpest: float, kinks: Sequence[float] | None = None
) -> Blended | None:
    """Lines of continuous curvature along a route from start to goal, both exact.

    Parameters
    ----------
    route
        Best from half a blend ahead of the start to half a blend short of the goal.
    start, goal
        x, y [m] and tangent. [rad]
    blend
        Length of a ramp of curvature. [m]
    sharpest
        Largest curvature either way. [1/m]
    kinks
        Turn of the tangent between two lines, besides one on the spot, as the body keeps its yaw and its sideslip
        changes; None for none. [rad]

    Returns
    -------
    Blended
        None where lengths that are not negative and curvatures up to the sharpest do not reach the goal.
    """
    stretches, turns = stretches_of(route)
    if not stretches:
        return Blended((), turns) if math.dist(start[:2], goal[:2]) <= MET else None
    pieces = sum(stretch.length.size for stretch in stretches)
    stretches = [divided(stretch, blend, MOST_PARTS if pieces < MOST_PARTS else 1) for stretch in stretches]
    adjustment = Adjustment(stretches, turns, kinks, start, goal, blend, sharpest)
    found = met(adjustment)
    return None if found is None else adjustment.blended(found)


def jumping_route(
    route: Route, start: Pose, goal: Pose, blend: float, sharpest: float, kinks: Sequence[float] | None = None
) -> tuple[Blended, Blended] | None:
    """A route with its jumps of curvature, from start to goal, both exact, and its blended twin; see `blended_route`.

    Returns
    -------
    tuple of Blended
        The jumps are ramps of `JUMP`. The twin, of the same arc lengths, has ramps of a blend about the middles of the
        jumps, cut at the ends of stretches; it begins at the start and misses the goal. None as of `blended_route`.
    """
    stretches, turns = stretches_of(route)
    if not stretches:
        return None
    adjustment = Adjustment(stretches, turns, kinks, start, goal, blend, sharpest, JUMP)
    found = met(adjustment)
    return None if found is None else (adjustment.blended(found), adjustment.shaped(found, rounded, blend))


def met(adjustment: Adjustment) -> Array | None:
    """The unknowns with which the goal is met; None without."""
    unknowns: Array = np.clip(adjustment.first, adjustment.lower, adjustment.upper)
    for _ in range(NEWTON_STEPS):
        found = adjustment.blended(unknowns)
        gap = adjustment.gap(found)
        if np.abs(gap).max() <= MET:
            return unknowns
        unknowns = adjustment.step(unknowns, gap, adjustment.slopes(unknowns, found))
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
        Lengths and curvatures at first, stretch by stretch, and turns on the spot, shape (n,). [m], [1/m], [rad]
    lower, upper
        Their bounds.
    """

    def __init__(
        self,
        stretches: Sequence[Stretch],
        turns: Array,
        kinks: Sequence[float] | None,
        start: Pose,
        goal: Pose,
        blend: float,
        sharpest: float,
        jump: float | None = None,
    ) -> None:
        self._shape = (blended, blend) if jump is None else (rounded, jump)
        self._stretches, self._start, self._goal = stretches, start, np.array(goal)
        self._kinks = np.zeros(len(stretches) - 1) if kinks is None else np.array(kinks)
        self._turning = turns != 0.0
        self._cuts = np.cumsum([2 * stretch.length.size for stretch in stretches])
        parts = [part for each in stretches for part in (each.length, each.curvature)]
        self.first = np.concatenate((*parts, turns[self._turning]))
        is_length = np.concatenate([np.repeat([True, False], each.length.size) for each in stretches])
        free = np.full(np.count_nonzero(self._turning), np.inf)
        self.lower = np.concatenate((np.where(is_length, 0.0, -sharpest), -free))
        self.upper = np.concatenate((np.where(is_length, np.inf, sharpest), free))
        scale = np.where(is_length, blend, CURVATURE_SHARE * sharpest)
        self._scale = np.concatenate((scale, np.full_like(free, TURN_SCALE)))

    def _changed(self, unknowns: Array) -> tuple[list[Stretch], Array]:
        """The stretches, and the turns before each and after the last. [rad]"""
        *parts, angles = np.split(unknowns, self._cuts)
        turns = np.zeros(self._turning.size)
        turns[self._turning] = angles
        pairs = [np.split(part, 2) for part in parts]
        stretches = [
            replace(stretch, length=length, curvature=curvature)
            for stretch, (length, curvature) in zip(self._stretches, pairs, strict=True)
        ]
        return stretches, turns

    def shaped(self, unknowns: Array, shape: Shape, ramp: float) -> Blended:
        """Lines of some shape with ramps of some length [m], and turns."""
        stretches, turns = self._changed(unknowns)
        start = (*self._start[:2], self._start[2] + turns[0])
        return Blended(tuple(chained(stretches, start, ramp, self._kinks + turns[1:-1], shape)), turns)

    def blended(self, unknowns: Array) -> Blended:
        """What is to meet the goal."""
        return self.shaped(unknowns, *self._shape)

    def gap(self, found: Blended) -> Array:
        """What is missing to the goal, x, y [m] and tangent [rad], shape (3,)."""
        missing = self._goal - found.goal
        missing[2] = math.remainder(missing[2], 2.0 * math.pi)
        return missing

    def slopes(self, unknowns: Array, blended: Blended) -> Array:
        """Derivatives of the end by the unknowns, shape (3, n): what follows a stretch or a turn moves with it.

        Those of rounded stretches are off by a share as small as their ramps.
        """
        x, y, _ = blended.lines[-1].end
        found = []
        for stretch, line in zip(self._changed(unknowns)[0], blended.lines, strict=True):
            slopes, (from_x, from_y, _) = end_slopes(stretch, line, self._shape[1]), line.end
            slopes[:2] += np.array([[from_y - y], [x - from_x]]) * slopes[2]
            found.append(slopes)
        at = np.array([*(line.start[:2] for line in blended.lines), (x, y)])[self._turning]
        turned = np.stack((at[:, 1] - y, x - at[:, 0], np.ones(len(at))))
        return np.hstack((*found, turned))

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
