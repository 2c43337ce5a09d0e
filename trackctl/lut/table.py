"""A look-up table in memory: what each cell holds, and where it came from."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from trackctl.lut.axes import Array, Axes
from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import VehicleProfile


class Status(IntEnum):
    """What became of a cell. The order is that of the file's ``flag_values``."""

    CONVERGED = 0
    INFEASIBLE_GRIP = 1
    INFEASIBLE_LIFTOFF = 2
    INFEASIBLE_PITCHOVER = 3
    OUTSIDE_MODEL = 4
    NOT_CONVERGED = 5


#: Float variables of a table, in file order, with unit and long name.
VARIABLES: dict[str, tuple[str, str]] = {
    "sprocket_rate_left": ("rad/s", "angular velocity of the left sprocket"),
    "sprocket_rate_right": ("rad/s", "angular velocity of the right sprocket"),
    "sideslip": ("rad", "angle from the body x axis to the velocity of the mass centre, counter-clockwise"),
    "slip_left": ("1", "slip of the left track, positive driving, negative braking"),
    "slip_right": ("1", "slip of the right track, positive driving, negative braking"),
    "traction_left": (
        "N",
        "longitudinal shear force of the ground on the left track, resistance not included",
    ),
    "traction_right": (
        "N",
        "longitudinal shear force of the ground on the right track, resistance not included",
    ),
    "residual": ("1", "largest balance residual, in units of weight and weight times contact length"),
}


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """A compiled look-up table.

    Attributes
    ----------
    axes
        Grid nodes.
    values
        One array per name of `VARIABLES`, shape `axes.shape`; NaN where `status` is not converged
        (`residual` holds the best found there).
    status
        `Status` of each cell, shape `axes.shape`, uint8.
    vehicle, terrain
        The profiles it was compiled from.
    gravity
        Standard gravity unless told otherwise. [m/s2]
    attributes
        The other root attributes of the file: settings, seed, certificate, history.
    """

    axes: Axes
    values: dict[str, Array]
    status: NDArray[np.uint8]
    vehicle: VehicleProfile
    terrain: TerrainProfile
    gravity: float
    attributes: dict[str, object] = field(default_factory=dict)

    @property
    def stores_left_turns_only(self) -> bool:
        """Whether right turns are to be read as mirrored left turns."""
        return bool(self.axes.curvature[0] >= 0.0)
