"""The keys of ROS maps and their image, as nav2's map_server reads them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from trackctl.errors import MapError
from trackctl.files.map_image import read_image
from trackctl.files.map_keys import PLACE, file_name, named_by, numbers, ranged, truth
from trackctl.files.shades import MapMode, Shades, occupancy_cells
from trackctl.files.strict_yaml import Entry, plain_text
from trackctl.planning.occupancy import GridFrame, Occupancy

Entries = Mapping[str, Entry]

FINEST, COARSEST = 1e-4, 1e4  # [m]
#: What a map with an image must hold.
IMAGE_KEYS = ("image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh")


def read_occupancy(entries: Entries, file: str, folder: Path) -> Occupancy | None:
    """What the image of a map says; None where none of its keys is there but `resolution`.

    Raises
    ------
    MapError, ProfileError
        If some of the keys are missing, or a value or the image is not allowed.
    """
    missing = [key for key in IMAGE_KEYS if key not in entries]
    if not set(IMAGE_KEYS) - set(missing) - {"resolution"}:
        return None
    if missing:
        raise MapError(file, f"missing keys of a map with an image: {', '.join(missing)}")
    shades = _shades(entries)
    x, y, yaw = numbers(entries["origin"], {"x": PLACE, "y": PLACE, "yaw": (-1000.0, 1000.0)})
    path = folder / file_name(entries["image"])
    with named_by(entries["image"]):
        cells = occupancy_cells(read_image(path), shades)
    n_rows, n_columns = cells.shape
    return Occupancy(cells, GridFrame(n_rows, n_columns, cell_width(entries["resolution"]), x, y, yaw), str(path))


def cell_width(entry: Entry) -> float:
    """The width of a cell. [m]"""
    return ranged(entry, FINEST, COARSEST)


def _shades(entries: Entries) -> Shades:
    mode = plain_text(entries["mode"]) if "mode" in entries else MapMode.TRINARY
    if mode not in list(MapMode):
        raise entries["mode"].error(f"{mode!r} is not allowed; allowed: {', '.join(MapMode)}", mode)
    occupied, free = (ranged(entries[key], 0.0, 1.0) for key in ("occupied_thresh", "free_thresh"))
    if free > occupied:
        raise entries["free_thresh"].error(f"{free:g} is above occupied_thresh; allowed: up to {occupied:g}", free)
    return Shades(MapMode(mode), truth(entries["negate"]), occupied, free)
