"""Choices of `forces`, apart from its modules so that the command line loads quickly."""

from __future__ import annotations

from enum import StrEnum


class SpeedKind(StrEnum):
    """How the speed changes along the path."""

    CONSTANT = "constant"
    TRIANGULAR = "triangular"
    TRAPEZOIDAL = "trapezoidal"
    SMOOTH = "smooth"
    OPTIMAL = "optimal"


class Basis(StrEnum):
    """What the yaw along the path is made of: sideslip a spline, or yaw gradient a polynomial."""

    SPLINE = "spline"
    POLYNOMIAL = "polynomial"
