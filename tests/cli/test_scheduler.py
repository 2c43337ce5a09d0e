"""`compute-lut --scheduler` as a user runs it."""

import sys
import time

from dask_cluster import Cluster
from patience import PATIENCE
from systems import interrupt, needs_interrupt, start
from typer.testing import CliRunner

from trackctl.cli.app import app

TABLE = (
    "--steps",
    "velocity=.01,radius=1,heading=10",
    "--velocity-mps",
    "1:2",
    "--radius-m",
    "1:20",
    "--seeding",
    "pso",
)


@needs_interrupt
def test_ctrl_c_on_a_cluster_keeps_what_is_done(tmp_path):
    checkpoint = tmp_path / "lut.h5.partial"
    with Cluster(tmp_path) as machines:
        machines.staff("one")
        run = start("compute-lut", *TABLE, "-o", tmp_path / "lut.h5", "--scheduler", machines.address)
        while not (checkpoint.exists() and checkpoint.stat().st_size > 20_000):
            assert run.poll() is None
            time.sleep(0.01)
        interrupt(run)
        _, told = run.communicate(timeout=PATIENCE)
    assert run.returncode == 130
    assert "lut.h5.partial keeps what is done, --resume continues" in told
    assert "Traceback" not in told
    assert not (tmp_path / "lut.h5").exists()


def test_a_wrong_address_exits_2_before_any_work(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(app, ["compute-lut", *TABLE, "--scheduler", "nonsense"])
    assert result.exit_code == 2
    assert result.stderr.count("Error: --scheduler: 'nonsense'") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_missing_library_exits_2(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    result = CliRunner().invoke(app, ["compute-lut", *TABLE, "--scheduler", "127.0.0.1:1"])
    assert result.exit_code == 2
    assert "trackctl[cluster]" in result.stderr
