"""Maps in YAML: those of ROS as they are, with keys of our own for a plan."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from trackctl.errors import MapError, ProfileError
from trackctl.files.elevation_file import read_elevation
from trackctl.files.map_keys import file_name, find, in_metres, in_unit, named_by, obstacles, pose, tolerance
from trackctl.files.profile_folders import is_name
from trackctl.files.ros_map import COARSEST, FINEST, IMAGE_KEYS, Entries, cell_width, read_occupancy
from trackctl.files.strict_yaml import STDIN, read_entries, read_text
from trackctl.planning.planning_map import PlanningMap
from trackctl.units import accepted_keys

STEEPEST, MOST_TURNED = math.radians(44.9), 20.0 * math.pi
PLAN_KEYS = (
    "start", "goal", "goal_tolerance", "slope_deg", "uphill_yaw_deg", "elevation", "elevation_resolution_m",
    "elevation_origin_m", "obstacles", "bounds_m", "vehicle", "terrain", "lut",
)  # fmt: skip


def read_map_yaml(source: str) -> PlanningMap:
    """A map and what it lays down for a plan, from a file or ``-`` for standard input.

    Files that it names lie in its folder unless their path is whole. Keys that are neither ours nor map_server's are
    left alone, as in ROS.

    Raises
    ------
    MapError
        If the file, or one that it names, is none; names line, key, value and what is allowed.
    """
    try:
        text, file = read_text(source)
        if not text.strip():
            raise MapError(file, "is empty; allowed: a map")
        entries = read_entries(text, file, hint="")
        if not any(find(entries, key) for key in (*IMAGE_KEYS, *PLAN_KEYS)):
            raise MapError(file, f"is no map; allowed: {', '.join(IMAGE_KEYS)}, and {', '.join(PLAN_KEYS)}")
        return _planning_map(entries, file, Path("." if source == STDIN else source).parent)
    except ProfileError as error:
        raise MapError(error.file, error.problem, error.line, error.key, error.value) from error


def _planning_map(entries: Entries, file: str, folder: Path) -> PlanningMap:
    readers = {"start": pose, "goal": pose, "goal_tolerance": tolerance, "resolution": cell_width}
    fields: dict[str, Any] = {key: reader(entries[key]) for key, reader in readers.items() if key in entries}
    if "obstacles" in entries:
        fields["circles"], fields["polygons"] = obstacles(entries["obstacles"])
    parts = _ground(entries, folder), _bounds(entries), _named(entries, folder)
    for part in parts:
        fields |= part
    notes = (*fields.pop("notes", ()), *_misspelt(entries))
    return PlanningMap(file=file, occupancy=read_occupancy(entries, file, folder), notes=notes, **fields)


def _ground(entries: Entries, folder: Path) -> dict[str, Any]:
    """The plane or the elevation grid, as far as given."""
    slope, uphill = find(entries, "slope_deg"), find(entries, "uphill_yaw_deg")
    width, corner = find(entries, "elevation_resolution_m"), find(entries, "elevation_origin_m")
    elevation = entries.get("elevation")
    if slope and elevation:
        raise slope.error("stands beside elevation; allowed: one of the two")
    for entry, needed, name in ((uphill, slope, "slope_deg"), (width or corner, elevation, "elevation")):
        if entry and not needed:
            raise entry.error(f"stands without {name}; allowed: both")
    if elevation:
        spacing = in_unit(width, FINEST, COARSEST) if width else None
        origin = in_metres(corner, ("x", "y")) if corner else None
        with named_by(elevation):
            grid, notes = read_elevation(folder / file_name(elevation), spacing, origin)
        return {"elevation": grid, "notes": notes}
    fields = {"slope": in_unit(slope, 0.0, STEEPEST)} if slope else {}
    return fields | {"uphill_yaw": in_unit(uphill, -MOST_TURNED, MOST_TURNED)} if uphill else fields


def _bounds(entries: Entries) -> dict[str, Any]:
    entry = find(entries, "bounds_m")
    if entry is None:
        return {}
    if "image" in entries or "elevation" in entries:
        raise entry.error("stands beside image or elevation, which have bounds; allowed: one of them")
    left, low, right, high = in_metres(entry, ("x_min", "y_min", "x_max", "y_max"))
    if not (left < right and low < high):
        raise entry.error("is empty; allowed: x_min below x_max, y_min below y_max")
    return {"bounds": (left, low, right, high)}


def _named(entries: Entries, folder: Path) -> dict[str, Any]:
    """Profiles by their names or as files, and the look-up table as a file."""
    names = {key: file_name(entries[key]) for key in ("vehicle", "terrain", "lut") if key in entries}
    return {key: name if key != "lut" and is_name(name) else str(folder / name) for key, name in names.items()}


def _misspelt(entries: Entries) -> Iterator[str]:
    """A sentence for each key that is left alone but nearly one of ours."""
    for key, entry in entries.items():
        near = difflib.get_close_matches(key, PLAN_KEYS, n=1, cutoff=0.7)
        if near and key not in IMAGE_KEYS and key not in accepted_keys(near[0]):
            yield f"{entry.file}, line {entry.line}: {key} is no key of a plan and left alone; did you mean {near[0]}?"
