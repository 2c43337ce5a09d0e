"""What one system has and another has not, for the tests that need it."""

import os
import signal
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

try:
    import resource
except ModuleNotFoundError:  # Windows
    resource = None

#: Modules of Python that Windows lacks.
NOT_ON_WINDOWS = ("fcntl", "grp", "posix", "pty", "pwd", "resource", "syslog", "termios", "tty")
FULL_DISK = Path("/dev/full")
#: As `python -m trackctl`, but for one that is to be interrupted, though these tests may run in the background, where
#: nothing is.
TRACKCTL = [
    sys.executable,
    "-c",
    "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); import trackctl.__main__",
]

needs_pipe = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs a named pipe")
needs_devices = pytest.mark.skipif(not Path("/dev/zero").exists(), reason="needs devices that are files")
needs_full_disk = pytest.mark.skipif(not FULL_DISK.exists(), reason="needs a device that is always full")
needs_file_limit = pytest.mark.skipif(resource is None, reason="needs a limit on the size of files")
needs_interrupt = pytest.mark.skipif(sys.platform == "win32", reason="needs a Ctrl-C for one process alone")
needs_fork = pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
#: For files that their own owner may not read or write; root may all, and Windows has other permissions.
needs_permissions = pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() == 0, reason="needs a user whom permissions bind"
)


@contextmanager
def disk_of(size):
    """No file may grow beyond a size [bytes]; what the disk says then is `File too large`."""
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, limits[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)


def interrupt(process):
    """Ctrl-C for a process of `TRACKCTL`."""
    process.send_signal(signal.SIGINT)


def start(*words, **streams):
    """The command line in a process of its own, its standard error read."""
    return subprocess.Popen([*TRACKCTL, *map(str, words)], stderr=subprocess.PIPE, text=True, **streams)
