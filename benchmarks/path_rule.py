"""The path rule's table: how far vehicles miss their paths open loop, beside what is known, over a range of shapes.

The known figures name neither radii nor speeds. All rows of a vehicle share one of each: those of the paper's
experiment B for the small one; for the big one the radius at which the naive reading misses a circle by the known
3.5 %. Each row is driven with that radius, and with 0.8 and 1.25 times as much.

Run from the repository: ``python benchmarks/path_rule.py``.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from tables import print_machine

from trackctl.files.profile_yaml import load_terrain, load_vehicle
from trackctl.mechanics.parameters import STANDARD_GRAVITY
from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import VehicleProfile
from trackctl.simulation.following import Feedback, deviation, follow, start_on
from trackctl.simulation.path import Path, circle, path_of_curvature
from trackctl.simulation.path_rule import PathCommands, naive_commands, no_slip_commands, path_commands
from trackctl.simulation.vehicle_rates import Scene, scene

FACTORS = (0.8, 1.0, 1.25)
ORIGIN = (0.0, 0.0, 0.0)
#: What a row may be over its figure; a figure of 0 stands for less than 0.001 %.
MARGIN, LEAST_FIGURE = 1.5, 0.001


@dataclass(frozen=True)
class Size:
    """A vehicle on its ground, and the radius [m] and speed [m/s] of its rows."""

    vehicle: VehicleProfile
    terrain: TerrainProfile
    radius: float
    speed: float


SIZES = {
    "small": Size(load_vehicle("utv-61cm"), load_terrain("asphalt"), 2.0, 2.0 / 3.6),
    "big": Size(
        load_vehicle("carrier-13t6"),
        replace(load_terrain("hard-soil"), friction_coefficient=0.6, shear_deformation_modulus=0.025),
        9.0,
        2.0,
    ),
}


def lap(size: Size, radius: float) -> Path:
    """Once around a circle."""
    return circle(radius, size.speed, 1.0, ORIGIN)


def traverse(size: Size, radius: float) -> Path:
    """As far as the circle is round, straight across the slope."""
    s = np.linspace(0.0, 2.0 * math.pi * radius, 961)
    return path_of_curvature(s, 0.0 * s, np.full_like(s, size.speed), ORIGIN)


def s_curve(size: Size, radius: float) -> Path:
    """One wave of curvature, as sharp as the circle."""
    s = np.linspace(0.0, 3.0 * math.pi * radius, 1201)
    return path_of_curvature(s, np.sin(2.0 * s / (3.0 * radius)) / radius, np.full_like(s, size.speed), ORIGIN)


def speed_ramp(size: Size, radius: float) -> Path:
    """A circle on which the speed grows by 0.5 m/s2, from 0.8 to 1.6 times that of the other rows."""
    s = np.linspace(0.0, 2.0 * math.pi * radius, 961)
    start = 0.8 * size.speed
    square = start**2 + 2.0 * 0.5 * (s - 0.25 * s[-1])
    return path_of_curvature(
        s, np.full_like(s, 1.0 / radius), np.sqrt(np.clip(square, start**2, 4.0 * start**2)), ORIGIN
    )


def blended_arcs(size: Size, radius: float) -> Path:
    """Half a turn, a straight, half a turn, with blends of one contact length."""
    length = size.vehicle.contact_length
    ends = np.cumsum([0.0, math.pi * radius, length, 3.0 * length, length, math.pi * radius])
    s = np.arange(0.0, ends[-1], length / 48.0)
    curvature = np.interp(s, ends, np.array([1.0, 1.0, 0.0, 0.0, 1.0, 1.0]) / radius)
    return path_of_curvature(s, curvature, np.full_like(s, size.speed), ORIGIN)


Shape = Callable[[Size, float], Path]
Commands = Callable[[Scene, Path], PathCommands]

#: Shape, slope [deg], size, and the known figures in percent: no slip, naive, path rule with and without memory.
ROWS: list[tuple[Shape, float, str, tuple[float | None, ...]]] = [
    (lap, 12, "small", (12, 3.3, 0.09, 0.002)),
    (lap, 12, "big", (14, 3.5, 0.07, 0.004)),
    (lap, 18, "small", (15, 5.0, 0.07, 0.02)),
    (lap, 18, "big", (19, 6.4, 0.73, 0.03)),
    (traverse, 12, "small", (5, 0.01, 0, 0)),
    (traverse, 12, "big", (4, 0.01, 0, 0)),
    (s_curve, 12, "small", (16, 2.2, 0.25, 0.005)),
    (s_curve, 12, "big", (18, 2.0, 0.19, 0.015)),
    (speed_ramp, 12, "small", (21, 4.4, 0.05, 0.008)),
    (blended_arcs, 12, "small", (None, 1.5, 0.65, 0.004)),
    (blended_arcs, 12, "big", (None, 1.5, 0.73, 0.02)),
]
COLUMNS: list[tuple[str, Commands, bool]] = [
    ("no slip", no_slip_commands, True),
    ("naive", naive_commands, True),
    ("path rule", path_commands, True),
    ("present motion", path_commands, False),
]


def missed(size: Size, degrees: float, path: Path, commands_of: Commands, *, remember: bool) -> float:
    """Largest distance from a path in percent of its length; infinite where there are no commands."""
    ground = scene(size.vehicle, size.terrain, STANDARD_GRAVITY, math.radians(degrees), remember=remember)
    commands = commands_of(ground, path)
    if not commands.residual.max() <= 1e-8:
        return math.inf
    simulation, _ = follow(ground, commands, Feedback.NONE, start_on(commands), 1e-6, steady_start=True)
    places = simulation.steps["pose"][: simulation.count]
    return 100.0 * float(deviation(path, places[..., 0].ravel(), places[..., 1].ravel()).max()) / path.length


def main() -> None:
    """Print the table."""
    print_machine()
    print(f"largest distance from the path in % of its length, for radii of {FACTORS} times the vehicle's")
    print(
        f"{'row':26}{'commands':16}{'known':>7}   {'ours':>24}   ratio of the middle one; where it is within {MARGIN}"
    )
    for shape, degrees, name, figures in ROWS:
        size = SIZES[name]
        for (commands, commands_of, remember), figure in zip(COLUMNS, figures, strict=True):
            paths = [shape(size, factor * size.radius) for factor in FACTORS]
            found = [missed(size, degrees, path, commands_of, remember=remember) for path in paths]
            ours = "".join(f"{value:8.4f}" for value in found)
            note = ""
            if figure is not None:
                ratios = np.array(found) / max(figure, LEAST_FIGURE)
                note = f"{ratios[1]:6.2f}   {''.join('y' if ratio <= MARGIN else 'n' for ratio in ratios)}"
            print(
                f"{shape.__name__} {degrees:g} deg {name:8}".ljust(26) + f"{commands:16}{figure!s:>7}   {ours}   {note}"
            )


if __name__ == "__main__":
    main()
