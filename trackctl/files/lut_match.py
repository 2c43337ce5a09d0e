"""Whether a look-up table was made for the vehicle, terrain and gravity at hand."""

from __future__ import annotations

from pathlib import Path

from trackctl.errors import LutMismatchError
from trackctl.files.lut_reader import LutHeader
from trackctl.lut.table import Table
from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import VehicleProfile

#: What a table depends on; the rest of a profile describes the vehicle or limits its use.
VEHICLE_FIELDS = (
    "mass",
    "track_gauge",
    "track_width",
    "contact_length",
    "cog_height",
    "cog_forward",
    "cog_left",
    "sprocket_radius",
)
TERRAIN_FIELDS = (
    "friction_coefficient",
    "shear_deformation_modulus",
    "cohesion",
    "motion_resistance_coefficient",
)
SHOWN_DIFFERENCES = 3


def check_matches(
    found: Table | LutHeader, vehicle: VehicleProfile, terrain: TerrainProfile, gravity: float, file: Path
) -> None:
    """Refuse a table that was made for something else.

    Parameters
    ----------
    found
        The table, or its header.
    vehicle, terrain, gravity
        What it is to be used for; only what the table depends on is compared. Gravity: [m/s2]
    file
        Where the table comes from, for the message.

    Raises
    ------
    LutMismatchError
        Names the first differences, in SI units.
    """
    triples = [
        *((name, getattr(found.vehicle, name), getattr(vehicle, name)) for name in VEHICLE_FIELDS),
        *((name, getattr(found.terrain, name), getattr(terrain, name)) for name in TERRAIN_FIELDS),
        ("gravity", found.gravity, gravity),
    ]
    differences = [f"{name} {had:.12g}, not {asked:.12g}" for name, had, asked in triples if had != asked]
    if differences:
        shown = "; ".join(differences[:SHOWN_DIFFERENCES])
        more = len(differences) - SHOWN_DIFFERENCES
        raise LutMismatchError(
            file,
            f"was made for {found.vehicle.name} on {found.terrain.name} with {shown}"
            f"{f' and {more} more differences' if more > 0 else ''} (SI units); "
            "name what it was made for, or compile another table",
        )
