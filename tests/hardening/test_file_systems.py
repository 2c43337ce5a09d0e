"""File systems that have no locks or fail to read: what the system says is told, and never called damage."""

import errno
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from readers import READERS
from system_words import CANNOT_READ
from writing_commands import SMALL_TABLE

from trackctl.errors import TrackctlError
from trackctl.files.elevation_file import read_elevation
from trackctl.files.lut_reader import read_lut, read_lut_header
from trackctl.files.map_file import read_planning_map
from trackctl.files.map_image import read_image

#: A file that is there and cannot be read.
UNREADABLE = Path("/proc/self/mem")
#: Beside the readers of files that users write: those of files that libraries read.
ALL_READERS = {
    **READERS,
    "table": (lambda path: read_lut(Path(path)), "lut.h5"),
    "table's header": (lambda path: read_lut_header(Path(path)), "lut.h5"),
    "image": (lambda path: read_image(Path(path)), "map.pgm"),
    "grid map": (read_planning_map, "arena.map"),
    **{ending: (lambda path: read_elevation(Path(path)), f"ground{ending}") for ending in (".npy", ".npz")},
}

#: Stands in for the system's calls: no locks where `flock_error` is set, no reads by HDF5 once `reads_left` are done.
SYSTEM = """
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <sys/types.h>

int flock_error = 0, reads_left = -1;

int flock(int file, int operation)
{
    int (*call)(int, int) = dlsym(RTLD_NEXT, "flock");
    errno = flock_error;
    return flock_error ? -1 : call(file, operation);
}

ssize_t pread64(int file, void *to, size_t size, off_t place)
{
    ssize_t (*call)(int, void *, size_t, off_t) = dlsym(RTLD_NEXT, "pread64");
    if (reads_left == 0) {
        errno = EIO;
        return -1;
    }
    reads_left -= reads_left > 0;
    return call(file, to, size, place);
}
"""

WITHOUT_LOCKS = """
import ctypes, sys
from typer.testing import CliRunner
from trackctl.cli.app import app

ctypes.c_int.in_dll(ctypes.CDLL(None), "flock_error").value = int(sys.argv[1])
for words in [line.split() for line in sys.argv[2:]]:
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 0, (words, result.stderr, result.exception)
    print(words[0], result.stderr.count("cannot be locked"))
"""

READ_BY_READ = """
import ctypes, errno, os, sys
from pathlib import Path
from trackctl.errors import LutFormatError
from trackctl.files.lut_details import count_cells_beyond, read_sensitivity
from trackctl.files.lut_reader import read_lut, read_lut_header

path, left = Path(sys.argv[1]), ctypes.c_int.in_dll(ctypes.CDLL(None), "reads_left")
for read in (read_lut, read_lut_header, read_sensitivity, lambda path: count_cells_beyond(path, ["sideslip"], 1.0)):
    for reads in range(1000):
        left.value = reads
        try:
            read(path)
        except LutFormatError as error:
            assert str(error) == f"{path}: cannot be read: {os.strerror(errno.EIO)}", (reads, str(error))
        else:
            break
    print(reads)
"""


@pytest.fixture(scope="module")
def system(tmp_path_factory):
    """The stand-in as what is to be loaded before all else."""
    if sys.platform != "linux" or shutil.which("gcc") is None:
        pytest.skip("needs Linux and gcc")
    source = tmp_path_factory.mktemp("system") / "system.c"
    source.write_text(SYSTEM, encoding="ascii")
    library = source.with_suffix(".so")
    subprocess.run(["gcc", "-shared", "-fPIC", source, "-o", library, "-ldl"], check=True)
    return {"LD_PRELOAD": str(library)}


def told(system, script, *words, cwd=None):
    """What a script prints under the stand-in."""
    command = [sys.executable, "-c", script, *words]
    done = subprocess.run(command, env=os.environ | system, cwd=cwd, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout.split()


@pytest.mark.parametrize("number", [errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS])
def test_without_locks_tables_are_compiled_with_a_note_and_read(tmp_path, system, number):
    commands = [
        f"compute-lut {SMALL_TABLE}", "info lut.h5", "export lut.h5 -o lut.npz", "plot lut.h5 -o lut.png",
        "lookup lut.h5 --velocity-mps 1 --radius-m 5 --heading-deg 90",
    ]  # fmt: skip
    printed = told(system, WITHOUT_LOCKS, str(number), *commands, cwd=tmp_path)
    assert printed == ["compute-lut", "1", "info", "0", "export", "0", "plot", "0", "lookup", "0"]
    assert {path.name for path in tmp_path.iterdir()} == {"lut.h5", "lut.npz", "lut.png"}


def test_a_table_whose_reading_fails_at_any_moment_is_not_called_damaged(inputs, system):
    counts = [int(word) for word in told(system, READ_BY_READ, inputs["lut"])]
    assert len(counts) == 4
    assert all(10 < count < 999 for count in counts)


@pytest.mark.skipif(not UNREADABLE.exists(), reason="needs a file that cannot be read")
@pytest.mark.parametrize("reader", ALL_READERS)
def test_every_reader_tells_the_systems_reason(reader, tmp_path):
    read, name = ALL_READERS[reader]
    path = tmp_path / name
    path.symlink_to(UNREADABLE)
    with pytest.raises(TrackctlError) as raised:
        read(str(path))
    assert str(raised.value) == f"{path}: cannot be read: {CANNOT_READ}"
