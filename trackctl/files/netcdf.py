"""HDF5 in the form that netCDF4 gives it: numbered dimension scales and plain attributes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from io import FileIO
from typing import Any

import h5py
import numpy as np
from h5py import h5f, h5fd, h5g, h5p
from numpy.typing import ArrayLike

# What netCDF writes as the name of a dimension that has no coordinates.
BARE_DIMENSION = "This is a netCDF dimension but not a netCDF variable. {:9d}"


def new_file(stream: FileIO) -> h5py.File:
    """An empty HDF5 file; the stream is to be closed after it."""
    access = h5p.create(h5p.FILE_ACCESS)
    # HDF5 1.8 on, the oldest that netCDF4 is; fixed, for the bytes not to depend on the library's defaults.
    access.set_libver_bounds(h5f.LIBVER_V18, h5f.LIBVER_V110)
    access.set_fclose_degree(h5f.CLOSE_STRONG)
    access.set_fileobj_driver(h5fd.fileobj_driver, stream)
    creation = ordered_and_timeless(h5p.FILE_CREATE)
    return h5py.File(h5f.create(b"netcdf", h5f.ACC_TRUNC, creation, access))


def new_group(file: h5py.File, name: str) -> h5py.Group:
    """An empty group at the root."""
    return h5py.Group(h5g.create(file.id, name.encode(), gcpl=ordered_and_timeless(h5p.GROUP_CREATE)))


def ordered_and_timeless(kind: int) -> h5p.PropOCID:
    """Creation properties of a file or group that keeps the order of its items, as netCDF does, but no times.

    h5py has no option against times before 3.15.
    """
    properties = h5p.create(kind)
    properties.set_link_creation_order(h5p.CRT_ORDER_TRACKED | h5p.CRT_ORDER_INDEXED)
    properties.set_attr_creation_order(h5p.CRT_ORDER_TRACKED | h5p.CRT_ORDER_INDEXED)
    properties.set_obj_track_times(False)
    return properties


def add_coordinate(group: h5py.Group, name: str, values: ArrayLike, number: int) -> h5py.Dataset:
    """Add a dimension with its coordinate.

    Parameters
    ----------
    group
        Where to.
    name
        Of the dimension and the coordinate.
    values : array_like, shape (n,)
        Numbers or texts.
    number
        Of the dimension, another one for each in the file.
    """
    array = np.asarray(values)
    dtype = h5py.string_dtype() if array.dtype.kind == "U" else None
    scale = group.create_dataset(name, data=array.astype(object) if dtype else array, dtype=dtype)
    make_scale(scale, name, number)
    return scale


def add_bare_dimension(group: h5py.Group, name: str, size: int, number: int) -> None:
    """Add a dimension without coordinates; see `add_coordinate`."""
    make_scale(group.create_dataset(name, (size,), ">f4"), BARE_DIMENSION.format(size), number)


def make_scale(dataset: h5py.Dataset, name: str, number: int) -> None:
    """Make a dataset a dimension of netCDF."""
    dataset.make_scale(name)
    dataset.attrs["_Netcdf4Dimid"] = np.int32(number)


def attach_dimensions(dataset: h5py.Dataset, names: Sequence[str]) -> None:
    """Tell the dimensions of a dataset, which are in the same group."""
    for dimension, name in zip(dataset.dims, names, strict=True):
        dimension.attach_scale(dataset.parent[name])


def set_attributes(item: h5py.Group | h5py.Dataset, attributes: Mapping[str, object]) -> None:
    """Add or replace attributes: numbers, truth values (stored as 0 and 1), texts, or flat arrays."""
    for name, value in attributes.items():
        item.attrs[name] = stored_attribute(value)


def stored_attribute(value: object) -> object:
    """An attribute in a type that netCDF knows."""
    if isinstance(value, str):
        return value.encode(errors="replace").decode()  # file names may hold what is no Unicode
    array = np.asarray(value)
    if array.dtype.kind == "U":
        return [stored_attribute(text) for text in array.tolist()]
    return array.astype(np.int8) if array.dtype.kind == "b" else array


def present(items: h5py.Group | h5py.AttributeManager, name: str) -> Any:
    """The item or attribute of a name, None if there is none; `get` would take a failed read for that, too."""
    if name not in items:
        return None
    return items[name]


def plain_attributes(item: h5py.Group | h5py.Dataset) -> dict[str, object]:
    """All attributes as Python numbers, texts, lists of texts, or arrays."""
    return {name: plain_attribute(value) for name, value in item.attrs.items()}


def plain_attribute(value: object) -> object:
    """An attribute as Python number, text, list of texts, or array."""
    if isinstance(value, np.generic):
        return plain_attribute(value.item())
    if isinstance(value, bytes):
        return value.decode()
    if isinstance(value, np.ndarray) and value.dtype.kind in "OS":
        return [plain_attribute(text) for text in value.tolist()]
    return "" if isinstance(value, h5py.Empty) else value
