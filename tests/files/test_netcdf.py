import h5py
import numpy as np
import pytest

from trackctl.files.netcdf import plain_attributes, set_attributes


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ("text", "text"),
        ("", ""),
        ("grüße\n", "grüße\n"),
        (3, 3),
        (np.int64(3), 3),
        (2.5, 2.5),
        (True, 1),
        (["a", "bc"], ["a", "bc"]),
        (np.array(["a", "bc"]), ["a", "bc"]),
        (np.bytes_(b"fixed"), "fixed"),
        (h5py.Empty("S1"), ""),
    ],
)
def test_attributes_come_back(tmp_path, value, expected):
    with h5py.File(tmp_path / "file.h5", "w") as file:
        if isinstance(value, np.bytes_ | h5py.Empty):  # what other programs write
            file.attrs["x"] = value
        else:
            set_attributes(file, {"x": value})
        found = plain_attributes(file)["x"]
    assert found == expected
    assert type(found) is type(expected)


def test_arrays_come_back(tmp_path):
    with h5py.File(tmp_path / "file.h5", "w") as file:
        set_attributes(file, {"floats": [0.5, 1.0], "flags": np.array([True, False])})
        found = plain_attributes(file)
    np.testing.assert_array_equal(found["floats"], [0.5, 1.0])
    np.testing.assert_array_equal(found["flags"], [1, 0])
