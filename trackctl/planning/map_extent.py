"""Whether a pose lies on a map."""

from __future__ import annotations

from trackctl.errors import MapError
from trackctl.planning.occupancy import GridFrame
from trackctl.planning.planning_map import PlanningMap, Pose, grid_frame


def refuse_outside(planning_map: PlanningMap, name: str, pose: Pose) -> None:
    """Refuse a pose whose position is not on the map.

    Parameters
    ----------
    planning_map
        The map.
    name
        What the pose is, such as ``start``.
    pose
        x, y [m] and yaw [rad].

    Raises
    ------
    MapError
        If it lies outside; names where, and how far the map reaches.
    """
    frame = grid_frame(planning_map)
    if frame.cell(*pose[:2]) is None:
        place = f"({pose[0]:.10g}, {pose[1]:.10g}) m"
        raise MapError(planning_map.file, f"{name}: {place} lies outside the map; allowed: {_reach(frame)}", key=name)


def _reach(frame: GridFrame) -> str:
    """How far a grid reaches: from corner to corner, or by all four where it is turned."""
    ends = ((0, 0), (frame.n_columns, 0), (frame.n_columns, frame.n_rows), (0, frame.n_rows))
    corners = [frame.to_world(float(column), float(row)) for column, row in ends]
    texts = [f"({x:.10g}, {y:.10g})" for x, y in corners]
    return f"from {texts[0]} to {texts[2]} m" if frame.yaw == 0.0 else f"between the corners {', '.join(texts)} m"
