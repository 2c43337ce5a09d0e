"""What the system says while a file is read, told apart from what is wrong with the file itself."""

from __future__ import annotations

import errno
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from trackctl.errors import InputFileError

#: HDF5 puts the system's error into the text of its own, whichever kind h5py makes of it.
HDF5_ERRNO = re.compile(r"errno = (\d+)")
LONGEST = 200


@contextmanager
def read_errors(file: Path | str, kind: type[InputFileError] = InputFileError) -> Iterator[None]:
    """Turn a failed read into an error of a kind on `file`."""
    try:
        yield
    except OSError as error:
        raise kind(file, why_unreadable(error, "cannot be read")) from error


def why_unreadable(error: Exception, content: str) -> str:
    """What to say of an error of a library that reads a file: the system's reason, or else that of the content.

    Parameters
    ----------
    error
        Of the library.
    content
        What to say of the file in front of the library's words.
    """
    number = system_errno(error)
    if number is not None:
        return f"cannot be read: {os.strerror(number)}"
    return f"{content}: {' '.join(str(error).split())[:LONGEST]}"


def system_errno(error: Exception) -> int | None:
    """The system's number for an error of a library; None if the library itself does not like the file."""
    told = HDF5_ERRNO.search(str(error))
    if told:
        return int(told[1])
    # A damaged file sends its reader to places that no file has, which the system calls invalid.
    if isinstance(error, OSError) and error.errno != errno.EINVAL:
        return error.errno
    return None
