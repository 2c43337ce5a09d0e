"""What the README says of the file and of the commands, against the file and the commands."""

import re
import shlex
from pathlib import Path

import h5py
import pytest
import typer
from typer.testing import CliRunner

from trackctl.cli.app import app

README = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")
AXES = ("slope", "velocity", "curvature", "heading")


def section(title):
    """Text of a section, up to the next of the same level."""
    return re.search(rf"^## {title}\n(.*?)(?=^## )", README, re.MULTILINE | re.DOTALL).group(1)


def table_rows():
    """Variable, shape and unit of the README's table of the file."""
    for line in section("The look-up table file").splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        names = re.findall(r"`(\w+)`", cells[0])
        if line.startswith("| `") and not cells[0].endswith("/`"):
            units = [unit.strip() for unit in cells[2].split(",")]
            for k, name in enumerate(names):
                yield name, cells[1], units[k] if len(units) == len(names) else units[0]


def command_lines():
    """The lines of the README that run trackctl, joined where they go on."""
    for block in re.findall(r"```sh\n(.*?)```", README, re.DOTALL):
        for line in block.replace("\\\n", " ").splitlines():
            for part in re.split(r"&&|\|(?!\|)", line):
                words = shlex.split(part, comments=True)
                while words and "=" in words[0] and not words[0].startswith("-"):
                    words = words[1:]
                if words and words[0].split("/")[-1] == "trackctl":
                    yield words[1:]


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    path = tmp_path_factory.mktemp("readme") / "lut.h5"
    assert CliRunner().invoke(app, ["compute-lut", "--budget", "8000", "-o", str(path)]).exit_code == 0
    with h5py.File(path) as file:
        yield file


def test_the_table_names_every_variable_and_no_other(table):
    written = {name for name, item in table.items() if isinstance(item, h5py.Dataset)}
    assert {name for name, _, _ in table_rows()} == written
    assert "sensitivity" in table


@pytest.mark.parametrize(("name", "shape", "unit"), list(table_rows()))
def test_a_variable_has_the_shape_and_the_unit_of_the_table(table, name, shape, unit):
    dimensions = {"each its own": (name,), "4-D": AXES}.get(shape, (shape,))
    variable = table[name]
    assert variable.shape == tuple(table[axis].size for axis in dimensions)
    if unit == "flag":
        assert "flag_meanings" in variable.attrs
    else:
        assert variable.attrs["units"] == unit


def test_the_attributes_that_are_named_are_there(table):
    text = section("The look-up table file")
    told = text[text.index("Root attributes:") :]
    for name in re.findall(r"`(\w+\*?)`", told):
        if name != "trackctl" and not name.startswith("trackctl-"):
            assert any(re.fullmatch(name.replace("*", r"\w+"), key) for key in table.attrs), name


@pytest.mark.parametrize("words", list(command_lines()), ids=" ".join)
def test_a_command_of_the_readme_is_one(words):
    command = typer.main.get_command(app)
    while hasattr(command, "commands"):
        command, words = command.commands[words[0]], words[1:]
        if words[:1] == ["--help"]:
            return
    command.make_parser(typer.Context(command)).parse_args(list(words))
