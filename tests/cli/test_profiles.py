import json

import pytest
from system_words import NO_FILE
from typer.testing import CliRunner

from trackctl.cli.app import app
from trackctl.files.profile_folders import ProfileKind, profile_files
from trackctl.files.profile_yaml import load_terrain, load_vehicle


def run(*words, stdin=None):
    return CliRunner().invoke(app, ["profiles", *map(str, words)], input=stdin)


@pytest.fixture
def broken(tmp_path):
    path = tmp_path / "broken.yaml"
    path.write_text(run("show", "asphalt").output.replace("0.8  ", "-0.8  "))
    return path


def test_list_names_every_profile_with_a_line():
    lines = run("list").output.splitlines()
    assert lines[0] == "vehicles:"
    assert "terrains:" in lines
    assert any(line.split()[:2] == ["asphalt", "Dry"] for line in lines)


def test_list_as_json_is_one_object():
    listed = json.loads(run("list", "--json").output)
    assert list(listed) == ["vehicles", "terrains"]
    assert {"utv-61cm", "m113"} <= {row["name"] for row in listed["vehicles"]}
    assert set(listed["terrains"][0]) == {"name", "path", "description"}


@pytest.mark.parametrize("name", ["utv-61cm", "snow"])
def test_show_prints_the_file_as_it_is(name):
    path = next(path for kind in ProfileKind for stem, path in profile_files(kind).items() if stem == name)
    assert run("show", name).output == path.read_text(encoding="utf-8")
    assert run("show", path).output == path.read_text(encoding="utf-8")


@pytest.mark.parametrize("profile", ["nonsense", "nonsense.yaml", "."])
def test_show_of_what_is_no_profile_exits_2(profile):
    result = run("show", profile)
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith(f"Error: {profile}: ")


def test_check_says_ok_for_each_file(tmp_path):
    for name in ("m113", "clay"):
        (tmp_path / f"{name}.yaml").write_text(run("show", name).output)
    paths = [tmp_path / "m113.yaml", tmp_path / "clay.yaml"]
    result = run("check", *paths)
    assert result.exit_code == 0
    assert result.stdout == f"{paths[0]}: ok, vehicle m113\n{paths[1]}: ok, terrain clay\n"


def test_check_goes_on_after_an_error(tmp_path, broken):
    good = tmp_path / "good.yaml"
    good.write_text(run("show", "asphalt").output)
    result = run("check", broken, tmp_path / "missing.yaml", good)
    assert result.exit_code == 2
    assert result.stdout == f"{good}: ok, terrain asphalt\n"
    first, second = result.stderr.splitlines()
    assert first.startswith(f"Error: {broken}, line 7: friction_coefficient: -0.8 is not allowed; allowed: ")
    assert second == f"{tmp_path / 'missing.yaml'}: cannot be read: {NO_FILE}"


def test_check_takes_names_too():
    assert run("check", "m113", "snow").exit_code == 0
    assert "no vehicle or terrain profile has this name" in run("check", "nonsense").stderr


def test_check_reads_standard_input():
    assert run("check", "-", stdin=run("show", "m113").output).stdout == "<stdin>: ok, vehicle m113\n"
    assert run("check", "-", stdin="").exit_code == 2


def test_check_needs_a_file():
    assert run("check").exit_code == 2


@pytest.mark.parametrize("kind", ["vehicle", "terrain"])
def test_new_writes_a_profile_that_checks(kind):
    template = run("new", kind)
    assert template.exit_code == 0
    assert run("check", "-", stdin=template.output).stdout == f"<stdin>: ok, {kind} my-{kind}\n"


def test_new_holds_the_default_values(tmp_path):
    vehicle, terrain = tmp_path / "vehicle.yaml", tmp_path / "terrain.yaml"
    assert run("new", "vehicle", "-o", vehicle).exit_code == 0
    assert run("new", "terrain", "--output", terrain).exit_code == 0
    assert load_vehicle(str(vehicle)).footprint == load_vehicle("utv-61cm").footprint
    assert load_terrain(str(terrain)).friction_coefficient == load_terrain("asphalt").friction_coefficient


def test_new_replaces_a_file_only_by_force(broken):
    before = broken.read_text()
    refused = run("new", "terrain", "-o", broken)
    assert refused.exit_code == 2
    assert "--force" in refused.stderr
    assert broken.read_text() == before
    assert run("new", "terrain", "-o", broken, "--force").exit_code == 0
    assert broken.read_text() == run("new", "terrain", "-o", "-").output


@pytest.mark.parametrize("words", ["", "tank", "vehicle -o no-such-folder/x.yaml", "vehicle -o ."])
def test_new_refuses_other_kinds_and_places(words):
    assert run("new", *words.split()).exit_code == 2
