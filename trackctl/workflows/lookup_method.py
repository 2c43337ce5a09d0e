"""Ways to answer a query of a table; on its own, so that the command line can name them quickly."""

from __future__ import annotations

from enum import StrEnum


class LookupMethod(StrEnum):
    """Interpolation between a table's nodes, or the model solved at the point."""

    MLS = "mls"
    LINEAR = "linear"
    CUBIC = "cubic"
    EXACT = "exact"
