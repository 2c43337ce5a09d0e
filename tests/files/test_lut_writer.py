"""Tables as written: layout, bytes, memory, faults of the disk."""

import os
import subprocess
import sys
import time
from itertools import product
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray
from lut_examples import ATTRIBUTES, GRAVITY, TERRAIN, VEHICLE, example_table
from system_words import FILE_TOO_LARGE, NO_SPACE
from systems import FULL_DISK, needs_file_limit, needs_full_disk, needs_pipe

from trackctl import __version__
from trackctl.errors import OutputError
from trackctl.files.atomic import whole_file
from trackctl.files.lut_writer import LutWriter, write_lut
from trackctl.files.profile_yaml import parse_terrain, parse_vehicle
from trackctl.lut.table import VARIABLES
from trackctl.sensitivity.pawn import PawnIndex, Statistic

PROFILES = VEHICLE, TERRAIN, GRAVITY
OUTPUTS, INPUTS = ("sprocket_rate_left", "sideslip"), ("velocity", "radius", "heading")
INDICES = [
    PawnIndex(output, name, statistic, 0.1 * number, 0.1 * number - 0.05, 0.1 * number + 0.05, 0.02)
    for number, (output, name, statistic) in enumerate(product(OUTPUTS, INPUTS, Statistic))
]
SAMPLES = np.random.default_rng(0).normal(size=(20, 5))

# A limit on the size of files acts as a full disk.
DISK_FULL = """
import resource, signal, sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
from lut_examples import example_table
from trackctl.errors import OutputError
from trackctl.files.atomic import whole_file
from trackctl.files.lut_writer import write_lut
output, limit = Path(sys.argv[2]), int(sys.argv[3])
table = example_table(headings=60)
resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
try:
    with whole_file(output, force=False) as path:
        write_lut(path, table)
except OutputError as error:
    print(error)
"""

MEMORY = """
import resource, sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
import numpy as np
from lut_examples import GRAVITY, TERRAIN, VEHICLE, example_axes
from trackctl.files.lut_writer import LutWriter
from trackctl.lut.table import VARIABLES
axes = example_axes(1, 40, 150, 360)
values = {name: np.ones((40, 360)) for name in VARIABLES}
status = np.zeros((40, 360), np.uint8)
peaks = []
with LutWriter(Path(sys.argv[2]), axes, VEHICLE, TERRAIN, GRAVITY, {}) as writer:
    for k in range(150):
        writer.write_column(0, k, values, status)
        peaks.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
print(peaks[-1] - peaks[9])
"""


@pytest.fixture
def table():
    return example_table()


@pytest.fixture(params=[None, 4], ids=["plain", "gzip"])
def path(tmp_path, table, request):
    write_lut(tmp_path / "lut.h5", table, gzip=request.param)
    return tmp_path / "lut.h5"


def run(script, *arguments):
    command = [sys.executable, "-c", script, str(Path(__file__).parent), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def write_columns(path, table, columns):
    with LutWriter(path, table.axes, *PROFILES, table.attributes) as writer:
        for i, k in columns:
            column = {name: values[i, :, k] for name, values in table.values.items()}
            writer.write_column(i, k, column, table.status[i, :, k])
        writer.write_sensitivity(INDICES, [*INPUTS, *OUTPUTS], SAMPLES, {"velocity_step": 0.5})


def test_xarray_shows_named_coordinates(path, table):
    with xarray.open_dataset(path, engine="h5netcdf") as dataset:
        dimensions = ("slope", "velocity", "curvature", "heading")
        assert set(dataset.coords) == {*dimensions, "radius"}
        assert set(dataset.data_vars) == {*VARIABLES, "status"}
        for name in dimensions:
            np.testing.assert_array_equal(dataset[name], getattr(table.axes, name))
        for name, values in table.values.items():
            assert dataset[name].dims == dimensions
            assert dataset[name].dtype == np.dtype("<f8")
            np.testing.assert_array_equal(dataset[name], values)
        for name, variable in dataset.variables.items():
            assert variable.attrs["long_name"]
            assert name == "status" or variable.attrs["units"]
        np.testing.assert_array_equal(dataset.radius, [-0.5, -1.0, np.inf, 1.0, 0.5])
        assert dataset.radius.dims == ("curvature",)


def test_status_has_cf_flags(path, table):
    with xarray.open_dataset(path, engine="h5netcdf") as dataset:
        status = dataset.status
        assert status.dtype == np.uint8
        np.testing.assert_array_equal(status, table.status)
        np.testing.assert_array_equal(status.attrs["flag_values"], [0, 1, 2, 3, 4, 5])
        assert status.attrs["flag_meanings"] == (
            "converged infeasible_grip infeasible_liftoff infeasible_pitchover outside_model not_converged"
        )


def test_root_attributes(path):
    with xarray.open_dataset(path, engine="h5netcdf") as dataset:
        attributes = dataset.attrs
    assert attributes["filetype"] == "trackctl-lut"
    assert attributes["version"] == 1
    assert attributes["Conventions"] == "CF-1.11"
    assert attributes["title"] == "Look-up table of utv-61cm on asphalt"
    assert attributes["trackctl_version"] == __version__
    assert attributes["gravity"] == GRAVITY
    assert parse_vehicle(attributes["vehicle_profile"], "") == VEHICLE
    assert parse_terrain(attributes["terrain_profile"], "") == TERRAIN
    for name, value in ATTRIBUTES.items():
        np.testing.assert_array_equal(attributes[name], value)


def test_attributes_in_netcdf_types(tmp_path, table):
    attributes = {"flag": True, "texts": ["a", "b"], "array": np.array(["c"]), "file": "x\udcff.yaml"}
    with LutWriter(tmp_path / "lut.h5", table.axes, *PROFILES, {"title": "mine"}) as writer:
        for i, k in product(range(2), range(5)):
            writer.write_column(i, k, {name: np.zeros((3, 4)) for name in VARIABLES}, np.zeros((3, 4)))
        writer.set_attributes(attributes)
    with h5py.File(tmp_path / "lut.h5") as file:
        assert file.attrs["flag"].dtype == np.int8
        assert list(file.attrs["texts"]) == ["a", "b"]
        assert list(file.attrs["array"]) == ["c"]
        assert file.attrs["file"] == "x?.yaml"
        assert file.attrs["title"] == "Look-up table of utv-61cm on asphalt"


def test_dimensions_are_numbered_as_in_netcdf(path):
    with h5py.File(path) as file:
        numbers = [file[name].attrs["_Netcdf4Dimid"] for name in ("slope", "velocity", "curvature", "heading")]
        assert numbers == [0, 1, 2, 3]
        assert file["sideslip"].dims[3][0] == file["heading"]


def test_a_column_is_a_chunk(path):
    with h5py.File(path) as file:
        for name in (*VARIABLES, "status"):
            assert file[name].chunks == (1, 3, 1, 4)


def test_equal_input_gives_equal_bytes(tmp_path, table):
    columns = list(product(range(2), range(5)))
    write_columns(tmp_path / "first", table, columns)
    time.sleep(1.1)  # a stored time would have whole seconds
    write_columns(tmp_path / "second", table, columns[::-1])
    assert (tmp_path / "first").read_bytes() == (tmp_path / "second").read_bytes()


def test_a_missing_column_is_an_error(tmp_path, table):
    with pytest.raises(RuntimeError, match="1 columns"):
        write_columns(tmp_path / "lut.h5", table, list(product(range(2), range(5)))[1:])


def test_a_column_of_another_shape_is_an_error(tmp_path, table):
    column = {name: np.zeros((4, 3)) for name in VARIABLES}
    with (
        pytest.raises(ValueError, match=r"sprocket_rate_left: \(4, 3\)"),
        LutWriter(tmp_path / "lut.h5", table.axes, *PROFILES, {}) as writer,
    ):
        writer.write_column(0, 0, column, np.zeros((4, 3), np.uint8))


def test_an_attribute_of_no_type_leaves_no_open_file(tmp_path, table):
    with pytest.raises(TypeError):
        LutWriter(tmp_path / "lut.h5", table.axes, *PROFILES, {"nothing": None})
    assert not h5py.h5f.get_obj_count(types=h5py.h5f.OBJ_FILE)


def test_sensitivity(tmp_path, table):
    path = tmp_path / "lut.h5"
    write_columns(path, table, product(range(2), range(5)))
    with xarray.open_dataset(path, engine="h5netcdf", group="sensitivity") as group:
        assert group.attrs == {"velocity_step": 0.5}
        for index in INDICES:
            place = {"output": index.output, "input": index.input, "statistic": str(index.statistic)}
            for name in ("index", "ci_low", "ci_high", "dummy"):
                assert group[name].sel(place) == getattr(index, name)
        assert group["samples"].dims == ("sample", "quantity")
        np.testing.assert_array_equal(group["samples"].sel(quantity="heading"), SAMPLES[:, 2])
    with xarray.open_dataset(path, engine="h5netcdf") as root:
        assert set(root.data_vars) == {*VARIABLES, "status"}


# From within the first attribute to within the last column.
@needs_file_limit
@pytest.mark.parametrize("limit", [100, 5_000, 30_000, 80_000, 100_000])
def test_a_full_disk_leaves_nothing(tmp_path, limit):
    done = run(DISK_FULL, tmp_path / "lut.h5", limit)
    assert done.stderr == ""
    assert done.returncode == 0
    assert done.stdout.endswith(f"lut.h5: cannot be written: {FILE_TOO_LARGE}\n")
    assert not list(tmp_path.iterdir())


@needs_full_disk
def test_a_full_device(table):
    with (
        pytest.raises(OutputError, match=NO_SPACE),
        whole_file(FULL_DISK, True) as path,
    ):
        write_lut(path, table)


@needs_pipe
def test_a_pipe_is_refused(tmp_path, table):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(OutputError, match="no pipe"), whole_file(tmp_path / "pipe", False) as path:
        write_lut(path, table)


@pytest.mark.skipif(sys.platform != "linux", reason="needs a peak of memory in KiB, as Linux tells it")
def test_memory_does_not_grow_with_the_table(tmp_path):
    done = run(MEMORY, tmp_path / "lut.h5")
    assert done.stderr == ""
    # 140 columns of 0.9 MB; HDF5 keeps the addresses of their chunks only. [KiB]
    assert int(done.stdout) < 10_000
