import math

import numpy as np
import pytest

from trackctl.errors import UsageError
from trackctl.units import QUANTITIES, accepted_keys, factor_to_si, split_suffix, to_si


@pytest.mark.parametrize(
    ("key", "parts"),
    [
        ("heading_deg", ("heading", "deg")),
        ("sprocket_rate_left_radps", ("sprocket_rate_left", "radps")),
        ("yaw_inertia_kgm2", ("yaw_inertia", "kgm2")),
        ("curvature_1pm", ("curvature", "1pm")),
        ("slip_left", ("slip_left", "")),
        ("p1_std", ("p1_std", "")),
        ("m", ("m", "")),
        ("_m", ("_m", "")),
        ("", ("", "")),
    ],
)
def test_suffix_is_the_last_part_if_it_is_a_unit(key, parts):
    assert split_suffix(key) == parts


@pytest.mark.parametrize(
    ("key", "value", "in_si"),
    [
        ("yaw_deg", 180.0, math.pi),
        ("speed_kmph", 36.0, 10.0),
        ("sprocket_rate_left_rpm", 60.0, 2.0 * math.pi),
        ("yaw_rate_degps", 90.0, 0.5 * math.pi),
        ("mass_t", 13.6, 13600.0),
        ("mass_g", 250.0, 0.25),
        ("track_gauge_mm", 610.0, 0.61),
        ("cohesion_kpa", 1.72, 1720.0),
        ("curvature_1pm", 0.05, 0.05),
        ("slip_left", 0.3, 0.3),
    ],
)
def test_values_become_si(key, value, in_si):
    # one rounding in the factor, one in the product
    assert to_si(key, value) == pytest.approx(in_si, rel=4e-16)


def test_arrays_become_si():
    np.testing.assert_array_equal(to_si("time_ms", np.array([0.0, 500.0])), [0.0, 0.5])


@pytest.mark.parametrize("key", ["heading_deg", "heading_mrad", "heading_rad"])
def test_another_unit_of_the_quantity_is_accepted(key):
    assert factor_to_si(key, "heading_rad") == accepted_keys("heading_rad")[key]


@pytest.mark.parametrize("key", ["heading_m", "heading", "heading_turns", "yaw_rad"])
def test_what_is_no_unit_of_the_quantity_is_refused_with_those_that_are(key):
    with pytest.raises(UsageError, match="heading_rad, heading_deg, heading_mrad") as error:
        factor_to_si(key, "heading_rad")
    assert error.value.value == key


def test_a_pure_number_takes_no_unit():
    assert accepted_keys("slip_left") == {"slip_left": 1.0}
    with pytest.raises(UsageError):
        factor_to_si("slip_left_m", "slip_left")


def test_a_suffix_belongs_to_one_quantity_and_its_si_unit_comes_first():
    suffixes = [suffix for units in QUANTITIES.values() for suffix in units]
    assert len(suffixes) == len(set(suffixes))
    assert all(next(iter(units.values())) == 1.0 for units in QUANTITIES.values())
