"""Turns on the spot as parts of a plan."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from trackctl.simulation.spot_turn import SpotTurn

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class DrivenTurn:
    """A turn on the spot with its commands.

    Attributes
    ----------
    pose
        x, y [m] and yaw [rad] at its start.
    uphill
        What counts as the direction of up-slope on level ground. [rad]
    gauge
        Of the tracks. [m]
    turn
        Commands, and the turn that they make.
    """

    pose: tuple[float, float, float]
    uphill: float
    gauge: float
    turn: SpotTurn

    @property
    def poses(self) -> tuple[Array, Array, Array]:
        """x, y [m] and yaw [rad] over time."""
        x, y, yaw = self.pose
        return np.full_like(self.turn.yaw, x), np.full_like(self.turn.yaw, y), yaw + self.turn.yaw

    @property
    def without_slip(self) -> DrivenTurn:
        """The same with commands that would make the turn without slip."""
        speed = 0.5 * self.gauge * self.turn.yaw_rate
        return replace(self, turn=replace(self.turn, track_speed_left=-speed, track_speed_right=speed))
