"""A small table of made-up numbers, with every status in it."""

import numpy as np

from trackctl.files.profile_yaml import load_terrain, load_vehicle
from trackctl.lut.axes import FULL_CIRCLE, Axes
from trackctl.lut.table import VARIABLES, Status, Table

VEHICLE, TERRAIN = load_vehicle("utv-61cm"), load_terrain("asphalt")
GRAVITY = 9.80665
ATTRIBUTES = {
    "history": "trackctl compute-lut --budget 72",
    "created": "2024-01-01T00:00:00Z",
    "seed": 3,
    "tolerance": 0.5,
    "steps": np.array([0.5, 0.25, 1.0]),
    "seeding": "continuation",
}


def example_axes(slopes=2, velocities=3, curvatures=5, headings=4):
    """Axes of given lengths."""
    return Axes(
        np.linspace(0.0, 0.3, slopes),
        np.linspace(0.5, 2.0, velocities),
        np.arange(curvatures) - float(curvatures // 2),
        np.arange(headings) * FULL_CIRCLE / headings,
        heading_is_periodic=True,
    )


def example_table(**lengths):
    """Random values; the first cells are without an answer, one of each kind."""
    axes = example_axes(**lengths)
    rng = np.random.default_rng(0)
    values = {name: rng.normal(size=axes.shape) for name in VARIABLES}
    status = np.zeros(axes.shape, dtype=np.uint8)
    status.flat[1 : len(Status)] = list(Status)[1:]
    for name, array in values.items():
        if name != "residual":
            array[status != Status.CONVERGED] = np.nan
    return Table(axes, values, status, VEHICLE, TERRAIN, GRAVITY, ATTRIBUTES)
