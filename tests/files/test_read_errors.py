import errno
import os

import pytest

from trackctl.errors import InputFileError, MapError
from trackctl.files.read_errors import read_errors, why_unreadable

HDF5 = "Unable to open object (file read failed: time = now\n, errno = 5, error message = 'x', offset = 3)"


@pytest.mark.parametrize("kind", [InputFileError, MapError])
@pytest.mark.parametrize("number", [errno.EIO, errno.EACCES, errno.ENOLCK, errno.ESTALE])
def test_a_failed_read_is_an_error_on_the_file(kind, number):
    with pytest.raises(kind) as raised, read_errors("x.csv", kind):
        raise OSError(number, os.strerror(number))
    assert str(raised.value) == f"x.csv: cannot be read: {os.strerror(number)}"


def test_other_errors_stay_what_they_are():
    with pytest.raises(ZeroDivisionError), read_errors("x.csv"):
        raise ZeroDivisionError


@pytest.mark.parametrize("error", [OSError(errno.EIO, "x"), OSError(HDF5), KeyError(HDF5), RuntimeError(HDF5)])
def test_the_system_speaks_before_the_library(error):
    assert why_unreadable(error, "is damaged") == f"cannot be read: {os.strerror(errno.EIO)}"


@pytest.mark.parametrize("error", [OSError("image file is\ntruncated"), ValueError("image file is truncated")])
def test_what_a_library_does_not_like_is_the_files_content(error):
    assert why_unreadable(error, "is damaged") == "is damaged: image file is truncated"


def test_a_place_that_no_file_has_is_the_files_content():
    error = OSError(errno.EINVAL, "Invalid argument")
    assert why_unreadable(error, "is damaged") == "is damaged: [Errno 22] Invalid argument"
