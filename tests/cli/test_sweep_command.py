import csv
import io
import json
import math

import pytest
from typer.testing import CliRunner

from trackctl.cli.app import app

ROWS = [
    "slope_rad",
    "velocity_mps",
    "radius_m",
    "heading_rad",
    "track_speed_inner_mps",
    "track_speed_outer_mps",
    "body_speed_inner_mps",
    "body_speed_outer_mps",
    "slip_inner",
    "slip_outer",
    "sideslip_rad",
    "theoretical_radius_m",
    "status",
]
SUMMARY = [
    "slope_rad",
    "velocity_mps",
    "radius_m",
    "rmse_inner_mps",
    "rmse_outer_mps",
    "max_radius_m",
    "max_radius_heading_rad",
    "min_radius_m",
    "min_radius_heading_rad",
    "infeasible_count",
]


def run(*words):
    return CliRunner().invoke(app, ["sweep", *map(str, words)])


def rows(text):
    return list(csv.DictReader(io.StringIO(text)))


def test_the_default_is_the_papers_sweep_over_slopes():
    result = run("--summary")
    assert (result.exit_code, list(rows(result.stdout)[0])) == (0, SUMMARY)
    found = rows(result.stdout)
    assert [math.degrees(float(row["slope_rad"])) for row in found] == pytest.approx([3, 5, 8, 10, 12])
    assert {(row["velocity_mps"], row["radius_m"], row["infeasible_count"]) for row in found} == {("2.0", "20.0", "0")}
    assert result.stderr == "utv-61cm on asphalt, radius 20 m: 5 x 1 x 360 slopes, speeds and headings\n"


def test_one_row_per_slope_speed_and_heading():
    result = run("--slope-deg", "0,5", "--velocity-mps", "1:2:1", "--radius-m", -10, "--heading-deg", "0:360:90")
    found = rows(result.stdout)
    assert list(found[0]) == ROWS
    degrees = [0.0, 90.0, 180.0, 270.0]
    expected = [(s, v, h) for s in (0.0, 5.0) for v in (1.0, 2.0) for h in degrees]
    for row, (slope, velocity, heading) in zip(found, expected, strict=True):
        assert float(row["slope_rad"]) == pytest.approx(math.radians(slope))
        assert (float(row["velocity_mps"]), float(row["radius_m"])) == (velocity, -10.0)
        assert float(row["heading_rad"]) == pytest.approx(math.radians(heading))
        assert row["status"] == "converged"
        inner, outer = float(row["track_speed_inner_mps"]), float(row["track_speed_outer_mps"])
        assert inner < velocity < outer
        assert -10.0 < float(row["theoretical_radius_m"]) == pytest.approx(-0.305 * (outer + inner) / (outer - inner))


def test_rows_without_an_answer_are_empty():
    result = run("--slope-deg", 5, "--velocity-mps", 6, "--radius-m", 5, "--heading-deg", "90,270")
    easy, hard = rows(result.stdout)
    assert result.exit_code == 0
    assert (easy["status"], hard["status"]) == ("converged", "infeasible_grip")
    assert {hard[name] for name in ROWS[4:-1]} == {""}
    assert result.stderr.endswith("; without an answer: 1 infeasible_grip\n")


def test_json(tmp_path):
    words = ("--slope-deg", 5, "--velocity-mps", "2,12", "--radius-m", 5, "--json", "--quiet")
    result = run(*words, "-o", tmp_path / "sweep.csv")
    found = json.loads(result.stdout)
    assert result.stderr == ""
    assert (found["rows"], found["status"]["converged"], found["status"]["infeasible_grip"]) == (720, 360, 360)
    assert list(found["summary"][0]) == SUMMARY
    assert found["summary"][1]["rmse_inner_mps"] is None
    assert len(rows((tmp_path / "sweep.csv").read_text())) == 720
    run(*words, "--summary", "--force", "-o", tmp_path / "sweep.csv")
    (slow, _) = rows((tmp_path / "sweep.csv").read_text())
    assert {name: float(cell) for name, cell in slow.items()} == found["summary"][0]


def test_nothing_feasible_exits_1():
    result = run("--velocity-mps", 30)
    assert (result.exit_code, result.stdout) == (1, "")
    assert result.stderr == "Error: none of the 1800 operating points has an answer: 1800 infeasible_grip\n"


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (["--slope-deg", "5:1:1"], "--slope-deg: 5:1:1 is not allowed"),
        (["--slope-deg", 50], "--slope-deg: 50 is not allowed; allowed: 0 or more, below 45"),
        (["--velocity-mps", "0:1:1"], "--velocity-mps: 0 is not allowed; allowed: above 0"),
        (["--velocity-mps", "fast"], "--velocity-mps: fast is not allowed"),
        (["--radius-m", 0], "--radius-m: 0 is not allowed"),
        (["--radius-m", "inf"], "--radius-m: inf is not allowed"),
        (["--heading-deg", 360], "--heading-deg: 360 is not allowed; allowed: 0 or more, below 360"),
        (["--heading-deg", "0:400:1"], "--heading-deg: 360 is not allowed"),
        (["--heading-deg", "0:1e308:1e-308"], "--heading-deg: 0:1e308:1e-308 is not allowed; allowed: at most 100000"),
        (["--vehicle", "tank"], "tank: no vehicle profile has this name"),
        (["--json", "-o", "-"], "--output: - is not allowed"),
    ],
)
def test_wrong_usage_exits_2(words, problem):
    result = run(*words)
    assert (result.exit_code, result.stdout) == (2, "")
    assert problem in result.stderr


def test_an_existing_output_stays(tmp_path):
    path = tmp_path / "sweep.csv"
    path.write_text("mine")
    assert run("--heading-deg", 0, "-o", path).exit_code == 2
    assert path.read_text() == "mine"
