"""Which operating points a table holds: ranges drawn from the vehicle, steps, nodes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from trackctl.errors import UsageError
from trackctl.lut.axes import FULL_CIRCLE, Array, Axes
from trackctl.profiles.vehicle import VehicleProfile

#: Slowest speed of a table, as a share of the vehicle's top speed.
SLOWEST_SHARE = 0.05
#: Largest radius of a table, in gauges, and least radius, in half gauges.
LARGEST_RADIUS_GAUGES = 60.0
LEAST_RADIUS_HALF_GAUGES = 1.2
#: Steepest slope that a table may hold. [rad]
STEEPEST_SLOPE = math.radians(45.0)
#: More would take gigabytes of memory, and of disk ten times as many.
MOST_CELLS = 10**8
#: Shares of a step that a range may differ from a whole number of steps by.
WHOLE = 1e-9


@dataclass(frozen=True, slots=True)
class Ranges:
    """Ends of the axes, both included.

    Attributes
    ----------
    velocity
        [m/s]
    radius
        Of turns to either side. [m]
    heading
        [rad]
    """

    velocity: tuple[float, float]
    radius: tuple[float, float]
    heading: tuple[float, float]

    @property
    def is_full_circle(self) -> bool:
        """Whether the headings go all the way round."""
        return self.heading[1] - self.heading[0] >= FULL_CIRCLE * (1.0 - WHOLE)

    @property
    def ends_at_start(self) -> bool:
        """Whether the last heading is 360 degrees, the same as 0."""
        return self.heading[1] >= FULL_CIRCLE * (1.0 - WHOLE)


@dataclass(frozen=True, slots=True)
class Divisions:
    """Number of steps along the range of velocity, radius and heading."""

    velocity: int
    radius: int
    heading: int


def default_ranges(vehicle: VehicleProfile) -> Ranges:
    """Ranges that suit a vehicle: up to its top speed, from its tightest turn to 60 gauges, full circle."""
    least = vehicle.min_turn_radius or LEAST_RADIUS_HALF_GAUGES * 0.5 * vehicle.track_gauge
    largest = max(LARGEST_RADIUS_GAUGES * vehicle.track_gauge, 2.0 * least)
    return Ranges(
        velocity=(SLOWEST_SHARE * vehicle.max_speed, vehicle.max_speed),
        radius=(least, largest),
        heading=(0.0, FULL_CIRCLE),
    )


def check_ranges(vehicle: VehicleProfile, slope: Array, ranges: Ranges) -> None:
    """Refuse operating points that no table can hold.

    Raises
    ------
    UsageError
        Naming the option, its value and what is allowed.
    """
    for angle in slope:
        if not 0.0 <= angle < STEEPEST_SLOPE:
            raise UsageError("--slope-deg", f"{math.degrees(angle):g}", "0 or more, below 45")
    low, high = ranges.velocity
    if not 0.0 < low <= high < math.inf:
        raise UsageError("--velocity-mps", f"{low:g}:{high:g}", "MIN:MAX with 0 < MIN <= MAX")
    low, high = ranges.radius
    half_gauge = 0.5 * vehicle.track_gauge
    if not half_gauge < low <= high < math.inf:
        allowed = f"MIN:MAX with {half_gauge:g} (half the gauge) < MIN <= MAX"
        raise UsageError("--radius-m", f"{low:g}:{high:g}", allowed)
    low, high = ranges.heading
    if not (0.0 <= low <= high <= FULL_CIRCLE * (1.0 + WHOLE) and low < FULL_CIRCLE * (1.0 - WHOLE)):
        given = f"{math.degrees(low):g}:{math.degrees(high):g}"
        raise UsageError("--heading-deg", given, "MIN:MAX with 0 <= MIN < 360 and MIN <= MAX <= 360")


def divisions_of(width: float, step: float, option: str) -> int:
    """Least number of equal steps, none longer than `step`, that make up a range.

    Raises
    ------
    UsageError
        If the step is not positive, or far too many fit.
    """
    if not 0.0 < step < math.inf:
        raise UsageError(option, f"{step:g}", "a positive step")
    count = width / step
    if count > MOST_CELLS:
        raise UsageError(option, f"{step:g}", f"a step that fits at most {MOST_CELLS:g} times into its range")
    return max(math.ceil(count - WHOLE), 1) if width > 0.0 else 0


def make_axes(vehicle: VehicleProfile, slope: Array, ranges: Ranges, divisions: Divisions) -> Axes:
    """Nodes of a table: uniform in velocity, radius and heading, with straight driving always.

    A vehicle with its mass centre off the centreline needs turns to both sides; otherwise right turns are mirrored left
    turns and are left out.

    Raises
    ------
    UsageError
        If the table would hold more than `MOST_CELLS` cells.
    """
    cells = slope.size * cell_count(vehicle, ranges, divisions)
    if cells > MOST_CELLS:
        raise UsageError("--steps", f"a table of {cells:.3g} cells", f"at most {MOST_CELLS:.3g} cells")
    left = 1.0 / np.linspace(*ranges.radius, nodes(ranges.radius, divisions.radius))[::-1]
    right = -left[::-1] if vehicle.cog_left != 0.0 else np.empty(0)
    headings = heading_count(ranges, divisions.heading)
    heading = np.linspace(*ranges.heading, nodes(ranges.heading, divisions.heading))
    return Axes(
        slope=slope,
        velocity=np.linspace(*ranges.velocity, nodes(ranges.velocity, divisions.velocity)),
        curvature=np.concatenate((right, [0.0], left)),
        heading=heading[:headings],
        heading_is_periodic=ranges.is_full_circle and headings > 1,
    )


def nodes(ends: tuple[float, float], divisions: int) -> int:
    """Nodes of a range that holds both its ends."""
    return divisions + 1 if ends[1] > ends[0] else 1


def curvature_count(vehicle: VehicleProfile, ranges: Ranges, divisions: int) -> int:
    """Nodes of the curvature axis: both sides if the vehicle is not symmetric, and straight driving."""
    sides = 2 if vehicle.cog_left != 0.0 else 1
    return sides * nodes(ranges.radius, divisions) + 1


def heading_count(ranges: Ranges, divisions: int) -> int:
    """Nodes of the heading axis: an end of 360 degrees is the same as 0, and dropped."""
    return nodes(ranges.heading, divisions) - int(ranges.ends_at_start)


def cell_count(vehicle: VehicleProfile, ranges: Ranges, divisions: Divisions) -> int:
    """Cells of a table of one slope."""
    return (
        nodes(ranges.velocity, divisions.velocity)
        * curvature_count(vehicle, ranges, divisions.radius)
        * heading_count(ranges, divisions.heading)
    )
