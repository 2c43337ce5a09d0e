"""Elevation grids of any kind, laid into a map."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from trackctl.errors import MapError
from trackctl.files.esri_grid import read_esri
from trackctl.files.geotiff import read_geotiff
from trackctl.files.height_grid import HeightGrid
from trackctl.files.numpy_grid import read_npy, read_npz
from trackctl.planning.elevation import Elevation

Pair = tuple[float, float]

READERS = {
    ".asc": read_esri, ".grd": read_esri, ".npy": read_npy, ".npz": read_npz, ".tif": read_geotiff,
    ".tiff": read_geotiff,
}  # fmt: skip
#: Degrees of longitude and latitude end here, and no grid of them for a vehicle is coarser than this. [deg]
LONGITUDE_END, LATITUDE_END, COARSEST_DEGREES = 360.0, 90.0, 0.1
#: The ellipsoid of WGS 84: larger half axis [m] and square of the eccentricity.
HALF_AXIS, ECCENTRICITY_2 = 6378137.0, 6.69437999014e-3


def is_elevation_file(source: str) -> bool:
    """Whether a file is an elevation grid by the ending of its name."""
    return Path(source).suffix.lower() in READERS


def read_elevation(
    path: Path, resolution: float | None = None, origin: tuple[float, ...] | None = None
) -> tuple[Elevation, tuple[str, ...]]:
    """An elevation grid, and what the user should know of how it was understood, as sentences.

    Degrees become metres east and north of the lower left corner: those of a file that says that it has them, or of
    one that does not, lies within longitudes and latitudes, and would be higher than wide in metres.

    Parameters
    ----------
    path
        The file, of a kind told by its ending.
    resolution
        Width of a cell in place of the file's. [m]
    origin
        Lower left corner in place of the file's. [m]

    Raises
    ------
    MapError
        If the file is none, or its place is neither in it nor given.
    """
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise MapError(path, f"is of no known kind; allowed: {', '.join(READERS)}")
    grid = reader(path)
    notes: tuple[str, ...] = ()
    spacing, corner = (resolution, resolution) if resolution else grid.spacing, grid.corner
    if spacing is None:
        raise MapError(
            path,
            f"does not tell how far apart its heights are; the YAML of a map can: a line `elevation: {path.name}` and "
            "one `elevation_resolution_m: 0.5`",
        )
    if not resolution and (looks_geographic(grid) if grid.is_geographic is None else grid.is_geographic):
        spacing, corner, notes = _in_metres(path, grid.height.shape[0], spacing, corner or (0.0, 0.0))
    x, y = origin or corner or (0.0, 0.0)
    height = np.ascontiguousarray(grid.height[::-1])
    return Elevation(height, *spacing, x + 0.5 * spacing[0], y + 0.5 * spacing[1], str(path)), notes


def looks_geographic(grid: HeightGrid) -> bool:
    """Whether lengths must be degrees: all of them could be, and in metres the ground were higher than wide."""
    if grid.spacing is None or grid.corner is None:
        return False
    n_rows, n_columns = grid.height.shape
    width, height = n_columns * grid.spacing[0], n_rows * grid.spacing[1]
    fits = max(abs(grid.corner[0]), abs(grid.corner[0] + width)) <= LONGITUDE_END
    fits &= max(abs(grid.corner[1]), abs(grid.corner[1] + height)) <= LATITUDE_END
    relief = np.nanmax(grid.height) - np.nanmin(grid.height)
    return bool(fits and max(grid.spacing) <= COARSEST_DEGREES and relief > max(width, height))


def _in_metres(path: Path, n_rows: int, spacing: Pair, corner: Pair) -> tuple[Pair, Pair, tuple[str]]:
    """Spacing in metres at the middle latitude, the lower left corner as (0, 0), and a note of it."""
    latitude = corner[1] + 0.5 * n_rows * spacing[1]
    if not abs(latitude) < LATITUDE_END:
        raise MapError(path, f"lies at a latitude of {latitude:g} deg; allowed: -90 to 90")
    eastward, northward = metres_per_degree(latitude)
    note = (
        f"{path}: degrees; x and y are metres east and north of its lower left corner, longitude {corner[0]:.6f} and "
        f"latitude {corner[1]:.6f}"
    )
    return (spacing[0] * eastward, spacing[1] * northward), (0.0, 0.0), (note,)


def metres_per_degree(latitude: float) -> Pair:
    """Lengths of a degree of longitude and of latitude on the ellipsoid of WGS 84 at a latitude. [m; deg]"""
    phi = math.radians(latitude)
    shrink = 1.0 - ECCENTRICITY_2 * math.sin(phi) ** 2
    eastward = HALF_AXIS * math.cos(phi) / math.sqrt(shrink)
    northward = HALF_AXIS * (1.0 - ECCENTRICITY_2) / shrink**1.5
    return math.radians(eastward), math.radians(northward)
