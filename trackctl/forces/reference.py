"""A path with a speed along it: what the vehicle is asked to do."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackctl.forces.model import ReferencePoints
from trackctl.forces.speed_profile import SpeedProfile
from trackctl.geometry.path import Path

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """A path and the speed along it."""

    path: Path
    speed: SpeedProfile

    def at(self, arc_length: Array) -> ReferencePoints:
        """Path and speed at arc lengths, shape (n,); from the right where they jump."""
        points = self.path.at(arc_length)
        return ReferencePoints(
            x=points.x,
            y=points.y,
            tangent=points.tangent,
            curvature=points.curvature,
            curvature_gradient=points.curvature_gradient,
            squared_speed=self.speed.squared(arc_length),
            acceleration=self.speed.acceleration(arc_length),
        )
