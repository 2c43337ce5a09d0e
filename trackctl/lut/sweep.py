"""A table to be solved column by column, in any order."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from trackctl.lut.axes import Array, Axes
from trackctl.lut.cells import Cells, pending_cells
from trackctl.lut.column import Column, compile_column, solve_column
from trackctl.lut.point import compile_batch, solve_batch
from trackctl.lut.solver import load_procedures, solver
from trackctl.lut.table import Status
from trackctl.mechanics.parameters import TrackModel
from trackctl.mechanics.slip import body_speed, slip


class Seeding(StrEnum):
    """Where a cell's solver starts."""

    CONTINUATION = "continuation"
    PSO = "pso"


@dataclass(frozen=True, slots=True, eq=False)
class Sweep:
    """All that the cells of a table depend on.

    Attributes
    ----------
    model
        Vehicle on its terrain.
    axes
        Grid nodes.
    seeding
        By continuation from neighbours, or by a swarm in every cell.
    seed
        Of the swarms.
    """

    model: TrackModel
    axes: Axes
    seeding: Seeding
    seed: int

    @property
    def column_count(self) -> int:
        """Number of columns: one for each slope and curvature."""
        return self.axes.slope.size * self.axes.curvature.size

    def place(self, column: int) -> tuple[int, int]:
        """Slope and curvature index of a column."""
        return divmod(column, self.axes.curvature.size)


def load_kernels(seeding: Seeding) -> None:
    """Compile what solves a column, or load it: not in threads, since an interrupt waits for what they compile."""
    load_procedures()
    if seeding is Seeding.CONTINUATION:
        compile_column()
    else:
        compile_batch()


def solve(sweep: Sweep, column: int) -> Cells:
    """Cells of one column, shape (n_velocity, n_heading); they depend on no other column."""
    axes = sweep.axes
    slope_index, curvature_index = sweep.place(column)
    slope, curvature = float(axes.slope[slope_index]), float(axes.curvature[curvature_index])
    shape = axes.velocity.size, axes.heading.size
    cells = pending_cells(shape)
    if sweep.seeding is Seeding.CONTINUATION:
        velocity, heading = np.array(axes.velocity), np.array(axes.heading)
        asked = Column(slope, curvature, velocity, heading, axes.heading_is_periodic, sweep.seed)
        solve_column(solver(sweep.model), asked, cells)
    else:
        velocity, heading = np.meshgrid(axes.velocity, axes.heading, indexing="ij")
        columns = (np.full(shape, slope), velocity, np.full(shape, curvature), heading)
        points = np.stack(columns, axis=-1).reshape(-1, 4)
        solve_batch(solver(sweep.model), points, sweep.seed, column * points.shape[0], False, cells.reshape(-1))
    return cells


def column_values(sweep: Sweep, column: int, cells: Cells, sprocket_radius: float, weight: float) -> dict[str, Array]:
    """Variables of a table for one column.

    Parameters
    ----------
    sweep, column, cells
        The column and what `solve` gave for it.
    sprocket_radius
        [m]
    weight
        m g. [N]

    Returns
    -------
    dict
        One array of shape (n_velocity, n_heading) per name of `VARIABLES`; NaN where not converged, except `residual`.
    """
    model = sweep.model
    curvature = float(sweep.axes.curvature[sweep.place(column)[1]])
    converged = cells["status"] == Status.CONVERGED
    unknowns = np.where(converged[..., None], cells["unknowns"], np.nan)
    traction = np.where(converged[..., None], cells["traction"], np.nan) * weight
    sideslip = unknowns[..., 2]
    velocity = sweep.axes.velocity[:, None]
    values = {"sideslip": sideslip, "residual": cells["residual"]}
    for track, side in enumerate(("left", "right")):
        arm = (0.5 - track) * model.gauge - model.cog_left
        values[f"sprocket_rate_{side}"] = unknowns[..., track] * velocity / sprocket_radius
        values[f"slip_{side}"] = slip(unknowns[..., track], body_speed(1.0, curvature, sideslip, arm))
        values[f"traction_{side}"] = traction[..., track]
    return values
