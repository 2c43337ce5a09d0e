"""What a first run says, and that later runs compile nothing."""

import json
import os
import subprocess
import sys

import pytest
from typer.testing import CliRunner

from trackctl.cli import first_run
from trackctl.cli.app import app
from trackctl.compiled import kernel_folder
from trackctl.workflows import warm_up
from trackctl.workflows.warm_up import TASKS


@pytest.fixture
def compiled(monkeypatch, tmp_path):
    """Nothing is compiled yet; the pieces that would be."""
    names = []
    monkeypatch.setenv("TRACKCTL_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(warm_up, "warm_up", lambda wanted, progress: names.extend(wanted))
    return names


def test_only_the_first_run_is_announced(compiled, monkeypatch, capsys):
    first_run.compile_now(False, "look up")
    assert capsys.readouterr().err.startswith("compiling kernels, once; this takes about ")
    assert compiled == ["interpolation"]
    first_run.compile_now(True, "look up")
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(warm_up, "missing", lambda tasks: [])
    first_run.compile_now(False, "look up")
    assert capsys.readouterr() == ("", "")


def test_a_dry_run_compiles_nothing_and_gives_a_bound(compiled, tmp_path):
    result = CliRunner().invoke(app, ["compute-lut", "--dry-run", "--budget", "50000"])
    assert result.exit_code == 0
    assert result.stdout.startswith("at most 50000 cells, 3.2 MB, about ")
    assert "warm-up" in result.stderr
    assert compiled == []
    assert not list(tmp_path.rglob("*.nbc"))


def test_a_dry_run_with_steps_counts_the_cells(compiled):
    steps = ["--steps", "velocity=.5,radius=1,heading=30", "--velocity-mps", "1:2", "--radius-m", "5:10"]
    result = CliRunner().invoke(app, ["compute-lut", "--dry-run", *steps])
    assert result.exit_code == 0
    assert result.stdout.startswith("252 cells, ")
    assert compiled == []


COMMANDS = {
    "compile a table": "compute-lut --budget 2000 --slope-deg 5 -o lut.h5",
    "look up": "lookup lut.h5 rows.csv",
    "solve points": "lookup lut.h5 --velocity-mps 1 --radius-m 5 --heading-deg 90 --method exact",
    "solve columns": "sweep --slope-deg 5 --velocity-mps 1 --radius-m 5 --heading-deg 0:300:60",
    "indices": "sensitivity --samples 200 --resamples 10",
    "plan": "plan map.yaml --iterations 200 -o plan.csv",
    "simulate": "simulate plan.csv -o motion.csv",
    "filter a log": "identify log.csv --save slip.yaml -o updates.csv",
    "calibrate": "calibrate log.csv -o terrain.yaml",
}
ROWS = "velocity_mps,radius_m,heading_deg\n" + 100 * "1,5,90\n"
MAP = (
    "bounds_m: [0, 0, 10, 10]\nobstacles:\n  circles: [[5, 5, 1]]\nslope_deg: 5\nstart: [1, 1, 45]\ngoal: [9, 9, 45]\n"
)


def run(words, folder):
    command = [sys.executable, "-m", "trackctl", *words.split()]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, env=os.environ)


def test_after_a_warm_up_no_command_compiles(tmp_path):
    assert set(COMMANDS) == set(TASKS)
    result = run("warm-up --json", tmp_path)
    assert result.returncode == 0, result.stderr
    before = set(kernel_folder().rglob("*.nbc"))
    (tmp_path / "map.yaml").write_text(MAP, encoding="utf-8")
    (tmp_path / "rows.csv").write_text(ROWS, encoding="utf-8")
    for task, words in COMMANDS.items():
        if task == "filter a log":
            turns = "simulate --track-speeds-mps 0.4,0.6 --duration-s 20 --slope-deg 0 -o log.csv"
            assert run(turns, tmp_path).returncode == 0
        result = run(words, tmp_path)
        assert result.returncode in (0, 1), (words, result.stderr)
        assert "compiling" not in result.stderr
        added = set(kernel_folder().rglob("*.nbc")) - before
        assert not added, words


def test_a_dry_run_counts_on_the_time_of_a_swarm(compiled):
    words = ["compute-lut", "--dry-run", "--budget", "50000", "--jobs", "1", "--json"]
    seconds = [
        json.loads(CliRunner().invoke(app, [*words, "--seeding", seeding]).stdout)["seconds"]
        for seeding in ("continuation", "pso")
    ]
    assert seconds[1] > 10.0 * seconds[0]


def test_bad_input_is_told_before_anything_is_compiled(compiled, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for words in (["identify", "none.csv"], ["lookup", "none.h5", "rows.csv"], ["sensitivity", "--slope-deg", "nan"]):
        (tmp_path / "rows.csv").write_text(ROWS, encoding="utf-8")
        result = CliRunner().invoke(app, words)
        assert result.exit_code == 2
        assert "compiling" not in result.stderr
    assert compiled == []
