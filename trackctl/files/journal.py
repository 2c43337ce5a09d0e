"""Checkpoint of a long run: finished blocks, appended to one file beside the output.

A header line in JSON (format, version, digest of the request, the request itself) is followed by records:
block index, payload length, CRC-32 of both and the payload, the payload; integers little-endian. A run killed
at any moment leaves at worst a torn last record, which is cut off when the run is resumed.
"""

from __future__ import annotations

import json
import os
import struct
import sys
import warnings
import zlib
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from io import FileIO
from pathlib import Path
from typing import BinaryIO, Self

from trackctl.errors import InputFileError, OutputError, TrackctlWarning
from trackctl.files.atomic import output_errors
from trackctl.files.read_errors import read_errors

FORMAT = "trackctl-checkpoint"
VERSION = 1
MAX_HEADER_BYTES = 2**24
READ_BYTES = 2**20

INDEX_AND_LENGTH = struct.Struct("<qq")
CHECKSUM = struct.Struct("<I")
HEAD_BYTES = INDEX_AND_LENGTH.size + CHECKSUM.size


def journal_path(output: Path) -> Path:
    """Where the checkpoint of an output lies."""
    return output.with_name(f"{output.name}.partial")


class Journal:
    """Finished blocks of a run, safe against its being killed; made by `create` or `resume`.

    Memory holds only where each block lies. The file is locked against a second run until it is closed, where the file
    system has locks.
    """

    def __init__(self, path: Path, file: FileIO) -> None:
        self.path = path
        self._file = file
        self._payloads: dict[int, tuple[int, int]] = {}
        self._end = 0

    @classmethod
    def create(cls, path: Path, digest: str, description: Mapping[str, object], force: bool = False) -> Self:
        """Start a checkpoint.

        Parameters
        ----------
        path
            The checkpoint file.
        digest
            Of all that the blocks depend on.
        description
            The same for people, in what JSON can hold.
        force
            Whether the work of an unfinished run may be dropped.

        Raises
        ------
        OutputError
            If the file cannot be written, another run holds it, or it holds work and `force` is not set.
        """
        header = header_line(digest, description)
        with cls._locked(path) as journal:
            if not (force or journal._holds_at_most(header)):
                raise OutputError(
                    path, "holds the work of an unfinished run; --resume continues it, --force starts afresh"
                )
            journal._start(header)
        return journal

    @classmethod
    def resume(cls, path: Path, digest: str, description: Mapping[str, object]) -> Self:
        """Continue a checkpoint, its torn end cut off; start it if there is none. Parameters as of `create`.

        Raises
        ------
        InputFileError
            If the file is no checkpoint, or that of another request.
        OutputError
            If the file cannot be written, or another run holds it.
        """
        header = header_line(digest, description)
        with cls._locked(path) as journal:
            if journal._holds_at_most(header):
                journal._start(header)
            else:
                journal._load(digest)
        return journal

    @classmethod
    @contextmanager
    def _locked(cls, path: Path) -> Iterator[Self]:
        """An empty journal on a locked file, closed again if the block fails."""
        with output_errors(path), ExitStack() as on_error:
            journal = cls(path, locked_file(path))
            on_error.callback(journal.close)
            yield journal
            on_error.pop_all()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def append(self, block: int, payload: bytes) -> None:
        """Add a finished block, in place of an earlier one of the same index.

        Raises
        ------
        OutputError
            If the disk is full or the like; the blocks before stay safe.
        """
        self._write(record(block, payload))
        self._payloads[block] = (self._end - len(payload), len(payload))

    def read(self, block: int) -> bytes:
        """The payload of one of `blocks`.

        Raises
        ------
        InputFileError
            If it cannot be read, or another run has written over it, as can be where there are no locks.
        """
        offset, length = self._payloads[block]
        content = self._read(offset - HEAD_BYTES, HEAD_BYTES + length)
        payload = content[HEAD_BYTES:]
        if content != record(block, payload):
            raise InputFileError(self.path, "was changed by another run; --resume continues what is left of it")
        return payload

    def blocks(self) -> set[int]:
        """Indices of the blocks that are there."""
        return set(self._payloads)

    def close(self) -> None:
        """Unlock the file and leave it for a later `resume`."""
        self._file.close()

    def discard(self) -> None:
        """Remove the file, its work done."""
        if sys.platform == "win32":  # which removes no open file
            self.close()
        self.path.unlink(missing_ok=True)
        self.close()

    def _holds_at_most(self, header: bytes) -> bool:
        """Whether the file is empty or was torn while this header was written."""
        start = self._read(0, len(header))
        return len(start) < len(header) and header.startswith(start)

    def _start(self, header: bytes) -> None:
        self._file.truncate(0)
        self._write(header)

    def _write(self, content: bytes) -> None:
        """Add bytes at the end, all or none; `_end` moves once they are there."""
        with output_errors(self.path):
            try:
                self._file.seek(self._end)
                remaining = memoryview(content)
                while remaining:
                    remaining = remaining[self._file.write(remaining) :]
            except OSError:
                self._file.truncate(self._end)
                raise
        self._end += len(content)

    def _read(self, offset: int, size: int) -> bytes:
        """Bytes from a place on, fewer at the end of the file."""
        with read_errors(self.path):
            self._file.seek(offset)
            return self._file.read(size)

    def _load(self, digest: str) -> None:
        """Find the whole records and cut off what follows them."""
        with read_errors(self.path), os.fdopen(os.dup(self._file.fileno()), "rb") as stream:
            stream.seek(0)
            check_header(self.path, stream.readline(MAX_HEADER_BYTES), digest)
            self._end = stream.tell()
            for block, length in whole_records(stream):
                self._end = stream.tell()
                self._payloads[block] = (self._end - length, length)
        self._file.truncate(self._end)


def locked_file(path: Path) -> FileIO:
    """Open a file to read and write, made if missing, and lock it."""
    while True:
        with ExitStack() as on_error:
            file = on_error.enter_context(FileIO(path, "r+", opener=create_or_open))
            lock(path, file)
            # The run that held it may have removed it between the two calls.
            if path.exists() and os.path.samestat(os.fstat(file.fileno()), path.stat()):
                on_error.pop_all()
                return file


def lock(path: Path, file: FileIO) -> None:
    """Lock an open file until it is closed or the process ends; a courtesy, so that without locks it only warns.

    Raises
    ------
    OutputError
        If another run has locked it.
    """
    from filelock import lock_descriptor  # here, as it hooks into each fork of the program

    try:
        is_ours = lock_descriptor(file.fileno(), blocking=False)
    except OSError as error:
        note = f"{path}: cannot be locked ({error.strerror}); let no other run use it meanwhile"
        warnings.warn(note, TrackctlWarning, stacklevel=2)
        return
    if not is_ours:
        raise OutputError(path, "is in use by another run; wait for it or choose another")


def create_or_open(path: str, flags: int) -> int:
    """Opener that neither truncates an existing file nor refuses a missing one."""
    return os.open(path, flags | os.O_CREAT, 0o666)


def record(block: int, payload: bytes) -> bytes:
    """A block as it stands in the file."""
    head = INDEX_AND_LENGTH.pack(block, len(payload))
    return head + CHECKSUM.pack(zlib.crc32(payload, zlib.crc32(head))) + payload


def header_line(digest: str, description: Mapping[str, object]) -> bytes:
    """First line of a checkpoint."""
    header = {"format": FORMAT, "version": VERSION, "digest": digest, "request": description}
    return json.dumps(header).encode() + b"\n"


def check_header(path: Path, line: bytes, digest: str) -> None:
    """Raise an `InputFileError` unless a header line is of this format, version and request."""
    try:
        header = json.loads(line)
    except (ValueError, RecursionError):
        header = None
    if not isinstance(header, dict) or header.get("format") != FORMAT:
        raise InputFileError(path, "is no checkpoint of trackctl; --force replaces it", 1)
    if header.get("version") != VERSION:
        problem = f"is a checkpoint of version {header.get('version')}; this trackctl reads {VERSION}"
        raise InputFileError(path, f"{problem}; --force starts afresh", 1)
    if header.get("digest") != digest:
        problem = "is the checkpoint of another request (other settings, profiles or axes)"
        raise InputFileError(path, f"{problem}; --force starts afresh", 1)


def whole_records(stream: BinaryIO) -> Iterator[tuple[int, int]]:
    """Block index and payload length of each record up to the first torn or damaged one.

    At each step the stream stands behind the record.
    """
    size = os.fstat(stream.fileno()).st_size
    while len(head := stream.read(HEAD_BYTES)) == HEAD_BYTES:
        block, length = INDEX_AND_LENGTH.unpack_from(head)
        (expected,) = CHECKSUM.unpack_from(head, INDEX_AND_LENGTH.size)
        if not 0 <= length <= size - stream.tell():
            return
        checksum = zlib.crc32(head[: INDEX_AND_LENGTH.size])
        for start in range(0, length, READ_BYTES):
            checksum = zlib.crc32(stream.read(min(READ_BYTES, length - start)), checksum)
        if checksum != expected:
            return
        yield block, length
