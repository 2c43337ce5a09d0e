"""`calibrate`: the ground under a vehicle, from a log of its steady motions on level ground."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from trackctl.errors import InputFileError, NoAnswerError
from trackctl.files.log_stream import Source, log_sources, read_blocks
from trackctl.files.profile_yaml import terrain_to_yaml
from trackctl.identification.calibration import Calibration, calibrate_ground
from trackctl.identification.steady_windows import SteadyWindows, steady_windows, within_model
from trackctl.mechanics.parameters import track_model
from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import VehicleProfile

Array = NDArray[np.float64]

#: Velocities that may stand in place of time and poses: each row is a steady motion then.
TWIST = ("forward_velocity_mps", "lateral_velocity_mps", "yaw_rate_radps")
#: Their standard deviation. [m/s], [m/s], [rad/s]
TWIST_STD = (0.005, 0.005, 0.005)
#: The calibrated quantities by the names of a terrain profile.
TERRAIN_NAMES = {
    "friction": "friction_coefficient",
    "shear_modulus": "shear_deformation_modulus",
    "resistance": "motion_resistance_coefficient",
}
TERRAIN_KEYS = {
    "friction": "friction_coefficient",
    "shear_modulus": "shear_deformation_modulus_m",
    "resistance": "motion_resistance_coefficient",
}


@dataclass(frozen=True, slots=True)
class CalibrateRequest:
    """What to fit.

    Attributes
    ----------
    log
        File, or ``-`` for standard input.
    vehicle
        That made the log.
    assumed
        Ground whose values stand for what the log does not determine; its cohesion is not used.
    gravity
        [m/s2]
    """

    log: str
    vehicle: VehicleProfile
    assumed: TerrainProfile
    gravity: float


def calibrate(request: CalibrateRequest) -> Calibration:
    """Fit the ground to a log.

    Raises
    ------
    InputFileError
        If the log is none.
    NoAnswerError
        If it has no steady motion that the model may hold for, or determines nothing.
    """
    windows = windows_of(request)
    vehicle = request.vehicle
    count = len(within_model(windows, vehicle.contact_length)[0].speeds)
    if not count:
        raise NoAnswerError(
            f"{request.log}: none of {len(windows.speeds)} steady stretches has both tracks rolling one way, "
            "and a shoe turning by less than half a turn while on the ground"
        )
    model = track_model(vehicle, replace(request.assumed, cohesion=0.0), request.gravity)
    result = calibrate_ground(model, windows)
    if not any(estimate.determined for estimate in result.estimates.values()):
        raise NoAnswerError(
            f"{request.log}: its {count} steady motions determine neither friction, K nor resistance; "
            "it takes turns of several radii and speeds"
        )
    return result


def windows_of(request: CalibrateRequest) -> SteadyWindows:
    """The steady motions of the log: stretches between poses, or where it has velocities alone, its rows."""
    poses = log_sources(request.vehicle.sprocket_radius)
    twist = tuple(Source(((key, 1.0),), optional=True) for key in TWIST)
    optional = tuple(replace(source, optional=True) for source in poses)
    sources = (optional[0], *poses[1:3], *optional[3:], *twist)
    rows = np.concatenate(list(read_blocks(request.log, sources)))
    if np.isfinite(rows[:, [0, 3, 4, 5]]).any(axis=0).all():
        return steady_windows(rows[:, :6])
    rows = rows[np.isfinite(rows[:, [1, 2, 6, 7, 8]]).all(axis=1)]
    if not len(rows):
        raise InputFileError(
            request.log, f"has neither time_s, x_m, y_m and yaw_rad nor {', '.join(TWIST)} with numbers in them"
        )
    return SteadyWindows(rows[:, 1:3], rows[:, 6:9], np.array(TWIST_STD))


def calibrated_terrain(request: CalibrateRequest, result: Calibration) -> str:
    """The terrain as YAML, with a comment on how sure each value is."""
    terrain = TerrainProfile(
        name="calibrated",
        description=f"Ground fitted to {result.windows} steady motions of {request.vehicle.name}",
        source=f"trackctl calibrate {request.log}: {in_words(result)}",
        **{TERRAIN_NAMES[name]: max(each.value, 0.0) for name, each in result.estimates.items()},
    )
    comments = {TERRAIN_KEYS[name]: comment(result, name) for name in result.estimates}
    lines = terrain_to_yaml(terrain).splitlines()
    return "".join(f"{line}{comments.get(line.partition(':')[0], '')}\n" for line in lines)


def comment(result: Calibration, name: str) -> str:
    """What a value's line says on how it came about."""
    estimate = result.estimates[name]
    share = f" ({estimate.noise_std:.2g} but for the model's misfit)" if estimate.is_by_misfit else ""
    if estimate.determined:
        return f"  # fitted, standard deviation {estimate.std:.2g}{share}"
    return f"  # not determined by the log (standard deviation {estimate.std:.2g}); it goes with the other values here"


def in_words(result: Calibration) -> str:
    """The fitted values, and those that the log does not determine."""
    words = {"friction": "friction", "shear_modulus": "K", "resistance": "resistance"}
    units = {"friction": "", "shear_modulus": " m", "resistance": ""}
    known = [
        f"{words[name]} {each.value:.3g} +- {each.std:.2g}{units[name]}"
        for name, each in result.estimates.items()
        if each.determined
    ]
    loose = [words[name] for name, each in result.estimates.items() if not each.determined]
    without = f"; the log does not determine {' and '.join(loose)}" if loose else ""
    misfit = any(each.is_by_misfit for each in result.estimates.values() if each.determined)
    why = "; the model's misfit dominates these deviations, a longer log will not reduce them" if misfit else ""
    return ", ".join(known) + without + why


def calibration_summary(result: Calibration) -> dict[str, object]:
    """The result for a script."""
    return {
        "steady_motions": result.windows,
        "without_equilibrium": result.unsolved,
        "parameters": {
            TERRAIN_KEYS[name]: {
                "value": each.value,
                "std": each.std,
                "noise_std": each.noise_std,
                "misfit_std": each.misfit_std,
                "determined": each.determined,
            }
            for name, each in result.estimates.items()
        },
        "residual_std": dict(zip(TWIST, result.residual_std, strict=True)),
    }
