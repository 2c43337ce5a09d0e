import math

import numpy as np
import pytest
from planning_cases import RECTANGLE, contains, driven, grid_of, laid_down, level_problem

from trackctl.planning.clearance import first_hit, least_clearance
from trackctl.planning.collision import NOWHERE, disc_clearance, is_clear, obstacles_of, touched_cell
from trackctl.planning.footprint import footprint_of
from trackctl.planning.pieces import FINEST_STEP, free_length, pivot_is_free
from trackctl.planning.search import Settings, task_of

ELL = np.array([[-0.6, -0.5], [0.7, -0.5], [0.7, 0.0], [0.1, 0.1], [0.1, 0.6], [-0.6, 0.6]])
TRIANGLE = np.array([[0.8, 0.1], [-0.4, 0.5], [-0.5, -0.6]])
POLYGONS = {"rectangle": RECTANGLE, "ell": ELL, "triangle": TRIANGLE}
SQUARE = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])


def scattered(share=0.006, shape=(30, 40), seed=0, **frame):
    return grid_of(np.random.default_rng(seed).random(shape) < share, **frame)


def distance_to_boundary(polygon, points):
    start, along = polygon, np.roll(polygon, -1, axis=0) - polygon
    share = ((points[:, None] - start) * along).sum(-1) / (along**2).sum(-1)
    feet = start + np.clip(share, 0.0, 1.0)[..., None] * along
    return np.hypot(*np.moveaxis(points[:, None] - feet, -1, 0)).min(axis=1)


def true_clearance(grid, polygon, pose):
    """Distance between polygon and the nearest blocked square by vertices against edges, cells around the grid too."""
    turn = np.array([[grid.cos_yaw, -grid.sin_yaw], [grid.sin_yaw, grid.cos_yaw]])
    blocked = np.pad(grid.blocked, 1, constant_values=True)
    corners = np.argwhere(blocked)[:, ::-1] - 1.0
    squares = ((corners[:, None] + 0.5 + SQUARE) * grid.resolution) @ turn.T + (grid.x, grid.y)
    near = np.hypot(*(squares.mean(axis=1) - pose[:2]).T) < 2.3
    outline, least = laid_down(polygon, *pose), 9.0
    for square in squares[near]:
        touching = contains(outline, square).any() or contains(square, outline).any() or crosses(outline, square)
        if touching:
            return 0.0
        least = min(least, distance_to_boundary(outline, square).min(), distance_to_boundary(square, outline).min())
    return least


def crosses(first, second):
    def side(a, b, p):
        return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])

    for a, b in zip(first, np.roll(first, -1, axis=0), strict=True):
        for c, d in zip(second, np.roll(second, -1, axis=0), strict=True):
            if side(a, b, c) * side(a, b, d) < 0.0 and side(c, d, a) * side(c, d, b) < 0.0:
                return True
    return False


@pytest.mark.parametrize("polygon", POLYGONS.values(), ids=POLYGONS)
@pytest.mark.parametrize("yaw", [0.0, 0.7])
def test_poses_against_edges_and_vertices(polygon, yaw):
    grid = scattered(x=-1.0, y=2.0, yaw=yaw)
    obstacles = obstacles_of(grid, footprint_of(polygon))
    stream = np.random.default_rng(1)
    turn = np.array([[grid.cos_yaw, -grid.sin_yaw], [grid.sin_yaw, grid.cos_yaw]])
    local = stream.uniform((0.5, 0.5), (3.5, 2.5), (30, 2))
    poses = np.column_stack((local @ turn.T + (grid.x, grid.y), stream.uniform(-4.0, 4.0, 30)))
    expected = np.array([true_clearance(grid, polygon, pose) for pose in poses])
    assert 5 < (expected > 0.0).sum() < 28
    found = [least_clearance(obstacles, *pose[:, None]) for pose in poses]
    np.testing.assert_allclose(found, expected, atol=1e-12)
    apart = expected > 0.0
    assert least_clearance(obstacles, *poses[apart].T) == pytest.approx(expected[apart].min(), abs=1e-12)
    for (x, y, angle), clearance in zip(poses, expected, strict=True):
        facing = math.cos(angle), math.sin(angle)
        assert disc_clearance(obstacles, x, y, *facing) <= clearance + 1e-12
        assert is_clear(obstacles, x, y, *facing, 0.0) == (clearance > 0.0)
        for growth in (0.02, 0.1):
            assert clearance > growth or not is_clear(obstacles, x, y, *facing, growth)


def test_a_margin_is_kept():
    blocked = np.zeros((60, 60), bool)
    blocked[:, 40] = True
    x = 4.0 - 0.5 - 0.2
    for margin, clear in ((0.19, True), (0.21, False)):
        obstacles = obstacles_of(grid_of(blocked), footprint_of(RECTANGLE), margin)
        assert is_clear(obstacles, x, 3.0, 1.0, 0.0, 0.0) is clear


def test_the_touched_cell_is_named():
    blocked = np.zeros((60, 60), bool)
    blocked[31, 33] = True
    obstacles = obstacles_of(grid_of(blocked), footprint_of(RECTANGLE))
    assert touched_cell(obstacles, 3.0, 3.0, 0.0) == (31, 33)
    assert touched_cell(obstacles, 2.0, 2.0, 0.0)[0] == NOWHERE
    assert touched_cell(obstacles, 0.3, 3.0, 0.0)[1] < 0


def test_sweeps_cut_no_corner_and_give_up_only_at_obstacles():
    grid = scattered(share=0.01, shape=(80, 80), seed=3)
    problem = level_problem(grid.blocked, (4.0, 4.0, 0.0), (5.0, 5.0, 0.0))
    task = task_of(problem, Settings())
    stream = np.random.default_rng(4)
    stopped = 0
    for _ in range(300):
        x, y, tangent = stream.uniform((1.0, 1.0, -4.0), (7.0, 7.0, 4.0))
        if not is_clear(task.obstacles, x, y, math.cos(tangent), math.sin(tangent), 0.0):
            continue
        curvature, length = stream.uniform(-1.0, 1.0) / 1.5, stream.uniform(0.5, 5.0)
        free = free_length(task, x, y, tangent, curvature, length)
        poses = driven((x, y, tangent), [(curvature, free, 0.0)], 0.003)
        assert least_clearance(task.obstacles, *poses.T) > 0.0
        if free < length:
            # Sweeps step by what the clearance proves; a mitred corner counts for up to 1/sin(45 deg) of it.
            assert least_clearance(task.obstacles, *poses[-1:].T) <= 2.0 * math.sqrt(2.0) * FINEST_STEP * 0.1 + 1e-9
            stopped += 1
    assert stopped > 50


def test_a_sweep_backwards_is_one_forwards_turned_round():
    grid = scattered(share=0.01, shape=(80, 80), seed=3)
    task = task_of(level_problem(grid.blocked, (4.0, 4.0, 0.0), (5.0, 5.0, 0.0)), Settings())
    stream = np.random.default_rng(5)
    for _ in range(50):
        x, y, tangent = stream.uniform((1.5, 1.5, -4.0), (6.5, 6.5, 4.0))
        if is_clear(task.obstacles, x, y, math.cos(tangent), math.sin(tangent), 0.0):
            # The rectangle is its own image when turned by a half turn.
            backwards = free_length(task, x, y, tangent, 0.5, -3.0)
            assert backwards == pytest.approx(free_length(task, x, y, tangent + math.pi, -0.5, 3.0), abs=1e-6)


def test_a_single_cell_is_not_jumped_over():
    blocked = np.zeros((100, 400), bool)
    blocked[50, 200] = True
    task = task_of(level_problem(blocked, (2.0, 5.05, 0.0), (38.0, 5.0, 0.0)), Settings())
    assert free_length(task, 2.0, 5.05, 0.0, 0.0, 36.0) == pytest.approx(20.0 - 0.5 - 2.0, abs=0.03)
    assert free_length(task, 2.0, 5.05 + 0.43, 0.0, 0.0, 36.0) == 36.0


def test_turns_on_the_spot_need_room_for_the_corners():
    reach = math.hypot(0.5, 0.35)
    for gap, free in ((0.03, True), (-0.01, False)):
        blocked = np.zeros((200, 200), bool)
        blocked[180:, :] = True  # from y = 1.8 up
        task = task_of(level_problem(blocked, (1.0, 1.0, 0.0), (1.0, 1.0, 0.0), resolution=0.01), Settings())
        assert pivot_is_free(task, 1.0, 1.8 - reach - gap, 0.0, math.pi) is free
        assert pivot_is_free(task, 1.0, 1.8 - reach - gap, 0.0, 0.1)


def test_a_sampled_path_is_proved_between_its_samples():
    blocked = np.zeros((60, 200), bool)
    blocked[30, 100] = True
    obstacles = obstacles_of(grid_of(blocked), footprint_of(RECTANGLE))
    y = np.full(9, 3.05 + 0.35 + 0.06)
    x = np.linspace(6.0, 14.0, 9)
    assert first_hit(obstacles, x, y, np.zeros(9)) is not None  # 1 m apart: not proved
    fine = np.linspace(6.0, 14.0, 1601)
    assert first_hit(obstacles, fine, np.full(1601, y[0]), np.zeros(1601)) is None
    assert first_hit(obstacles, fine, np.full(1601, y[0] - 0.02), np.zeros(1601)) is not None


def test_footprints_are_cut_into_convex_parts_of_the_same_area():
    def area(polygon):
        x, y = polygon.T
        return 0.5 * float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))

    for polygon in (*POLYGONS.values(), ELL[::-1]):
        footprint = footprint_of(polygon)
        parts = np.split(footprint.vertices, footprint.first[1:-1])
        assert sum(map(area, parts)) == pytest.approx(abs(area(polygon)))
        assert min(map(area, parts)) > 0.0
        points = np.random.default_rng(0).uniform(-1.0, 1.0, (2000, 2))
        points = points[contains(polygon, points)]
        covered = np.hypot(*np.moveaxis(points[:, None] - footprint.discs[:, :2], -1, 0)) <= footprint.discs[:, 2]
        assert covered.any(axis=1).all()
