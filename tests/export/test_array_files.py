import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator
from scipy.io import loadmat, whosmat
from table_variants import scattered, variants

from trackctl.export import array_files
from trackctl.export.array_files import write_mat, write_npz
from trackctl.export.gridded import DIMENSIONS, RATIOS, UNITS, gridded
from trackctl.lut.interpolation import LookupStatus, interpolant, look_up
from trackctl.lut.shape_functions import Method
from trackctl.lut.table import VARIABLES, Status

TABLES = variants()
#: Those whose right turns are stored or can be mirrored.
BOTH_TURNS = ("symmetric", "two slopes", "off centre")
NUMBERS = {"track_gauge": 0.61, "sprocket_radius": 0.0875, "max_sprocket_rate": 30.0, "gravity": 9.80665}
TEXTS = {"title": "utv-61cm on asphalt", "readme": "Über alles\nand more", "history": ""}


def read_mat(path):
    return loadmat(path, squeeze_me=False)


@pytest.mark.parametrize("name", BOTH_TURNS)
def test_plain_interpolation_answers_as_lookup(name):
    """In both turns and between the last heading and the first, without a mirror or a wrap by the user."""
    table = TABLES[name]
    found = gridded(table)
    points = scattered(table, np.random.default_rng(3), 3000)
    points = points[:, abs(points[2]) <= table.axes.curvature[-1]]
    points[1] = np.clip(points[1], table.axes.velocity[0], table.axes.velocity[-1])
    points[0] = np.clip(points[0], table.axes.slope[0], table.axes.slope[-1])
    wanted = look_up(interpolant(table), *points, method=Method.LINEAR)
    kept = slice(None) if table.axes.slope.size > 1 else slice(3)
    axes = [found.axes[dimension] for dimension in DIMENSIONS[kept]]
    places = np.stack([points[1], points[2], points[3], points[0]], axis=-1)[:, kept]
    arrays = {key: array if kept == slice(None) else array[..., 0] for key, array in found.values.items()}
    answered = wanted.status == LookupStatus.CONVERGED
    unanswered = ~answered & (wanted.status != LookupStatus.ACTUATOR_LIMIT)
    assert answered.sum() > 1000
    for ratio, speed in zip(RATIOS, (wanted.track_speed_left, wanted.track_speed_right), strict=True):
        read = RegularGridInterpolator(axes, arrays[ratio])(places) * points[1]
        np.testing.assert_allclose(read[answered], speed[answered], rtol=1e-12)
        # NaN where lookup has no answer, next to infeasible cells, too.
        assert np.isnan(read[unanswered]).all()
    read = RegularGridInterpolator(axes, arrays["sideslip"])(places)
    np.testing.assert_allclose(read[answered], wanted.sideslip[answered], atol=1e-13)


@pytest.mark.parametrize("name", list(TABLES))
def test_left_turns_are_those_of_the_table(name):
    table = TABLES[name]
    found = gridded(table)
    left = found.axes["curvature"].size - table.axes.curvature.size
    for key in VARIABLES:
        inner = found.values[key][:, left:, : table.axes.heading.size]
        np.testing.assert_array_equal(np.moveaxis(inner, -1, 0), table.values[key])
    np.testing.assert_array_equal(np.moveaxis(found.status[:, left:, : table.axes.heading.size], -1, 0), table.status)
    np.testing.assert_array_equal(found.feasible, ~np.isnan(found.values["traction_left"]))


@pytest.mark.parametrize("name", list(TABLES))
def test_axes_ascend_and_fit_the_arrays(name):
    table = TABLES[name]
    found = gridded(table)
    for axis in found.axes.values():
        assert (np.diff(axis) > 0.0).all()
    shape = tuple(found.axes[dimension].size for dimension in DIMENSIONS)
    assert {array.shape for array in (*found.values.values(), found.status)} == {shape}
    if table.axes.heading_is_periodic:
        assert found.axes["heading"][-1] - found.axes["heading"][0] == pytest.approx(2.0 * np.pi)
        np.testing.assert_array_equal(found.status[:, :, 0], found.status[:, :, -1])


def test_right_turns_come_with_both_turns_or_headings_that_are_their_own_image():
    assert {name: gridded(table).right_turns for name, table in TABLES.items()} == {
        "symmetric": True,
        "two slopes": True,
        "off centre": True,
        "off centre, left turns only": False,
        "half a circle": False,
        "one speed and heading": True,
        "slow sprockets": True,
    }


def test_traction_changes_sides_in_a_mirrored_turn():
    found = gridded(TABLES["symmetric"])
    left, right = (found.values[f"traction_{side}"][1, :, :, 0] for side in ("left", "right"))
    # Heading 60 deg and -60 deg, turns of 5 m: the sides differ.
    assert left[-3, 2] == right[2, -3]
    assert left[-3, 2] != left[2, -3]


@pytest.mark.parametrize("name", ["symmetric", "two slopes"])
def test_mat_round_trip(tmp_path, name):
    table = gridded(TABLES[name])
    write_mat(tmp_path / "table.mat", table, NUMBERS, TEXTS)
    found = read_mat(tmp_path / "table.mat")
    for dimension in DIMENSIONS:
        np.testing.assert_array_equal(found[dimension], table.axes[dimension][:, None])
    slopes = table.axes["slope"].size
    for key, array in (*table.values.items(), ("status", table.status), ("feasible", table.feasible)):
        wanted = array if slopes > 1 else array[..., 0]
        assert found[key].dtype == (np.uint8 if key == "feasible" else array.dtype)
        np.testing.assert_array_equal(found[key], wanted)
    kinds = {key: kind for key, _, kind in whosmat(tmp_path / "table.mat")}
    assert (kinds["feasible"], kinds["status"], kinds["heading"]) == ("logical", "uint8", "double")
    assert (kinds["units"], kinds["dimensions"], kinds["readme"]) == ("struct", "cell", "char")
    assert {key: found[key].item() for key in NUMBERS} == NUMBERS
    assert "".join(found["readme"]) == TEXTS["readme"]
    assert [word.item() for word in found["dimensions"].ravel()] == list(DIMENSIONS)
    assert [word.item() for word in found["status_meanings"].ravel()] == [each.name.lower() for each in Status]
    units = found["units"]
    assert {key: units[key].item().item() for key in units.dtype.names} == UNITS


@pytest.mark.parametrize("name", ["symmetric", "two slopes"])
def test_npz_round_trip(tmp_path, name):
    table = gridded(TABLES[name])
    write_npz(tmp_path / "table.npz", table, NUMBERS, TEXTS)
    with np.load(tmp_path / "table.npz", allow_pickle=False) as found:
        for key, array in (*table.axes.items(), *table.values.items()):
            np.testing.assert_array_equal(found[key], array)
        np.testing.assert_array_equal(found["status"], table.status)
        np.testing.assert_array_equal(found["feasible"], table.feasible)
        assert found["feasible"].dtype == bool
        assert {key: float(found[key]) for key in NUMBERS} == NUMBERS
        assert {key: str(found[key]) for key in TEXTS} == TEXTS
        assert tuple(found["dimensions"]) == DIMENSIONS
        assert dict(found["units"].tolist()) == UNITS
        assert found["status_meanings"].tolist() == [each.name.lower() for each in Status]


@pytest.mark.parametrize("write", [write_mat, write_npz])
def test_the_same_table_gives_the_same_bytes(tmp_path, monkeypatch, write):
    table = gridded(TABLES["symmetric"])
    write(tmp_path / "first", table, NUMBERS, TEXTS)
    monkeypatch.setattr("time.asctime", lambda *_: "Thu Jan  1 00:00:00 1970")
    monkeypatch.setattr("time.time", lambda: 0.0)
    write(tmp_path / "second", table, NUMBERS, TEXTS)
    assert (tmp_path / "first").read_bytes() == (tmp_path / "second").read_bytes()


def test_a_variable_too_large_for_matlab_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(array_files, "LARGEST_VARIABLE", 2000)
    with pytest.raises(ValueError, match=r"speed_ratio_left has .* a variable of a MATLAB file has less than 2 GB"):
        write_mat(tmp_path / "table.mat", gridded(TABLES["symmetric"]), NUMBERS, TEXTS)
    assert not (tmp_path / "table.mat").exists()
