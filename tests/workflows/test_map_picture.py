import numpy as np

from trackctl.planning.occupancy import FREE, OCCUPIED, UNKNOWN, GridFrame, Occupancy
from trackctl.planning.planning_map import PlanningMap, collision_grid, slope_field
from trackctl.profiles.footprint import rectangle
from trackctl.workflows.map_picture import UNKNOWN_LIGHTNESS, map_image


def test_a_map_is_drawn_the_top_row_first_where_it_lies():
    cells = np.array([[FREE, OCCUPIED], [UNKNOWN, FREE], [FREE, FREE]], np.int8)
    known = PlanningMap(file="a", occupancy=Occupancy(cells, GridFrame(3, 2, 0.5, 1.0, -2.0, 2.5), "a.pgm"))
    image = map_image(known, collision_grid(known, slope_field(known, rectangle(1.0, 0.5))))
    assert image.lightness.tolist() == [[1.0, 1.0], [UNKNOWN_LIGHTNESS, 1.0], [1.0, 0.0]]
    assert image.resolution == 0.5
    np.testing.assert_allclose(image.origin, (1.0, -2.0, 2.5))
