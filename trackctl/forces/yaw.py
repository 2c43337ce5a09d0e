"""How the vehicle turns along its path, as the solvers of the constraint give it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from trackctl.forces.model import Array, ReferencePoints


@dataclass(frozen=True, slots=True, eq=False)
class YawMotion:
    """Yaw at points of the path, arrays of shape (n,).

    Attributes
    ----------
    sideslip
        Path tangent minus yaw. [rad]
    gradient, gradient_change
        theta_s and its derivative along the path. [1/m], [1/m2]
    """

    sideslip: Array
    gradient: Array
    gradient_change: Array


class Yaw(Protocol):
    """A solution of the constraint."""

    def at(self, arc_length: Array, reference: ReferencePoints) -> YawMotion:
        """Yaw at arc lengths of which the reference is known, shape (n,)."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class YawSolution:
    """A yaw and how it was found.

    Attributes
    ----------
    yaw
        Of least squared residual among its kind.
    mesh
        Arc lengths between which it is smooth. [m]
    breaks
        Arc lengths where its second derivative, and with it dQ, jumps; jumps of the reference are not among them. [m]
    iterations
        Of Gauss and Newton's method, on the last mesh.
    """

    yaw: Yaw
    mesh: Array
    breaks: Array
    iterations: int
