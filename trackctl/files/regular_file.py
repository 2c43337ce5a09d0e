"""Files that a map names: read only if they are ordinary files of a size that fits."""

from __future__ import annotations

import stat
from pathlib import Path

from trackctl.errors import MapError
from trackctl.files.read_errors import read_errors


def check_regular(path: Path) -> int:
    """Size of an ordinary file. [bytes]

    Raises
    ------
    MapError
        If there is none, or it is a folder, a device or a pipe, which could block or never end.
    """
    try:
        with read_errors(path, MapError):
            status = path.stat()
    except ValueError as error:  # a name with a null character
        raise MapError(path, f"cannot be read: {error}") from error
    if not stat.S_ISREG(status.st_mode):
        kind = "a folder" if stat.S_ISDIR(status.st_mode) else "no regular file"
        raise MapError(path, f"is {kind}; allowed: a file")
    return status.st_size


def read_bytes(path: Path, largest: int) -> bytes:
    """Content of an ordinary file of up to `largest` bytes.

    Raises
    ------
    MapError
        As `check_regular`; or if it is larger, or not permitted.
    """
    if check_regular(path) > largest:
        raise MapError(path, f"is larger than {largest} bytes; allowed: a smaller map")
    with read_errors(path, MapError):
        return path.read_bytes()
