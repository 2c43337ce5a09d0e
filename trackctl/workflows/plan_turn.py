"""Turns on the spot as parts of a plan."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from trackctl.planning.clearance import first_hit
from trackctl.simulation.spot_turn import SpotTurn, spot_rate, spot_turn
from trackctl.workflows.plan_model import DriveModel, UndrivableError, checked_step

Array = NDArray[np.float64]
Pose = tuple[float, float, float]


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

    pose: Pose
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


def driven_turn(model: DriveModel, pose: Pose, angle: float) -> DrivenTurn:
    """A turn on the spot from a pose, x, y [m] and yaw [rad], by an angle. [rad]"""
    if model.spot is None:
        raise UndrivableError("it turns on the spot")
    turn = spot_turn(model.ahead, model.spot, angle)
    if turn is None:
        raise UndrivableError(f"its tracks spin in a turn on the spot by {math.degrees(angle):.3g} deg")
    driven = DrivenTurn(pose, model.field.level_uphill, model.vehicle.track_gauge, turn)
    if first_hit(model.obstacles, *finely_turned(model, driven)) is not None:
        raise UndrivableError(f"it touches an obstacle turning on the spot at ({pose[0]:.2f}, {pose[1]:.2f}) m")
    return driven


def finely_turned(model: DriveModel, driven: DrivenTurn) -> tuple[Array, Array, Array]:
    """x, y [m] and yaw [rad] of a turn, in steps as of `checked_step`."""
    x, y, yaw = driven.poses
    step = checked_step(model.obstacles) / model.obstacles.footprint.reach
    fine = np.linspace(yaw[0], yaw[-1], math.ceil(abs(yaw[-1] - yaw[0]) / step) + 2)
    return np.full_like(fine, x[0]), np.full_like(fine, y[0]), fine


def pivot_speed(model: DriveModel) -> float:
    """Rate of turns on the spot as a search takes them; 0: cannot. [rad/s]"""
    return 0.0 if model.spot is None else spot_rate(model.ahead.model, model.spot)
