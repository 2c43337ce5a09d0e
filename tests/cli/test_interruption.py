"""`compute-lut` stopped on the way, killed at a given column or by Ctrl-C in a table that takes long."""

import os
import subprocess
import sys
import time

import h5py
import pytest
from patience import PATIENCE
from systems import TRACKCTL, interrupt, needs_interrupt

STEPS, FINE_STEPS = "velocity=.05,radius=1,heading=20", "velocity=.005,radius=1,heading=20"
#: `trackctl` that is killed before it appends to a checkpoint of so many columns: no clock decides when.
KILLED = """
import os, sys
from trackctl.cli.app import main
from trackctl.files.journal import Journal

left, append = int(sys.argv.pop(1)), Journal.append

def append_or_die(*column):
    global left
    if left == 0:
        os._exit(9)
    left -= 1
    append(*column)

Journal.append = append_or_die
main()
"""


def start(folder, *words, program=TRACKCTL, steps=STEPS):
    table = ("--steps", steps, "--velocity-mps", "1:2", "--seeding", "pso", "--jobs", "2")
    command = [*program, "compute-lut", *table, "-o", str(folder / "lut.h5"), *words]
    environment = os.environ | {"SOURCE_DATE_EPOCH": "1"}
    return subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True)


def finished(process):
    """Exit code of a process, once it has ended."""
    process.communicate(timeout=PATIENCE)
    return process.returncode


def contents(path):
    """All bytes of the datasets, and the attributes but the command line."""
    with h5py.File(path) as file:
        data = {name: item[()].tobytes() for name, item in file.items() if isinstance(item, h5py.Dataset)}
        return data, {name: str(value) for name, value in file.attrs.items() if name != "history"}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    assert finished(start(folder)) == 0
    return contents(folder / "lut.h5")


@pytest.mark.parametrize("columns", [0, 2, 20])
def test_killed_and_resumed_it_is_as_if_never_killed(tmp_path, whole, columns):
    killed = start(tmp_path, program=[sys.executable, "-c", KILLED, str(columns)])
    assert finished(killed) == 9
    assert [path.name for path in tmp_path.iterdir()] == ["lut.h5.partial"]
    assert finished(start(tmp_path, "--resume")) == 0
    assert [path.name for path in tmp_path.iterdir()] == ["lut.h5"]
    assert contents(tmp_path / "lut.h5") == whole


@needs_interrupt
def test_ctrl_c_stops_soon_and_names_the_checkpoint(tmp_path):
    """Soon: long before the 201 columns are done."""
    process, checkpoint = start(tmp_path, steps=FINE_STEPS), tmp_path / "lut.h5.partial"
    while not (checkpoint.exists() and checkpoint.stat().st_size > 20_000):
        assert process.poll() is None
        time.sleep(0.005)
    interrupt(process)
    _, told = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    assert "lut.h5.partial keeps what is done, --resume continues" in told
    assert "Traceback" not in told
    assert [path.name for path in tmp_path.iterdir()] == ["lut.h5.partial"]
