"""Maps in YAML: those of ROS as they are, with keys of our own for a plan."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from trackctl.errors import MapError, ProfileError
from trackctl.files.map_image import read_image
from trackctl.files.map_keys import (
    FARTHEST,
    file_name,
    in_unit,
    numbers,
    obstacles,
    pose,
    ranged,
    tolerance,
    truth,
)
from trackctl.files.profile_folders import is_name
from trackctl.files.ros_map import MapMode, Shades, occupancy_cells
from trackctl.files.strict_yaml import STDIN, Entry, plain_text, read_entries, read_text
from trackctl.planning.occupancy import GridFrame, Occupancy
from trackctl.planning.planning_map import Bounds, PlanningMap
from trackctl.units import accepted_keys

Entries = Mapping[str, Entry]

FINEST, COARSEST = 1e-4, 1e4  # [m]
STEEPEST = math.radians(45.0)
PLACE = (-FARTHEST, FARTHEST)
#: What a map with an image must hold, as map_server asks.
IMAGE_KEYS = ("image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh")
#: Keys of our own.
PLAN_KEYS = (
    "start",
    "goal",
    "goal_tolerance",
    "slope_deg",
    "uphill_yaw_deg",
    "elevation",
    "obstacles",
    "bounds_m",
    "vehicle",
    "terrain",
    "lut",
)


def read_map_yaml(source: str) -> PlanningMap:
    """A map and what it lays down for a plan, from a file or ``-`` for standard input.

    Keys that are neither ours nor map_server's are left alone, as in ROS.

    Raises
    ------
    MapError
        If the file, or one that it names, is none; names line, key, value and what is allowed.
    """
    try:
        text, file = read_text(source)
        if not text.strip():
            raise MapError(file, "is empty; allowed: a map")
        return planning_map(read_entries(text, file), file, Path("." if source == STDIN else source).parent)
    except ProfileError as error:
        raise MapError(error.file, error.problem, error.line, error.key, error.value) from error


def planning_map(entries: Entries, file: str, folder: Path) -> PlanningMap:
    """The map that the entries of a file describe; files that they name lie in `folder` or have a whole path."""
    known = [_find(entries, key) for key in (*IMAGE_KEYS, *PLAN_KEYS)]
    if not any(known):
        raise MapError(file, f"is no map; allowed: {', '.join(IMAGE_KEYS)}, and {', '.join(PLAN_KEYS)}")
    has_image = any(key in entries for key in IMAGE_KEYS if key != "resolution")
    fields: dict[str, Any] = {"occupancy": _occupancy(entries, file, folder)} if has_image else {}
    for name, entry in entries.items():
        if name in ("start", "goal"):
            fields[name] = pose(entry)
        elif name in ("vehicle", "terrain"):
            profile = file_name(entry)
            fields[name] = profile if is_name(profile) else str(folder / profile)
    if "obstacles" in entries:
        fields["circles"], fields["polygons"] = obstacles(entries["obstacles"])
    if "goal_tolerance" in entries:
        fields["goal_tolerance"] = tolerance(entries["goal_tolerance"])
    if "lut" in entries:
        fields["lut"] = str(folder / file_name(entries["lut"]))
    if "resolution" in entries:
        fields["resolution"] = ranged(entries["resolution"], FINEST, COARSEST)
    return PlanningMap(file=file, bounds=_bounds(entries), notes=tuple(_misspelt(entries)), **_plane(entries), **fields)


def _find(entries: Entries, key: str) -> Entry | None:
    """The entry of a key in whatever unit."""
    found = [entries[other] for other in accepted_keys(key) if other in entries]
    if len(found) > 1:
        raise found[1].error(f"stands in line {found[0].line} as {found[0].key}; allowed: one of the two")
    return found[0] if found else None


def _occupancy(entries: Entries, file: str, folder: Path) -> Occupancy:
    missing = [key for key in IMAGE_KEYS if key not in entries]
    if missing:
        raise MapError(file, f"missing keys of a map with an image: {', '.join(missing)}")
    shades = _shades(entries)
    resolution = ranged(entries["resolution"], FINEST, COARSEST)
    place = {"x": PLACE, "y": PLACE, "yaw": (-1000.0, 1000.0)}
    x, y, yaw = numbers(entries["origin"], place)
    path = folder / file_name(entries["image"])
    cells = occupancy_cells(read_image(path), shades)
    return Occupancy(cells, GridFrame(cells.shape[0], cells.shape[1], resolution, x, y, yaw), str(path))


def _shades(entries: Entries) -> Shades:
    mode = plain_text(entries["mode"]) if "mode" in entries else MapMode.TRINARY
    if mode not in list(MapMode):
        raise entries["mode"].error(f"{mode!r} is not allowed; allowed: {', '.join(MapMode)}", mode)
    occupied = ranged(entries["occupied_thresh"], 0.0, 1.0)
    free = ranged(entries["free_thresh"], 0.0, 1.0)
    if free > occupied:
        raise entries["free_thresh"].error(f"{free:g} is above occupied_thresh; allowed: up to {occupied:g}", free)
    return Shades(MapMode(mode), truth(entries["negate"]), occupied, free)


def _plane(entries: Entries) -> dict[str, Any]:
    """The plane's slope and direction, as far as given."""
    slope, uphill = _find(entries, "slope_deg"), _find(entries, "uphill_yaw_deg")
    if slope is None:
        if uphill is not None:
            raise uphill.error("stands without slope_deg; allowed: both")
        return {}
    if "elevation" in entries:
        raise slope.error("stands beside elevation; allowed: one of the two")
    plane = {"slope": in_unit(slope, 0.0, STEEPEST)}
    return plane if uphill is None else plane | {"uphill_yaw": in_unit(uphill, -20.0 * math.pi, 20.0 * math.pi)}


def _bounds(entries: Entries) -> Bounds | None:
    entry = _find(entries, "bounds_m")
    if entry is None:
        return None
    if "image" in entries or "elevation" in entries:
        raise entry.error("stands beside image or elevation, which have bounds; allowed: one of them")
    size = accepted_keys(entry.key)[entry.key]
    names = ("x_min", "y_min", "x_max", "y_max")
    left, low, right, high = (size * value for value in numbers(entry, dict.fromkeys(names, PLACE)))
    if not (left < right and low < high):
        raise entry.error("is empty; allowed: x_min below x_max, y_min below y_max")
    return left, low, right, high


def _misspelt(entries: Entries) -> Iterable[str]:
    """A sentence for each key that is left alone but nearly one of ours."""
    for key, entry in entries.items():
        near = difflib.get_close_matches(key, PLAN_KEYS, n=1, cutoff=0.8)
        if near and key not in IMAGE_KEYS and key not in accepted_keys(near[0]):
            yield f"{entry.file}, line {entry.line}: {key} is no key of a plan and left alone; did you mean {near[0]}?"
