"""Settings of the whole suite."""

from __future__ import annotations

from hypothesis import settings

# A kernel's first call compiles it; and a failure should be the same tomorrow.
settings.register_profile("trackctl", deadline=None, derandomize=True)
settings.load_profile("trackctl")
