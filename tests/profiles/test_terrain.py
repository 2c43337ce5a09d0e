import dataclasses
import math

import pytest

from trackctl.errors import ProfileError
from trackctl.profiles.terrain import TERRAIN_QUANTITIES, TerrainProfile

VALUES = {
    "name": "test",
    "description": "A terrain",
    "source": "Made up",
    "friction_coefficient": 0.8,
    "shear_deformation_modulus": 0.01,
    "motion_resistance_coefficient": 0.04,
}


def test_firm_ground_has_no_cohesion_and_no_friction_of_its_own_sideways():
    terrain = TerrainProfile(**VALUES)
    assert terrain.cohesion == 0.0
    assert terrain.lateral_friction_coefficient is None


def test_every_number_has_a_range():
    fields = [field.name for field in dataclasses.fields(TerrainProfile)]
    assert [quantity.name for quantity in TERRAIN_QUANTITIES] == fields[3:]


@pytest.mark.parametrize("quantity", TERRAIN_QUANTITIES, ids=lambda quantity: quantity.name)
def test_a_number_out_of_range_is_refused_by_name(quantity):
    for value in (quantity.high * 1.001, -1e-9, math.nan, math.inf, False, "1"):
        with pytest.raises(ProfileError, match="terrain profile 'test'") as error:
            TerrainProfile(**VALUES | {quantity.name: value})
        assert error.value.key == quantity.name
        assert quantity.allowed() in str(error.value)


@pytest.mark.parametrize("key", ["friction_coefficient", "shear_deformation_modulus"])
def test_no_friction_and_no_shear_modulus_are_refused(key):
    with pytest.raises(ProfileError, match=key):
        TerrainProfile(**VALUES | {key: 0.0})
