"""Unit suffixes of file keys, CSV headers and options, and their factors to SI.

The suffix is what follows the last underscore: ``heading_deg`` is ``heading`` in ``deg``. Inside the package
values are in SI and names carry no suffix; `files` and `cli` convert here, once.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, TypeVar

from trackctl.errors import UsageError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Scalable = TypeVar("Scalable", float, "NDArray[np.float64]")

#: Units of each quantity, the SI unit first, with the factor to it.
QUANTITIES: dict[str, dict[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3, "min": 60.0, "h": 3600.0},
    "length": {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "km": 1e3},
    "angle": {"rad": 1.0, "deg": math.pi / 180.0, "mrad": 1e-3},
    "curvature": {"1pm": 1.0, "1pkm": 1e-3},
    "speed": {"mps": 1.0, "mmps": 1e-3, "cmps": 1e-2, "kmph": 1.0 / 3.6},
    "acceleration": {"mps2": 1.0, "mmps2": 1e-3, "cmps2": 1e-2},
    "angular rate": {"radps": 1.0, "degps": math.pi / 180.0, "rpm": math.pi / 30.0},
    "angular acceleration": {"radps2": 1.0, "degps2": math.pi / 180.0},
    "mass": {"kg": 1.0, "g": 1e-3, "t": 1e3},
    "inertia": {"kgm2": 1.0, "gm2": 1e-3, "tm2": 1e3},
    "force": {"n": 1.0, "kn": 1e3},
    "moment": {"nm": 1.0, "knm": 1e3},
    "pressure": {"pa": 1.0, "kpa": 1e3, "mpa": 1e6},
}
_UNITS_BESIDE = {suffix: units for units in QUANTITIES.values() for suffix in units}


def split_suffix(key: str) -> tuple[str, str]:
    """Name and unit suffix of a key; the suffix is empty where the last part is no known unit."""
    name, _, suffix = key.rpartition("_")
    return (name, suffix) if name and suffix in _UNITS_BESIDE else (key, "")


def accepted_keys(key: str) -> dict[str, float]:
    """The keys that may stand for one, itself first, each with its factor to SI.

    ``heading_deg`` gives ``heading_deg``, ``heading_rad``, ``heading_mrad``; a key without a unit, itself.
    """
    name, suffix = split_suffix(key)
    if not suffix:
        return {key: 1.0}
    return {f"{name}_{unit}": _UNITS_BESIDE[unit][unit] for unit in (suffix, *_UNITS_BESIDE[suffix])}


def factor_to_si(key: str, expected: str | None = None) -> float:
    """Factor from the unit of a key to SI.

    Parameters
    ----------
    key
        A file key or CSV header such as ``heading_deg``.
    expected
        The key that it stands for, such as ``heading_rad``; by default itself.

    Raises
    ------
    UsageError
        If `key` is not `expected` in some unit of the same quantity; names the allowed keys.
    """
    accepted = accepted_keys(expected or key)
    if key not in accepted:
        raise UsageError("unit", key, ", ".join(accepted))
    return accepted[key]


def to_si(key: str, value: Scalable, expected: str | None = None) -> Scalable:
    """A number or array in SI, converted from the unit in its key; see `factor_to_si`."""
    return value * factor_to_si(key, expected)
