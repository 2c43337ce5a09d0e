"""Global heaps of an HDF5 file, looked through before HDF5 reads them.

HDF5 keeps texts there without a checksum, and loops for ever, deaf to Ctrl-C, on an object that takes no room. The
heaps of our tables lie near the ends of the file. Layout: HDF5 file format specification 3.0, III.E.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from pathlib import Path

SIGNATURE = b"GCOL"
#: Version and size of a heap, behind its signature.
HEAD = struct.Struct("<4xB3xQ")
#: Index and size of an object; index 0 is the free room, whose size counts this head.
OBJECT = struct.Struct("<H6xQ")
ALIGNMENT = 8
#: How much of each end of a file is searched. [bytes]
SEARCHED = 2**22


def has_endless_heap(path: Path) -> bool:
    """Whether a heap near an end of the file would never be read to its end.

    Raises
    ------
    OSError
        If the file cannot be read.
    """
    with path.open("rb") as stream:
        start = stream.read(SEARCHED)
        stream.seek(max(SEARCHED, os.fstat(stream.fileno()).st_size - SEARCHED))
        return any(is_endless(content, place) for content in (start, stream.read()) for place in heaps(content))


def heaps(content: bytes) -> Iterator[int]:
    """Where heaps start."""
    place = content.find(SIGNATURE)
    while place >= 0:
        yield place
        place = content.find(SIGNATURE, place + 1)


def is_endless(content: bytes, place: int) -> bool:
    """Whether an object of the heap takes no room, or more than there is."""
    if place + HEAD.size > len(content):
        return False
    version, size = HEAD.unpack_from(content, place)
    if version != 1:
        return False
    end = min(place + size, len(content))
    place += HEAD.size
    while place + OBJECT.size <= end:
        index, size = OBJECT.unpack_from(content, place)
        step = OBJECT.size + -(-size // ALIGNMENT) * ALIGNMENT if index else size
        if not 0 < step <= SEARCHED:
            return True
        place += step
    return False
