"""Settings of the whole suite."""

from __future__ import annotations

import pytest
from hypothesis import settings

# A kernel's first call compiles it; and a failure should be the same tomorrow.
settings.register_profile("trackctl", deadline=None, derandomize=True)
settings.load_profile("trackctl")

#: Cases that the solver still decides wrongly or leaves undecided, as brute force shows: steep slopes, islands, a hair
#: beyond a fold. Cells of shipped vehicles are affected, too. Each must fail until it is mended, and then leaves it.
KNOWN_DEFECTS = {
    "test_hard_columns_are_decided_as_the_oracle_decides[slippery, braking and driving at the limit]",
    "lut/test_column.py::test_hard_columns_are_decided_as_the_oracle_decides[too steep to stand on, to the right]",
    "lut/test_column.py::test_hard_columns_are_decided_as_the_oracle_decides[too steep to stand on]",
    "lut/test_column.py::test_hard_columns_are_decided_as_the_oracle_decides[wide turn]",
    "lut/test_column.py::test_no_swarm_finds_what_a_column_misses",
    "lut/test_column.py::test_random_columns_are_decided",
    "lut/test_column.py::test_turn_about_the_inner_track_is_outside_the_model",
    "lut/test_point.py::test_each_reason_for_no_answer[turn about the inner track-no-slip start]",
    "lut/test_point.py::test_each_reason_for_no_answer[turn about the inner track-swarm]",
    "lut/test_point.py::test_hard_points_are_decided_rightly[a hair beyond the fold-no-slip start]",
    "lut/test_point.py::test_hard_points_are_decided_rightly[a hair beyond the fold-swarm]",
    "lut/test_point.py::test_hard_points_are_decided_rightly[no root, and none without the turn's speed-no-slip start]",
    "lut/test_point.py::test_hard_points_are_decided_rightly[no root, and none without the turn's speed-swarm]",
    "lut/test_point.py::test_hard_points_are_decided_rightly[tall and off centre-swarm]",
    "lut/test_point.py::test_hard_points_are_decided_rightly[three roots at high speed-swarm]",
    "lut/test_point.py::test_hard_points_are_decided_rightly[too steep to stand on, held by its turn-swarm]",
    "lut/test_point.py::test_random_points_are_decided_as_the_oracle_decides[no-slip start]",
    "lut/test_point.py::test_random_points_are_decided_as_the_oracle_decides[swarm]",
    "lut/test_point.py::test_swarm_and_no_slip_start_agree_on_many_random_points",
}


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Expect the known defects to fail."""
    for item in items:
        if any(item.nodeid.endswith(defect) for defect in KNOWN_DEFECTS):
            item.add_marker(pytest.mark.xfail(reason="known defect of the solver", strict=True))
