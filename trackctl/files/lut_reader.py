"""Reading of look-up tables; every fault is an error that names the file."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import h5py
import numpy as np
from numpy.typing import NDArray

from trackctl.errors import LutFormatError, ProfileError
from trackctl.files import lut_format as layout
from trackctl.files import netcdf
from trackctl.files.heap_check import has_endless_heap
from trackctl.files.profile_yaml import parse_terrain, parse_vehicle
from trackctl.files.read_errors import read_errors, why_unreadable
from trackctl.lut.axes import FULL_CIRCLE, Array, Axes
from trackctl.lut.table import VARIABLES, Status, Table
from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import VehicleProfile

Profile = TypeVar("Profile", VehicleProfile, TerrainProfile)

# What h5py raises on a damaged structure.
DAMAGE = (OSError, RuntimeError, LookupError, ValueError, TypeError, AttributeError, MemoryError)
# Allowed range of each coordinate, as a test and as a phrase.
RANGES: dict[str, tuple[Callable[[Array], NDArray[np.bool_]], str]] = {
    "slope": (lambda slope: (slope >= 0.0) & (slope < 0.25 * math.pi), "0 to below pi/4"),
    "velocity": (lambda velocity: velocity > 0.0, "above 0"),
    "curvature": (np.isfinite, "finite"),
    "heading": (lambda heading: (heading >= 0.0) & (heading < FULL_CIRCLE), "0 to below 2 pi"),
}
# Tells evenly spaced headings (rounding: 1e-15) from ones that are not (degrees in a file: 1e-6).
EVENNESS = 1e-9
COUNTED_CELLS = 2**22


@dataclass(frozen=True, slots=True, eq=False)
class LutHeader:
    """What a table file holds besides its cells.

    Attributes
    ----------
    axes, vehicle, terrain, gravity, attributes
        See `Table`.
    status_counts
        Number of cells of each status.
    """

    axes: Axes
    vehicle: VehicleProfile
    terrain: TerrainProfile
    gravity: float
    attributes: dict[str, object]
    status_counts: dict[Status, int]


def read_lut(path: Path) -> Table:
    """Read a table.

    Raises
    ------
    LutFormatError
        If the file is missing, damaged, no table, of a newer version, or at odds with itself.
    """
    with opened_lut(path) as file:
        axes, attributes = read_axes(path, file), netcdf.plain_attributes(file)
        vehicle, terrain, gravity = take_provenance(path, attributes)
        status = find_variable(path, file, layout.STATUS, axes)[()]
        values = {name: find_variable(path, file, name, axes)[()] for name in VARIABLES}
    check_status(path, status)
    for name, array in values.items():
        check_values(path, name, array, status == Status.CONVERGED)
    return Table(axes, values, status, vehicle, terrain, gravity, attributes)


def read_lut_header(path: Path) -> LutHeader:
    """Read what describes a table and count its statuses, its cells not loaded; errors as of `read_lut`."""
    with opened_lut(path) as file:
        axes, attributes = read_axes(path, file), netcdf.plain_attributes(file)
        vehicle, terrain, gravity = take_provenance(path, attributes)
        for name in VARIABLES:
            find_variable(path, file, name, axes)
        counts = count_statuses(path, find_variable(path, file, layout.STATUS, axes))
    return LutHeader(axes, vehicle, terrain, gravity, attributes, counts)


@contextmanager
def opened_lut(path: Path) -> Iterator[h5py.File]:
    """An open table of a version that can be read; damage met inside the block becomes a `LutFormatError`."""
    check_is_hdf5(path)
    try:
        with opened_hdf5(path) as file:
            check_version(path, file)
            yield file
    except DAMAGE as error:
        raise LutFormatError(path, why_unreadable(error, "is damaged or cut off")) from error


def opened_hdf5(path: Path) -> h5py.File:
    """A file open for reading, which needs no lock: tables are replaced whole."""
    try:
        # Locked, for HDF5 opens no file twice in different ways, and others in this program may have it open.
        return h5py.File(path, "r")
    except OSError:
        return h5py.File(path, "r", locking=False)


def check_is_hdf5(path: Path) -> None:
    """Refuse what is no HDF5 file, before HDF5 sees it."""
    with read_errors(path, LutFormatError):
        if path.exists() and not path.is_file():
            raise LutFormatError(path, "is a folder, device or pipe; a table is a file")
        with path.open("rb") as stream:
            is_empty = not stream.read(1)
        if is_empty:
            raise LutFormatError(path, "is empty; `trackctl compute-lut` writes a table")
        if not is_hdf5(path):
            raise LutFormatError(path, "is no HDF5 file; `trackctl compute-lut` writes a table")
        if has_endless_heap(path):
            raise LutFormatError(path, "is damaged: a heap of texts has no end")


def is_hdf5(path: Path) -> bool:
    """Whether a path is a file that HDF5 would open; errors as of `read_lut`."""
    with read_errors(path, LutFormatError):
        return path.is_file() and bool(h5py.is_hdf5(path))


def check_version(path: Path, file: h5py.File) -> None:
    """Refuse other HDF5 files, and tables of a later format."""
    filetype = netcdf.plain_attribute(netcdf.present(file.attrs, "filetype"))
    if filetype != layout.FILETYPE:
        raise LutFormatError(path, f"filetype: {filetype!r} is not allowed; allowed: {layout.FILETYPE!r}")
    version = netcdf.plain_attribute(netcdf.present(file.attrs, "version"))
    if version != layout.VERSION:
        hint = "; a later trackctl reads it" if isinstance(version, int) and version > layout.VERSION else ""
        raise LutFormatError(path, f"version: {version!r} is not allowed; allowed: {layout.VERSION}{hint}")


def read_axes(path: Path, file: h5py.File) -> Axes:
    """The coordinates, checked."""
    slope, velocity, curvature, heading = (read_coordinate(path, file, name) for name in layout.COORDINATES)
    if not np.any(curvature == 0.0):
        raise LutFormatError(path, "curvature: 0 (straight) is missing")
    periodic = netcdf.plain_attribute(netcdf.present(file["heading"].attrs, layout.PERIODIC))
    if periodic not in (0, 1):
        raise LutFormatError(path, f"heading: attribute {layout.PERIODIC} is {periodic!r}; allowed: 0, 1")
    even = heading[0] + np.arange(heading.size) * FULL_CIRCLE / heading.size
    if periodic and not np.allclose(heading, even, rtol=0.0, atol=EVENNESS):
        raise LutFormatError(path, "heading: is periodic, but does not go round the full circle evenly")
    return Axes(slope, velocity, curvature, heading, bool(periodic))


def read_coordinate(path: Path, file: h5py.File, name: str) -> Array:
    """One coordinate, ascending and in range."""
    dataset = find_dataset(path, file, name, "<f8")
    if dataset.ndim != 1 or not dataset.size:
        raise LutFormatError(path, f"{name}: shape {dataset.shape} is not allowed; allowed: (n,)")
    nodes: Array = dataset[()]
    is_allowed, allowed = RANGES[name]
    for node in nodes[~is_allowed(nodes)]:
        raise LutFormatError(path, f"{name}: {node} is not allowed; allowed: {allowed}")
    if not np.all(np.diff(nodes) > 0.0):
        raise LutFormatError(path, f"{name}: is not ascending")
    return nodes


def find_variable(path: Path, file: h5py.File, name: str, axes: Axes) -> h5py.Dataset:
    """A variable over all coordinates, not yet loaded."""
    dataset = find_dataset(path, file, name, layout.DTYPES[name])
    if dataset.shape != axes.shape:
        raise LutFormatError(path, f"{name}: shape {dataset.shape}; the axes have {axes.shape}")
    if name == layout.STATUS and netcdf.present(dataset.attrs, "flag_meanings") != layout.FLAG_MEANINGS:
        raise LutFormatError(path, f"{name}: flag_meanings must be {layout.FLAG_MEANINGS!r}")
    return dataset


def find_dataset(path: Path, file: h5py.File, name: str, dtype: str) -> h5py.Dataset:
    """A dataset of a name and type."""
    dataset = netcdf.present(file, name)
    if not isinstance(dataset, h5py.Dataset):
        raise LutFormatError(path, f"{name}: is missing")
    if dataset.dtype != np.dtype(dtype):
        raise LutFormatError(path, f"{name}: type {dataset.dtype} is not allowed; allowed: {np.dtype(dtype)}")
    return dataset


def take_provenance(path: Path, attributes: dict[str, object]) -> tuple[VehicleProfile, TerrainProfile, float]:
    """Vehicle, terrain and gravity, removed from the root attributes together with the format's marks."""
    del attributes["filetype"], attributes["version"]
    vehicle = parsed_profile(path, layout.VEHICLE_PROFILE, attributes, parse_vehicle)
    terrain = parsed_profile(path, layout.TERRAIN_PROFILE, attributes, parse_terrain)
    gravity = attributes.pop(layout.GRAVITY, None)
    if not isinstance(gravity, float) or not 0.0 < gravity < math.inf:
        raise LutFormatError(path, f"{layout.GRAVITY}: {gravity!r} is not allowed; allowed: a number above 0")
    return vehicle, terrain, gravity


def parsed_profile(
    path: Path, name: str, attributes: dict[str, object], parse: Callable[[str, str], Profile]
) -> Profile:
    """The profile in a root attribute, which is removed."""
    text = attributes.pop(name, None)
    if not isinstance(text, str):
        raise LutFormatError(path, f"{name}: is missing or no text")
    try:
        return parse(text, name)
    except ProfileError as error:
        raise LutFormatError(path, str(error)) from error


def count_statuses(path: Path, dataset: h5py.Dataset) -> dict[Status, int]:
    """Number of cells of each status, counted in parts."""
    slopes, velocities, curvatures, headings = dataset.shape
    step = max(1, COUNTED_CELLS // (velocities * headings))
    counts = np.zeros(len(Status), dtype=np.int64)
    for slope in range(slopes):
        for start in range(0, curvatures, step):
            status = dataset[slope, :, start : start + step]
            check_status(path, status)
            counts += np.bincount(status.ravel(), minlength=len(Status))
    return {status: int(counts[status]) for status in Status}


def check_status(path: Path, status: NDArray[np.uint8]) -> None:
    """Refuse a status that is none."""
    highest = int(status.max())
    if highest >= len(Status):
        raise LutFormatError(path, f"{layout.STATUS}: {highest} is not allowed; allowed: 0 to {len(Status) - 1}")


def check_values(path: Path, name: str, values: Array, converged: NDArray[np.bool_]) -> None:
    """Refuse a converged cell without a number, and another one with a number; a residual may be anywhere."""
    missing = ~np.isfinite(values)
    faults = missing & converged if name == "residual" else missing == converged
    if faults.any():
        place = tuple(int(index) for index in np.unravel_index(faults.argmax(), faults.shape))
        problem = "no number in a converged cell" if converged[place] else "a number in a cell without answer"
        raise LutFormatError(path, f"{name}: {problem}, at indices {place} of {', '.join(layout.COORDINATES)}")
