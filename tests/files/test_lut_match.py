from dataclasses import replace
from pathlib import Path

import pytest
from lut_examples import GRAVITY, TERRAIN, VEHICLE, example_table

from trackctl.errors import LutMismatchError
from trackctl.files.lut_match import check_matches
from trackctl.files.lut_reader import read_lut_header
from trackctl.files.lut_writer import write_lut

FILE = Path("lut.h5")


def test_the_same_profiles(tmp_path):
    table = example_table()
    check_matches(table, VEHICLE, TERRAIN, GRAVITY, FILE)
    write_lut(tmp_path / "lut.h5", table)
    check_matches(read_lut_header(tmp_path / "lut.h5"), VEHICLE, TERRAIN, GRAVITY, FILE)


def test_what_the_table_does_not_depend_on():
    vehicle = replace(VEHICLE, name="other", source="elsewhere", max_speed=1.0, yaw_inertia=1.0)
    terrain = replace(TERRAIN, name="other", description="other", lateral_friction_coefficient=0.1)
    check_matches(example_table(), vehicle, terrain, GRAVITY, FILE)


@pytest.mark.parametrize(
    "name",
    [
        "mass",
        "track_gauge",
        "track_width",
        "contact_length",
        "cog_height",
        "cog_forward",
        "cog_left",
        "sprocket_radius",
    ],
)
def test_another_vehicle(name):
    vehicle = replace(VEHICLE, **{name: getattr(VEHICLE, name) + 0.01})
    with pytest.raises(LutMismatchError, match=rf"lut\.h5: .* utv-61cm on asphalt with {name} "):
        check_matches(example_table(), vehicle, TERRAIN, GRAVITY, FILE)


@pytest.mark.parametrize(
    "name",
    [
        "friction_coefficient",
        "shear_deformation_modulus",
        "cohesion",
        "motion_resistance_coefficient",
    ],
)
def test_another_terrain(name):
    terrain = replace(TERRAIN, **{name: getattr(TERRAIN, name) + 0.01})
    with pytest.raises(LutMismatchError, match=f"with {name} "):
        check_matches(example_table(), VEHICLE, terrain, GRAVITY, FILE)


def test_another_gravity():
    with pytest.raises(LutMismatchError, match=r"gravity 9\.80665, not 9\.81"):
        check_matches(example_table(), VEHICLE, TERRAIN, 9.81, FILE)


def test_many_differences_are_counted():
    vehicle = replace(VEHICLE, mass=200.0, track_gauge=1.0, cog_height=0.1, contact_length=1.0)
    with pytest.raises(LutMismatchError, match=r"mass 120, not 200; .* and 2 more differences"):
        check_matches(example_table(), vehicle, TERRAIN, 9.81, FILE)
