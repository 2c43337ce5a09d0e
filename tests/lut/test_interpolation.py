"""Look-up on synthetic tables from closed forms that obey the model's mirror symmetry."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from numpy.typing import NDArray

from trackctl.lut.axes import FULL_CIRCLE, Axes
from trackctl.lut.interpolation import LookupResult, LookupStatus, interpolant, look_up
from trackctl.lut.shape_functions import Method
from trackctl.lut.table import Status, Table
from trackctl.profiles.terrain import TerrainProfile
from trackctl.profiles.vehicle import VehicleProfile

Array = NDArray[np.float64]

VEHICLE = VehicleProfile(
    name="test",
    description="",
    source="",
    mass=2000.0,
    yaw_inertia=3000.0,
    track_gauge=1.8,
    track_width=0.3,
    contact_length=2.5,
    cog_height=0.7,
    sprocket_radius=0.25,
    max_speed=8.0,
    max_acceleration=2.0,
    max_sprocket_rate=100.0,
    max_sprocket_acceleration=100.0,
    footprint=((1.5, 1.0), (-1.5, 1.0), (-1.5, -1.0), (1.5, -1.0)),
)
TERRAIN = TerrainProfile(
    name="test",
    description="",
    source="",
    friction_coefficient=0.6,
    shear_deformation_modulus=0.02,
    motion_resistance_coefficient=0.05,
)
LEFT_TURNS = np.append(0.0, 1.0 / np.arange(50.0, 2.5, -1.0))
BOTH_TURNS = np.concatenate([-LEFT_TURNS[:0:-1], LEFT_TURNS])
FLOATS = [name for name in LookupResult.__slots__ if name != "status"]

methods = pytest.mark.parametrize("method", list(Method))


def axes(
    slope: tuple[float, ...] = (0.2,),
    velocity: Array | None = None,
    curvature: Array = LEFT_TURNS,
    heading: Array | None = None,
    headings: int = 36,
) -> Axes:
    """Axes of a table; unless they are given, so many headings all round."""
    return Axes(
        np.array(slope),
        np.linspace(0.5, 8.0, 16) if velocity is None else velocity,
        curvature,
        np.arange(headings) * (FULL_CIRCLE / headings) if heading is None else heading,
        heading_is_periodic=heading is None,
    )


def closed_form(slope: Array, velocity: Array, curvature: Array, heading: Array) -> tuple[Array, Array, Array]:
    """Track speeds over speed and sideslip, smooth, mirrored when curvature and heading change sign."""
    up, across = np.sin(slope) * np.cos(heading), np.sin(slope) * np.sin(heading)
    left, right = (
        1.0 + 0.3 * up * (1.0 + 0.05 * velocity) - side * (0.95 * curvature * (1.0 + 0.01 * velocity) - 0.1 * across)
        for side in (1.0, -1.0)
    )
    return left, right, 0.3 * across * (1.0 + curvature**2) + 0.4 * curvature * (1.0 + 0.02 * velocity * up)


def table_of(axes: Axes, vehicle: VehicleProfile = VEHICLE, form=closed_form) -> Table:  # type: ignore[no-untyped-def]
    """A table of a closed form, converged everywhere."""
    mesh = np.meshgrid(axes.slope, axes.velocity, axes.curvature, axes.heading, indexing="ij")
    left, right, sideslip = form(*mesh)
    rate = mesh[1] / vehicle.sprocket_radius
    values = {"sprocket_rate_left": left * rate, "sprocket_rate_right": right * rate, "sideslip": sideslip}
    return Table(axes, values, np.zeros(axes.shape, np.uint8), vehicle, TERRAIN, 9.80665)


def with_status(table: Table, status: NDArray[np.uint8], poison: float) -> Table:
    """The table with other status, and a poison in every value of a cell that is not converged."""
    values = {name: np.where(status == 0, array, poison) for name, array in table.values.items()}
    return replace(table, status=status, values=values)


def random_points(axes: Axes, count: int, seed: int = 0) -> tuple[Array, Array, Array, Array]:
    """Points all over a table."""
    generator = np.random.default_rng(seed)
    slope, velocity, curvature = (
        generator.uniform(axis[0], axis[-1], count) for axis in (axes.slope, axes.velocity, axes.curvature)
    )
    last = FULL_CIRCLE if axes.heading_is_periodic else axes.heading[-1]
    return slope, velocity, curvature, generator.uniform(axes.heading[0], last, count)


def ratios(found: LookupResult, velocity: Array) -> Array:
    """Track speeds over speed and sideslip, shape (3, n)."""
    return np.stack([found.track_speed_left / velocity, found.track_speed_right / velocity, found.sideslip])


def test_status_extends_that_of_the_table() -> None:
    assert all(LookupStatus(status).name == status.name for status in Status)
    labels = {LookupStatus(code).label for code in range(len(Status), len(LookupStatus))}
    assert labels == {"outside_table", "near_infeasible", "actuator_limit"}


@methods
def test_nodes_are_met(method: Method) -> None:
    table = table_of(axes(slope=(0.0, 0.1, 0.2)))
    mesh = np.meshgrid(
        *(getattr(table.axes, name) for name in ("slope", "velocity", "curvature", "heading")), indexing="ij"
    )
    found = look_up(interpolant(table), *(array.ravel() for array in mesh), method)
    assert not found.status.any()
    # The way to a ratio and back rounds four times.
    for name in ("sprocket_rate_left", "sprocket_rate_right"):
        np.testing.assert_allclose(getattr(found, name), table.values[name].ravel(), rtol=1e-15)
    assert np.array_equal(found.sideslip, table.values["sideslip"].ravel())


@pytest.mark.parametrize(("method", "degree"), [(Method.LINEAR, 1), (Method.MLS, 2), (Method.CUBIC, 2)])
def test_products_of_polynomials_are_reproduced(method: Method, degree: int) -> None:
    def product_of_polynomials(slope: Array, velocity: Array, curvature: Array, heading: Array) -> tuple[Array, ...]:
        form = (1 + slope**degree) * (1 - (velocity / 8) ** degree) * (1 + curvature**degree) * (heading**degree - 5)
        return form, 2.0 - form, 0.1 * form

    range_axes = axes(slope=(0.0, 0.05, 0.2, 0.3), curvature=BOTH_TURNS, heading=np.linspace(0.4, 2.0, 9))
    table = table_of(range_axes, replace(VEHICLE, max_sprocket_rate=1e4), product_of_polynomials)
    points = random_points(table.axes, 2000)
    found = ratios(look_up(interpolant(table), *points, method), points[1])
    # Weights in the widest curvature cell reach 25, values 9.
    np.testing.assert_allclose(found, np.stack(product_of_polynomials(*points)), rtol=0, atol=1e-12)


@methods
def test_slips_are_those_of_the_model(method: Method) -> None:
    vehicle = replace(VEHICLE, cog_left=-0.1)
    table = table_of(axes(curvature=BOTH_TURNS), vehicle)
    slope, velocity, curvature, heading = random_points(table.axes, 500)
    found = look_up(interpolant(table), slope, velocity, curvature, heading, method)
    for side, track, slip in (
        (1.0, found.track_speed_left, found.slip_left),
        (-1.0, found.track_speed_right, found.slip_right),
    ):
        body = velocity * np.cos(found.sideslip) - velocity * curvature * (side * 0.9 + 0.1)
        expected = (track - body) / np.maximum(np.abs(track), np.abs(body))
        np.testing.assert_allclose(slip, expected, rtol=0, atol=1e-14)  # rounding of numbers near 1
    np.testing.assert_allclose(found.sprocket_rate_left * 0.25, found.track_speed_left, rtol=1e-15)
    np.testing.assert_allclose(found.sprocket_rate_right * 0.25, found.track_speed_right, rtol=1e-15)


@methods
def test_right_turns_mirror_left_turns(method: Method) -> None:
    packed = interpolant(table_of(axes()))
    slope, velocity, curvature, heading = random_points(axes(), 500)
    left_turn = look_up(packed, slope, velocity, curvature, heading, method)
    right_turn = look_up(packed, slope, velocity, -curvature, -heading, method)
    assert not right_turn.status.any()
    for quantity in ("track_speed", "sprocket_rate", "slip"):
        for side, other in (("left", "right"), ("right", "left")):
            mirrored = getattr(right_turn, f"{quantity}_{other}")
            assert np.array_equal(mirrored, getattr(left_turn, f"{quantity}_{side}"))
    assert np.array_equal(right_turn.sideslip, -left_turn.sideslip)


@methods
def test_left_turns_alone_answer_as_both_turns_do(method: Method) -> None:
    def bent(slope: Array, velocity: Array, curvature: Array, heading: Array) -> tuple[Array, Array, Array]:
        left, right, sideslip = closed_form(slope, velocity, curvature, heading)
        return left, right, sideslip + 0.3 * np.sin(heading) * np.abs(curvature)

    points = random_points(axes(curvature=BOTH_TURNS), 2000)
    both = look_up(interpolant(table_of(axes(curvature=BOTH_TURNS), form=bent)), *points, method)
    left = look_up(interpolant(table_of(axes(), form=bent)), *points, method)
    assert not both.status.any()
    for name in FLOATS:
        # Headings of mirrored stencils differ by 1e-15; rates reach 50.
        np.testing.assert_allclose(getattr(left, name), getattr(both, name), rtol=0, atol=1e-11)


def test_a_vehicle_that_is_not_symmetric_is_not_mirrored() -> None:
    packed = interpolant(table_of(axes(), replace(VEHICLE, cog_left=0.05)))
    found = look_up(packed, 0.2, 2.0, [0.1, -0.1, 0.0, -0.0], 1.0)
    outside = LookupStatus.OUTSIDE_TABLE
    assert found.status.tolist() == [0, outside, 0, 0]


@methods
def test_headings_are_periodic(method: Method) -> None:
    packed = interpolant(table_of(axes()))
    points = random_points(axes(), 500)
    expected = look_up(packed, *points, method)
    for turns in (-2, 1):
        found = look_up(packed, *points[:3], points[3] + turns * FULL_CIRCLE, method)
        np.testing.assert_allclose(found.sideslip, expected.sideslip, rtol=0, atol=1e-14)  # 4 pi rounds by 1e-15
    seam = look_up(packed, 0.2, 2.0, 0.1, [FULL_CIRCLE - 1e-6, 1e-6, -1e-17], method)
    assert not seam.status.any()
    assert np.ptp(seam.sideslip) < 1e-6  # slope below 0.1 rad/rad


@methods
def test_a_range_of_headings_ends_there(method: Method) -> None:
    packed = interpolant(table_of(axes(heading=np.linspace(0.0, 1.5, 16))))
    found = look_up(packed, 0.2, 2.0, 0.1, [0.0, 0.77, 1.5, 0.77 - FULL_CIRCLE, -1e-17, -0.01, 1.51, 4.0], method)
    assert found.status.tolist() == [0] * 5 + [LookupStatus.OUTSIDE_TABLE] * 3
    assert found.sideslip[1] == pytest.approx(found.sideslip[3], abs=1e-14)
    mirrored = look_up(packed, 0.2, 2.0, -0.1, [-0.77, 0.77], method)
    assert mirrored.status.tolist() == [0, LookupStatus.OUTSIDE_TABLE]
    assert mirrored.sideslip[0] == pytest.approx(-found.sideslip[1], abs=1e-14)


@methods
def test_one_slope_of_many_answers_as_a_table_of_its_own(method: Method) -> None:
    points = random_points(axes(), 500)
    alone = look_up(interpolant(table_of(axes(slope=(0.2,)))), *points, method)
    among = look_up(interpolant(table_of(axes(slope=(0.0, 0.1, 0.2, 0.25)))), *points, method)
    for name in FLOATS:
        assert np.array_equal(getattr(alone, name), getattr(among, name))


@methods
@pytest.mark.parametrize("axis", ["slope", "velocity", "curvature", "heading"])
def test_axes_of_one_and_two_nodes(axis: str, method: Method) -> None:
    lone, other = {
        "slope": (0.2, 0.25),
        "velocity": (2.0, 2.5),
        "curvature": (0.0, 0.01),
        "heading": (1.0, 1.1),
    }[axis]
    point = {"slope": 0.2, "velocity": 2.0, "curvature": 0.02, "heading": 1.0} | {axis: lone}
    single = (lone,) if axis == "slope" else np.array([lone])
    pair = (lone, other) if axis == "slope" else np.array([lone, other])
    missed = {name: [value, value + (name == axis)] for name, value in point.items()}
    found = look_up(interpolant(table_of(axes(**{axis: single}))), **missed, method=method)  # type: ignore[arg-type]
    assert found.status.tolist() == [0, LookupStatus.OUTSIDE_TABLE]
    packed = interpolant(table_of(axes(**{axis: pair})))  # type: ignore[arg-type]
    ends = [lone, 0.5 * (lone + other), other]
    found = look_up(packed, **(point | {axis: ends}), method=method)  # type: ignore[arg-type]
    assert not found.status.any()
    speed_ratio = found.track_speed_left / (ends if axis == "velocity" else point["velocity"])
    assert speed_ratio[1] == pytest.approx(0.5 * (speed_ratio[0] + speed_ratio[2]), abs=1e-14)


@pytest.mark.parametrize(("method", "order"), [(Method.LINEAR, 2.0), (Method.MLS, 3.0), (Method.CUBIC, 4.0)])
def test_order_of_convergence_on_all_axes(method: Method, order: float) -> None:
    generator = np.random.default_rng(5)
    # Away from the ends, where cubic has three nodes.
    velocity, curvature = generator.uniform(3.0, 5.0, 4000), generator.uniform(0.1, 0.2, 4000)
    heading = generator.uniform(0.0, FULL_CIRCLE, 4000)

    def waves(_: Array, velocity: Array, curvature: Array, heading: Array) -> tuple[Array, Array, Array]:
        form = np.sin(velocity) + np.cos(20.0 * curvature + heading)
        return form, form, form

    counts, errors = (12, 24, 48), []
    for count in counts:
        coarse = axes(
            velocity=np.linspace(1.0, 7.0, count + 1),
            curvature=np.linspace(0.0, 0.3, count + 1),
            headings=count,
        )
        table = table_of(coarse, form=waves)
        found = look_up(interpolant(table), 0.2, velocity, curvature, heading, method)
        errors.append(np.abs(found.sideslip - waves(velocity, velocity, curvature, heading)[2]).max())
    assert -np.polyfit(np.log(counts), np.log(errors), 1)[0] == pytest.approx(order, abs=0.15)


def stencil(nodes: Array, x: float, method: Method, period: float | None = None) -> tuple[list[int], list[int]]:
    """Corners and stencil of the cell about a point between nodes: a second, slow way to find them."""
    count = nodes.size
    if count == 1:
        return [0], [0]
    cell = int(np.searchsorted(nodes, x)) - 1
    wanted = [cell, cell + 1] if method is Method.LINEAR else list(range(cell - 1, cell + 3))
    if period is not None:
        return [cell, (cell + 1) % count], [node % count for node in wanted]
    return [cell, cell + 1], [node for node in wanted if 0 <= node < count]


@methods
@pytest.mark.parametrize("poison", [1e30, np.nan])
def test_infeasible_cells_are_never_mixed_in(method: Method, poison: float) -> None:
    table = table_of(axes((0.1, 0.2, 0.3), np.linspace(0.5, 8.0, 9), np.linspace(0.0, 1 / 3, 9), headings=12))
    _, velocity, curvature, heading = np.meshgrid(
        table.axes.slope, table.axes.velocity, table.axes.curvature, table.axes.heading, indexing="ij"
    )
    status = np.zeros(table.axes.shape, np.uint8)
    status[velocity**2 * curvature > 4.0 + 2.0 * np.cos(heading)] = Status.INFEASIBLE_GRIP
    status[velocity**2 * curvature > 15.0 + 2.0 * np.cos(heading)] = Status.INFEASIBLE_LIFTOFF
    status[0, 2, 4, 3] = Status.NOT_CONVERGED
    clean, packed = interpolant(table), interpolant(with_status(table, status, poison))
    points = random_points(table.axes, 1500)
    truth, found = look_up(clean, *points, method), look_up(packed, *points, method)
    for query, (theta, v, kappa, phi) in enumerate(zip(*points, strict=True)):
        corners, nodes = zip(
            stencil(table.axes.slope, theta, method),
            stencil(table.axes.velocity, v, method),
            stencil(table.axes.curvature, kappa, method),
            stencil(table.axes.heading, phi, method, FULL_CIRCLE),
            strict=True,
        )
        at_corners = {int(status[corner]) for corner in product(*corners)}
        if {int(status[node]) for node in product(*nodes)} == {0}:
            expected = 0
        elif len(at_corners) == 1 and at_corners != {0}:
            (expected,) = at_corners
        else:
            expected = LookupStatus.NEAR_INFEASIBLE
        assert found.status[query] == expected
    assert {int(code) for code in np.unique(found.status)} >= {0, 1, 2, LookupStatus.NEAR_INFEASIBLE}
    converged = found.status == 0
    for name in FLOATS:
        assert np.array_equal(getattr(found, name)[converged], getattr(truth, name)[converged])
        assert np.isnan(getattr(found, name)[~converged]).all()


@methods
def test_cells_without_weight_are_not_touched(method: Method) -> None:
    table = table_of(axes())
    status = np.full(table.axes.shape, Status.INFEASIBLE_GRIP, np.uint8)
    status[:, 5, :, :] = 0  # one velocity
    status[:, :, 7, 10] = 0  # one curvature and heading
    packed = interpolant(with_status(table, status, np.nan))
    velocity, curvature, heading = table.axes.velocity, table.axes.curvature, table.axes.heading
    found = look_up(
        packed,
        0.2,
        [velocity[5], velocity[5], 3.3, 3.3, 4.7],
        [curvature[7], 0.1234, curvature[7], curvature[7], curvature[8]],
        [heading[10], 1.234, heading[10], heading[10] + 0.01, heading[10]],
        method,
    )
    near, grip = LookupStatus.NEAR_INFEASIBLE, LookupStatus.INFEASIBLE_GRIP
    assert found.status.tolist() == [0, 0, 0, near, grip]
    expected = closed_form(*np.array([[0.2], [3.3], [curvature[7]], [heading[10]]]))[2]
    assert found.sideslip[2] == pytest.approx(expected[0], abs=1e-3)  # linear over half a m/s; poison is 1e30


def test_a_status_common_to_the_corners_comes_before_near_infeasible() -> None:
    table = table_of(axes())
    status = np.zeros(table.axes.shape, np.uint8)
    status[:, 8:10, 20:22, 5:7] = Status.INFEASIBLE_PITCHOVER
    packed = interpolant(with_status(table, status, np.nan))
    step = FULL_CIRCLE / 36
    velocity, curvature = table.axes.velocity[8] + 0.1, 0.5 * table.axes.curvature[20:22].sum()
    found = look_up(packed, 0.2, velocity, curvature, np.array([5.5, 4.5, 3.5, 2.5]) * step, Method.MLS)
    near = LookupStatus.NEAR_INFEASIBLE
    assert found.status.tolist() == [Status.INFEASIBLE_PITCHOVER, near, near, 0]
    found = look_up(packed, 0.2, velocity, curvature, np.array([5.5, 4.5, 3.5, 2.5]) * step, Method.LINEAR)
    assert found.status.tolist() == [Status.INFEASIBLE_PITCHOVER, near, 0, 0]


def test_actuator_limits_come_last() -> None:
    table = table_of(axes(), replace(VEHICLE, max_sprocket_rate=20.0))
    status = np.zeros(table.axes.shape, np.uint8)
    status[:, 14:] = Status.INFEASIBLE_GRIP
    packed = interpolant(with_status(table, status, np.nan))
    found = look_up(packed, [0.2, 0.2, 0.2, 0.2, 0.3], [3.0, 6.0, 7.1, 7.6, 6.0], [0.05, 0.05, 0.05, 0.05, 0.05], 1.0)
    limit, near, outside = (
        LookupStatus.ACTUATOR_LIMIT,
        LookupStatus.NEAR_INFEASIBLE,
        LookupStatus.OUTSIDE_TABLE,
    )
    assert found.status.tolist() == [0, limit, near, Status.INFEASIBLE_GRIP, outside]
    for name in FLOATS:
        assert np.isnan(getattr(found, name)).tolist() == [False, True, True, True, True]


def test_either_track_may_meet_the_actuator_limit() -> None:
    packed = interpolant(table_of(axes(), replace(VEHICLE, max_sprocket_rate=22.0)))
    found = look_up(packed, 0.2, 5.0, [0.0, 0.2, -0.2], np.pi)
    assert found.status.tolist() == [0, LookupStatus.ACTUATOR_LIMIT, LookupStatus.ACTUATOR_LIMIT]


@pytest.mark.parametrize("name", ["slope", "velocity", "curvature", "heading"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_queries_that_are_no_numbers_are_outside(name: str, value: float) -> None:
    point = {"slope": 0.2, "velocity": 2.0, "curvature": 0.1, "heading": 1.0} | {name: value}
    found = look_up(interpolant(table_of(axes())), **point)
    assert found.status.tolist() == [LookupStatus.OUTSIDE_TABLE]
    assert all(np.isnan(getattr(found, name)).all() for name in FLOATS)


def test_beyond_the_axes_is_outside() -> None:
    packed = interpolant(table_of(axes()))
    found = look_up(packed, 0.2, [0.49, 8.01, 2.0, 2.0, 2.0], [0.1, 0.1, 0.34, -0.34, 1e-6], 1.0)
    assert found.status.tolist() == [LookupStatus.OUTSIDE_TABLE] * 4 + [0]


def test_answers_depend_neither_on_jobs_nor_on_the_batch() -> None:
    packed = interpolant(table_of(axes()))
    points = random_points(axes(), 10_000)
    alone, shared = look_up(packed, *points), look_up(packed, *points, jobs=3)
    last = look_up(packed, *(axis[-1] for axis in points))
    for name in (*FLOATS, "status"):
        assert np.array_equal(getattr(alone, name), getattr(shared, name))
        assert getattr(last, name).tolist() == [getattr(alone, name)[-1]]
    assert look_up(packed, 0.2, [], 0.1, 1.0, jobs=2).status.size == 0


def test_errors_on_a_table_of_usual_size() -> None:
    table = table_of(axes(headings=360))
    points = random_points(table.axes, 5000)
    truth = np.stack(closed_form(*points))
    errors = {m: np.abs(ratios(look_up(interpolant(table), *points, m), points[1]) - truth).max() for m in Method}
    # Twice the error terms: linear h^2/8 of 0.12 in the widest curvature cell; MLS h^3/15 and cubic 3 h^4/128
    # of 0.08 along heading.
    assert errors[Method.LINEAR] < 2.1e-4
    assert errors[Method.MLS] < 5.7e-8
    assert errors[Method.CUBIC] < 3.6e-10
