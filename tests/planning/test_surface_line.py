import math

import numpy as np
import pytest

from trackctl.planning.blending import Line
from trackctl.planning.elevation import Elevation, fitted_slopes
from trackctl.planning.slope_field import plane_slope
from trackctl.planning.surface_line import on_ground, on_map, surface_line

SLOPE, UPHILL = math.radians(20.0), 0.7


def bend():
    """A line that turns left, sampled."""
    line = Line(False, (1.0, 2.0, 0.1), np.array([0.0, 2.0, 6.0]), np.array([0.0, 0.4, 0.2]))
    s = np.linspace(0.0, 6.0, 1201)
    return s, line.at(s), line.curvature_at(s)


def tilted_plane():
    """An elevation grid that is a plane: x and y are horizontal there."""
    centres = np.linspace(-5.0, 15.0, 201)
    rise = math.tan(SLOPE) * (math.cos(UPHILL) * centres + math.sin(UPHILL) * centres[:, None])
    return fitted_slopes(Elevation(rise, 0.1, 0.1, -5.0, -5.0, "plane"), 0.3)


def test_in_one_plane_nothing_changes():
    s, pose, curvature = bend()
    line = surface_line(plane_slope(SLOPE, UPHILL), s, pose, curvature)
    assert line.arc_length is s
    assert line.curvature is curvature
    assert line.slope == pytest.approx(SLOPE)
    assert line.uphill == pytest.approx(UPHILL)


def test_a_map_of_a_tilted_plane_is_stretched_uphill():
    s, pose, curvature = bend()
    line = surface_line(tilted_plane(), s, pose, curvature)
    x, y, _ = pose
    up, across = math.cos(UPHILL) * x + math.sin(UPHILL) * y, math.cos(UPHILL) * y - math.sin(UPHILL) * x
    up = up / math.cos(SLOPE)
    length = np.concatenate(([0.0], np.cumsum(np.hypot(np.diff(up), np.diff(across)))))
    # Chords in place of arcs of 5 mm, and trapezia in place of integrals.
    assert line.arc_length == pytest.approx(length, abs=1e-5)
    direction = np.unwrap(np.arctan2(np.gradient(across, length), np.gradient(up, length)))
    inner = slice(3, -3)
    assert (line.direction - line.uphill)[inner] == pytest.approx(direction[inner], abs=1e-4)
    bent = np.gradient(direction, length)
    assert line.curvature[inner] == pytest.approx(bent[inner], abs=2e-3)
    assert line.slope == pytest.approx(SLOPE, abs=1e-9)


def test_up_slope_stands_still_in_an_unrolled_plane():
    s, pose, curvature = bend()
    line = surface_line(tilted_plane(), s, pose, curvature)
    assert np.ptp(line.uphill) < 1e-4


def test_angles_on_the_map_and_on_the_ground():
    angle = np.linspace(-3.0, 3.0, 13)
    slope = np.full_like(angle, SLOPE)
    assert on_map(on_ground(angle, slope), slope) == pytest.approx(angle, abs=1e-14)
    assert on_ground(np.array([0.25 * math.pi]), slope[:1])[0] == pytest.approx(math.atan(math.cos(SLOPE)))
