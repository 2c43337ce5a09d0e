import json

import h5py
import numpy as np
import pytest
import xarray
from systems import needs_permissions
from typer.testing import CliRunner

from trackctl.cli.app import app

SMALL = ("--steps", "velocity=.5,radius=9,heading=30", "--velocity-mps", "0.5:1.5", "--radius-m", "1:19")


def run(*words):
    return CliRunner().invoke(app, ["compute-lut", *map(str, words)])


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_a_table_opens_in_xarray_with_named_coordinates(tmp_path):
    assert run(*SMALL, "--slope-deg", "0:10:5").exit_code == 0
    with xarray.open_dataset("lut.h5", engine="h5netcdf") as table:
        assert table.sprocket_rate_left.dims == ("slope", "velocity", "curvature", "heading")
        assert np.degrees(table.slope.values) == pytest.approx([0.0, 5.0, 10.0])
        assert table.attrs["history"].partition(": ")[2].startswith("trackctl")
        assert table.attrs["step_reason"] == "explicit steps"
    assert [path.name for path in tmp_path.iterdir()] == ["lut.h5"]


def test_default_steps_are_drawn_from_sensitivity_told_and_stored():
    result = run("--budget", "2000", "--jobs", "1")
    assert result.exit_code == 0
    assert "divisions follow the PAWN indices" in result.stderr
    assert result.stdout == ""
    with h5py.File("lut.h5") as file:
        assert file.attrs["step_velocity"] > 0.0
        assert {"index", "ci_low", "ci_high", "samples"} <= set(file["sensitivity"])
        assert "PAWN" in file["sensitivity"].attrs["step_reason"]


def test_json_and_quiet():
    result = run(*SMALL, "--json", "--quiet")
    summary = json.loads(result.stdout)
    assert result.stderr == ""
    assert summary["cells"] == sum(summary["status"].values()) == 3 * 4 * 12
    assert summary["swarm_check"]["different_root"] == 0
    assert 0.0 < summary["certificate"]["rms_error"] < summary["certificate"]["max_error"]


def test_dry_run_writes_nothing(tmp_path):
    (tmp_path / "lut.h5").write_text("not to be replaced")
    found = json.loads(run(*SMALL, "--dry-run", "--json").stdout)
    assert (found["cells"], found["step_radius_m"]) == (144, 9.0)
    assert "144 cells" in run(*SMALL, "--dry-run", "--quiet").stdout
    assert [path.name for path in tmp_path.iterdir()] == ["lut.h5"]


def test_a_shrunk_step_and_a_dropped_end_are_told():
    words = ("--steps", "velocity=.4,radius=90,heading=30", "--radius-m", "1:5", "--heading-deg", "270:360")
    told = run(*words, "--velocity-mps", "1:2", "--dry-run").stderr
    assert "the velocity step 0.4 does not divide its range and becomes 0.333333" in told
    assert "the radius step 90 does not divide its range and becomes 4" in told
    assert "360 itself left out" in told


def test_a_single_value_is_a_range():
    result = run("--velocity-mps", "1:1", "--radius-m", "4", "--heading-deg", "90:90")
    assert result.exit_code == 0
    assert "2 cells" in result.stderr


def test_jobs_do_not_change_the_file(monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1")
    run(*SMALL, "-o", "one.h5", "--jobs", "1")
    run(*SMALL, "-o", "two.h5", "--jobs", "2")
    with open("one.h5", "rb") as one, open("two.h5", "rb") as two:
        assert one.read() == two.read()


def test_a_tolerance_is_met_or_missed_within_the_budget(tmp_path):
    ranges = ("--velocity-mps", "0.5:1.5", "--radius-m", "1:10")
    summary = json.loads(run(*ranges, "--tolerance", "1", "--budget", "5000", "--json").stdout)
    assert summary["certificate"]["certified_error"] < 0.01
    missed = run(*ranges, "--tolerance", "1e-7", "--budget", "5000", "-o", "missed.h5")
    assert missed.exit_code == 1
    assert " errs most, by " in missed.stderr
    assert "--budget 5000" in missed.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["lut.h5"]


def test_the_moon_lets_a_vehicle_slide_sooner():
    speeds = ("--gravity-mps2", "1.62", "--json", "--quiet")
    on_earth, on_moon = (json.loads(run(*SMALL, *more).stdout) for more in (speeds[2:], (*speeds, "-o", "moon.h5")))
    assert on_moon["status"]["converged"] < on_earth["status"]["converged"]


def test_no_feasible_cell_exits_1_and_leaves_nothing(tmp_path):
    result = run(*SMALL, "--terrain", "snow", "--slope-deg", "44", "--heading-deg", "0:60")
    assert result.exit_code == 1
    assert "no cell of the table is feasible" in result.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "option"),
    [
        ("--radius-m 0.2:5", "--radius-m"),
        ("--radius-m=", "--radius-m"),
        ("--velocity-mps 0:1", "--velocity-mps"),
        ("--slope-deg 45", "--slope-deg"),
        ("--heading-deg 350:370", "--heading-deg"),
        ("--steps velocity=0,radius=1,heading=1", "--steps velocity"),
        ("--steps velocity=1,radius=-1,heading=1", "--steps radius"),
        ("--steps speed=1,radius=1,heading=1", "--steps"),
        ("--steps velocity=1e-4,radius=1e-3,heading=1e-3", "--steps"),
        ("--steps velocity=1,radius=1,heading=1 --budget 9", "--steps"),
        ("--budget 1", "--budget"),
        ("--budget 1000000000000", "--budget"),
        ("--tolerance nan", "--tolerance"),
        ("--tolerance 0", "--tolerance"),
        ("--output -", "--output"),
        ("--output /dev/null", "--output"),
        ("--output missing/lut.h5", "missing/lut.h5"),
        ("--seeding guess", "--seeding"),
        ("--vehicle nope", "nope"),
    ],
)
def test_bad_input_exits_2_names_the_option_and_leaves_nothing(tmp_path, words, option):
    result = run(*words.split())
    assert result.exit_code == 2
    assert "Traceback" not in result.output
    assert option in result.stderr.partition("Error: ")[2]
    assert list(tmp_path.iterdir()) == []


def test_an_existing_file_is_replaced_only_with_force(tmp_path):
    (tmp_path / "lut.h5").write_text("mine")
    result = run(*SMALL)
    assert result.exit_code == 2
    assert "--force" in result.stderr
    assert (tmp_path / "lut.h5").read_text() == "mine"
    assert run(*SMALL, "--force").exit_code == 0
    assert h5py.is_hdf5("lut.h5")


@needs_permissions
def test_a_read_only_folder_is_refused(tmp_path):
    (tmp_path / "closed").mkdir(mode=0o500)
    result = run(*SMALL, "-o", "closed/lut.h5")
    assert result.exit_code == 2
    assert "closed/lut.h5" in result.stderr
