import json
import os
import subprocess
import sys

import plot_examples
import pytest
from typer.testing import CliRunner

from trackctl.cli.app import app
from trackctl.cli.plot import INSTALL


def run(*words, stdin=None):
    return CliRunner().invoke(app, ["plot", *map(str, words)], input=stdin)


@pytest.fixture
def plan(tmp_path):
    return plot_examples.write(tmp_path / "plan.csv", plot_examples.plan())


def test_beside_the_input(plan):
    result = run(plan)
    picture = plan.with_suffix(".png")
    assert (result.exit_code, result.stdout) == (0, "")
    assert result.stderr == f"{plan}: plan, drawn to {picture}\n"
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(("suffix", "start"), [(".svg", b"<?xml"), (".PDF", b"%PDF"), (".png", b"\x89PNG")])
def test_the_suffix_tells_the_format(plan, tmp_path, suffix, start):
    picture = tmp_path / f"picture{suffix}"
    result = run(plan, "-o", picture, "--json", "--quiet")
    assert (result.exit_code, result.stderr) == (0, "")
    assert json.loads(result.stdout) == {"file": str(plan), "kind": "plan", "output": str(picture)}
    assert picture.read_bytes().startswith(start)


def test_what_sweep_writes(tmp_path):
    path = tmp_path / "sweep.csv"
    for words, kind in ((["--heading-deg", "0:360:30"], "sweep"), (["--summary"], "summary of a sweep")):
        assert CliRunner().invoke(app, ["sweep", "--force", "--quiet", "-o", str(path), *words]).exit_code == 0
        result = run(path, "--force")
        assert (result.exit_code, result.stderr) == (0, f"{path}: {kind}, drawn to {path.with_suffix('.png')}\n")


def test_what_sensitivity_and_compute_lut_write(tmp_path):
    indices, lut = tmp_path / "indices.csv", tmp_path / "lut.h5"
    few = ["--samples", "300", "--resamples", "20"]
    assert CliRunner().invoke(app, ["sensitivity", *few, "-o", str(indices), "--quiet"]).exit_code == 0
    assert run(indices).stderr.startswith(f"{indices}: sensitivity analysis, drawn to")
    assert CliRunner().invoke(app, ["compute-lut", "--budget", "2000", "-o", str(lut), "--quiet"]).exit_code == 0
    assert run(lut).stderr.startswith(f"{lut}: look-up table, drawn to")
    assert run(lut, "--sensitivity", "-o", tmp_path / "steps.svg").stderr.startswith(f"{lut}: sensitivity analysis")


def test_standard_input(plan, tmp_path):
    text = plan.read_text()
    assert run("-", "-o", tmp_path / "a.svg", stdin=text).exit_code == 0
    assert run(plan, "-o", tmp_path / "b.svg").exit_code == 0
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()


def test_crlf_and_byte_order_mark(plan, tmp_path):
    other = tmp_path / "other.csv"
    other.write_bytes(b"\xef\xbb\xbf" + plan.read_bytes().replace(b"\r\n", b"\n").replace(b"\n", b"\r\n"))
    assert run(other, "-o", tmp_path / "a.svg").exit_code == run(plan, "-o", tmp_path / "b.svg").exit_code == 0
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (["missing.csv"], "missing.csv: cannot be read"),
        (["-"], "--output: is missing; allowed: a file, as the input is standard input"),
        (["plan.csv", "-o", "plan.jpg"], "--output: plan.jpg is not allowed; allowed: a file that ends in .png, .svg"),
        (["plan.csv", "-o", "-"], "--output: - is not allowed"),
        (["plan.csv", "-o", "nowhere/plan.png"], "there is no folder"),
        (["plan.csv", "--slope-deg", "5"], "--slope-deg: 5 is not allowed; allowed: only beside a look-up table"),
        (["empty.csv"], "empty.csv, line 1: is empty"),
        ([], "FILE"),
    ],
)
def test_wrong_usage_exits_2(plan, monkeypatch, words, problem):
    monkeypatch.chdir(plan.parent)
    (plan.parent / "empty.csv").touch()
    result = run(*words)
    assert (result.exit_code, result.stdout) == (2, "")
    assert problem in result.stderr.partition("Error: ")[2]


def test_without_matplotlib_it_says_what_to_install(plan, tmp_path):
    (tmp_path / "matplotlib.py").write_text("raise ModuleNotFoundError('no', name='matplotlib')")
    folders = os.pathsep.join((str(tmp_path), *sys.path))
    words = [sys.executable, "-m", "trackctl", "plot", str(plan)]
    done = subprocess.run(words, env=os.environ | {"PYTHONPATH": folders}, capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == f"Error: drawing needs matplotlib, which is not installed; to install it: {INSTALL}\n"
    assert not plan.with_suffix(".png").exists()
