"""Commands where compiled code cannot be kept, or not be read."""

import os
import subprocess
import sys

import pytest

POINT = ["lookup", "lut.h5", "--velocity-mps", "1", "--radius-m", "5", "--heading-deg", "90"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a small table."""
    folder = tmp_path_factory.mktemp("no-cache")
    run(folder, "compute-lut", "--steps", "velocity=.5,radius=2,heading=30", "--velocity-mps", "1:2", "-o", "lut.h5")
    return folder


def run(folder, *words, **settings):
    command = [sys.executable, "-m", "trackctl", *words]
    environment = {**os.environ, **settings}
    result = subprocess.run(command, cwd=folder, capture_output=True, text=True, env=environment)
    assert result.returncode == 0, result.stderr
    return result


def answer_of(result):
    """Numbers of the first row."""
    return [float(cell) for cell in result.stdout.splitlines()[1].split(",")[:-1]]


def test_one_point_needs_no_kernels_and_no_folder(folder, tmp_path):
    (tmp_path / "file").touch()
    nowhere = {"TRACKCTL_CACHE_DIR": str(tmp_path / "file" / "cache"), "HOME": str(tmp_path / "file")}
    result = run(folder, *POINT, **nowhere)
    assert result.stdout.endswith("converged\n")
    assert result.stderr == ""


def test_without_a_folder_it_works_after_one_note(folder, tmp_path):
    (tmp_path / "file").touch()
    nowhere = {"TRACKCTL_CACHE_DIR": str(tmp_path / "file" / "cache"), "HOME": str(tmp_path / "file")}
    rows = "velocity_mps,radius_m,heading_deg\n" + 100 * "1,5,90\n"
    (folder / "rows.csv").write_text(rows, encoding="utf-8")
    many = run(folder, "lookup", "lut.h5", "rows.csv", **nowhere)
    assert many.stdout.count("converged") == 100
    said = many.stderr.splitlines()
    assert [line.partition(" ")[0] for line in said] == ["compiling", "Note:"]
    assert "compiled code cannot be kept" in said[1]
    one = run(folder, *POINT)
    # Compiled and interpreted, they differ by rounding.
    assert answer_of(many) == pytest.approx(answer_of(one), rel=1e-12)


def test_numba_stays_away_from_look_ups_of_one_point(folder):
    code = "import sys; from trackctl.cli.app import main\ntry: main()\nfinally: print('numba' in sys.modules)"
    result = subprocess.run(
        [sys.executable, "-c", code, *POINT], cwd=folder, capture_output=True, text=True, check=True
    )
    assert result.stdout.endswith("converged\nFalse\n")
