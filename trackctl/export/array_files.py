"""A look-up table as a MATLAB file or a NumPy archive: the same arrays under the same names."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import savemat

from trackctl.export.gridded import DIMENSIONS, UNITS, GriddedTable
from trackctl.lut.table import Status

#: A variable of a level-5 file is smaller. [bytes]
LARGEST_VARIABLE = 2**31
#: What a level-5 file begins with: a text of this length, which would else tell the time.
TEXT_LENGTH = 116


def write_mat(path: Path, table: GriddedTable, numbers: Mapping[str, float], texts: Mapping[str, str]) -> None:
    """Write a table for MATLAB and Simulink.

    Level 5, which every MATLAB and Octave reads without HDF5; the largest table that `compute-lut` makes has variables
    of 1.7 GB. A last dimension of one slope is left out, as MATLAB does; vectors are columns.

    Parameters
    ----------
    path
        The file.
    table
        The arrays.
    numbers
        Scalars beside them.
    texts
        What the table is and where it comes from, by name.

    Raises
    ------
    ValueError
        If a variable is too large for this format.
    """
    arrays = {name: without_last(array) for name, array in table_arrays(table).items()}
    for name, array in arrays.items():
        if array.nbytes >= LARGEST_VARIABLE:
            raise ValueError(f"{name} has {array.nbytes} bytes; a variable of a MATLAB file has less than 2 GB")
    words: dict[str, Any] = {
        "dimensions": np.array(DIMENSIONS, object),
        "status_meanings": np.array([status.name.lower() for status in Status], object),
        "units": {name: unit for name, unit in UNITS.items() if name in arrays or name in numbers},
    }
    savemat(path, {**arrays, **numbers, **words, **texts}, appendmat=False, do_compression=True, oned_as="column")
    text = f"MATLAB 5.0 MAT-file, {texts['title']}".encode("ascii", "replace")
    with path.open("r+b") as stream:
        stream.write(text[:TEXT_LENGTH].ljust(TEXT_LENGTH))


def write_npz(path: Path, table: GriddedTable, numbers: Mapping[str, float], texts: Mapping[str, str]) -> None:
    """Write a table for NumPy; as `write_mat`, always of four dimensions, units as rows of name and unit."""
    arrays = table_arrays(table)
    words = {
        "dimensions": np.array(DIMENSIONS),
        "status_meanings": np.array([status.name.lower() for status in Status]),
        "units": np.array([row for row in UNITS.items() if row[0] in arrays or row[0] in numbers]),
    }
    everything: dict[str, Any] = {**arrays, **numbers, **words, **texts}
    # As np.savez_compressed, which before NumPy 2 does not close an archive that a full disk cut short.
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, value in everything.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, np.asanyarray(value), allow_pickle=False)


def table_arrays(table: GriddedTable) -> dict[str, np.ndarray[Any, Any]]:
    """All arrays by name."""
    return {**table.axes, **table.values, "status": table.status, "feasible": table.feasible}


def without_last(array: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """An array without a last, fourth dimension of 1."""
    return array[..., 0] if array.ndim == len(DIMENSIONS) and array.shape[-1] == 1 else array
