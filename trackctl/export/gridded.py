"""A look-up table as arrays that any interpolation in a box takes: both turns, headings closed, no mirror to mind."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from trackctl.lut.axes import FULL_CIRCLE, Array, Axes
from trackctl.lut.table import VARIABLES, Status, Table

Indices = NDArray[np.intp]
Number = TypeVar("Number", np.float64, np.uint8)

#: Order of the dimensions: slope last, since a last dimension of 1 is none in MATLAB.
DIMENSIONS = ("velocity", "curvature", "heading", "slope")
#: Headings that differ by less are the same. [rad]
SAME_HEADING = 1e-9
RATIOS = ("speed_ratio_left", "speed_ratio_right")
#: Unit of each array.
UNITS = {
    "velocity": "m/s",
    "curvature": "1/m",
    "heading": "rad",
    "slope": "rad",
    **dict.fromkeys(RATIOS, "1"),
    **{name: unit for name, (unit, _) in VARIABLES.items()},
    "track_gauge": "m",
    "sprocket_radius": "m",
    "max_sprocket_rate": "rad/s",
    "gravity": "m/s2",
}


@dataclass(frozen=True, slots=True, eq=False)
class GriddedTable:
    """A table on the nodes of a box.

    Attributes
    ----------
    axes
        Nodes of each of `DIMENSIONS`, strictly ascending.
    values
        Each of `RATIOS` (track speed over the vehicle's) and `VARIABLES`, over `DIMENSIONS`; NaN (but for the residual)
        where there is no answer.
    status
        `Status` of each node.
    right_turns
        Whether right turns are inside, stored or mirrored; a symmetric table whose headings are not their own mirror
        image has left turns only, as has one that lacks them.
    """

    axes: dict[str, Array]
    values: dict[str, Array]
    status: NDArray[np.uint8]
    right_turns: bool

    @property
    def feasible(self) -> NDArray[np.bool_]:
        """Where there is an answer."""
        return np.asarray(self.status == Status.CONVERGED)


def gridded(table: Table) -> GriddedTable:
    """A table with its right turns and its headings closed."""
    axes = table.axes
    partner = mirror_headings(axes) if table.stores_left_turns_only and table.vehicle.cog_left == 0.0 else None
    curvature = axes.curvature
    if partner is not None:
        curvature = np.concatenate((-curvature[curvature > 0.0][::-1], curvature))
    heading = np.append(axes.heading, axes.heading[0] + FULL_CIRCLE) if axes.heading_is_periodic else axes.heading
    arrays = speed_ratios(table) | table.values
    return GriddedTable(
        {"velocity": axes.velocity, "curvature": curvature, "heading": heading, "slope": axes.slope},
        {name: spread(with_right_turns(arrays, name, axes, partner), heading.size) for name in arrays},
        spread(with_right_turns({"status": table.status}, "status", axes, partner), heading.size),
        right_turns=bool(curvature[0] < 0.0),
    )


def speed_ratios(table: Table) -> dict[str, Array]:
    """Track speeds over the vehicle's."""
    radius, velocity = table.vehicle.sprocket_radius, table.axes.velocity[:, None, None]
    rates = (table.values["sprocket_rate_left"], table.values["sprocket_rate_right"])
    return {name: rate * (radius / velocity) for name, rate in zip(RATIOS, rates, strict=True)}


def mirror_headings(axes: Axes) -> Indices | None:
    """Index of the mirror image of each heading, None if one is not on the axis."""
    images = np.mod(-axes.heading, FULL_CIRCLE)
    found = np.searchsorted(axes.heading, images - SAME_HEADING) % axes.heading.size
    apart = np.abs(np.mod(axes.heading[found] - images + np.pi, FULL_CIRCLE) - np.pi)
    return found if bool((apart <= SAME_HEADING).all()) else None


def with_right_turns(
    arrays: Mapping[str, NDArray[Number]], name: str, axes: Axes, partner: Indices | None
) -> NDArray[Number]:
    """An array with its right turns ahead of its left ones: sides change places, the sideslip its sign."""
    if partner is None:
        return arrays[name]
    turned = arrays[mirror_name(name)][:, :, axes.curvature > 0.0][:, :, ::-1][..., partner]
    return np.concatenate((-turned if name == "sideslip" else turned, arrays[name]), axis=2)


def mirror_name(name: str) -> str:
    """The same quantity of the other track."""
    for side, other in (("left", "right"), ("right", "left")):
        if name.endswith(f"_{side}"):
            return f"{name.removesuffix(side)}{other}"
    return name


def spread(array: NDArray[Number], headings: int) -> NDArray[Number]:
    """An array over `DIMENSIONS`, its headings going on from the first after the last."""
    around = np.arange(headings) % array.shape[-1]
    return np.moveaxis(array[..., around], 0, -1)
