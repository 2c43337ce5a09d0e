"""What a typed script does with trackctl; `tests/test_api.py` runs it, and mypy reads it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, assert_type

import numpy as np
from numpy.typing import NDArray

import trackctl


def commands(folder: Path) -> tuple[float, NDArray[np.uint8]]:
    """A rate by the model, and statuses by a table."""
    vehicle: trackctl.VehicleProfile = trackctl.load_vehicle("utv-61cm")
    terrain: trackctl.TerrainProfile = trackctl.load_terrain("asphalt")
    solved = trackctl.solve_point(vehicle, terrain, velocity=1.0, curvature=0.2, heading=0.0, slope=0.2)
    opened: trackctl.LookupTable = trackctl.open_table(folder / "lut.h5")
    found = opened.lookup(np.array([1.0, 9.0]), 0.2, 0.0, method=trackctl.LookupMethod.LINEAR)
    assert_type(found, trackctl.LookupResult)
    written = trackctl.export_table(folder / "lut.h5", folder / "robot.c", precision=trackctl.Precision.FLOAT)
    assert [file.name for file in written.files] == ["robot.h", "robot.c"]
    return float(solved.sprocket_rate_left), found.status


def motions(folder: Path) -> tuple[float, float]:
    """Friction that a circle needs, and where constant track speeds lead."""
    vehicle, terrain = trackctl.load_vehicle("utv-61cm"), trackctl.load_terrain("asphalt")
    speed = trackctl.SpeedRequest(trackctl.SpeedKind.SMOOTH, ends=0.2, peak=1.0)
    forces = trackctl.nominal_forces(vehicle, trackctl.arc_path(5.0, math.pi), speed, terrain=terrain)
    result = trackctl.simulate(vehicle, terrain, trackctl.constant_speeds(0.5, 0.5, 1.0), interval=0.5)
    (folder / "log.csv").write_text(
        "time_s,track_speed_left_mps,track_speed_right_mps,x_m,y_m,yaw_rad\n0,1,1,0,0,0\n1,1,1,1,0,0\n2,1,1,2,0,0\n"
    )
    learned = trackctl.identify(folder / "log.csv", vehicle, model=trackctl.SlipModel.CONSTANT)
    assert learned.updates > 0
    return forces.required_friction, float(result.motion.x[-1])


def refused() -> str:
    """What is raised for a profile that is not there."""
    try:
        trackctl.load_vehicle("tank")
    except trackctl.InputFileError as error:
        return f"{error.file}: {error.problem}"
    raise AssertionError


if TYPE_CHECKING:
    # A checker that took these would find the exceptions unused.
    trackctl.load_vehicle(3)  # type: ignore[arg-type]
    trackctl.open_tabel("lut.h5")  # type: ignore[attr-defined]
    trackctl.solve_point(1.0, 0.2, 0.0)  # type: ignore[call-arg, arg-type]
