"""The path that `forces` is asked about, from numbers or waypoints."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackctl.errors import InputFileError, UsageError
from trackctl.files.path_csv import Waypoints
from trackctl.geometry.bspline import Spline
from trackctl.geometry.clothoid_path import arc, clothoid_arc_clothoid
from trackctl.geometry.path import Path
from trackctl.geometry.smoothing import fit_spline
from trackctl.geometry.spline_path import SplinePath, fit_path, has_cusp, rounded

Array = NDArray[np.float64]

LONGEST = 1e5  # [m]
#: Degree of the spline through the squares of given speeds, and how far it may leave the largest, as a share.
SPEED_DEGREE = 3
SPEED_TOLERANCE = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class ForcesPath:
    """A path to follow.

    Attributes
    ----------
    path
        The curve.
    squared_speed
        Along it, as the waypoints have it, if they do. [m2/s2]
    notes
        What a user should know about how it came about.
    """

    path: Path
    squared_speed: Spline | None = None
    notes: tuple[str, ...] = ()


def arc_path(radius: float, angle: float) -> ForcesPath:
    """A circle or a part of one; see `arc`."""
    check_length("--arc-deg", math.degrees(angle), abs(radius) * angle)
    return ForcesPath(arc(radius, angle))


def clothoid_path(
    radius: float, entry: float, middle: float, exit_length: float, transition: float | None = None
) -> ForcesPath:
    """A curve between two straights; a `transition` takes the place of a clothoid without length. [m]"""
    entry, exit_length = (length or transition or 0.0 for length in (entry, exit_length))
    check_length("--clothoid", f"{entry:g},{middle:g},{exit_length:g}", entry + middle + exit_length)
    path = clothoid_arc_clothoid(radius, entry, middle, exit_length)
    note = "the curvature jumps where a straight meets the arc; --transition-length-m puts a clothoid between"
    return ForcesPath(path, notes=(note,) if path.jumps.size else ())


def check_length(option: str, value: object, length: float) -> None:
    """Refuse a path of no length, or an overlong one."""
    if not 0.0 < length <= LONGEST:
        raise UsageError(option, value, f"a path longer than 0 and up to {LONGEST:g} m; this one has {length:g} m")


def waypoint_path(waypoints: Waypoints, tolerance: float, transition: float | None) -> ForcesPath:
    """A curve of continuous curvature along waypoints.

    Parameters
    ----------
    waypoints
        Points, and perhaps speeds.
    tolerance
        How far the curve may leave them to even out their scatter. [m]
    transition
        Length to draw jumps of curvature out to, None to leave them as the waypoints have them. [m]

    Raises
    ------
    InputFileError
        If the curve is too long or has a cusp, or the speed stops between waypoints.
    """
    path, fit = fit_path(waypoints.x, waypoints.y, tolerance)
    if path.length > LONGEST:
        raise InputFileError(waypoints.file, f"the path is {path.length:g} m long; allowed: up to {LONGEST:g} m")
    if has_cusp(path):
        raise InputFileError(
            waypoints.file, "the curve through the waypoints has a cusp; allowed: waypoints closer together in bends"
        )
    squared = None if waypoints.speed is None else squared_speed(waypoints, path)
    pieces = np.unique(fit.spline.space.knots).size - 1
    notes = [f"curve of {pieces} pieces, at most {fit.deviation:.2g} m from the waypoints"]
    if waypoints.repeated:
        notes.append(f"{waypoints.repeated} repeated waypoints left out")
    if transition is not None:
        if transition > path.length:
            raise UsageError("--transition-length-m", transition, f"up to the path's length, {path.length:g} m")
        path, moved, length = *rounded(path, transition), path.length
        squared = squared and stretched(squared, path.length / length)
        notes.append(f"rounding moves the path by up to {moved:.2g} m")
    return ForcesPath(path, squared, tuple(notes))


def squared_speed(waypoints: Waypoints, path: SplinePath) -> Spline:
    """The squares of the waypoints' speeds over the arc length of the path along them. [m2/s2]"""
    speed = np.asarray(waypoints.speed)
    chords = np.hypot(np.diff(waypoints.x), np.diff(waypoints.y))
    parameter = np.concatenate(([0.0], np.cumsum(chords)))
    places = np.interp(parameter, path.parameters, path.arc_lengths)
    largest = float(speed.max()) ** 2
    if largest == 0.0:
        raise InputFileError(waypoints.file, "all speeds are 0; allowed: above 0 between the ends")
    fit = fit_spline(places, speed[:, None] ** 2, SPEED_DEGREE, SPEED_TOLERANCE * largest)
    spline = Spline(fit.spline.space, fit.spline.coefficients[:, 0])
    inside = np.linspace(places[0], places[-1], 8 * places.size + 1)[1:-1]
    if spline(inside).min() <= 0.0:
        raise InputFileError(
            waypoints.file,
            "a smooth speed through these falls to 0 on the way; allowed: gentler changes",
        )
    return spline


def stretched(spline: Spline, factor: float) -> Spline:
    """A spline over an axis that is longer by a factor."""
    return Spline(type(spline.space)(spline.space.knots * factor, spline.space.degree), spline.coefficients)
