"""Nominal track forces tried out: the vehicle driven by them, and how far it leaves its path."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from trackctl.forces.model import SLOWEST, YAW_RATE_SCALE, ForceModel
from trackctl.forces.nominal import NominalForces, nominal_forces
from trackctl.forces.reference import Reference
from trackctl.forces.yaw import YawSolution
from trackctl.simulation.track_force_drive import BodyState, ForceHistory, TrackForceVehicle, drive

Array = NDArray[np.float64]

#: Quantities of a simulated motion that a nominal one has, too.
MOTION = ("x", "y", "yaw", "yaw_rate", "speed", "sideslip")
#: Error of the forces between two samples, as a share of the load.
TOLERANCE = 1e-7
#: Halvings between samples to that end, and the shortest time between two; friction turns round in less than 1e-4 s.
HALVINGS = 40
SHORTEST = 1e-7


@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """How far the simulated motion is from the nominal one at the same nominal time, arrays of shape (n,).

    Attributes
    ----------
    arc_length
        Of the nominal motion at that time. [m]
    x, y, yaw
        Simulated minus nominal, as all that follow. [m], [rad]
    yaw_rate, speed, sideslip
        [rad/s], [m/s], [rad]
    """

    arc_length: Array
    x: Array
    y: Array
    yaw: Array
    yaw_rate: Array
    speed: Array
    sideslip: Array

    @property
    def largest_deviation(self) -> float:
        """Largest distance of the simulated mass centre from the path. [m]"""
        return float(np.hypot(self.x, self.y).max())

    def simulated(self, forces: NominalForces) -> dict[str, Array]:
        """The simulated motion at the stations of nominal forces, by the names of its quantities.

        What is interpolated is the small difference from the nominal motion; it is kept before and after the
        simulated part of the path.
        """
        return {
            name: getattr(forces, name) + np.interp(forces.arc_length, self.arc_length, getattr(self, name))
            for name in MOTION
        }


def try_out(model: ForceModel, reference: Reference, solution: YawSolution) -> Trial:
    """Simulate the open loop from the nominal state at the start; from rest, from where it has a speed."""
    parts = sampled_forces(model, reference, solution)
    start, histories, time = parts[0], [], 0.0
    for part in parts:
        histories.append(ForceHistory(time + part.time, part.total, part.difference))
        time += part.time[-1]
    state = BodyState(
        start.x[0],
        start.y[0],
        start.yaw[0],
        start.speed[0] * np.cos(start.sideslip[0]),
        start.speed[0] * np.sin(start.sideslip[0]),
        start.yaw_rate[0],
    )
    driven = drive(vehicle_of(model), state, histories)
    forward, lateral = np.asarray(driven.forward_velocity), np.asarray(driven.lateral_velocity)
    speed, sideslip = np.hypot(forward, lateral), np.arctan2(lateral, forward)
    nominal = {name: np.concatenate([getattr(part, name) for part in parts]) for name in ("arc_length", *MOTION)}
    found = (driven.x, driven.y, driven.yaw, driven.yaw_rate, speed, sideslip)
    off = {name: values - nominal[name] for name, values in zip(MOTION, found, strict=True)}
    return Trial(nominal["arc_length"], **off)


def vehicle_of(model: ForceModel) -> TrackForceVehicle:
    """The same vehicle for the simulation, with friction smoothed alike."""
    return TrackForceVehicle(
        mass=model.mass,
        yaw_inertia=model.yaw_inertia,
        gauge=model.gauge,
        length=model.length,
        cog_height=model.cog_height,
        lateral_friction=model.lateral_friction,
        gravity=model.gravity,
        slope=model.slope,
        uphill_yaw=model.uphill_yaw,
        yaw_rate_scale=YAW_RATE_SCALE,
    )


def sampled_forces(model: ForceModel, reference: Reference, solution: YawSolution) -> list[NominalForces]:
    """Forces on each stretch between two places where they jump, the later one as just before."""
    length = reference.path.length
    edges = moving(reference, np.concatenate((solution.mesh, reference.path.kinks, reference.speed.jumps)))
    jumps = np.concatenate((solution.breaks, reference.path.kinks, reference.path.jumps, reference.speed.jumps))
    inner = jumps[(jumps > edges[0]) & (jumps < min(edges[-1], length))]
    corners = np.unique(np.concatenate((edges[[0, -1]], inner)))
    parts = []
    for low, high in pairwise(corners):
        inside = edges[(edges > low) & (edges < high)]
        stations = np.concatenate(([low], inside, [np.nextafter(high, low)]))
        parts.append(sampled_stretch(model, reference, solution, stations))
    return parts


def moving(reference: Reference, edges: Array) -> Array:
    """Ascending edges, graded towards an end at rest and without the last bit of way there. [m]"""
    edges = np.unique(edges)
    shrinking = 0.5 ** np.arange(1.0, 60.0)
    graded = np.concatenate(
        (edges, edges[0] + (edges[1] - edges[0]) * shrinking, edges[-1] - (edges[-1] - edges[-2]) * shrinking)
    )
    at_rest = np.sqrt(reference.speed.squared(edges[[0, -1]])) < SLOWEST
    if not at_rest.any():
        return edges
    graded = np.unique(graded)
    return np.asarray(graded[np.sqrt(reference.speed.squared(graded)) >= SLOWEST])


def sampled_stretch(model: ForceModel, reference: Reference, solution: YawSolution, stations: Array) -> NominalForces:
    """Forces at stations so close that cubic splines over time meet those in between."""
    for _ in range(HALVINGS):
        middles = 0.5 * (stations[:-1] + stations[1:])
        both = np.sort(np.concatenate((stations, middles)))
        forces = nominal_forces(model, reference, solution.yaw, both)
        values = np.stack((forces.total, forces.difference), axis=1)
        spline = CubicSpline(forces.time[::2], values[::2])
        error = np.abs(spline(forces.time[1::2]) - values[1::2]).max(axis=1)
        coarse = (error > TOLERANCE * model.load) & (np.diff(forces.time[::2]) > SHORTEST)
        if not coarse.any():
            break
        near = coarse.copy()  # splines spread their error to the neighbours
        near[1:] |= coarse[:-1]
        near[:-1] |= coarse[1:]
        stations = np.sort(np.concatenate((stations, middles[near])))
    return forces
