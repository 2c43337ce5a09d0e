"""Choices of `simulate`; on their own, so that the command line can name them quickly."""

from __future__ import annotations

from enum import StrEnum


class Steering(StrEnum):
    """How a path becomes track speeds: the path rule, a table read at the path's curvature, or as if without slip."""

    PATH = "path"
    TABLE = "table"
    NO_SLIP = "no-slip"


class Measured(StrEnum):
    """What is measured and fed back to the track speeds."""

    NONE = "none"
    HEADING = "heading"
    POSE = "pose"
