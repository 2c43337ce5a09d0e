"""Any map: what kind it is, and its reading."""

from __future__ import annotations

from pathlib import Path

from trackctl.files.elevation_file import is_elevation_file, read_elevation
from trackctl.files.map_yaml import read_map_yaml
from trackctl.files.movingai import read_movingai
from trackctl.planning.planning_map import PlanningMap


def read_planning_map(source: str) -> PlanningMap:
    """A map of the kind that the ending of its name tells, without one in YAML; ``-`` for YAML on standard input.

    `.map` is a MovingAI grid; an elevation grid is a map on which every place with a known slope is free.

    Raises
    ------
    MapError
        If it is none; names file, line, key, value and what is allowed.
    """
    if is_elevation_file(source):
        elevation, notes = read_elevation(Path(source))
        return PlanningMap(file=source, elevation=elevation, notes=notes)
    if source.lower().endswith(".map"):
        return read_movingai(Path(source))
    return read_map_yaml(source)
