"""Ground whose slope changes on the way of a vehicle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackctl.simulation.vehicle_rates import Scene

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Slopes:
    """Slope of the ground over time, arrays of shape (n,), linear between samples.

    Attributes
    ----------
    time
        Ascending. [s]
    slope
        Angle. [rad]
    uphill_yaw
        Direction of up-slope, without jumps. [rad]
    """

    time: Array
    slope: Array
    uphill_yaw: Array

    def scene_at(self, scene: Scene, time: float) -> Scene:
        """The scene with the slope at a time."""
        slope, uphill_yaw = (float(np.interp(time, self.time, each)) for each in (self.slope, self.uphill_yaw))
        return scene._replace(slope=slope, uphill_yaw=uphill_yaw)
