import math

import numpy as np
import pytest

from trackctl.errors import MapError
from trackctl.planning.map_extent import refuse_outside
from trackctl.planning.occupancy import GridFrame, Occupancy
from trackctl.planning.planning_map import PlanningMap


def lying(yaw):
    frame = GridFrame(10, 20, 0.5, 1.0, 2.0, yaw)
    return PlanningMap(file="hall.yaml", occupancy=Occupancy(np.zeros((10, 20), np.int8), frame, "hall.pgm"))


def test_a_pose_on_the_map_passes():
    refuse_outside(lying(0.0), "start", (1.01, 2.01, 0.0))
    refuse_outside(lying(0.0), "start", (10.99, 6.99, 0.0))
    refuse_outside(lying(math.radians(90.0)), "start", (0.9, 11.9, 0.0))


@pytest.mark.parametrize(
    ("yaw", "reach"),
    [
        (0.0, "from (1, 2) to (11, 7) m"),
        (math.radians(90.0), "between the corners (1, 2), (1, 12), (-4, 12), (-4, 2) m"),
    ],
)
def test_a_pose_outside_is_refused_with_the_reach_of_the_map(yaw, reach):
    with pytest.raises(MapError) as error:
        refuse_outside(lying(yaw), "goal", (1.5, 12.5, 0.0))
    assert str(error.value) == f"hall.yaml: goal: (1.5, 12.5) m lies outside the map; allowed: {reach}"
    assert error.value.key == "goal"
