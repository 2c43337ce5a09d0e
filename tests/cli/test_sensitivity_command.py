import csv
import io
import json

import pytest
from typer.testing import CliRunner

from trackctl.cli.app import app

HEADER = ["output", "input", "statistic", "index", "ci_low", "ci_high", "dummy"]
FEW = ("--samples", 300, "--resamples", 50)


def run(*words):
    return CliRunner().invoke(app, ["sensitivity", *map(str, words)])


def test_rows():
    result = run(*FEW)
    assert result.exit_code == 0
    found = list(csv.DictReader(io.StringIO(result.stdout)))
    assert list(found[0]) == HEADER
    assert [(row["output"], row["input"], row["statistic"]) for row in found] == [
        (output, name, statistic)
        for output in ("sprocket_rate_left", "sprocket_rate_right")
        for name in ("velocity", "radius", "heading")
        for statistic in ("median", "max")
    ]
    for row in found:
        assert 0.0 <= float(row["ci_low"]) <= float(row["index"]) <= float(row["ci_high"]) <= 1.0
    assert "utv-61cm on asphalt, slope 12.13 deg: velocity 0.1 to 2 m/s, radius 0.366 to 36.6 m" in result.stderr


def test_same_seed_same_bytes():
    assert run(*FEW, "--jobs", 1).stdout == run(*FEW, "--jobs", 2).stdout
    assert run(*FEW).stdout != run(*FEW, "--seed", 1).stdout


def test_summary(tmp_path):
    path = tmp_path / "indices.csv"
    result = run(*FEW, "--json", "-o", path, "--quiet")
    found = json.loads(result.stdout)
    assert result.stderr == ""
    assert (found["samples"], found["confidence"], found["seed"]) == (300, 0.95, 0)
    assert found["rows"] == pytest.approx(300 * (1.0 - found["dropped_share"]))
    rows = list(csv.DictReader(io.StringIO(path.read_text())))
    assert [float(row["index"]) for row in rows] == [row["index"] for row in found["indices"]]
    assert run(*FEW, "-o", path).exit_code == 2
    assert run(*FEW, "-o", path, "--force").exit_code == 0


def test_other_ranges_and_profiles():
    words = ("--velocity-mps", "1:2", "--radius-m", "5:20", "--heading-deg", "0:180", "--slope-deg", 5)
    result = run(*FEW, *words, "--vehicle", "m113", "--terrain", "hard-soil", "--gravity-mps2", 3.71)
    assert result.exit_code == 0
    assert "m113 on hard-soil, slope 5 deg: velocity 1 to 2 m/s, radius 5 to 20 m, heading 0 to 180" in result.stderr


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (["--velocity-mps", "2:1"], "--velocity-mps: 2:1 is not allowed; allowed: MIN:MAX with MIN <= MAX"),
        (["--velocity-mps", "0:1"], "--velocity-mps: 0:1 is not allowed"),
        (["--radius-m", "fast"], "--radius-m: fast is not allowed"),
        (["--radius-m", "0.1:5"], "--radius-m: 0.1:5 is not allowed; allowed: MIN:MAX with 0.305 (half the gauge)"),
        (["--heading-deg", "0:400"], "--heading-deg: 0:400 is not allowed"),
        (["--slope-deg", 45], "--slope-deg: 45 is not allowed"),
        (["--slope-deg", "nan"], "--slope-deg: nan is not allowed"),
        (["--samples", 0], "--samples"),
        (["--samples", 99], "--samples: 99"),
        (["--slices", 1], "--slices: 1 is not allowed; allowed: 2 or more"),
        (["--resamples", 0], "--resamples: 0 is not allowed"),
        (["--confidence", 1], "--confidence: 1.0 is not allowed"),
        (["--gravity-mps2", 0], "--gravity-mps2"),
        (["--terrain", "moon"], "moon: no terrain profile has this name"),
        (["--json", "-o", "-"], "--output: - is not allowed"),
    ],
)
def test_wrong_usage_exits_2(words, problem):
    result = run(*words)
    assert (result.exit_code, result.stdout) == (2, "")
    assert problem in result.stderr


def test_nothing_feasible_exits_1(tmp_path):
    terrain = tmp_path / "ice.yaml"
    terrain.write_text(
        "name: ice\ndescription: ice\nsource: made up\nfriction_coefficient: 0.05\n"
        "shear_deformation_modulus_m: 0.01\nmotion_resistance_coefficient: 0.01\n"
    )
    result = run(*FEW, "--terrain", terrain, "--slope-deg", 40, "--velocity-mps", "0.1:0.5")
    assert (result.exit_code, result.stdout) == (1, "")
    assert result.stderr == "Error: no sampled operating point has an answer: 300 infeasible_grip\n"
