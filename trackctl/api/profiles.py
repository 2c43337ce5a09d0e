"""Vehicles and terrains."""

from __future__ import annotations

from pathlib import Path

from trackctl.files import profile_yaml
from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import VehicleProfile

__all__ = ["TerrainProfile", "VehicleProfile", "load_terrain", "load_vehicle"]


def load_vehicle(name_or_file: str | Path) -> VehicleProfile:
    """The vehicle of a shipped profile's name, or of a YAML file.

    Raises
    ------
    ProfileError
        If there is no such profile, or it holds what is not allowed.

    Examples
    --------
    >>> import trackctl
    >>> vehicle = trackctl.load_vehicle("utv-61cm")
    >>> vehicle.track_gauge, vehicle.max_speed
    (0.61, 2.0)

    A change is a replacement, checked as a file is:

    >>> from dataclasses import replace
    >>> replace(vehicle, mass=150.0).mass
    150.0
    """
    return profile_yaml.load_vehicle(str(name_or_file))


def load_terrain(name_or_file: str | Path) -> TerrainProfile:
    """The terrain of a shipped profile's name, or of a YAML file; errors as of `load_vehicle`.

    Examples
    --------
    >>> import trackctl
    >>> trackctl.load_terrain("asphalt").friction_coefficient > 0.5
    True
    """
    return profile_yaml.load_terrain(str(name_or_file))
