"""What the models know about a tracked vehicle."""

from __future__ import annotations

from dataclasses import dataclass

from trackctl.errors import ProfileError
from trackctl.profiles.checks import Quantity, check_fields
from trackctl.profiles.footprint import Footprint, counter_clockwise, footprint_problem

# From a 100 g toy to the largest excavators.
VEHICLE_QUANTITIES = (
    Quantity("mass", "kg", 0.1, 1e6, "with payload"),
    Quantity("yaw_inertia", "kgm2", 1e-6, 1e8, "about the vertical axis through the mass centre"),
    Quantity("track_gauge", "m", 0.02, 20.0, "between the centre lines of the tracks"),
    Quantity("track_width", "m", 0.002, 10.0, "of one track; below the gauge"),
    Quantity("contact_length", "m", 0.02, 30.0, "of track on the ground"),
    Quantity("cog_height", "m", 0.0, 20.0, "mass centre above the ground; 0 for no load transfer"),
    Quantity("cog_forward", "m", -15.0, 15.0, "mass centre ahead of the contact centre"),
    Quantity("cog_left", "m", -10.0, 10.0, "mass centre left of the contact centre"),
    Quantity("sprocket_radius", "m", 0.002, 5.0, "track speed over sprocket rate"),
    Quantity("max_speed", "mps", 1e-3, 100.0, "of the mass centre"),
    Quantity("max_acceleration", "mps2", 1e-3, 100.0, "along the path, driving and braking"),
    Quantity("max_sprocket_rate", "radps", 1e-3, 1e4, "either way"),
    Quantity("max_sprocket_acceleration", "radps2", 1e-3, 1e6, "either way"),
    Quantity("max_track_force", "n", 0.0, 1e8, "that the drive can put on one track", low_excluded=True),
    Quantity("min_turn_radius", "m", 0.0, 1e4, "the tightest that a plan may hold", low_excluded=True),
)

# What a file may give in place of a footprint.
BODY_QUANTITIES = (
    Quantity("body_length", "m", 0.02, 100.0, "of the rectangle about the contact centre"),
    Quantity("body_width", "m", 0.02, 100.0, "of the rectangle about the contact centre"),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleProfile:
    """A tracked vehicle, in SI units; x forward, y left, origin at the centre of the ground contact.

    Attributes
    ----------
    name, description, source
        What it is called, what it is, where the values come from.
    mass
        With payload. [kg]
    yaw_inertia
        About the vertical axis through the mass centre. [kg m2]
    track_gauge
        Between the centre lines of the tracks. [m]
    track_width, contact_length
        Of the rectangle each track presses on the ground. [m]
    cog_height
        Mass centre above the ground. [m]
    cog_forward, cog_left
        Mass centre from the contact centre; inside the contact patch. [m]
    sprocket_radius
        Pitch radius: track speed over sprocket rate. [m]
    max_speed, max_acceleration
        Of the mass centre, along the path. [m/s], [m/s2]
    max_sprocket_rate, max_sprocket_acceleration
        Either way. [rad/s], [rad/s2]
    max_track_force
        Limit of the drive on one track, None for no limit. [N]
    min_turn_radius
        Tightest path a plan may hold, None for no limit. [m]
    footprint
        Corners of a simple polygon, counter-clockwise about the contact centre. [m]

    Raises
    ------
    ProfileError
        If a value is no number, out of its range in `VEHICLE_QUANTITIES`, or at odds with another.
    """

    name: str
    description: str
    source: str
    mass: float
    yaw_inertia: float
    track_gauge: float
    track_width: float
    contact_length: float
    cog_height: float
    cog_forward: float = 0.0
    cog_left: float = 0.0
    sprocket_radius: float
    max_speed: float
    max_acceleration: float
    max_sprocket_rate: float
    max_sprocket_acceleration: float
    max_track_force: float | None = None
    min_turn_radius: float | None = None
    footprint: Footprint

    def __post_init__(self) -> None:
        label = f"vehicle profile {self.name!r}"
        check_fields(self, label, VEHICLE_QUANTITIES)
        for key, bound, partner in (
            ("track_width", self.track_gauge, "the track gauge"),
            ("cog_forward", 0.5 * self.contact_length, "half the contact length, either way"),
            ("cog_left", 0.5 * self.track_gauge, "half the track gauge, either way"),
        ):
            value = getattr(self, key)
            if abs(value) >= bound:
                allowed = f"below {bound:g} m, {partner}"
                raise ProfileError(label, f"{key}: {value:g} m is not allowed; allowed: {allowed}", None, key, value)
        problem = footprint_problem(self.footprint)
        if problem:
            raise ProfileError(label, f"footprint: {problem}", None, "footprint", self.footprint)
        object.__setattr__(self, "footprint", counter_clockwise(self.footprint))
