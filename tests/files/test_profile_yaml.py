import dataclasses
import re
import sys
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st
from system_words import IS_FOLDER, NO_FILE, NOT_PERMITTED
from systems import needs_permissions

from trackctl.errors import ProfileError
from trackctl.files.profile_folders import ProfileKind, profile_files
from trackctl.files.profile_yaml import (
    load_terrain,
    load_vehicle,
    parse_profile,
    parse_terrain,
    parse_vehicle,
    profile_template,
    read_profile,
    terrain_to_yaml,
    vehicle_to_yaml,
)
from trackctl.files.strict_yaml import MAX_BYTES
from trackctl.profiles.terrain import TERRAIN_QUANTITIES, TerrainProfile
from trackctl.profiles.vehicle import VEHICLE_QUANTITIES, VehicleProfile

LINES = {
    "name": "test",
    "description": "A vehicle",
    "source": "Made up",
    "mass_kg": "120",
    "yaw_inertia_kgm2": "12",
    "track_gauge_m": "0.61",
    "track_width_m": "0.15",
    "contact_length_m": "0.8",
    "cog_height_m": "0.25",
    "sprocket_radius_m": "0.1",
    "max_speed_mps": "2",
    "max_acceleration_mps2": "1",
    "max_sprocket_rate_radps": "30",
    "max_sprocket_acceleration_radps2": "60",
    "body_length_m": "1.0",
    "body_width_m": "0.8",
}
TERRAIN = """\
name: test
description: A terrain
source: Made up
friction_coefficient: 0.8
shear_deformation_modulus_m: 0.01
motion_resistance_coefficient: 0.04
"""


def text_with(**changes):
    """The vehicle of `LINES` with some values changed, added, or with None left out."""
    lines = {key: value for key, value in {**LINES, **changes}.items() if value is not None}
    return "".join(f"{key}: {value}\n" for key, value in lines.items())


def refusal(text, parse=parse_vehicle):
    with pytest.raises(ProfileError) as error:
        parse(text, "here.yaml")
    assert str(error.value).startswith("here.yaml")
    return error.value


def in_range(quantity):
    return st.floats(quantity.low, quantity.high, exclude_min=quantity.low_excluded)


TEXT = st.text(st.characters(exclude_categories=["C", "Zl", "Zp", "Zs"]) | st.just(" "))


def terrains():
    numbers = {quantity.name: in_range(quantity) for quantity in TERRAIN_QUANTITIES}
    numbers["lateral_friction_coefficient"] |= st.none()
    name = TEXT.filter(str.strip)
    return st.builds(TerrainProfile, name=name, description=TEXT, source=TEXT, **numbers)


def vehicles():
    free = {"cog_forward", "cog_left", "track_gauge", "track_width", "contact_length"}
    numbers = {q.name: in_range(q) for q in VEHICLE_QUANTITIES if q.name not in free}
    numbers["max_track_force"] |= st.none()
    triangle = st.tuples(st.floats(0.1, 50.0), st.floats(0.1, 50.0)).map(
        lambda corner: ((-corner[0], 0.0), (corner[0], 0.0), (0.0, corner[1]))
    )
    return st.builds(
        VehicleProfile,
        name=TEXT.filter(str.strip),
        description=TEXT,
        source=TEXT,
        track_gauge=st.floats(1.0, 20.0),
        track_width=st.floats(0.002, 0.9),
        contact_length=st.floats(1.0, 30.0),
        cog_forward=st.floats(-0.4, 0.4),
        cog_left=st.floats(-0.4, 0.4),
        footprint=triangle,
        **numbers,
    )


@given(terrains())
def test_terrains_come_back_bit_for_bit(terrain):
    assert repr(parse_terrain(terrain_to_yaml(terrain), "x")) == repr(terrain)


@given(vehicles())
def test_vehicles_come_back_bit_for_bit(vehicle):
    assert repr(parse_vehicle(vehicle_to_yaml(vehicle), "x")) == repr(vehicle)


def test_body_size_becomes_a_rectangle_about_the_contact_centre():
    corners = ((-0.5, -0.4), (0.5, -0.4), (0.5, 0.4), (-0.5, 0.4))
    assert parse_vehicle(text_with(), "x").footprint == corners


@pytest.mark.parametrize(
    ("changes", "field", "value"),
    [
        ({"mass_kg": None, "mass_t": "13.6"}, "mass", 13600.0),
        ({"mass_kg": None, "mass_g": "250"}, "mass", 0.25),
        ({"track_gauge_m": None, "track_gauge_mm": "2159"}, "track_gauge", 2.159),
        ({"max_speed_mps": None, "max_speed_kmph": "36"}, "max_speed", 10.0),
        ({"max_track_force_kn": "1.7"}, "max_track_force", 1700.0),
        ({"mass_kg": "1.2e+2"}, "mass", 120.0),
        ({"mass_kg": "0120"}, "mass", 120.0),
    ],
)
def test_units_of_the_quantity_are_accepted(changes, field, value):
    assert getattr(parse_vehicle(text_with(**changes), "x"), field) == value


def test_footprint_may_be_in_another_unit():
    corners = {"body_length_m": None, "body_width_m": None, "footprint_mm": "[[0, 0], [900, 0], [0, 7]]"}
    assert parse_vehicle(text_with(**corners), "x").footprint == ((0.0, 0.0), (0.9, 0.0), (0.0, 0.007))


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("-1", "mass_kg: -1 is not allowed; allowed: 0.1 to 1000000"),
        (".nan", ".nan is no finite decimal number; allowed: 0.1 to 1000000"),
        ("-.inf", "no finite decimal number"),
        ("1.0e+99999999999999999999", "no finite decimal number"),
        ("0x10", "no finite decimal number"),
        ("1:30", "no finite decimal number"),
        ("1e3", "YAML reads 1e3 as text; write it with a point and a signed exponent"),
        ("'120'", "text because of its quotes"),
        ("yes", "'yes' is no number"),
        ("12 kg", "'12 kg' is no number"),
        ("", "an empty value is no number"),
        ("[120]", "a list is no number"),
        ("{a: 1}", "a mapping is no number"),
        ("9" * 60, "allowed: 0.1 to 1000000"),
    ],
)
def test_a_bad_number_is_told_with_line_key_and_range(value, said):
    error = refusal(text_with(mass_kg=value))
    assert (error.line, error.key) == (4, "mass_kg")
    assert said in error.problem
    assert "allowed: 0.1 to 1000000" in error.problem


def test_the_range_is_told_in_the_unit_of_the_file():
    error = refusal(text_with(mass_kg=None, mass_g="5"))
    assert error.problem == "mass_g: 5 is not allowed; allowed: 100 to 1000000000"


@pytest.mark.parametrize(
    ("key", "said"),
    [
        ("mass_m", "has an unknown unit; allowed: mass_kg, mass_g, mass_t"),
        ("mass_lbs", "has an unknown unit; allowed: mass_kg, mass_g, mass_t"),
        ("mass", "has no unit; allowed: mass_kg, mass_g, mass_t"),
        ("masss_kg", "unknown key; did you mean mass_kg?"),
        ("colour", "unknown key; allowed: name, description"),
        ("friction_coefficient", "unknown key"),
        ("mass_g", "stands in line 4 as mass_kg"),
        ("cog_height_m", "stands here and in line 9"),
    ],
)
def test_a_key_too_many_is_refused_with_its_line(key, said):
    error = refusal(text_with() + f"{key}: 1\n")
    assert (error.line, error.key) == (17, key)
    assert said in error.problem


def test_all_missing_keys_are_in_one_message():
    assert "missing keys: mass_kg, track_gauge_m" in str(refusal(text_with(mass_kg=None, track_gauge_m=None)))


@pytest.mark.parametrize("key", [key for key in LINES if not key.startswith("body")])
def test_each_key_is_missed(key):
    assert f"missing keys: {key}" in str(refusal(text_with(**{key: None})))


def test_an_outline_is_needed_once():
    no_body = {"body_length_m": None, "body_width_m": None}
    assert "body_length_m, body_width_m (or footprint_m" in str(refusal(text_with(**no_body)))
    assert "missing keys: body_width_m" in str(refusal(text_with(body_width_m=None)))
    error = refusal(text_with(footprint_m="[[0, 0], [1, 0], [0, 1]]"))
    assert (error.line, error.key) == (15, "body_length_m")
    assert "stands beside footprint_m" in error.problem


@pytest.mark.parametrize(
    "corners",
    [
        "[]",
        "[1, 2]",
        "7",
        "[[0, 0], [1, 0], [1]]",
        "[[0, 0], [1, 1], [1, 0], [0, 1]]",
        "[[0, 0], [1, .nan], [1, 0]]",
    ],
)
def test_a_bad_footprint_is_refused_with_its_line(corners):
    error = refusal(text_with(body_length_m=None, body_width_m=None, footprint_m=corners))
    assert (error.line, error.key) == (15, "footprint_m")


def test_numbers_at_odds_are_told_with_the_line():
    error = refusal(text_with(track_width_m="0.7"))
    assert (error.line, error.key) == (7, "track_width_m")
    assert "0.7 m is not allowed; allowed: below 0.61 m" in error.problem


@pytest.mark.parametrize("value", ["12", "yes", "2020-01-01", "[a]", "''", '"a\\0b"', "null"])
def test_a_name_is_text(value):
    assert refusal(text_with(name=value)).line == 1


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is empty"),
        ("# only a comment\n", "is empty"),
        ("- a\n- b\n", "no list of `key: value` lines"),
        ("words", "no list of `key: value` lines"),
        ("{}", "no key of a vehicle or terrain profile"),
        ("image: map.pgm\n", "no key of a vehicle or terrain profile"),
        ("a: [1\n", "line 2: is not valid YAML"),
        ("\tmass_kg: 1\n", "line 1: is not valid YAML"),
        ("a: \x01\n", "is not valid YAML"),
        ("mass_kg: &x 1\n", "anchors and aliases (x)"),
        ("mass_kg: *x\n", "anchors and aliases (x)"),
        ("mass_kg: !!float 1\n", "tags (tag:yaml.org,2002:float)"),
        ("mass_kg: !!python/object/apply:os.getcwd []\n", "tags"),
        ("mass_kg: 1\n---\nmass_kg: 1\n", "line 2: a second YAML document"),
        ("mass_kg: " + "[" * 8, "line 1: nested more than 8 deep"),
        ("mass_kg: " + "[" * 7, "is not valid YAML"),
        ("# [[[[[[[[[\na: [1\n", "is not valid YAML"),
        *(
            (f"name: x\nmass_kg:\n  {level * 50_000}", "line 3: nested more than 8 deep")
            for level in ("[", "{", "[{", "- ", "? ", "{a: ", "[[], ")
        ),
        ("mass_kg: " + "[\n" * 50_000, "line 8: nested more than 8 deep"),
        ("".join(f"{level * ' '}a:\n" for level in range(1200)), "line 9: nested more than 8 deep"),
        ("[1, 2]: 3\n", "a list is no key"),
        ("1: 2\n", "'1' is no key"),
        (TERRAIN, "is a terrain profile; a vehicle profile is needed here"),
    ],
)
def test_what_is_no_profile_is_refused(text, said):
    assert said in str(refusal(text))


def test_a_bomb_of_aliases_is_refused_at_once():
    levels = "".join(f"l{n + 1}: &l{n + 1} [{', '.join([f'*l{n}'] * 9)}]\n" for n in range(30))
    assert "anchors and aliases (l0)" in str(refusal("l0: &l0 [x]\n" + levels))


def time_to_refuse(keys):
    """Processor time, the less of two. [s]"""
    text, times = "".join(f"key{n}: 1\n" for n in range(keys)) + "mass_kg: 1\n", []
    for _ in range(2):
        start = time.process_time()
        refusal(text)
        times.append(time.process_time() - start)
    return min(times)


def test_a_file_of_many_keys_is_read_in_proportion_to_their_number():
    """40 times as many take 40 to 100 times as long, as processors go; were it quadratic, 1600 times."""
    assert time_to_refuse(20_000) < 400.0 * time_to_refuse(500)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"\xff\xfe\x00binary", "line 1: is not UTF-8 text"),
        (b"name: a\nname: \xe9\n", "line 2: is not UTF-8 text"),
        (b"# " + b"x" * MAX_BYTES, "larger than 1000000 bytes"),
    ],
)
def test_an_unreadable_file_is_refused(tmp_path, content, said):
    path = tmp_path / "profile.yaml"
    path.write_bytes(content)
    with pytest.raises(ProfileError, match=said) as error:
        load_vehicle(str(path))
    assert str(path) in str(error.value)


def test_a_byte_order_mark_and_dos_line_ends_do_no_harm(tmp_path):
    path = tmp_path / "profile.yaml"
    path.write_bytes(b"\xef\xbb\xbf" + TERRAIN.replace("\n", "\r\n").encode())
    assert load_terrain(str(path)) == parse_terrain(TERRAIN, "x")


def test_a_missing_file_and_a_folder_are_refused(tmp_path):
    with pytest.raises(ProfileError, match=NO_FILE):
        load_vehicle(str(tmp_path / "missing.yaml"))
    with pytest.raises(ProfileError, match=IS_FOLDER):
        load_vehicle(str(tmp_path))


@needs_permissions
def test_a_file_without_permission_is_refused(tmp_path):
    path = tmp_path / "profile.yaml"
    path.touch(mode=0)
    with pytest.raises(ProfileError, match=NOT_PERMITTED):
        load_vehicle(str(path))


SHIPPED = {
    ProfileKind.VEHICLE: ["carrier-13t6", "husky", "m113", "marder", "shiller-1993", "tracked-ugv-61kg", "utv-61cm"],
    ProfileKind.TERRAIN: [
        "asphalt",
        "clay",
        "concrete",
        "dry-sand",
        "grass",
        "hard-soil",
        "sandy-loam",
        "snow",
    ],
}


@pytest.mark.parametrize("kind", ProfileKind)
def test_shipped_profiles_are_named_after_their_files(kind, monkeypatch):
    monkeypatch.delenv("TRACKCTL_PROFILE_PATH", raising=False)
    assert list(profile_files(kind)) == SHIPPED[kind]
    for name in SHIPPED[kind]:
        text, file = read_profile(name, kind)
        assert parse_profile(text, file).name == name
        numbers = [line for line in text.splitlines() if re.match(r"\w+: -?[0-9]", line)]
        assert len(numbers) >= 3
        assert all("# " in line for line in numbers), "every number says where it comes from"


def test_the_default_vehicle_and_terrain():
    vehicle, terrain = load_vehicle("utv-61cm"), load_terrain("asphalt")
    assert (vehicle.mass, vehicle.track_gauge, vehicle.contact_length) == (120.0, 0.61, 0.8)
    assert terrain == dataclasses.replace(
        terrain,
        friction_coefficient=0.8,
        lateral_friction_coefficient=None,
        shear_deformation_modulus=0.01,
        cohesion=0.0,
        motion_resistance_coefficient=0.04,
    )


@pytest.mark.parametrize("example", [load_vehicle("m113"), load_terrain("clay")], ids=["vehicle", "terrain"])
def test_a_template_is_a_profile_with_every_key(example):
    text = profile_template(example)
    filled = dataclasses.replace(
        parse_profile(text, "x"), name=example.name, description=example.description, source=example.source
    )
    assert filled == example
    quantities = VEHICLE_QUANTITIES if isinstance(example, VehicleProfile) else TERRAIN_QUANTITIES
    assert all(f"{quantity.key}:" in text for quantity in quantities)


def test_standard_input_is_a_profile_too(monkeypatch, tmp_path):
    path = tmp_path / "profile.yaml"
    path.write_text(TERRAIN)
    with path.open() as stream:
        monkeypatch.setattr(sys, "stdin", stream)
        assert load_terrain("-") == parse_terrain(TERRAIN, "x")
