"""Choices of `plan`; on their own, so that the command line can name them quickly."""

from __future__ import annotations

from enum import StrEnum


class PlanCost(StrEnum):
    """What a plan is to have the least of."""

    TIME = "time"
    LENGTH = "length"
    ENERGY = "energy"
    SLIP = "slip"


class PlanFormat(StrEnum):
    """Form of the output: a CSV table, its columns as one JSON object, or nav_msgs/Path in YAML."""

    CSV = "csv"
    JSON = "json"
    ROS = "ros"
