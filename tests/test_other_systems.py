"""The package without what only some systems have, in a process of its own."""

import os
import subprocess
import sys

from systems import NOT_ON_WINDOWS

#: What Windows lacks of `os`; the standard library here is done with it once it is imported.
NAMES = (
    "fork", "forkpty", "getegid", "geteuid", "getgid", "getuid", "killpg", "lockf", "mkfifo", "posix_fallocate",
    "pread", "preadv", "pwrite", "pwritev", "sched_getaffinity", "sendfile", "setsid",
)  # fmt: skip
WINDOWS = """
import importlib, os, sys
from pathlib import Path
import filelock, h5py, numba, scipy.optimize, yaml
from typer.testing import CliRunner

modules, names = sys.argv[1].split(), sys.argv[2].split()
sys.modules.update(dict.fromkeys(modules))
for name in names:
    vars(os).pop(name, None)

from trackctl.cli.app import app
package = Path(sys.modules["trackctl"].__file__).parent
sources = [path.relative_to(package.parent) for path in package.rglob("*.py") if path.stem != "__main__"]
for source in sources:
    importlib.import_module(".".join(source.with_suffix("").parts))
for words in (
    "compute-lut --steps velocity=.5,radius=9,heading=60 --velocity-mps 1:2 --radius-m 1:10",
    "lookup lut.h5 --velocity-mps 1 --radius-m 5 --heading-deg 90",
    "plot lut.h5 -o lut.png",
):
    result = CliRunner().invoke(app, words.split())
    assert result.exit_code == 0, (words, result.stderr, result.exception)
print(len(sources))
"""


def test_it_runs_without_what_windows_lacks(tmp_path):
    words = [" ".join(set(NOT_ON_WINDOWS) - {"posix"}), " ".join(NAMES)]
    done = subprocess.run([sys.executable, "-c", WINDOWS, *words], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-3000:]
    assert int(done.stdout) > 150
    assert sorted(os.listdir(tmp_path)) == ["lut.h5", "lut.png"]
