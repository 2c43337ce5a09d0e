"""Tables as read: round trip, and faults that all name the file."""

import os

import h5py
import numpy as np
import pytest
from lut_examples import ATTRIBUTES, GRAVITY, TERRAIN, VEHICLE, example_table
from system_words import NO_FILE
from systems import needs_pipe

from trackctl.errors import LutFormatError
from trackctl.files.lut_reader import read_lut, read_lut_header
from trackctl.files.lut_writer import write_lut
from trackctl.lut.table import VARIABLES, Status


@pytest.fixture
def path(tmp_path):
    write_lut(tmp_path / "lut.h5", example_table())
    return tmp_path / "lut.h5"


def assert_refused(path, problem, readers=(read_lut, read_lut_header)):
    for read in readers:
        with pytest.raises(LutFormatError, match=problem) as error:
            read(path)
        assert str(error.value).startswith(f"{path}: ")


def replace_dataset(file, name, values):
    """Put other values, of any shape and type, in the place of a dataset, with its attributes."""
    attributes = dict(file[name].attrs)
    del file[name]
    file[name] = values
    for key in attributes.keys() & {"flag_meanings", "periodic"}:
        file[name].attrs[key] = attributes[key]


@pytest.mark.parametrize("gzip", [None, 1])
@pytest.mark.parametrize("lengths", [{}, {"slopes": 1, "velocities": 1, "curvatures": 1, "headings": 9}])
def test_round_trip(tmp_path, lengths, gzip):
    table = example_table(**lengths)
    write_lut(tmp_path / "lut.h5", table, gzip=gzip)
    found = read_lut(tmp_path / "lut.h5")
    for name in ("slope", "velocity", "curvature", "heading", "heading_is_periodic"):
        np.testing.assert_array_equal(getattr(found.axes, name), getattr(table.axes, name))
    assert found.values.keys() == table.values.keys()
    for name, values in table.values.items():
        np.testing.assert_array_equal(found.values[name], values)
    np.testing.assert_array_equal(found.status, table.status)
    assert (found.vehicle, found.terrain, found.gravity) == (VEHICLE, TERRAIN, GRAVITY)
    for name, value in ATTRIBUTES.items():
        np.testing.assert_array_equal(found.attributes[name], value)
        assert isinstance(found.attributes[name], type(value))


def test_a_table_read_and_written_has_the_same_bytes(tmp_path, path):
    write_lut(tmp_path / "again.h5", read_lut(path))
    assert (tmp_path / "again.h5").read_bytes() == path.read_bytes()


@pytest.mark.parametrize("cells", [1, 10**6])
def test_header(path, monkeypatch, cells):
    monkeypatch.setattr("trackctl.files.lut_reader.COUNTED_CELLS", cells)
    header, table = read_lut_header(path), read_lut(path)
    np.testing.assert_array_equal(header.axes.heading, table.axes.heading)
    assert (header.vehicle, header.terrain, header.gravity) == (VEHICLE, TERRAIN, GRAVITY)
    assert header.attributes.keys() == table.attributes.keys()
    others = dict.fromkeys(list(Status)[1:], 1)
    assert header.status_counts == {Status.CONVERGED: table.axes.size - 5, **others}


@pytest.mark.parametrize("locking", [None, False])
def test_a_table_that_this_program_has_open_already(path, locking):
    with h5py.File(path, "r", locking=locking):
        assert read_lut(path).vehicle == VEHICLE


def test_a_missing_file(tmp_path):
    assert_refused(tmp_path / "none.h5", NO_FILE)


def test_a_folder(tmp_path):
    assert_refused(tmp_path, "is a folder")


@needs_pipe
def test_a_pipe(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    assert_refused(tmp_path / "pipe", "is a folder, device or pipe")


@pytest.mark.parametrize(
    ("content", "problem"),
    [(b"", "is empty"), (b"velocity_mps\n1\n", "is no HDF5"), (b"\x89HDF", "is no HDF5")],
)
def test_another_format(tmp_path, content, problem):
    (tmp_path / "lut.h5").write_bytes(content)
    assert_refused(tmp_path / "lut.h5", problem)


def test_cut_off_anywhere(path):
    content = path.read_bytes()
    for size in np.linspace(1, len(content) - 1, 40, dtype=int):
        path.write_bytes(content[:size])
        assert_refused(path, "is damaged or cut off|is no HDF5")


def test_damage_anywhere_is_an_error_or_harmless(path):
    content = path.read_bytes()
    refused = 0
    for place in range(0, len(content), len(content) // 150):
        damaged = bytearray(content)
        damaged[place] ^= 0xFF
        path.write_bytes(damaged)
        try:
            read_lut(path)
        except LutFormatError:
            refused += 1
    assert refused


@pytest.mark.parametrize(
    ("name", "value", "problem"),
    [
        ("filetype", "other", "filetype: 'other'.*allowed: 'trackctl-lut'"),
        ("version", 2, "version: 2 is not allowed; allowed: 1; a later trackctl"),
        ("version", 0, "version: 0 is not allowed; allowed: 1$"),
        ("version", "one", "version: 'one'"),
        ("gravity", 0.0, "gravity: 0.0"),
        ("gravity", np.nan, "gravity: nan"),
        ("gravity", "moon", "gravity: 'moon'"),
        ("vehicle_profile", 1, "vehicle_profile: is missing or no text"),
        ("vehicle_profile", "mass_kg: x\n", "vehicle_profile"),
        ("vehicle_profile", "mass_kg: [", "vehicle_profile.*YAML"),
        ("terrain_profile", "", "terrain_profile"),
    ],
)
def test_root_attributes(path, name, value, problem):
    with h5py.File(path, "a") as file:
        file.attrs[name] = value
    assert_refused(path, problem)


@pytest.mark.parametrize("name", ["filetype", "version", "gravity", "vehicle_profile", "terrain_profile"])
def test_missing_root_attributes(path, name):
    with h5py.File(path, "a") as file:
        del file.attrs[name]
    assert_refused(path, name)


@pytest.mark.parametrize("name", ["slope", "velocity", "curvature", "heading", "residual", "status"])
def test_missing_variables(path, name):
    with h5py.File(path, "a") as file:
        del file[name]
    assert_refused(path, f"{name}: is missing")


def test_a_group_in_the_place_of_a_variable(path):
    with h5py.File(path, "a") as file:
        del file["sideslip"]
        file.create_group("sideslip")
    assert_refused(path, "sideslip: is missing")


@pytest.mark.parametrize(
    ("name", "values", "problem"),
    [
        ("slope", [0.0, np.pi / 4], "slope: 0.78.* is not allowed; allowed: 0 to below pi/4"),
        ("slope", [-0.1, 0.0], "slope: -0.1"),
        ("velocity", [0.0, 1.0, 2.0], "velocity: 0.0 is not allowed; allowed: above 0"),
        ("velocity", [1.0, 1.0, 2.0], "velocity: is not ascending"),
        ("velocity", [1.0, np.nan, 2.0], "velocity: nan"),
        ("velocity", [[1.0, 2.0, 3.0]], r"velocity: shape \(1, 3\)"),
        ("velocity", np.float64(1.0), r"velocity: shape \(\)"),
        ("velocity", np.empty(0), r"velocity: shape \(0,\)"),
        ("velocity", [1, 2, 3], "velocity: type int64 is not allowed; allowed: float64"),
        ("velocity", [1.0, 2.0], r"shape \(2, 3, 5, 4\); the axes have \(2, 2, 5, 4\)"),
        ("curvature", [1.0, 2.0, 3.0, 4.0, 5.0], r"curvature: 0 \(straight\) is missing"),
        ("curvature", [-2.0, -1.0, 0.0, 1.0, np.inf], "curvature: inf"),
        ("heading", [0.0, 1.0, 2.0, 2 * np.pi], "heading: 6.28.* is not allowed; allowed: 0 to below 2 pi"),
        ("heading", [0.0, 1.0, 2.0, 3.0], "heading: is periodic, but"),
        ("sideslip", np.zeros((2, 3, 5, 3)), r"sideslip: shape \(2, 3, 5, 3\)"),
        ("sideslip", np.zeros((2, 3, 5, 4), np.float32), "sideslip: type float32"),
        ("status", np.zeros((2, 3, 5, 4), np.int32), "status: type int32 is not allowed; allowed: uint8"),
        ("status", np.full((2, 3, 5, 4), 6, np.uint8), "status: 6 is not allowed; allowed: 0 to 5"),
    ],
)
def test_odd_variables(path, name, values, problem):
    with h5py.File(path, "a") as file:
        replace_dataset(file, name, np.asarray(values))
    assert_refused(path, problem)


@pytest.mark.parametrize("value", [None, 2, "yes"])
def test_odd_periodicity(path, value):
    with h5py.File(path, "a") as file:
        del file["heading"].attrs["periodic"]
        if value is not None:
            file["heading"].attrs["periodic"] = value
    assert_refused(path, "heading: attribute periodic")


def test_other_flags(path):
    with h5py.File(path, "a") as file:
        file["status"].attrs["flag_meanings"] = "good bad"
    assert_refused(path, "status: flag_meanings")


@pytest.mark.parametrize("name", VARIABLES)
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_converged_cell_without_a_number(path, name, value):
    with h5py.File(path, "a") as file:
        file[name][1, 2, 3, 0] = value
    assert_refused(path, rf"{name}: no number in a converged cell, at indices \(1, 2, 3, 0\)", [read_lut])


def test_a_number_in_a_cell_without_an_answer(path):
    with h5py.File(path, "a") as file:
        file["sideslip"][0, 0, 0, 1] = 0.0
    assert_refused(path, r"sideslip: a number in a cell without answer, at indices \(0, 0, 0, 1\)", [read_lut])


def test_a_residual_may_be_anywhere(path):
    with h5py.File(path, "a") as file:
        file["residual"][0, 0, 0, 1:3] = [np.nan, 0.5]
    assert read_lut(path).values["residual"][0, 0, 0, 2] == 0.5
