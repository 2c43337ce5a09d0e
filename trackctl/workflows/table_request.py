"""What a look-up table is compiled from."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, replace

from trackctl import __version__
from trackctl.files.profile_yaml import terrain_to_yaml, vehicle_to_yaml
from trackctl.lut.axes import Array, Axes
from trackctl.lut.grid import Divisions, Ranges, check_ranges, make_axes
from trackctl.lut.sweep import Seeding, Sweep
from trackctl.mechanics.parameters import TrackModel, track_model
from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import VehicleProfile


@dataclass(frozen=True, slots=True, eq=False)
class TableRequest:
    """What a table is compiled from.

    Attributes
    ----------
    vehicle, terrain
        Profiles.
    gravity
        [m/s2]
    slope
        Nodes of the slope axis. [rad]
    ranges, divisions
        Of the other axes.
    seeding, seed
        Of the solver.
    """

    vehicle: VehicleProfile
    terrain: TerrainProfile
    gravity: float
    slope: Array
    ranges: Ranges
    divisions: Divisions
    seeding: Seeding
    seed: int

    @property
    def model(self) -> TrackModel:
        """Vehicle on its terrain."""
        return track_model(self.vehicle, self.terrain, self.gravity)

    @property
    def axes(self) -> Axes:
        """Grid nodes."""
        return make_axes(self.vehicle, self.slope, self.ranges, self.divisions)

    @property
    def sweep(self) -> Sweep:
        """What the columns are solved from."""
        return Sweep(self.model, self.axes, self.seeding, self.seed)

    def divided(self, divisions: Divisions) -> TableRequest:
        """The same with other divisions."""
        return replace(self, divisions=divisions)

    def description(self) -> dict[str, object]:
        """All that the cells depend on, for people and for a digest."""
        return {
            "trackctl_version": __version__,
            "vehicle": vehicle_to_yaml(self.vehicle),
            "terrain": terrain_to_yaml(self.terrain),
            "gravity_mps2": self.gravity,
            "slope_rad": self.slope.tolist(),
            "ranges": asdict(self.ranges),
            "divisions": asdict(self.divisions),
            "seeding": str(self.seeding),
            "seed": self.seed,
        }


def new_request(
    vehicle: VehicleProfile,
    terrain: TerrainProfile,
    gravity: float,
    slope: Array,
    ranges: Ranges,
    seeding: str,
    seed: int,
) -> TableRequest:
    """A checked request whose divisions are still to be chosen.

    Raises
    ------
    UsageError
        If a slope or range is not allowed.
    """
    check_ranges(vehicle, slope, ranges)
    return TableRequest(vehicle, terrain, gravity, slope, ranges, Divisions(0, 0, 0), Seeding(seeding), seed)


def digest_of(description: dict[str, object]) -> str:
    """Digest of a request's description."""
    return hashlib.sha256(json.dumps(description, sort_keys=True).encode()).hexdigest()
