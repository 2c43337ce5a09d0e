import json
import os
import shutil
from dataclasses import replace

import numpy as np
import pytest
from solved_tables import solved_table
from system_words import NO_FILE
from systems import needs_pipe
from table_variants import part
from typer.testing import CliRunner

from trackctl.cli.app import app
from trackctl.errors import OutputError
from trackctl.files.lut_writer import write_lut
from trackctl.lut.table import Status
from trackctl.workflows import export as workflow
from trackctl.workflows.export import ExportRequest, export_table


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    folder = tmp_path_factory.mktemp("export")
    table = solved_table(history="trackctl compute-lut */ -o lut.h5")
    write_lut(folder / "lut.h5", table)
    write_lut(folder / "half.h5", part(table, heading=slice(2, 8)))
    values = {
        name: array if name == "residual" else np.full_like(array, np.nan) for name, array in table.values.items()
    }
    hopeless = replace(table, values=values, status=np.full_like(table.status, Status.INFEASIBLE_GRIP))
    write_lut(folder / "hopeless.h5", hopeless)
    whole = (folder / "lut.h5").read_bytes()
    (folder / "cut.h5").write_bytes(whole[: len(whole) // 2])
    (folder / "points.csv").write_text("velocity_mps\n1\n")
    return folder


@pytest.fixture
def folder(tables, tmp_path, monkeypatch):
    for file in tables.iterdir():
        shutil.copy(file, tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*words):
    return CliRunner().invoke(app, ["export", *map(str, words)])


def files(folder):
    return {file.name for file in folder.iterdir()} - {"lut.h5", "half.h5", "hopeless.h5", "cut.h5", "points.csv"}


def test_help_shows_an_example():
    result = run("--help")
    assert result.exit_code == 0
    assert "trackctl export lut.h5 --format c" in result.stdout


@pytest.mark.parametrize("name", ["robot.c", "robot.h"])
def test_c_has_two_files(folder, name):
    result = run("lut.h5", "-o", name)
    assert (result.exit_code, result.stdout) == (0, "")
    assert files(folder) == {"robot.c", "robot.h"}
    cells = 1 * 4 * 6 * 12
    size = cells + 8 * (3 * cells + 1 + 4 + 6 + 13)
    assert result.stderr == f"robot.h and robot.c: {cells} cells, {size} bytes of constant data, double\n"
    header = (folder / "robot.h").read_text()
    assert f"{size} bytes of constant data, double" in header
    assert "trackctl compute-lut * / -o lut.h5" in header
    assert "robot_lookup(double slope" in header
    assert '#include "robot.h"' in (folder / "robot.c").read_text()


def test_prefix_and_precision(folder):
    result = run("lut.h5", "--format", "c", "--precision", "float", "--prefix", "Marder_1", "--quiet", "--json")
    assert (result.exit_code, result.stderr) == (0, "")
    size = 288 + 4 * (3 * 288 + 24)
    assert json.loads(result.stdout) == {
        "format": "c",
        "files": ["lut.h", "lut.c"],
        "cells": 288,
        "bytes": size,
        "notes": [],
    }
    assert "Marder_1_lookup(float slope" in (folder / "lut.h").read_text()


@pytest.mark.parametrize(("words", "method"), [([], "linear"), (["--method", "mls"], "mls")])
def test_the_header_names_the_method(folder, words, method):
    assert run("lut.h5", "-o", "robot.c", *words).exit_code == 0
    assert f"Interpolates as `trackctl lookup --method {method}`" in (folder / "robot.h").read_text()
    assert ("square(" in (folder / "robot.c").read_text()) == (method == "mls")


@pytest.mark.parametrize("kind", ["mat", "npz"])
def test_arrays(folder, kind):
    result = run("lut.h5", "-o", f"table.{kind}", "--json")
    assert result.exit_code == 0
    assert files(folder) == {f"table.{kind}"}
    summary = json.loads(result.stdout)
    # Right turns mirrored, headings closed.
    assert summary["cells"] == 4 * 11 * 13
    assert summary["bytes"] == (folder / f"table.{kind}").stat().st_size
    assert run("lut.h5", "--format", kind).exit_code == 0
    assert (folder / f"lut.{kind}").read_bytes() == (folder / f"table.{kind}").read_bytes()


def test_the_readme_inside_holds_what_it_says(folder):
    assert run("lut.h5", "-o", "table.npz").exit_code == 0
    with np.load(folder / "table.npz", allow_pickle=False) as found:
        for word in ("velocity", "speed_ratio", "sprocket_radius", "max_sprocket_rate", "status_meanings", "feasible"):
            assert word in str(found["readme"])
        speed = found["velocity"][:, None, None, None]
        rate = found["speed_ratio_left"] * speed / found["sprocket_radius"]
        np.testing.assert_allclose(rate, found["sprocket_rate_left"], rtol=1e-14)
        assert "track_gauge_m: 0.61" in str(found["vehicle_profile"])
        assert "friction_coefficient" in str(found["terrain_profile"])


def test_a_table_that_cannot_be_mirrored_says_so(folder):
    result = run("half.h5", "-o", "half.npz")
    assert result.exit_code == 0
    assert "half.h5: left turns only" in result.stderr
    assert "left turns only" not in run("half.h5", "-o", "half.c").stderr


def test_existing_files_want_force(folder):
    (folder / "robot.h").write_text("mine")
    refused = run("lut.h5", "-o", "robot.c")
    assert refused.exit_code == 2
    assert "robot.h: exists already; --force replaces it" in refused.stderr
    assert files(folder) == {"robot.h"}
    assert (folder / "robot.h").read_text() == "mine"
    assert run("lut.h5", "-o", "robot.c", "--force").exit_code == 0
    assert "robot_lookup" in (folder / "robot.h").read_text()


@pytest.mark.parametrize("taken", ["robot.h", "robot.c"])
def test_a_file_that_appears_meanwhile_is_left_alone_and_none_written(folder, monkeypatch, taken):
    def slow_source(*words):
        (folder / taken).write_text("theirs")
        return workflow_source(*words)

    workflow_source = workflow.c_source
    monkeypatch.setattr(workflow, "c_source", slow_source)
    with pytest.raises(OutputError, match="exists already"):
        export_table(ExportRequest(folder / "lut.h5", folder / "robot.c"))
    assert files(folder) == {taken}
    assert (folder / taken).read_text() == "theirs"


def test_no_cell_with_an_answer_exits_1(folder):
    result = run("hopeless.h5", "-o", "robot.c")
    assert result.exit_code == 1
    assert result.stderr == "Error: hopeless.h5: no cell of the table has an answer\n"
    assert files(folder) == set()


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (["lut.h5"], "--format: is missing; allowed: one of c, mat, npz, or --output FILE"),
        (
            ["lut.h5", "-o", "table.csv"],
            "--output: table.csv is not allowed; allowed: a file that ends in .h, .c",
        ),
        (["lut.h5", "-o", "table"], "--output: table is not allowed"),
        (["lut.h5", "-o", "-"], "--output: - is not allowed"),
        (["lut.h5", "--format", "mat", "-o", "a.npz"], "allowed: a file that ends in .mat beside --format mat"),
        (["lut.h5", "--format", "json"], "--format"),
        (["lut.h5", "-o", "a.c", "--precision", "half"], "--precision"),
        (["lut.h5", "-o", "a.c", "--method", "cubic"], "--method"),
        (["lut.h5", "-o", "a.c", "--prefix", "1st"], "--prefix: 1st is not allowed; allowed: a letter, then"),
        (["lut.h5", "-o", "a.c", "--prefix", ""], "--prefix:  is not allowed"),
        (["lut.h5", "-o", "a.c", "--prefix", "größe"], "--prefix: größe is not allowed"),
        (["lut.h5", "-o", "my-robot.c"], "--prefix: is missing; allowed: a letter, then"),
        (["lut.h5", "-o", 'a".c'], '--output: a".c is not allowed; allowed: a name of letters'),
        (["lut.h5", "-o", "nowhere/a.c"], "there is no folder"),
        (["cut.h5", "-o", "a.c"], "cut.h5: is damaged or cut off"),
        (["points.csv", "-o", "a.c"], "points.csv: is no HDF5 file"),
        (["none.h5", "-o", "a.mat"], f"none.h5: cannot be read: {NO_FILE}"),
    ],
)
def test_bad_input_exits_2_and_writes_nothing(folder, words, problem):
    result = run(*words)
    assert (result.exit_code, result.stdout) == (2, "")
    assert problem in result.stderr
    assert files(folder) == set()


@needs_pipe
def test_a_pipe_is_refused(folder):
    os.mkfifo(folder / "pipe.npz")
    result = run("lut.h5", "-o", "pipe.npz")
    assert result.exit_code == 2
    assert "pipe.npz: is a device or a pipe; name a file" in result.stderr
