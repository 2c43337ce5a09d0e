"""What the models know about the ground under the tracks."""

from __future__ import annotations

from dataclasses import dataclass

from trackctl.profiles.checks import Quantity, check_fields

TERRAIN_QUANTITIES = (
    Quantity("friction_coefficient", "", 0.0, 3.0, "tan(phi) if cohesive", low_excluded=True),
    Quantity("lateral_friction_coefficient", "", 0.0, 3.0, "sideways, where it differs", low_excluded=True),
    Quantity("shear_deformation_modulus", "m", 0.0, 1.0, "K in 1 - exp(-j/K)", low_excluded=True),
    Quantity("cohesion", "kpa", 0.0, 1e6, "shear strength without pressure; 0 on firm ground"),
    Quantity("motion_resistance_coefficient", "", 0.0, 1.0, "resistance over load"),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class TerrainProfile:
    """Ground of one kind, in SI units.

    Attributes
    ----------
    name, description, source
        What it is called, what it is, where the values come from.
    friction_coefficient
        Shear stress over pressure in full sliding; tan(phi) where there is a cohesion. [1]
    lateral_friction_coefficient
        The same for sideways sliding, None where it is no other. [1]
    shear_deformation_modulus
        K of the shear curve 1 - exp(-j/K). [m]
    cohesion
        Shear strength without pressure. [Pa]
    motion_resistance_coefficient
        Resistance to rolling over load. [1]

    Raises
    ------
    ProfileError
        If a value is no number or out of its range in `TERRAIN_QUANTITIES`.
    """

    name: str
    description: str
    source: str
    friction_coefficient: float
    lateral_friction_coefficient: float | None = None
    shear_deformation_modulus: float
    cohesion: float = 0.0
    motion_resistance_coefficient: float

    def __post_init__(self) -> None:
        check_fields(self, f"terrain profile {self.name!r}", TERRAIN_QUANTITIES)
