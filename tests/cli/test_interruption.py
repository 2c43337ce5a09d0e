"""`compute-lut` stopped from outside, as a user or the system does it."""

import os
import signal
import subprocess
import sys
import time

import h5py
import pytest

LONG = ("--steps", "velocity=.05,radius=1,heading=20", "--velocity-mps", "1:2", "--seeding", "pso", "--jobs", "2")
PATIENCE = 300.0


def heed_interrupts():
    """For a command that is to be interrupted, though these tests may run in the background, where nothing is."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def start(folder, *words):
    environment = os.environ | {"SOURCE_DATE_EPOCH": "1"}
    command = [sys.executable, "-m", "trackctl", "compute-lut", *LONG, "-o", str(folder / "lut.h5"), *words]
    return subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True, preexec_fn=heed_interrupts)


def finished(process):
    """Exit code of a process, once it has ended."""
    process.communicate(timeout=PATIENCE)
    return process.returncode


def await_columns(folder, columns):
    """Wait until so many columns are in the checkpoint."""
    column_bytes, checkpoint = 21 * 18 * 56, folder / "lut.h5.partial"
    until = time.monotonic() + PATIENCE
    while not (checkpoint.exists() and checkpoint.stat().st_size > columns * column_bytes):
        assert time.monotonic() < until
        time.sleep(0.005)


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
    process = start(tmp_path)
    await_columns(tmp_path, columns)
    process.kill()
    process.communicate()
    assert not (tmp_path / "lut.h5").exists()
    assert finished(start(tmp_path, "--resume")) == 0
    assert [path.name for path in tmp_path.iterdir()] == ["lut.h5"]
    assert contents(tmp_path / "lut.h5") == whole


def test_ctrl_c_stops_soon_and_names_the_checkpoint(tmp_path):
    process = start(tmp_path)
    await_columns(tmp_path, 1)
    process.send_signal(signal.SIGINT)
    _, told = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    assert "lut.h5.partial keeps what is done, --resume continues" in told
    assert "Traceback" not in told
    assert [path.name for path in tmp_path.iterdir()] == ["lut.h5.partial"]
