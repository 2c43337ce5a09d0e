"""Logs of vehicles that the package simulates on level ground: no model of the slip filter makes their motion."""

from __future__ import annotations

import numpy as np
from simulation.driving import drive_along, slope_scene
from slip_simulation import log

from trackctl.files.profile_yaml import load_terrain, load_vehicle
from trackctl.simulation.motion import sample

HOLD, RAMP, INTERVAL = 5.5, 0.5, 0.1


def shear_log(vehicle, terrain, fastest, seed=0, commands=40, read_over_true=1.0):
    """Rows of a log under random track speeds, and the true ICRs, shape (n, 3), NaN where the vehicle hardly turns.

    The encoders of the log read the track speeds in a wrong scale.
    """
    profile = load_vehicle(vehicle)
    start = (HOLD + RAMP) * np.arange(commands)
    time = np.stack((start, start + HOLD), axis=1).ravel()
    left, right = np.random.default_rng(seed).uniform(0.15 * fastest, fastest, (2, commands)).repeat(2, axis=1)
    simulation, _ = drive_along(slope_scene(0.0, profile, load_terrain(terrain)), time, left, right)
    motion = sample(simulation, profile.mass, np.arange(0.0, time[-1], INTERVAL))
    speeds = np.stack((motion.track_speed_left, motion.track_speed_right))
    turn = np.where(np.abs(motion.yaw_rate) > 0.1, motion.yaw_rate, np.nan)
    icrs = np.stack([*(motion.forward_velocity - speeds), -motion.lateral_velocity], axis=1) / turn[:, None]
    poses = np.column_stack((motion.x, motion.y, motion.yaw))
    return log(motion.time, *(read_over_true * speeds), poses, seed), icrs
