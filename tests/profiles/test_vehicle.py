import dataclasses
import math

import pytest

from trackctl.errors import ProfileError
from trackctl.profiles.footprint import rectangle
from trackctl.profiles.vehicle import BODY_QUANTITIES, VEHICLE_QUANTITIES, VehicleProfile

VALUES = {
    "name": "test",
    "description": "A vehicle",
    "source": "Made up",
    "mass": 120,
    "yaw_inertia": 12.0,
    "track_gauge": 0.61,
    "track_width": 0.15,
    "contact_length": 0.8,
    "cog_height": 0.25,
    "sprocket_radius": 0.1,
    "max_speed": 2.0,
    "max_acceleration": 1.0,
    "max_sprocket_rate": 30.0,
    "max_sprocket_acceleration": 60.0,
    "footprint": rectangle(1.0, 0.8),
}


def test_values_are_floats_and_the_rest_has_defaults():
    vehicle = VehicleProfile(**VALUES)
    assert isinstance(vehicle.mass, float)
    assert (vehicle.cog_forward, vehicle.cog_left) == (0.0, 0.0)
    assert vehicle.max_track_force is None
    assert vehicle.min_turn_radius is None


def test_every_number_has_a_range():
    texts_and_outline = {"name", "description", "source", "footprint"}
    fields = [field.name for field in dataclasses.fields(VehicleProfile) if field.name not in texts_and_outline]
    assert [quantity.name for quantity in VEHICLE_QUANTITIES] == fields


@pytest.mark.parametrize("quantity", VEHICLE_QUANTITIES, ids=lambda quantity: quantity.name)
def test_a_number_out_of_range_is_refused_by_name(quantity):
    for value in (quantity.high * 1.001, quantity.low - 1e-9, math.nan, math.inf, True, "1"):
        with pytest.raises(ProfileError, match=quantity.name) as error:
            VehicleProfile(**VALUES | {quantity.name: value})
        assert error.value.key == quantity.name
        assert quantity.allowed() in str(error.value)


@pytest.mark.parametrize(
    ("key", "value", "bound"),
    [
        ("track_width", 0.61, "0.61"),
        ("cog_forward", 0.4, "0.4"),
        ("cog_forward", -0.4, "0.4"),
        ("cog_left", 0.305, "0.305"),
        ("cog_left", -0.305, "0.305"),
    ],
)
def test_numbers_must_fit_each_other(key, value, bound):
    with pytest.raises(ProfileError, match=f"{key}.* below {bound} m") as error:
        VehicleProfile(**VALUES | {key: value})
    assert error.value.key == key
    VehicleProfile(**VALUES | {key: 0.999 * value})


def test_only_optional_numbers_may_be_none():
    with pytest.raises(ProfileError, match="mass: None"):
        VehicleProfile(**VALUES | {"mass": None})


@pytest.mark.parametrize("name", ["", "  ", "two\nlines", "nul\0", 7])
def test_a_name_is_a_line_of_text(name):
    with pytest.raises(ProfileError, match="name: "):
        VehicleProfile(**VALUES | {"name": name})


def test_a_description_may_have_lines_but_no_control_characters():
    VehicleProfile(**VALUES | {"description": "two\nlines"})
    with pytest.raises(ProfileError, match="description: "):
        VehicleProfile(**VALUES | {"description": "\x1b[31m"})


def test_the_footprint_is_a_simple_polygon_counter_clockwise():
    clockwise = rectangle(1.0, 0.8)[::-1]
    assert VehicleProfile(**VALUES | {"footprint": clockwise}).footprint == rectangle(1.0, 0.8)
    with pytest.raises(ProfileError, match="footprint: 2 vertices"):
        VehicleProfile(**VALUES | {"footprint": ((0.0, 0.0), (1.0, 0.0))})


def test_a_changed_copy_is_checked_too():
    with pytest.raises(ProfileError, match="vehicle profile 'test': mass: -1"):
        dataclasses.replace(VehicleProfile(**VALUES), mass=-1)


def test_the_largest_body_is_within_the_footprint_s_bounds():
    largest = rectangle(*(quantity.high for quantity in BODY_QUANTITIES))
    VehicleProfile(**VALUES | {"footprint": largest})
