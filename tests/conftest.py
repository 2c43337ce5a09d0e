"""Settings of the whole suite."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# A kernel's first call compiles it, other programs want the processor, too, and a failure should be the same tomorrow.
# A fixture serves all examples of its test: what one writes, the next writes over.
settings.register_profile(
    "trackctl",
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
settings.load_profile("trackctl")

DATA_VARIABLE = "TRACKCTL_TEST_DATA"


@pytest.fixture(scope="session")
def data_of_others():
    """Finds a file that others made, by its name below their folder; without it the test is skipped."""
    beside_the_project = Path(__file__).parents[2] / "shared" / "data"
    folder = Path(os.environ.get(DATA_VARIABLE, beside_the_project)).resolve()

    def find(name):
        if not (folder / name).is_file():
            pytest.skip(f"{name}, made by others, is not in {folder} (${DATA_VARIABLE})")
        return folder / name

    return find
