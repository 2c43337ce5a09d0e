"""The picture of a plan on its map."""

from __future__ import annotations

from pathlib import Path

from trackctl.files.atomic import whole_file
from trackctl.planning.planning_map import PlanningMap
from trackctl.plots import style
from trackctl.plots.plan import draw_plan
from trackctl.plots.saving import save
from trackctl.units import split_suffix
from trackctl.workflows.map_picture import map_image
from trackctl.workflows.plan import PlanResult
from trackctl.workflows.plan_rows import columns_of


def draw(result: PlanResult, planning_map: PlanningMap, picture: Path, force: bool) -> None:
    """Draw a plan, its map and the body along it to a file.

    Raises
    ------
    OutputError
        If the picture cannot be written.
    """
    columns = {split_suffix(header)[0]: values for header, values in columns_of(result.rows).items()}
    with style.applied():
        figure = draw_plan(columns, map_image(planning_map, result.grid), result.outline)
        with whole_file(picture, force) as path:
            save(figure, path)
