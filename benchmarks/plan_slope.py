"""Plans on a 12 deg slope: do the commands drive them, how far off are those without slip, how long does it take?

Run: python benchmarks/plan_slope.py [SEEDS]. The map is 20 m square with ten circles; clearance as planned.
"""

from __future__ import annotations

import math
import sys
import time

import numpy as np

from trackctl.files.profile_yaml import load_terrain, load_vehicle
from trackctl.geometry.circle import Circle
from trackctl.planning.collision import obstacles_of
from trackctl.planning.elevation import Elevation
from trackctl.planning.footprint import footprint_of
from trackctl.planning.planning_map import PlanningMap, collision_grid, slope_field
from trackctl.planning.search import Settings
from trackctl.simulation.following import Feedback
from trackctl.workflows.plan import PlanRequest, plan
from trackctl.workflows.plan_verification import verify

VEHICLE, TERRAIN, GRAVITY = load_vehicle("utv-61cm"), load_terrain("asphalt"), 9.80665
CIRCLES = (
    (17.46, 4.11, 0.81), (7.02, 8.78, 1.16), (14.39, 10.66, 0.42), (14.86, 6.68, 0.66), (3.91, 8.39, 0.76),
    (5.95, 14.27, 0.56), (9.75, 18.14, 0.62), (4.25, 17.96, 0.62), (3.64, 12.04, 0.81), (10.50, 9.30, 0.45),
)  # fmt: skip
CLEARANCE = 0.3
ITERATIONS = 1000


def slope_map() -> PlanningMap:
    return PlanningMap(
        file="circles",
        circles=tuple(Circle(*circle) for circle in CIRCLES),
        bounds=(0.0, 0.0, 20.0, 20.0),
        slope=math.radians(12.0),
        uphill_yaw=0.5 * math.pi,
        start=(1.5, 1.5, 0.0),
        goal=(18.0, 18.0, 0.5 * math.pi),
    )


def hill_map() -> PlanningMap:
    """500 x 500 cells of 0.1 m over hills of up to 22 deg."""
    centres = 0.1 * (np.arange(500) + 0.5)
    height = 1.2 * np.sin(2.0 * np.pi * centres / 18.0) * np.cos(2.0 * np.pi * centres[:, None] / 23.4)
    return PlanningMap(
        file="hills",
        elevation=Elevation(height, 0.1, 0.1, 0.05, 0.05, "hills"),
        circles=(Circle(20.0, 20.0, 3.0), Circle(30.0, 35.0, 4.0)),
        bounds=(0.0, 0.0, 50.0, 50.0),
        resolution=0.1,
        start=(3.0, 3.0, 0.0),
        goal=(45.0, 44.0, 1.0),
    )


def request(planning_map: PlanningMap, seed: int, **more) -> PlanRequest:
    return PlanRequest(
        planning_map=planning_map,
        vehicle=VEHICLE,
        terrain=TERRAIN,
        gravity=GRAVITY,
        search=Settings(seed=seed, iterations=ITERATIONS),
        **more,
    )


def one(planning_map: PlanningMap, seed: int) -> tuple[float, float, float, bool, float]:
    """Deviations in percent of the length: open loop, without slip, with pose feedback; collision; planning time."""
    found = plan(request(planning_map, seed, clearance=CLEARANCE, verify=True))
    grid = collision_grid(planning_map, slope_field(planning_map, VEHICLE.footprint))
    obstacles = obstacles_of(grid, footprint_of(np.array(VEHICLE.footprint)))
    closed = verify(found.rows, VEHICLE, TERRAIN, GRAVITY, obstacles, Feedback.POSE)
    share = 100.0 / found.rows.length
    return (
        share * found.verification.max_deviation,
        share * found.no_slip.max_deviation,
        share * closed.max_deviation,
        found.verification.collision or closed.collision,
        found.planning,
    )


def main() -> None:
    seeds = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    planning_map, rows = slope_map(), []
    for seed in range(seeds):
        rows.append(one(planning_map, seed))
        open_loop, no_slip, closed, collision, planning = rows[-1]
        print(
            f"seed {seed}: open loop {open_loop:.2f} %, without slip {no_slip:.1f} % ({no_slip / open_loop:.0f} x), "
            f"feedback {closed:.3f} %, {'COLLISION' if collision else 'clear'}, planned in {planning:.2f} s",
            flush=True,
        )
    worst = np.array([row[:3] for row in rows]).max(axis=0)
    ratio = min(row[1] / row[0] for row in rows)
    print(
        f"12 deg, {seeds} seeds: open loop up to {worst[0]:.2f} % of the length (allowed 1.2), without slip at least "
        f"{ratio:.0f} x that (5), pose feedback up to {worst[2]:.3f} % (0.2), "
        f"{sum(row[3] for row in rows)} collisions (0)"
    )
    plan(request(hill_map(), 0))
    begin = time.perf_counter()
    found = plan(request(hill_map(), 1))
    total = time.perf_counter() - begin
    print(
        f"500 x 500 cells on hills, {ITERATIONS} iterations: planned in {found.planning:.2f} s (allowed 1), "
        f"{total:.2f} s with map and limits; first way after {found.first_solution:.3f} s"
    )


if __name__ == "__main__":
    main()
