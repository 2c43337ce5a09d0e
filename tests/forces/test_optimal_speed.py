import math
from dataclasses import replace

import numpy as np
import pytest
from force_cases import CIRCLE, MODEL, solved, straight

from trackctl.errors import NoAnswerError
from trackctl.forces.nominal import limits
from trackctl.forces.optimal_speed import SpeedLimits, optimal_speed
from trackctl.geometry.clothoid_path import arc, clothoid_arc_clothoid


def checked(path, bounds, model=MODEL):
    """Forces at the optimal speed, which are feasible and within the bounds."""
    speed = optimal_speed(model, path, bounds)
    reference, _, forces = solved(path, speed, model)
    assert limits(model, reference, forces).feasible.all()
    assert forces.speed[[0, -1]] == pytest.approx(bounds.ends, abs=1e-6)
    assert forces.speed.max() <= bounds.top * (1.0 + 1e-9)
    assert abs(speed.acceleration(forces.arc_length)).max() <= bounds.acceleration * 1.02
    return forces


def test_a_circle_is_driven_at_its_closed_form_limit():
    forces = checked(arc(5.0, 4.0 * math.pi), SpeedLimits(2.0, 10.0, 2.0))
    limit = 6.5433
    assert 0.995 * limit < forces.speed.max() < limit


def test_without_friction_in_the_way_acceleration_decides():
    bounds = SpeedLimits(0.5, 10.0, 1.0)
    forces = checked(straight(40.0), bounds)
    # to the middle and back at full acceleration, but for the rise of it
    fastest = 2.0 * (math.sqrt(0.5**2 + 40.0) - 0.5)
    assert fastest < forces.time[-1] < 1.1 * fastest


def test_top_speed_and_drive_decide():
    assert checked(CIRCLE, SpeedLimits(0.2, 3.0, 1.0)).speed.max() == pytest.approx(3.0)
    path = clothoid_arc_clothoid(8.0, 8.0, 6.0, 6.0)
    strong, weak = (
        checked(path, SpeedLimits(0.2, 10.0, 1.0), replace(MODEL, max_track_force=force)) for force in (9000.0, 6500.0)
    )
    assert weak.time[-1] > 1.02 * strong.time[-1]


def test_no_speed_helps_where_slow_turning_is_too_hard():
    with pytest.raises(NoAnswerError, match="no speed along this path"):
        optimal_speed(replace(MODEL, longitudinal_friction=0.5), CIRCLE, SpeedLimits(0.2, 3.0, 1.0))


def test_it_beats_the_fastest_feasible_smooth_profile():
    from trackctl.forces import speed_profile

    path = clothoid_arc_clothoid(8.0, 8.0, 6.0, 6.0)
    best = checked(path, SpeedLimits(0.2, 10.0, 2.0)).time[-1]
    times = []
    for peak in np.arange(1.0, 8.0, 0.25):
        reference, _, forces = solved(path, speed_profile.smooth(path.length, 0.2, peak))
        if limits(MODEL, reference, forces).feasible.all():
            times.append(forces.time[-1])
    assert best < 0.8 * min(times)
