"""A file for HDF5 to write to that reports errors only when asked.

HDF5 cannot close a file that it failed to write to, on a full disk say: it keeps it half open, and may crash
the program at exit. A Ctrl-C inside a write has the same effect.
"""

from __future__ import annotations

import errno
from io import FileIO
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer


class DeferredErrorFile(FileIO):
    """An unbuffered new file whose writes always seem to succeed.

    Parameters
    ----------
    path
        Emptied if it exists.

    Raises
    ------
    OSError
        If the file cannot be opened, or is a pipe, in which HDF5 cannot move about.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path, "w+")
        self._error: OSError | KeyboardInterrupt | None = None
        if not self.seekable():
            self.close()
            raise OSError(errno.ESPIPE, "HDF5 needs a file, no pipe", str(path))

    def write(self, content: ReadableBuffer, /) -> int:
        """Write all of it, or after a first error nothing."""
        remaining = memoryview(content)
        try:
            while remaining and self._error is None:
                remaining = remaining[super().write(remaining) :]
        except (OSError, KeyboardInterrupt) as error:
            self._error = error
        return memoryview(content).nbytes

    def truncate(self, size: int | None = None, /) -> int:
        """Set the file's size, or after a first error leave it."""
        try:
            if self._error is None:
                return super().truncate(size)
        except (OSError, KeyboardInterrupt) as error:
            self._error = error
        return self.tell() if size is None else size

    def raise_deferred(self) -> None:
        """Raise the first error met so far."""
        if self._error is not None:
            raise self._error
