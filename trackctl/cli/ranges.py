"""Ranges, lists and steps as typed on the command line."""

from __future__ import annotations

import math
from itertools import pairwise

from trackctl.errors import UsageError

MOST_SLOPES = 1000


def number(text: str, option: str, allowed: str) -> float:
    """A finite number, or a `UsageError`."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise UsageError(option, text, allowed)
    return value


def range_of(text: str, option: str) -> tuple[float, float]:
    """``MIN:MAX``, or one number for both."""
    allowed = "MIN:MAX, two numbers"
    parts = text.split(":")
    if len(parts) > 2:
        raise UsageError(option, text, allowed)
    low, high = number(parts[0], option, allowed), number(parts[-1], option, allowed)
    if low > high:
        raise UsageError(option, text, "MIN:MAX with MIN <= MAX")
    return low, high


def list_of(text: str, option: str, most: int = MOST_SLOPES) -> list[float]:
    """``A``, ``A,B,C`` or ``MIN:MAX:STEP`` of at most so many values, ascending."""
    allowed = "a number, a list A,B,C in ascending order, or MIN:MAX:STEP"
    if ":" not in text:
        values = [number(part, option, allowed) for part in text.split(",")]
    else:
        parts = [number(part, option, allowed) for part in text.split(":")]
        if len(parts) != 3 or parts[2] <= 0.0 or parts[1] < parts[0]:
            raise UsageError(option, text, allowed)
        steps = (parts[1] - parts[0]) / parts[2] + 1e-9
        if steps >= most:
            raise UsageError(option, text, f"at most {most} values")
        values = [parts[0] + k * parts[2] for k in range(math.floor(steps) + 1)]
    if any(second <= first for first, second in pairwise(values)):
        raise UsageError(option, text, allowed)
    return values


def named_numbers(text: str, names: tuple[str, ...], option: str) -> dict[str, float]:
    """``name=NUMBER,...`` with each of the names once."""
    allowed = ",".join(f"{name}=NUMBER" for name in names)
    found: dict[str, float] = {}
    for part in text.split(","):
        name, separator, value = part.partition("=")
        if not separator or name.strip() not in names or name.strip() in found:
            raise UsageError(option, text, allowed)
        found[name.strip()] = number(value, option, allowed)
    if len(found) != len(names):
        raise UsageError(option, text, allowed)
    return found


def given_ranges(
    velocity: str | None, radius: str | None, heading_deg: str | None
) -> dict[str, tuple[float, float] | None]:
    """The ranges typed by the names of `ranges_within`, in m/s, m and rad; None where none was typed."""
    heading = None if heading_deg is None else range_of(heading_deg, "--heading-deg")
    return {
        "velocity": None if velocity is None else range_of(velocity, "--velocity-mps"),
        "radius": None if radius is None else range_of(radius, "--radius-m"),
        "heading": None if heading is None else (math.radians(heading[0]), math.radians(heading[1])),
    }
