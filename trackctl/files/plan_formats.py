"""A plan in the forms other than CSV: JSON, and the YAML of a ROS nav_msgs/Path."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import TextIO

from trackctl.files.csv_writer import Column

#: Frame of a map in ROS.
FRAME = "map"
NANOSECONDS = 10**9


def write_json(stream: TextIO, columns: Mapping[str, Column]) -> None:
    """Write columns as lists by their headers, one JSON object."""
    json.dump(
        {name: column if isinstance(column, list) else [*map(plain, column)] for name, column in columns.items()},
        stream,
    )
    stream.write("\n")


def plain(value: object) -> object:
    """A number of numpy as one of Python; no number becomes null."""
    item = getattr(value, "item", lambda: value)()
    return None if isinstance(item, float) and math.isnan(item) else item


def write_ros_path(stream: TextIO, columns: Mapping[str, Column]) -> None:
    """Write `time_s`, `x_m`, `y_m` and `yaw_rad` as the YAML of a nav_msgs/Path, in the frame `map`, from time 0.

    As ``ros2 topic pub --once /plan nav_msgs/msg/Path "$(cat FILE)"`` takes it.
    """
    stream.write(f"header:\n  stamp: {{sec: 0, nanosec: 0}}\n  frame_id: {FRAME}\nposes:\n")
    for time, x, y, yaw in zip(*(columns[name] for name in ("time_s", "x_m", "y_m", "yaw_rad")), strict=True):
        seconds, nanoseconds = divmod(round(float(time) * NANOSECONDS), NANOSECONDS)
        half = 0.5 * float(yaw)
        stream.write(
            f"- header:\n    stamp: {{sec: {seconds}, nanosec: {nanoseconds}}}\n    frame_id: {FRAME}\n"
            f"  pose:\n    position: {{x: {float(x):.9f}, y: {float(y):.9f}, z: 0.0}}\n"
            f"    orientation: {{x: 0.0, y: 0.0, z: {math.sin(half):.12f}, w: {math.cos(half):.12f}}}\n"
        )
