import math

import numpy as np
import pytest
from simulation.driving import State, drive, slope_scene

from trackctl.simulation.graded_quadrature import graded_rule
from trackctl.simulation.vehicle_rates import vehicle_rates


@pytest.mark.parametrize("width", np.geomspace(1e-6, 3.0, 13))
def test_kinks_and_near_singularities_at_an_end(width):
    """Closed forms of what the ground's stress looks like at the ends of a stretch."""
    rule = graded_rule()
    distance = np.hypot(rule.nodes, width)
    assert rule.weights @ distance == pytest.approx(
        0.5 * (math.hypot(1.0, width) + width**2 * math.asinh(1.0 / width)), abs=1e-9
    )
    assert rule.weights @ (width / distance) == pytest.approx(width * math.asinh(1.0 / width), abs=2e-6)
    assert rule.weights @ (rule.nodes / distance) == pytest.approx(math.hypot(1.0, width) - width, abs=2e-6)
    layer = -np.expm1(-rule.nodes / width)
    assert rule.weights @ layer == pytest.approx(1.0 + width * math.expm1(-1.0 / width), abs=2e-6)


@pytest.mark.parametrize("duration", [0.5, 1.5, 1.93, 2.5, 4.0])
def test_forces_of_a_turn_with_memory_need_no_more_nodes(duration):
    """Against 1000 nodes a stretch, where a track slips by little and shoes come back over their points of entry."""
    ground = slope_scene(12, uphill_yaw=1.0)
    simulation, _ = drive(ground, 0.3, 0.5, duration, State(1.0, 2.0, 0.5))
    run, rates = simulation.run[0], []
    for rule in (ground.rule, graded_rule(1000)):
        result = np.zeros(3)
        scene, velocity, rate = ground._replace(rule=rule), run["velocity"], run["rate"]
        vehicle_rates(scene, run["pose"], velocity, rate, 0.3, 0.5, simulation.memory, simulation.entries, result)
        rates.append(result / ground.model.gravity)
    assert rates[0] == pytest.approx(rates[1], abs=1e-5)
