import json

import numpy as np
import pytest
from solved_tables import VEHICLE, solved_table
from system_words import NO_FILE
from typer.testing import CliRunner

from trackctl import __version__
from trackctl.cli.app import app
from trackctl.files.lut_writer import LutWriter
from trackctl.lut.table import Status
from trackctl.sensitivity.pawn import PawnIndex, Statistic

ATTRIBUTES = {
    "created": "2024-01-01T00:00:00+00:00",
    "history": "trackctl compute-lut --budget 300",
    "seed": 3,
    "certificate_max_error": 0.0123,
    "step_reason": "divisions follow the PAWN indices",
}
INDEX = PawnIndex("sprocket_rate_left", "velocity", Statistic.MEDIAN, 0.65, 0.64, 0.66, 0.05)


@pytest.fixture(scope="module")
def table():
    return solved_table()


@pytest.fixture(scope="module")
def folder(table, tmp_path_factory):
    folder = tmp_path_factory.mktemp("info")
    with LutWriter(folder / "lut.h5", table.axes, VEHICLE, table.terrain, table.gravity, ATTRIBUTES) as writer:
        for k in range(table.axes.curvature.size):
            column = {name: values[0, :, k] for name, values in table.values.items()}
            writer.write_column(0, k, column, table.status[0, :, k])
        writer.write_sensitivity([INDEX], ["velocity"], [[1.0]], {})
    return folder


@pytest.fixture
def run(folder, monkeypatch):
    monkeypatch.chdir(folder)
    return lambda *words: CliRunner().invoke(app, ["info", *words])


def test_people_read_what_the_table_holds(run, table):
    result = run("lut.h5")
    assert (result.exit_code, result.stderr) == (0, "")
    lines = result.stdout.splitlines()
    converged = int((table.status == Status.CONVERGED).sum())
    rates = [np.abs(table.values[f"sprocket_rate_{side}"]) for side in ("left", "right")]
    beyond = int((np.maximum(*rates) > VEHICLE.max_sprocket_rate).sum())
    assert lines[0] == "lut.h5: Look-up table of utv-61cm on asphalt"
    for line in (
        f"  created 2024-01-01T00:00:00+00:00 by trackctl {__version__}",
        "  history trackctl compute-lut --budget 300",
        "  slope     1 node: 12 deg",
        "  velocity  4 nodes: 0.5 to 2 m/s by 0.5",
        "  radius    5 nodes: 0.5 to 20 m uneven; straight ahead; right turns read as mirrored left turns",
        "  heading   12 nodes: 0 to 330 deg by 30, full circle",
        "cells: 288",
        f"  max_sprocket_rate 30 rad/s  {beyond} ({beyond / 2.88:.3g} %)",
        "vehicle: utv-61cm",
        "terrain: asphalt",
        "gravity: 9.80665 m/s2",
        "  divisions follow the PAWN indices",
        "  sprocket_rate_left velocity median  0.650 (0.640 to 0.660), dummy 0.050",
        "  max_error  0.0123",
        "  seed  3",
    ):
        assert line in lines
    text = " ".join(result.stdout.split())
    assert "mass_kg 120, yaw_inertia_kgm2 12, track_gauge_m 0.61," in text
    assert "friction_coefficient 0.8, " in text
    assert f" converged {converged} ({converged / 2.88:.3g} %) " in text
    assert max(map(len, lines)) <= 120


def test_programs_read_the_same(run):
    result = run("lut.h5", "--json")
    found = json.loads(result.stdout)
    assert found["vehicle"]["track_gauge_m"] == 0.61
    assert found["axes"]["velocity_mps"] == {"count": 4, "low": 0.5, "high": 2.0, "step": 0.5}
    assert found["cells"] == 288
    assert found["certificate"] == {"max_error": 0.0123}
    assert found["sensitivity"][0]["statistic"] == "median"


@pytest.mark.parametrize(
    ("content", "problem"),
    [(None, f"cannot be read: {NO_FILE}"), (b"", "is empty"), (b"a,b\n1,2\n", "is no HDF5 file")],
)
def test_what_is_no_table_exits_2(run, folder, content, problem):
    path = folder / "other.h5"
    path.unlink(missing_ok=True)
    if content is not None:
        path.write_bytes(content)
    result = run("other.h5")
    assert (result.exit_code, result.stdout) == (2, "")
    assert f"Error: other.h5: {problem}" in result.stderr


def test_a_folder_and_nothing_exit_2(run):
    assert run(".").exit_code == 2
    assert run().exit_code == 2


def test_a_table_cut_off_exits_2(run, folder):
    whole = (folder / "lut.h5").read_bytes()
    (folder / "cut.h5").write_bytes(whole[: len(whole) // 2])
    result = run("cut.h5")
    assert result.exit_code == 2
    assert "Error: cut.h5: " in result.stderr
