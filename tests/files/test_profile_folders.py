import os

import pytest

from trackctl.errors import ProfileError
from trackctl.files.profile_folders import ProfileKind, is_name
from trackctl.files.profile_yaml import list_profiles, load_terrain

TERRAIN = """\
name: test
description: A terrain
source: Made up
friction_coefficient: 0.8
shear_deformation_modulus_m: 0.01
motion_resistance_coefficient: 0.04
"""


@pytest.mark.parametrize("name", ["utv-61cm", "asphalt", "v1.2"])
def test_names(name):
    assert is_name(name)


@pytest.mark.parametrize("path", ["x.yaml", "x.yml", "./x", "folder/x", "/x"])
def test_paths(path):
    assert not is_name(path)


def test_an_unknown_name_lists_names_and_folders(tmp_path, monkeypatch):
    monkeypatch.setenv("TRACKCTL_PROFILE_PATH", str(tmp_path))
    with pytest.raises(ProfileError, match="asphalt, clay") as error:
        load_terrain("tarmac")
    assert str(tmp_path) in str(error.value)


@pytest.mark.parametrize("place", [".", "terrains"])
def test_the_users_folders_come_first(tmp_path, monkeypatch, place):
    folders = [tmp_path / "one", tmp_path / "two"]
    for friction, folder in zip((0.4, 0.5), folders, strict=True):
        (folder / place).mkdir(parents=True)
        (folder / place / "asphalt.yaml").write_text(TERRAIN.replace("0.8", str(friction)))
    monkeypatch.setenv("TRACKCTL_PROFILE_PATH", os.pathsep.join(map(str, folders)))
    assert load_terrain("asphalt").friction_coefficient == 0.4
    assert load_terrain("concrete").friction_coefficient == 0.5
    assert load_terrain(str(folders[1] / place / "asphalt.yaml")).friction_coefficient == 0.5


def test_a_name_needs_no_file_in_the_working_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "asphalt").mkdir()
    assert load_terrain("asphalt").name == "asphalt"


def test_the_list_tells_kinds_apart_and_shows_broken_files(tmp_path, monkeypatch):
    (tmp_path / "mine.yaml").write_text(TERRAIN)
    (tmp_path / "broken.yml").write_text(TERRAIN.replace("0.8", "-0.8"))
    (tmp_path / "notes.txt").write_text("no profile")
    monkeypatch.setenv("TRACKCTL_PROFILE_PATH", str(tmp_path))
    terrains = {listed.name: listed for listed in list_profiles(ProfileKind.TERRAIN)}
    assert terrains["mine"].description == "A terrain"
    assert terrains["mine"].path == tmp_path / "mine.yaml"
    assert "cannot be used: friction_coefficient: -0.8" in terrains["broken"].description
    assert "notes" not in terrains
    assert "mine" not in {listed.name for listed in list_profiles(ProfileKind.VEHICLE)}
