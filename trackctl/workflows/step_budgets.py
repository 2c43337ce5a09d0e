"""How many cells a table may have; on its own, so that the command line can name it quickly."""

from __future__ import annotations

DEFAULT_BUDGET = 200_000
#: Where a tolerance is to be met.
LARGEST_REFINED = 5_000_000
