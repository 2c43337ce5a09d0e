"""Writing of look-up tables, column by column, in constant memory."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Self

import h5py
import numpy as np
from h5py import h5d, h5p
from numpy.typing import NDArray

from trackctl import __version__
from trackctl.files import lut_format as layout
from trackctl.files import netcdf
from trackctl.files.deferred_errors import DeferredErrorFile
from trackctl.files.lut_sensitivity import add_sensitivity
from trackctl.files.profile_yaml import terrain_to_yaml, vehicle_to_yaml
from trackctl.lut.axes import Array, Axes
from trackctl.lut.table import VARIABLES, Status, Table
from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import VehicleProfile

if TYPE_CHECKING:
    from trackctl.sensitivity.pawn import PawnIndex


def write_lut(path: Path, table: Table, *, gzip: int | None = None) -> None:
    """Write a whole table; see `LutWriter`."""
    profiles = table.vehicle, table.terrain, table.gravity
    with LutWriter(path, table.axes, *profiles, table.attributes, gzip=gzip) as writer:
        for i, k in product(range(table.axes.slope.size), range(table.axes.curvature.size)):
            column = {name: values[i, :, k] for name, values in table.values.items()}
            writer.write_column(i, k, column, table.status[i, :, k])


class LutWriter:
    """A table being written, a context manager; every column must be there when it ends.

    A column holds all velocities and headings of one slope and curvature, and is one chunk of the file.
    Without compression its place is fixed beforehand: the bytes do not depend on the order of the columns.

    Parameters
    ----------
    path
        The file, emptied if it exists; meant to come from `whole_file`.
    axes
        Grid nodes.
    vehicle, terrain, gravity
        What the table is made for. Gravity: [m/s2]
    attributes
        Further root attributes: numbers, texts, or flat arrays of either.
    gzip
        Level of compression from 1 to 9, None for none.

    Raises
    ------
    OSError
        From any method, if the disk is full or the like.
    """

    def __init__(
        self,
        path: Path,
        axes: Axes,
        vehicle: VehicleProfile,
        terrain: TerrainProfile,
        gravity: float,
        attributes: Mapping[str, object],
        *,
        gzip: int | None = None,
    ) -> None:
        self._column_shape = axes.velocity.size, axes.heading.size
        self._is_compressed = gzip is not None
        self._unwritten = set(product(range(axes.slope.size), range(axes.curvature.size)))
        own = own_attributes(vehicle, terrain, gravity)
        with ExitStack() as on_error:
            self._stream = on_error.enter_context(DeferredErrorFile(path))
            self._file = on_error.enter_context(netcdf.new_file(self._stream))
            netcdf.set_attributes(self._file, {**own, **attributes, **own})
            add_coordinates(self._file, axes)
            self._datasets = {name: add_variable(self._file, name, axes, gzip) for name in layout.DTYPES}
            self._stream.raise_deferred()
            self._closing = on_error.pop_all()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, error_type: type[BaseException] | None, *_: object) -> None:
        try:
            self._closing.close()
        finally:
            self._stream.raise_deferred()
        if error_type is None and self._unwritten:
            raise RuntimeError(f"{len(self._unwritten)} columns of the table were not written")

    def write_column(
        self, slope_index: int, curvature_index: int, values: Mapping[str, Array], status: NDArray[np.uint8]
    ) -> None:
        """Write all velocities and headings of one slope and curvature.

        Parameters
        ----------
        slope_index, curvature_index
            Place on the axes.
        values : mapping of ndarray, shape (n_velocities, n_headings)
            One per name of `VARIABLES`; NaN where `status` is not converged, except for `residual`.
        status : ndarray, shape (n_velocities, n_headings)
            `Status` of each cell.
        """
        for name, dataset in self._datasets.items():
            column = np.ascontiguousarray(status if name == layout.STATUS else values[name], layout.DTYPES[name])
            if column.shape != self._column_shape:
                raise ValueError(f"{name}: {column.shape} is not the shape {self._column_shape} of a column")
            if self._is_compressed:
                dataset[slope_index, :, curvature_index] = column
            else:
                dataset.id.write_direct_chunk((slope_index, 0, curvature_index, 0), column)
        self._stream.raise_deferred()
        self._unwritten.discard((slope_index, curvature_index))

    def write_sensitivity(
        self,
        indices: Sequence[PawnIndex],
        sample_names: Sequence[str],
        samples: Array,
        attributes: Mapping[str, object],
    ) -> None:
        """Write the analysis that the steps of the axes were drawn from.

        Parameters
        ----------
        indices
            One per output, input and statistic.
        sample_names
            Names of the inputs, then of the outputs: the columns of `samples`.
        samples : ndarray, shape (n_samples, n_names)
            In SI units.
        attributes
            The steps and the settings of the analysis; types as of the root.
        """
        group = netcdf.new_group(self._file, layout.SENSITIVITY)
        netcdf.set_attributes(group, attributes)
        add_sensitivity(group, indices, sample_names, samples)
        self._stream.raise_deferred()

    def set_attributes(self, attributes: Mapping[str, object]) -> None:
        """Add or replace root attributes."""
        netcdf.set_attributes(self._file, attributes)
        self._stream.raise_deferred()


def own_attributes(vehicle: VehicleProfile, terrain: TerrainProfile, gravity: float) -> dict[str, str | int | float]:
    """Root attributes that every table has."""
    return {
        "filetype": layout.FILETYPE,
        "version": layout.VERSION,
        "Conventions": layout.CONVENTIONS,
        "title": f"Look-up table of {vehicle.name} on {terrain.name}",
        "trackctl_version": __version__,
        layout.VEHICLE_PROFILE: vehicle_to_yaml(vehicle),
        layout.TERRAIN_PROFILE: terrain_to_yaml(terrain),
        layout.GRAVITY: gravity,
    }


def add_coordinates(file: h5py.File, axes: Axes) -> None:
    """Add the axes, and the radius beside the curvature."""
    for number, (name, (unit, long_name)) in enumerate(layout.COORDINATES.items()):
        scale = netcdf.add_coordinate(file, name, getattr(axes, name), number)
        netcdf.set_attributes(scale, {"units": unit, "long_name": long_name})
    netcdf.set_attributes(file["heading"], {layout.PERIODIC: axes.heading_is_periodic})
    radius = file.create_dataset(layout.RADIUS, data=axes.radius)
    netcdf.attach_dimensions(radius, ["curvature"])
    netcdf.set_attributes(radius, layout.RADIUS_ATTRIBUTES)


def add_variable(file: h5py.File, name: str, axes: Axes, gzip: int | None) -> h5py.Dataset:
    """Add an empty variable over all coordinates."""
    chunk = (1, axes.velocity.size, 1, axes.heading.size)
    dtype = layout.DTYPES[name]
    if gzip is None:
        dataset = file.create_dataset(name, axes.shape, dtype, chunks=chunk, dcpl=places_fixed_beforehand())
    else:
        dataset = file.create_dataset(
            name, axes.shape, dtype, chunks=chunk, compression="gzip", compression_opts=gzip, shuffle=True
        )
    netcdf.attach_dimensions(dataset, list(layout.COORDINATES))
    netcdf.set_attributes(dataset, variable_attributes(name))
    return dataset


def places_fixed_beforehand() -> h5p.PropDCID:
    """Creation properties of a dataset whose chunks have their place, but no content, from the start."""
    properties = h5p.create(h5p.DATASET_CREATE)
    properties.set_alloc_time(h5d.ALLOC_TIME_EARLY)
    properties.set_fill_time(h5d.FILL_TIME_NEVER)
    return properties


def variable_attributes(name: str) -> dict[str, object]:
    """CF attributes of a variable."""
    if name == layout.STATUS:
        flags = {"flag_values": np.array(list(Status), dtype=np.uint8), "flag_meanings": layout.FLAG_MEANINGS}
        return {"long_name": layout.STATUS_LONG_NAME, "coordinates": layout.RADIUS, **flags}
    unit, long_name = VARIABLES[name]
    return {"units": unit, "long_name": long_name, "coordinates": layout.RADIUS, "_FillValue": np.nan}
