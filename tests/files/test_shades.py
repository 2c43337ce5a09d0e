import math

import numpy as np
import pytest

from trackctl.files.map_image import GreyImage
from trackctl.files.shades import MapMode, Shades, occupancy_cells

SHADES = np.arange(256)


def occupancy(mode, occupied=0.65, free=0.196, *, negate=False, clear=False):
    """Occupancy of all shades, each a pixel."""
    image = GreyImage(SHADES.astype(np.uint8)[None, :], np.full((1, 256), clear))
    return occupancy_cells(image, Shades(mode, negate, occupied, free))[0]


def by_the_rules(mode, occupied, free, negate):
    """map_server's rules, shade by shade in Python's numbers."""
    for shade in range(256):
        p = shade / 255 if negate else 1.0 - shade / 255
        if mode is MapMode.RAW:
            yield shade if shade <= 100 else -1
        elif p >= occupied:
            yield 100
        elif p <= free:
            yield 0
        elif mode is MapMode.TRINARY:
            yield -1
        else:
            yield math.floor(100.0 * (p - free) / (occupied - free) + 0.5)


@pytest.mark.parametrize("mode", MapMode)
@pytest.mark.parametrize("negate", [False, True])
@pytest.mark.parametrize(("occupied", "free"), [(0.65, 0.196), (0.65, 0.25), (1.0, 0.0), (0.501, 0.499)])
def test_all_shades_by_the_rules(mode, negate, occupied, free):
    found = occupancy(mode, occupied, free, negate=negate)
    assert found.tolist() == list(by_the_rules(mode, occupied, free, negate))


def test_the_usual_grey_is_unknown_or_free_by_the_threshold():
    assert occupancy(MapMode.TRINARY, free=0.196)[205] == -1
    assert occupancy(MapMode.TRINARY, free=0.25)[205] == 0


def test_thresholds_are_inclusive_to_the_last_bit():
    """204/255 is 0.8 and 51/255 is 0.2, also in floating point."""
    assert occupancy(MapMode.TRINARY, 0.8, 0.2)[[50, 51, 52, 203, 204, 205]].tolist() == [100, 100, -1, -1, 0, 0]
    negated = occupancy(MapMode.TRINARY, 0.8, 0.2, negate=True)
    assert negated[[50, 51, 52, 203, 204, 205]].tolist() == [0, 0, -1, -1, 100, 100]


def test_scale_goes_evenly_from_free_to_occupied():
    found = occupancy(MapMode.SCALE, 1.0, 0.0)
    assert found[[255, 204, 153, 51, 0]].tolist() == [0, 20, 40, 80, 100]


def test_equal_thresholds_leave_nothing_between():
    assert set(occupancy(MapMode.SCALE, 0.5, 0.5).tolist()) == {0, 100}


@pytest.mark.parametrize("mode", MapMode)
def test_clear_pixels_are_unknown_but_in_raw(mode):
    opaque, clear = occupancy(mode), occupancy(mode, clear=True)
    assert clear.tolist() == (opaque.tolist() if mode is MapMode.RAW else [-1] * 256)


def test_the_first_row_of_an_image_is_the_top():
    image = GreyImage(np.array([[0, 255], [255, 255], [255, 0]], np.uint8), np.zeros((3, 2), np.bool_))
    cells = occupancy_cells(image, Shades(MapMode.TRINARY, False, 0.65, 0.196))
    assert cells.tolist() == [[0, 100], [0, 0], [100, 0]]
