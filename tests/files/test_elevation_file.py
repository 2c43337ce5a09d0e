import errno
import io
import math
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from system_words import CANNOT_READ, NO_FILE

from trackctl.errors import MapError, MissingLibraryError
from trackctl.files.elevation_file import metres_per_degree, read_elevation
from trackctl.files.map_file import read_planning_map

HEIGHTS = np.array([[7.0, 8.0, 9.0], [4.0, 5.0, 6.5]])  # the first row the top
ESRI = "ncols 3\nnrows 2\nxllcorner 10\nyllcorner 20\ncellsize 2\nNODATA_value -9999\n7 8 9\n4 5 6.5\n"


def file(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def archive(tmp_path, **arrays):
    path = tmp_path / "hill.npz"
    np.savez(path, **arrays)
    return path


def assert_is_the_hill(path, spacing=(2.0, 2.0), corner=(10.0, 20.0)):
    elevation, notes = read_elevation(path)
    np.testing.assert_array_equal(elevation.height, HEIGHTS[::-1])
    np.testing.assert_allclose((elevation.spacing_x, elevation.spacing_y), spacing)
    np.testing.assert_allclose(elevation.bounds[:2], corner)
    assert notes == ()


def refusal(path, **options):
    with pytest.raises(MapError) as error:
        read_elevation(path, **options)
    assert str(path) in str(error.value)
    assert "\n" not in str(error.value)
    return str(error.value)


@pytest.mark.parametrize(
    "text",
    [
        ESRI,
        ESRI.upper(),
        ESRI.replace("\n", "\r\n"),
        ESRI.replace("xllcorner 10", "XLLCENTER 11").replace("yllcorner 20", "yllcenter 21"),
        ESRI.replace("cellsize 2", "dx 2\ndy 2"),
        ESRI.replace("7 8 9\n4 5 6.5", "7 8\n9 4 5\n\n6.5\n"),
        ESRI.replace("NODATA_value -9999\n", "").replace(" ", "   "),
        ESRI.replace("-9999", "nan"),
    ],
)
def test_esri_grids(tmp_path, text):
    assert_is_the_hill(file(tmp_path, "hill.asc", text))


def test_oblong_cells(tmp_path):
    text = ESRI.replace("cellsize 2", "dx 2\ndy 0.5")
    assert_is_the_hill(file(tmp_path, "hill.asc", text), (2.0, 0.5))


@pytest.mark.parametrize("nodata", ["-9999", "9", "-3.4028235e+38"])
def test_unknown_heights(tmp_path, nodata):
    text = ESRI.replace("-9999", nodata).replace(" 9\n", f" {nodata}\n")
    height = read_elevation(file(tmp_path, "hill.asc", text))[0].height
    np.testing.assert_array_equal(np.isnan(height), [[False] * 3, [False, False, True]])


def test_unknown_heights_by_default(tmp_path):
    text = ESRI.replace("NODATA_value -9999\n", "").replace(" 9\n", " -9999\n")
    assert np.isnan(read_elevation(file(tmp_path, "hill.asc", text))[0].height[1, 2])


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("ncols 3", "", "missing key: ncols"),
        ("ncols 3", "ncols 3.5", "line 1: ncols: 3.5 is not allowed; allowed: a whole number"),
        ("ncols 3", "ncols 1", "has 2 x 1 heights; allowed: 2 x 2 or more"),
        ("ncols 3", "ncols 3000\nnrows 3000", "line 3: 'nrows' is unknown or there twice"),
        ("nrows 2", "nrows 4000000", "has 4000000 x 3 heights; allowed: 2 x 2 or more, up to 4000000"),
        ("nrows 2", "nrows -2", "line 2: nrows: -2 is not allowed"),
        ("nrows 2", "nrows two", "line 2: nrows: 'two' is no number"),
        ("cellsize 2", "cellsize 0", "line 5: cellsize: 0 is not allowed; allowed: above 0"),
        ("cellsize 2", "cellsize", "line 5: cellsize: '' is no number"),
        ("cellsize 2", "dx 2", "missing key: dy or cellsize"),
        ("xllcorner 10", "xllcorner nan", "line 3: xllcorner: 'nan' is no number"),
        ("xllcorner 10", "xllcorner inf", "line 3: xllcorner: inf is not allowed"),
        ("xllcorner", "left", "line 3: 'left' is unknown"),
        ("4 5 6.5", "4 5", "holds 5 heights; allowed: ncols times nrows, 6"),
        ("4 5 6.5", "4 5 6.5 7", "holds 7 heights"),
        ("4 5 6.5", "4 5 6,5", "line 8: holds what is no number"),
        ("7 8 9", "7 8 -3.4e38", "holds a height of -3.4e+38 m; allowed: up to 100000, others declared as NODATA"),
        ("7 8 9\n4 5 6.5", "-9999 -9999 -9999\n-9999 -9999 -9999", "holds no known height"),
    ],
)
def test_what_is_no_esri_grid_is_refused(tmp_path, old, new, words):
    assert words in refusal(file(tmp_path, "hill.asc", ESRI.replace(old, new)))


def test_binary_files_are_no_esri_grid(tmp_path):
    assert "is no text" in refusal(file(tmp_path, "hill.asc", bytes(range(256))))
    assert "missing key: ncols" in refusal(file(tmp_path, "hill.asc", ""))


@pytest.mark.parametrize(
    "place",
    [
        {"dx": 2.0, "dy": 2.0, "xmin": 10.0, "ymin": 20.0},
        {"resolution": 2, "xmin": 10.0, "ymin": 20.0},
        {"xmin": 10.0, "xmax": 16.0, "ymin": 20.0, "ymax": 24.0},
        {"dx": 2.0, "dy": 2.0, "xmin": 10.0, "xmax": 16.0, "ymin": 24.0, "ymax": 20.0},  # the wrong way round
        {"dx": 2.0, "dy": 2.0, "xmin": 11.0, "xmax": 15.0, "ymin": 21.0, "ymax": 23.0},  # of the outer centres
        {"x": [11.0, 13.0, 15.0], "y": [23.0, 21.0]},
    ],
)
@pytest.mark.parametrize("name", ["elevation", "z", "my_hill"])
def test_npz_files(tmp_path, place, name):
    assert_is_the_hill(archive(tmp_path, **{name: HEIGHTS}, **place))


def test_npz_axes_tell_which_way_the_heights_run(tmp_path):
    assert_is_the_hill(archive(tmp_path, z=HEIGHTS[::-1, ::-1], x=[15.0, 13.0, 11.0], y=[21.0, 23.0]))


def test_nodata_of_an_npz(tmp_path):
    elevation, _ = read_elevation(archive(tmp_path, z=HEIGHTS.astype(np.int16), resolution=1.0, nodata=6))
    np.testing.assert_array_equal(np.isnan(elevation.height), [[False, False, True], [False] * 3])


@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("kind", ["<f4", ">f8", "<i2", "u1"])
def test_npy_files_with_the_place_given(tmp_path, order, kind):
    path = tmp_path / "hill.npy"
    np.save(path, np.asarray(2.0 * HEIGHTS, kind, order=order))
    elevation, _ = read_elevation(path, 0.5, (1.0, 2.0))
    np.testing.assert_array_equal(elevation.height, 2.0 * HEIGHTS[::-1])
    assert elevation.bounds == (1.0, 2.0, 2.5, 3.0)
    assert (elevation.x, elevation.y) == (1.25, 2.25)
    assert read_elevation(path, 0.5)[0].bounds == (0.0, 0.0, 1.5, 1.0)


@pytest.mark.parametrize(
    ("arrays", "words"),
    [
        ({"z": HEIGHTS}, "does not tell how far apart"),
        ({"a": HEIGHTS, "b": HEIGHTS}, "holds a, b; allowed: one array of heights"),
        ({f"a{i}": HEIGHTS for i in range(17)}, "holds 17 arrays; allowed: up to 16"),
        ({"z": HEIGHTS[0]}, "allowed: one array of heights"),
        ({"z": HEIGHTS[:1], "resolution": 1.0}, "has 1 x 3 heights"),
        ({"z": np.array([["a", "b"]] * 2)}, "allowed: numbers in rows and columns"),
        ({"z": np.array([[None, 1]] * 2)}, "allowed: numbers in rows and columns"),
        ({"z": HEIGHTS * 1j}, "allowed: numbers in rows and columns"),
        ({"z": HEIGHTS, "dx": 0.0, "dy": 1.0}, "dx: 0 is not allowed"),
        ({"z": HEIGHTS, "dx": [1.0, 2.0], "dy": 1.0}, "dx: holds 2 numbers; allowed: one"),
        ({"z": HEIGHTS, "x": [0.0, 1.0, 3.0], "y": [0.0, 1.0]}, "x: is no axis of the heights"),
        ({"z": HEIGHTS, "x": [0.0, 1.0], "y": [0.0, 1.0]}, "x: is no axis of the heights"),
        ({"z": HEIGHTS, "dx": 1.0, "dy": 1.0, "xmin": 0.0, "xmax": 9.0}, "lie 9 apart, which 3 times 1 is not"),
        ({"z": HEIGHTS, "xmin": 0.0, "xmax": 0.0, "ymin": 0.0, "ymax": 1.0}, "allowed: two finite numbers"),
    ],
)
def test_what_is_no_npz_of_heights_is_refused(tmp_path, arrays, words):
    path = tmp_path / "hill.npz"
    np.savez(path, **arrays)
    assert words in refusal(path)


def test_a_signalling_nan_is_unknown_without_a_warning(tmp_path):
    bits = HEIGHTS.astype("<f4").view("<u4")
    bits[0, 0] = 0x7F800001
    elevation, _ = read_elevation(archive(tmp_path, z=bits.view("<f4"), resolution=1.0))
    assert np.isnan(elevation.height).sum() == 1


def test_a_header_that_promises_too_much_takes_no_memory(tmp_path):
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {"descr": "<f8", "fortran_order": False, "shape": (10**6, 10**6)})
    assert "allowed: up to 4000000 numbers" in refusal(file(tmp_path, "hill.npy", stream.getvalue()))
    path = tmp_path / "hill.npz"
    with zipfile.ZipFile(path, "w") as packed:
        packed.writestr("z.npy", stream.getvalue())
    assert "allowed: up to 4000000 numbers" in refusal(path)


def test_degrees_become_metres(tmp_path):
    """A grid like jacksboro_fault_dem of matplotlib: 3 arc seconds, whole metres, ymin and ymax exchanged."""
    step = 3.0 / 3600.0
    height = (200.0 + 500.0 * np.random.default_rng(0).random((30, 40))).astype(np.int16)
    south, west = 36.5, -84.25
    path = archive(
        tmp_path,
        elevation=height,
        dx=step,
        dy=step,
        xmin=west,
        xmax=west + 40 * step,
        ymin=south + 30 * step,
        ymax=south,
    )
    elevation, (note,) = read_elevation(path)
    # A second of latitude is about a sea mile over 60; of longitude, less by the cosine.
    assert elevation.spacing_y == pytest.approx(3.0 * 1852.0 / 60.0, rel=0.002)
    assert elevation.spacing_x == pytest.approx(elevation.spacing_y * math.cos(math.radians(36.5)), rel=0.005)
    assert elevation.bounds[:2] == (0.0, 0.0)
    assert "metres east and north of its lower left corner, longitude -84.250000 and latitude 36.500000" in note
    np.testing.assert_array_equal(elevation.height, height[::-1])
    assert read_elevation(path, step)[1] == ()  # metres where the spacing is given


def test_lengths_of_a_degree():
    """The meridian's quarter of WGS 84 is 10 001 965.73 m, its equator 2 pi 6 378 137 m round."""
    latitudes = np.arange(0.05, 90.0, 0.1)
    northward = [0.1 * metres_per_degree(latitude)[1] for latitude in latitudes]
    assert sum(northward) == pytest.approx(10_001_965.73, abs=1.0)
    assert 360.0 * metres_per_degree(0.0)[0] == pytest.approx(2.0 * math.pi * 6378137.0)
    assert metres_per_degree(90.0)[0] == pytest.approx(0.0, abs=1e-9)


def test_small_grids_of_metres_are_not_taken_for_degrees(tmp_path):
    """A sandbox of 1.5 m with hills of 0.5 m, near (0, 0)."""
    path = archive(tmp_path, z=0.5 * np.random.default_rng(0).random((30, 30)), resolution=0.05, xmin=0.0, ymin=0.0)
    elevation, notes = read_elevation(path)
    assert (elevation.spacing_x, notes) == (0.05, ())


def test_a_larger_grid_far_from_the_origin(tmp_path):
    """As map projections have it, every digit kept."""
    heights = 500.0 + 100.0 * np.random.default_rng(0).random((37, 50))
    header = "NCOLS 50\nNROWS 37\nXLLCORNER 556440.0\nYLLCORNER 5394932.0\nCELLSIZE 1.0\nNODATA_VALUE -9999\n"
    rows = "".join(" ".join(map(repr, row)) + "\n" for row in heights.tolist())
    elevation, notes = read_elevation(file(tmp_path, "hill.asc", header + rows))
    np.testing.assert_array_equal(elevation.height, heights[::-1])
    assert (elevation.bounds, notes) == ((556440.0, 5394932.0, 556490.0, 5394969.0), ())


def test_a_grid_in_capitals_of_landlab(data_of_others):
    elevation, _ = read_elevation(data_of_others("dem/kootenai_1m.asc"))
    assert elevation.height.shape == (37, 50)
    assert elevation.bounds == (556440.0, 5394932.0, 556490.0, 5394969.0)
    assert elevation.height[-1, 0] == 543.340026855468977


def test_a_geotiff_of_landlab(data_of_others):
    pytest.importorskip("tifffile")
    found = read_planning_map(str(data_of_others("dem/DEM_10m.tif"))).elevation
    assert found.height.shape == (53, 67)
    assert found.bounds == (317284.0, 3808476.0, 317284.0 + 670.0, 3808476.0 + 530.0)
    assert found.height[-1, :4].tolist() == [1668.0, 1669.0, 1671.0, 1674.0]


def geotiff(tmp_path, tags, heights=HEIGHTS, **options):
    tifffile = pytest.importorskip("tifffile")
    path = tmp_path / "hill.tif"
    tifffile.imwrite(
        path, heights if heights.dtype == np.uint8 else heights.astype(np.float32), extratags=tags, **options
    )
    return path


SCALE, TIE = (33550, "d", 3, (2.0, 2.0, 0.0), True), (33922, "d", 6, (0.0, 0.0, 0.0, 10.0, 24.0, 0.0), True)


def directory(*keys):
    return (
        34735,
        "H",
        4 + 4 * len(keys),
        (1, 1, 0, len(keys), *(n for key, value in keys for n in (key, 0, 1, value))),
        True,
    )


@pytest.mark.parametrize(
    "tags",
    [
        [SCALE, TIE],
        [SCALE, (33922, "d", 6, (1.0, 1.0, 0.0, 12.0, 22.0, 0.0), True)],
        [(34264, "d", 16, (2.0, 0, 0, 10.0, 0, -2.0, 0, 24.0, 0, 0, 0, 0, 0, 0, 0, 1.0), True)],
        [SCALE, TIE, directory((1024, 1), (1025, 1), (3076, 9001))],
        [SCALE, (33922, "d", 6, (0.0, 0.0, 0.0, 11.0, 23.0, 0.0), True), directory((1024, 1), (1025, 2))],
    ],
)
@pytest.mark.parametrize("options", [{}, {"compression": "zlib"}, {"compression": "lzw", "predictor": True}])
def test_geotiffs(tmp_path, tags, options):
    if options:
        pytest.importorskip("imagecodecs")
    assert_is_the_hill(geotiff(tmp_path, tags, **options))


def test_a_geotiff_is_a_map(tmp_path):
    heights = np.random.default_rng(0).integers(1600, 1800, (53, 67)).astype(float)
    tie = (33922, "d", 6, (0.0, 0.0, 0.0, 317284.0, 3809006.0, 0.0), True)
    found = read_planning_map(str(geotiff(tmp_path, [SCALE, tie], heights))).elevation
    assert found.bounds == (317284.0, 3808900.0, 317418.0, 3809006.0)
    np.testing.assert_array_equal(found.height, heights[::-1])


def test_a_geotiff_of_degrees_says_so(tmp_path):
    place = (33550, "d", 3, (1e-5, 1e-5, 0.0), True), (33922, "d", 6, (0, 0, 0, 10.0, 24.0, 0.0), True)
    elevation, (note,) = read_elevation(geotiff(tmp_path, [*place, directory((1024, 2))]))
    assert elevation.spacing_y == pytest.approx(1.11, rel=0.01)
    assert "latitude 23.999980" in note


def test_unknown_heights_of_a_geotiff(tmp_path):
    heights = HEIGHTS.astype(np.float32)
    heights[0, 0] = -3.4028235e38
    path = geotiff(tmp_path, [SCALE, TIE, (42113, "s", 0, "-3.4028235e+38", True)], heights)
    np.testing.assert_array_equal(np.isnan(read_elevation(path)[0].height), [[False] * 3, [True, False, False]])


@pytest.mark.parametrize(
    ("tags", "heights", "words"),
    [
        ([], HEIGHTS, "does not tell how far apart"),
        ([SCALE, TIE, directory((3076, 9002))], HEIGHTS, "has lengths in unit 9002 of EPSG; allowed: metre"),
        ([(33550, "d", 3, (0.0, 2.0, 0.0), True), TIE], HEIGHTS, "has cells of 0 x 2"),
        ([(34264, "d", 16, (2.0, 1.0, *[0.0] * 14), True)], HEIGHTS, "lies askew"),
        ([SCALE, TIE, (42113, "s", 0, "none", True)], HEIGHTS, "declares 'none' as NODATA"),
        ([SCALE, TIE], np.zeros((4, 5, 3), np.uint8), "is no image of one band"),
        ([SCALE, TIE], np.zeros((4, 1), np.float32), "has 4 x 1 heights"),
    ],
)
def test_what_is_no_elevation_in_a_geotiff_is_refused(tmp_path, tags, heights, words):
    assert words in refusal(geotiff(tmp_path, tags, heights))


def test_the_systems_reason_is_told(tmp_path, monkeypatch):
    class FailingFile(io.FileIO):
        def readinto(self, buffer):
            raise OSError(errno.EIO, CANNOT_READ)

    path = geotiff(tmp_path, [SCALE, TIE])
    monkeypatch.setattr(Path, "open", lambda path, mode: io.BufferedReader(FailingFile(path, mode)))
    assert refusal(path) == f"{path}: cannot be read: {CANNOT_READ}"


def test_geotiff_without_its_library(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "tifffile", None)
    with pytest.raises(MissingLibraryError, match=r"pip install 'trackctl\[geo\]'"):
        read_elevation(file(tmp_path, "hill.tif", "II*"))


@pytest.mark.parametrize("ending", [".asc", ".npy", ".npz", ".tif"])
def test_files_that_are_none(tmp_path, ending):
    assert NO_FILE in refusal(tmp_path / f"none{ending}")
    assert "is a folder" in refusal_of_folder(tmp_path / f"folder{ending}")
    refusal(file(tmp_path, f"empty{ending}", ""))
    refusal(file(tmp_path, f"text{ending}", "free as the wind\n"))


def refusal_of_folder(path):
    path.mkdir()
    return refusal(path)


@pytest.mark.parametrize("ending", [".asc", ".npy", ".npz", ".tif"])
def test_a_file_cut_short_or_damaged_reads_or_is_refused(tmp_path, ending):
    path = tmp_path / f"hill{ending}"
    if ending == ".asc":
        path.write_text(ESRI)
    elif ending == ".npy":
        np.save(path, HEIGHTS)
    elif ending == ".npz":
        np.savez_compressed(path, z=HEIGHTS, x=[1.0, 2.0, 3.0], y=[1.0, 2.0])
    else:
        geotiff(tmp_path, [SCALE, TIE], np.random.default_rng(0).random((20, 30)))
    whole, random = path.read_bytes(), np.random.default_rng(0)
    for length in range(0, len(whole), max(len(whole) // 40, 1)):
        path.write_bytes(whole[:length])
        reads_or_refuses(path)
    for _ in range(200):
        content = bytearray(whole)
        for place in random.integers(0, min(len(whole), 600), random.integers(1, 5)):
            content[place] = random.integers(0, 256)
        path.write_bytes(content)
        reads_or_refuses(path)


def reads_or_refuses(path):
    try:
        elevation, _ = read_elevation(path, 1.0)
    except MapError as error:
        assert "\n" not in str(error)  # noqa: PT017
    else:
        assert np.isfinite(elevation.height).any()
