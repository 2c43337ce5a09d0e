import math
import shutil
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image
from system_words import NO_FILE, NOT_PERMITTED
from systems import needs_devices, needs_permissions

from trackctl.errors import MapError
from trackctl.files.map_file import read_planning_map
from trackctl.geometry.circle import Circle

README = Path(__file__).parents[2] / "README.md"
ROS = {
    "image": "map.pgm",
    "resolution": "0.05",
    "origin": "[-1.0, 2.0, 0.5]",
    "negate": "0",
    "occupied_thresh": "0.65",
    "free_thresh": "0.196",
}


@pytest.fixture
def written(tmp_path):
    """Writes a map's YAML, beside an image of 3 x 2 pixels and an elevation grid, and names it."""
    Image.fromarray(np.array([[0, 205, 255], [255, 255, 255]], np.uint8)).save(tmp_path / "map.pgm")
    np.save(tmp_path / "hill.npy", np.arange(12.0).reshape(3, 4))
    (tmp_path / "hill.asc").write_text("ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 5\n0 1\n0 1\n")

    def write(keys, text=""):
        path = tmp_path / "map.yaml"
        path.write_text("".join(f"{key}: {value}\n" for key, value in keys.items()) + text, encoding="utf-8")
        return str(path)

    return write


def test_a_map_of_ros(written):
    path = written(ROS)
    found = read_planning_map(path)
    assert found.occupancy.cells.tolist() == [[0, 0, 0], [100, -1, 0]]
    frame = found.occupancy.frame
    assert (frame.n_rows, frame.n_columns, frame.resolution) == (2, 3, 0.05)
    assert (frame.x, frame.y, frame.yaw) == (-1.0, 2.0, 0.5)
    assert found.file == path
    assert found.occupancy.source == str(Path(path).parent / "map.pgm")
    assert (found.start, found.slope, found.elevation, found.notes) == (None, None, None, ())


@pytest.mark.parametrize("kind", ["pgm", "png", "bmp"])
def test_a_turned_map_of_many_cells(written, tmp_path, kind):
    """In shades as map_server writes them; the corners of the cells turn with the map."""
    shades = np.random.default_rng(0).choice(np.array([0, 205, 254], np.uint8), (17, 11))
    Image.fromarray(shades if kind == "pgm" else np.stack([shades] * 3, axis=-1)).save(tmp_path / f"turned.{kind}")
    changes = {"image": f"turned.{kind}", "resolution": "0.1", "origin": "[2.0, 3.0, 1.0]"}
    occupancy = read_planning_map(written(ROS | changes)).occupancy
    expected = np.select([shades == 0, shades == 254], [100, 0], -1)
    np.testing.assert_array_equal(occupancy.cells[::-1], expected)
    across, up = 0.1 * 11, 0.1 * 17
    np.testing.assert_allclose(
        occupancy.frame.to_world(11.0, 17.0),
        (2.0 + across * math.cos(1.0) - up * math.sin(1.0), 3.0 + across * math.sin(1.0) + up * math.cos(1.0)),
    )


@pytest.mark.parametrize(
    ("name", "shape", "occupied", "unknown"), [("testmap", (10, 10), 29, 0), ("TenByTen", (10, 10), 20, 2)]
)
def test_maps_of_nav2(data_of_others, name, shape, occupied, unknown):
    cells = read_planning_map(str(data_of_others(f"maps/{name}.yaml"))).occupancy.cells
    assert cells.shape == shape
    assert ((cells == 100).sum(), (cells == -1).sum()) == (occupied, unknown)


def test_a_turned_map_of_nav2(data_of_others):
    frame = read_planning_map(str(data_of_others("maps/testmap.yaml"))).occupancy.frame
    np.testing.assert_allclose(
        frame.to_world(10.0, 10.0), (2.0 + math.cos(1.0) - math.sin(1.0), 3.0 + math.sin(1.0) + math.cos(1.0))
    )


def test_numbers_and_truths_as_map_server_writes_and_reads_them(written):
    cases = {"resolution": "5e-02", "occupied_thresh": "6.5e-1", "negate": "false", "origin": "[-1, 2e0, .5]"}
    found = read_planning_map(written(ROS | cases))
    assert found.occupancy.frame == read_planning_map(written(ROS)).occupancy.frame
    negated = read_planning_map(written(ROS | {"negate": "true", "mode": '"scale"'}))
    assert negated.occupancy.cells.tolist() == [[100, 100, 100], [0, 100, 100]]
    assert read_planning_map(written(ROS | {"mode": "raw"})).occupancy.cells.tolist() == [[-1] * 3, [0, -1, -1]]


def test_an_image_by_its_whole_path_or_from_another_folder(written, tmp_path):
    below = tmp_path / "images"
    below.mkdir()
    shutil.move(tmp_path / "map.pgm", below / "other.pgm")
    path = written(ROS | {"image": "images/../images/other.pgm"})
    assert read_planning_map(path).occupancy.cells.shape == (2, 3)
    assert read_planning_map(written(ROS | {"image": below / "other.pgm"})).occupancy.cells.shape == (2, 3)


def test_keys_of_others_are_left_alone(written):
    text = "lanes:\n  - {from: 1, to: 2}\nvoxel: yes\n"
    assert read_planning_map(written(ROS, text)).notes == ()
    (note,) = read_planning_map(written(ROS, "slope: 12\n")).notes
    assert note.endswith("map.yaml, line 7: slope is no key of a plan and left alone; did you mean slope_deg?")


def test_what_a_map_lays_down_for_a_plan(written, tmp_path):
    keys = {
        "start": "[1, 2, 90]",
        "goal": "[3.5, -4, -180]",
        "goal_tolerance": "[0.1, 5]",
        "slope_deg": "12",
        "uphill_yaw_deg": "45",
        "bounds_m": "[-5, -6, 7, 8]",
        "resolution": "0.1",
        "vehicle": "carrier-13t6",
        "terrain": "soils/wet.yaml",
        "lut": "table.h5",
        "obstacles": "{circles: [[1, 2, 0.5]], polygons: [[[0, 0], [1, 0], [0, 1]]]}",
    }
    found = read_planning_map(written(keys))
    np.testing.assert_allclose(found.start, (1.0, 2.0, math.pi / 2))
    np.testing.assert_allclose(found.goal, (3.5, -4.0, -math.pi))
    np.testing.assert_allclose(found.goal_tolerance, (0.1, math.radians(5.0)))
    np.testing.assert_allclose((found.slope, found.uphill_yaw), np.radians((12.0, 45.0)))
    assert (found.bounds, found.resolution, found.occupancy) == ((-5.0, -6.0, 7.0, 8.0), 0.1, None)
    assert found.vehicle == "carrier-13t6"
    assert (found.terrain, found.lut) == (str(tmp_path / "soils/wet.yaml"), str(tmp_path / "table.h5"))
    assert found.circles == (Circle(1.0, 2.0, 0.5),)
    assert found.polygons == (((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)),)


def test_a_goal_tolerance_of_one_number_is_that_of_the_position(written):
    assert read_planning_map(written(ROS | {"goal_tolerance": "0.25"})).goal_tolerance == (0.25, 0.0)


def test_other_units_of_the_same_quantity(written):
    found = read_planning_map(written({"slope_rad": "0.2", "bounds_cm": "[0, 0, 100, 200]"}))
    assert (found.slope, found.bounds) == (0.2, (0.0, 0.0, 1.0, 2.0))


def test_elevation_grids_beside_a_map(written):
    found = read_planning_map(written(ROS | {"elevation": "hill.asc"}))
    assert found.elevation.bounds == (0.0, 0.0, 10.0, 10.0)
    moved = {"elevation": "hill.npy", "elevation_resolution_m": "0.5", "elevation_origin_m": "[-3, 4]"}
    found = read_planning_map(written(moved))
    assert found.elevation.bounds == (-3.0, 4.0, -1.0, 5.5)
    assert found.elevation.height[0].tolist() == [8.0, 9.0, 10.0, 11.0]  # the last row of the file


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"image": None}, "missing keys of a map with an image: image"),
        ({"negate": None, "origin": None}, "missing keys of a map with an image: origin, negate"),
        ({"image": "nowhere.pgm"}, f"nowhere.pgm: cannot be read: {NO_FILE}"),
        ({"image": "."}, "is a folder; allowed: a file"),
        pytest.param({"image": "/dev/zero"}, "/dev/zero: is no regular file", marks=needs_devices),
        ({"image": '""'}, "line 1: image: is empty"),
        ({"image": '"a\\0b"'}, "line 1: image: "),
        ({"image": "hill.asc"}, "hill.asc: is no image; allowed: PPM"),
        ({"image": "[a, b]"}, "line 1: image: a list is no text"),
        ({"resolution": "0"}, "line 2: resolution: 0 is not allowed; allowed: 0.0001 to 10000"),
        ({"resolution": "-0.05"}, "line 2: resolution: -0.05 is not allowed"),
        ({"resolution": ".nan"}, "line 2: resolution: .nan is no finite"),
        ({"resolution": "nan"}, "line 2: resolution: 'nan' is no number"),
        ({"resolution": "1e999"}, "line 2: resolution: "),
        ({"resolution": "5 cm"}, "line 2: resolution: '5 cm' is no number"),
        ({"origin": "[0, 0]"}, "line 3: origin: has 2 numbers; allowed: [x, y, yaw]"),
        ({"origin": "3"}, "line 3: origin: is no list"),
        ({"origin": "[0, 0, up]"}, "line 3: origin: 'up' is no number"),
        ({"origin": "[0, [1], 0]"}, "line 3: origin: a list is no number"),
        ({"origin": "[1e12, 0, 0]"}, "line 3: origin: 1e+12 is not allowed"),
        ({"negate": "2"}, "line 4: negate: 2 is not allowed; allowed: 0, 1, false, true"),
        ({"negate": "[1]"}, "line 4: negate: a list or mapping is not allowed"),
        ({"occupied_thresh": "65"}, "line 5: occupied_thresh: 65 is not allowed; allowed: 0 to 1"),
        ({"free_thresh": "0.7"}, "line 6: free_thresh: 0.7 is above occupied_thresh; allowed: up to 0.65"),
        ({"mode": "binary"}, "line 7: mode: 'binary' is not allowed; allowed: trinary, scale, raw"),
        ({"start": "[0, 0]"}, "line 7: start: has 2 numbers; allowed: [x_m, y_m, yaw_deg]"),
        ({"start": "[0, .inf, 0]"}, "line 7: start: .inf is no finite"),
        ({"goal": "here"}, "line 7: goal: is no list; allowed: [x_m, y_m, yaw_deg]"),
        ({"goal_tolerance": "[-1, 5]"}, "line 7: goal_tolerance: -1 is not allowed; allowed: 0 to 1000"),
        (
            {"goal_tolerance": "[0.1, .nan]"},
            "line 7: goal_tolerance: .nan is no finite decimal number; allowed: 0 to 180",
        ),
        ({"goal_tolerance": "[near, 5]"}, "line 7: goal_tolerance: 'near' is no number; allowed: 0 to 1000"),
        ({"goal_tolerance": "-0.1"}, "line 7: goal_tolerance: -0.1 is not allowed; allowed: 0 to 1000"),
        ({"goal_tolerance": "near"}, "line 7: goal_tolerance: 'near' is no number; allowed: 0 to 1000"),
        ({"goal_tolerance": "[1, 2, 3]"}, "line 7: goal_tolerance: has 3 numbers; allowed: [position_m, yaw_deg]"),
        ({"slope_deg": "45.5"}, "line 7: slope_deg: 45.5 is not allowed; allowed: 0 to 44.9"),
        ({"slope_deg": "steep"}, "line 7: slope_deg: 'steep' is no number; allowed: 0 to 44.9"),
        ({"slope_deg": "5", "slope_rad": "0.1"}, "line 8: slope_rad: stands in line 7 as slope_deg"),
        ({"uphill_yaw_deg": "5"}, "line 7: uphill_yaw_deg: stands without slope_deg"),
        ({"elevation_origin_m": "[0, 0]"}, "line 7: elevation_origin_m: stands without elevation"),
        ({"slope_deg": "5", "elevation": "hill.asc"}, "line 7: slope_deg: stands beside elevation"),
        ({"elevation": "hill.npy"}, "hill.npy: does not tell how far apart its heights are"),
        ({"elevation": "hill.txt"}, "hill.txt: is of no known kind; allowed: .asc"),
        ({"elevation": "none.asc"}, f"none.asc: cannot be read: {NO_FILE}"),
        ({"bounds_m": "[0, 0, 1, 1]"}, "line 7: bounds_m: stands beside image or elevation"),
        ({"vehicle": "[a]"}, "line 7: vehicle: a list is no text"),
        ({"obstacles": "[1, 2]"}, "line 7: obstacles: is no mapping"),
        ({"obstacles": "{squares: []}"}, "line 7: obstacles: 'squares' is unknown or there twice"),
        ({"obstacles": "{circles: 3}"}, "line 7: circles: is no list"),
        ({"obstacles": "{circles: [[1, 2, 3], [1, 2]]}"}, "line 7: obstacles, circle 2: has 2 numbers"),
        ({"obstacles": "{circles: [[1, 2, -3]]}"}, "circle 1: -3 is not allowed; allowed: 0.001 to"),
        ({"obstacles": "{polygons: [[[0, 0], [1, 1]]]}"}, "polygon 1: has 2 corners and no area"),
        ({"obstacles": "{polygons: [[[0, 0], [1, 1], [2, 2]]]}"}, "polygon 1: has 3 corners and no area"),
        ({"obstacles": "{polygons: [[[0, 0], [1], [2, 3]]]}"}, "polygon 1: has 1 numbers; allowed: [x_m, y_m]"),
        ({"resolution": "0.05\nresolution: 0.1"}, "line 3: resolution: stands here and in line 2"),
        ({"start": "&a [1, 2, 3]\ngoal: *a"}, "line 7: YAML anchors and aliases"),
    ],
)
def test_what_is_not_allowed_is_refused_by_name(written, changes, words):
    keys = {key: value for key, value in (ROS | changes).items() if value is not None}
    path = written(keys)
    with pytest.raises(MapError) as error:
        read_planning_map(path)
    assert words in str(error.value)
    assert "\n" not in str(error.value)
    assert str(error.value).startswith(path)
    assert ", line " in str(error.value) or "missing keys" in words


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "is empty"),
        ("# none\n", "is empty"),
        ("name: x\n", "is no map"),
        ("- 1\n", "is no list of"),
        ("a: [", "YAML"),
    ],
)
def test_what_is_no_map_is_refused(written, text, words):
    with pytest.raises(MapError, match=words):
        read_planning_map(written({}, text))


def test_bounds_without_a_room_are_refused(written):
    with pytest.raises(MapError, match="line 1: bounds_m: is empty; allowed: x_min below x_max"):
        read_planning_map(written({"bounds_m": "[0, 0, 0, 1]"}))


def test_an_image_in_place_of_a_map_is_refused(written, tmp_path):
    written(ROS)
    with pytest.raises(MapError, match=r"map.pgm"):
        read_planning_map(str(tmp_path / "map.pgm"))


WHOLE = "".join(
    f"{key}: {value}\n"
    for key, value in (
        ROS
        | {
            "start": "[0, 0, 0]",
            "goal_tolerance": "[0.1, 5]",
            "elevation": "hill.asc",
            "obstacles": "{circles: [[1, 2, 0.5]], polygons: [[[0, 0], [1, 0], [0, 1]]]}",
        }
    ).items()
)
MUTATIONS = st.lists(
    st.tuples(
        st.integers(0, len(WHOLE) - 1), st.sampled_from(["", "\0", "[", "}", "-", "9", "e", ":", "\n", " ", "'", "é"])
    ),
    min_size=1,
    max_size=4,
)


@settings(max_examples=300)
@given(MUTATIONS)
def test_a_changed_map_reads_or_is_refused_in_one_line(written, mutations):
    text = WHOLE
    for place, character in mutations:
        text = text[:place] + character + text[place + 1 :]
    path = written({}, text)
    try:
        read_planning_map(path)
    except MapError as error:
        assert "\n" not in str(error)  # noqa: PT017


@needs_permissions
def test_a_map_that_is_not_permitted(written):
    path = Path(written(ROS))
    path.chmod(0)
    with pytest.raises(MapError, match=NOT_PERMITTED):
        read_planning_map(str(path))


def test_the_map_of_the_readme_reads(written):
    section = README.read_text(encoding="utf-8").partition("## Maps")[2]
    text = section.partition("```yaml\n")[2].partition("```")[0]
    one_ground = "".join(line for line in text.splitlines(keepends=True) if not line.startswith("elevation"))
    found = read_planning_map(written({}, one_ground))
    assert (found.vehicle, len(found.circles), len(found.polygons), found.notes) == ("utv-61cm", 1, 1, ())
    other_ground = "".join(
        line for line in text.splitlines(keepends=True) if not line.startswith(("slope", "uphill", "bounds"))
    )
    assert read_planning_map(written({}, other_ground)).elevation.spacing_x == 0.5
