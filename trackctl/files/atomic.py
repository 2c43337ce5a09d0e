"""Output files that appear whole or not at all."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from trackctl.errors import OutputError

STREAM_FOLDERS = (Path("/dev"), Path("/dev/fd"), Path("/proc/self/fd"))


def check_output(path: Path, force: bool) -> None:
    """Refuse an output that could not be written; to be called before a long job starts.

    Parameters
    ----------
    path
        The output to come.
    force
        Whether an existing file may be replaced.

    Raises
    ------
    OutputError
        If the folder is missing or not writable, or `path` is a folder, or an existing file without `force`.
    """
    with output_errors(path):
        if not is_stream(path):
            refuse_occupied(path, force)
            new_file_beside(path).unlink()


@contextmanager
def whole_file(path: Path, force: bool) -> Iterator[Path]:
    """Path to write to, renamed to `path` when the block ends well and removed otherwise.

    Devices and pipes are written directly.

    Parameters
    ----------
    path
        The output to come; a symbolic link keeps pointing where it did.
    force
        Whether an existing file may be replaced.

    Yields
    ------
    Path
        An empty hidden file in the same folder, with the same suffix.

    Raises
    ------
    OutputError
        As `check_output`, or if the disk is full or the like.
    """
    with output_errors(path):
        if is_stream(path):
            yield path
            return
        refuse_occupied(path, force)
        temporary = new_file_beside(path)
        try:
            yield temporary
            flush_to_disk(temporary)
            refuse_occupied(path, force)
            put_in_place(temporary, path, force)
        finally:
            temporary.unlink(missing_ok=True)


def write_text(path: Path, text: str, force: bool) -> None:
    """Write a text file of the same bytes on every system; see `whole_file`."""
    with whole_file(path, force) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


def put_in_place(temporary: Path, path: Path, force: bool) -> None:
    """Give a whole file its name; without `force` only if no other run took the name at the last moment.

    Raises
    ------
    OutputError
        If one did.
    """
    target = os.path.realpath(path)
    if not force:
        with suppress(OSError):  # some file systems know no second names; then the moment is left open
            os.link(temporary, target)
            return
        refuse_occupied(path, force)
    os.replace(temporary, target)


@contextmanager
def whole_files(paths: Sequence[Path], force: bool) -> Iterator[list[Path]]:
    """Paths to write files to that belong together: all appear, or none.

    All are on the disk and their places free before the first is renamed; only a crash between two renames could part
    them.

    Parameters
    ----------
    paths
        The outputs to come.
    force
        Whether existing files may be replaced.

    Yields
    ------
    list of Path
        As of `whole_file`.

    Raises
    ------
    OutputError
        As `check_output`, or if the disk is full or the like, or an output is a device or a pipe.
    """
    for path in paths:
        if is_stream(path):
            raise OutputError(path, "is a device or a pipe; name a file")
    with ExitStack() as stack:
        temporaries = [stack.enter_context(whole_file(path, force)) for path in paths]
        yield temporaries
        for path, temporary in zip(paths, temporaries, strict=True):
            with output_errors(path):
                flush_to_disk(temporary)
                refuse_occupied(path, force)


@contextmanager
def output_errors(path: Path) -> Iterator[None]:
    """Turn a failed write into an `OutputError` on `path`; a closed pipe stays what it is."""
    try:
        yield
    except BrokenPipeError:
        raise
    except OSError as error:
        raise OutputError(path, f"cannot be written: {error.strerror or error}") from error


def is_stream(path: Path) -> bool:
    """Whether a path is a device, a pipe or a name of one (``/dev/stdout`` redirected to a file)."""
    return path.parent in STREAM_FOLDERS or (path.exists() and not path.is_file() and not path.is_dir())


def refuse_occupied(path: Path, force: bool) -> None:
    """Raise an `OutputError` if `path` has no folder, is one, or is taken."""
    folder = Path(os.path.realpath(path)).parent
    if path.is_dir():
        raise OutputError(path, "is a folder; name a file in it")
    if not folder.is_dir():
        raise OutputError(path, f"there is no folder {folder}; create it first or choose another")
    if path.exists() and not force:
        raise OutputError(path, "exists already; --force replaces it")


def new_file_beside(path: Path) -> Path:
    """Create an empty hidden file where `path` leads to, with its suffix and the usual permissions."""
    target = Path(os.path.realpath(path))
    temporary = target.with_name(f".trackctl-{secrets.token_hex(8)}{target.suffix}")
    os.close(os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
    return temporary


def flush_to_disk(path: Path) -> None:
    """Wait until a file's bytes are on the disk, so that no crash after the rename shows an empty file."""
    descriptor = os.open(path, os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
