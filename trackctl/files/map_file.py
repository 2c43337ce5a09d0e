"""Any map: what kind it is, and its reading."""

from __future__ import annotations

from trackctl.files.map_yaml import read_map_yaml
from trackctl.planning.planning_map import PlanningMap


def read_planning_map(source: str) -> PlanningMap:
    """A map by the ending of its name: YAML where there is no other, ``-`` for standard input.

    Raises
    ------
    MapError
        If it is none; names file, line, key, value and what is allowed.
    """
    return read_map_yaml(source)
