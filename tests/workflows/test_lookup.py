from dataclasses import fields, replace

import numpy as np
import pytest
from solved_tables import CURVATURE, HEADING, SLOPE, TERRAIN, VEHICLE, VELOCITY, solved_table

from trackctl.errors import InputFileError, LutFormatError, LutMismatchError
from trackctl.files.lut_writer import write_lut
from trackctl.lut.interpolation import LookupResult, LookupStatus
from trackctl.workflows import lookup as lookup_module
from trackctl.workflows.lookup import LookupRequest, answer_columns, lookup, status_counts
from trackctl.workflows.lookup_method import LookupMethod
from trackctl.workflows.operating_points import OperatingPoints

ANSWERS = [field.name for field in fields(LookupResult) if field.name != "status"]
# The model is solved to residuals of 1e-10, which leaves errors of this order in the speeds.
SOLVED = 1e-8


@pytest.fixture(scope="module")
def table():
    return solved_table()


@pytest.fixture(scope="module")
def lut(table, tmp_path_factory):
    path = tmp_path_factory.mktemp("lookup") / "lut.h5"
    write_lut(path, table)
    return path


@pytest.fixture(scope="module")
def two_slopes(tmp_path_factory):
    path = tmp_path_factory.mktemp("lookup") / "slopes.h5"
    write_lut(path, solved_table(slopes=(0.0, SLOPE)))
    return path


@pytest.fixture(scope="module")
def off_centre(tmp_path_factory):
    path = tmp_path_factory.mktemp("lookup") / "off-centre.h5"
    write_lut(path, solved_table(cog_left=0.05))
    return path


def points(velocity, curvature, heading, slope=None):
    arrays = np.broadcast_arrays(*(np.atleast_1d(np.float64(x)) for x in (velocity, curvature, heading)))
    return OperatingPoints(*arrays, None if slope is None else np.full(arrays[0].size, slope))


def answer(lut, *point, slope=None, **options):
    return lookup(LookupRequest(lut, points(*point, slope=slope), **options))


def words(result):
    return [LookupStatus(code).label for code in result.status]


@pytest.mark.parametrize("method", list(LookupMethod))
def test_every_method_meets_the_nodes(lut, table, method):
    at = np.ix_([0], range(VELOCITY.size), range(4), range(HEADING.size))
    nodes = np.meshgrid(VELOCITY, CURVATURE[:4], HEADING, indexing="ij")
    found = answer(lut, *(axis.ravel() for axis in nodes), method=method)
    assert set(words(found)) == {"converged"}
    for name in ("sprocket_rate_left", "sprocket_rate_right", "sideslip", "slip_left", "slip_right"):
        np.testing.assert_allclose(getattr(found, name), table.values[name][at].ravel(), atol=SOLVED)


def test_methods_differ_between_the_nodes_but_little(lut):
    exact, *others = (
        answer(lut, 1.2, 0.35, 1.0, method=method).track_speed_left[0] for method in list(LookupMethod)[::-1]
    )
    assert len({exact, *others}) == 4
    # The table is coarse: 12 headings.
    np.testing.assert_allclose(others, exact, atol=0.02)


@pytest.mark.parametrize("method", list(LookupMethod))
def test_a_right_turn_is_a_mirrored_left_turn(lut, method):
    left = answer(lut, 1.3, 0.3, 1.0, method=method)
    right = answer(lut, 1.3, -0.3, -1.0, method=method)
    for name in ("track_speed", "sprocket_rate", "slip"):
        for side, other in (("left", "right"), ("right", "left")):
            np.testing.assert_allclose(getattr(left, f"{name}_{side}"), getattr(right, f"{name}_{other}"), atol=SOLVED)
    np.testing.assert_allclose(left.sideslip, -right.sideslip, atol=SOLVED)


def test_an_asymmetric_vehicle_is_not_mirrored(off_centre):
    left = answer(off_centre, 1.0, CURVATURE[3], HEADING[2], method=LookupMethod.EXACT)
    right = answer(off_centre, 1.0, -CURVATURE[3], -HEADING[2], method=LookupMethod.EXACT)
    assert abs(left.track_speed_left[0] - right.track_speed_right[0]) > 1e-3
    stored = answer(off_centre, 1.0, -CURVATURE[3], -HEADING[2])
    for name in ANSWERS:
        np.testing.assert_allclose(getattr(stored, name), getattr(right, name), atol=SOLVED)


OUTSIDE = [
    (VELOCITY[0] - 0.01, 0.0, 0.0),
    (VELOCITY[-1] + 0.01, 0.0, 0.0),
    (1.0, CURVATURE[-1] + 0.01, 0.0),
    (1.0, -CURVATURE[-1] - 0.01, 0.0),
    (1.0, 2.0 / VEHICLE.track_gauge + 0.01, 0.0),
    (1.0, np.inf, 0.0),
]


@pytest.mark.parametrize("method", [LookupMethod.MLS, LookupMethod.EXACT])
def test_nothing_is_answered_outside_the_table(lut, method):
    found = answer(lut, *np.array(OUTSIDE).T, method=method)
    assert set(words(found)) == {"outside_table"}
    assert all(np.isnan(getattr(found, name)).all() for name in ANSWERS)
    assert words(answer(lut, 1.0, 0.0, 0.0, slope=SLOPE + 0.01, method=method)) == ["outside_table"]


@pytest.mark.parametrize("method", [LookupMethod.MLS, LookupMethod.EXACT])
def test_ends_and_any_turn_of_the_heading_are_inside(lut, method):
    found = answer(lut, VELOCITY[[0, -1, 0]], CURVATURE[[0, 4, 4]], [0.0, 2.0, 2.0 + 4.0 * np.pi], method=method)
    assert words(found) == ["converged"] * 3


# Gravity points away from the turning centre.
BEYOND_GRIP = (2.0, CURVATURE[-1], HEADING[9])


@pytest.mark.parametrize("method", list(LookupMethod))
def test_an_infeasible_node_says_why(lut, method):
    found = answer(lut, *BEYOND_GRIP, method=method)
    assert words(found) == ["infeasible_grip"]
    assert all(np.isnan(getattr(found, name)).all() for name in ANSWERS)


def test_beside_an_infeasible_cell_only_the_model_answers(lut):
    place = 1.98, 1.05, HEADING[9]
    assert words(answer(lut, *place)) == ["near_infeasible"]
    assert words(answer(lut, *place, method=LookupMethod.EXACT)) == ["converged"]


@pytest.mark.parametrize("method", [LookupMethod.LINEAR, LookupMethod.EXACT])
def test_the_limits_of_the_vehicle_given_apply(lut, method):
    point = 1.0, 0.2, 1.0
    fast = float(answer(lut, *point, method=method).sprocket_rate_right[0])
    for limit, word in ((fast * 1.001, "converged"), (fast * 0.999, "actuator_limit")):
        vehicle = replace(VEHICLE, max_sprocket_rate=limit)
        found = answer(lut, *point, method=method, vehicle=vehicle)
        assert words(found) == [word]
        assert np.isnan(found.slip_left[0]) == (word == "actuator_limit")


def test_the_only_slope_is_taken(lut):
    np.testing.assert_array_equal(answer(lut, 1.0, 0.2, 1.0).sideslip, answer(lut, 1.0, 0.2, 1.0, slope=SLOPE).sideslip)


def test_one_of_several_slopes_has_to_be_named(two_slopes):
    assert words(answer(two_slopes, 1.0, 0.2, 1.0, slope=0.5 * SLOPE)) == ["converged"]
    with pytest.raises(InputFileError, match=r"slopes\.h5: has 2 slopes \(0, 12 deg\) .* --slope-deg"):
        answer(two_slopes, 1.0, 0.2, 1.0)


@pytest.mark.parametrize("method", [LookupMethod.MLS, LookupMethod.EXACT])
@pytest.mark.parametrize(
    "other",
    [
        {"vehicle": replace(VEHICLE, mass=VEHICLE.mass + 1.0)},
        {"terrain": replace(TERRAIN, friction_coefficient=0.5)},
        {"gravity": 9.81},
    ],
)
def test_a_table_of_something_else_is_refused(lut, method, other):
    with pytest.raises(LutMismatchError, match=r"lut\.h5: was made for utv-61cm on asphalt"):
        answer(lut, 1.0, 0.0, 0.0, method=method, **other)


@pytest.mark.parametrize("method", [LookupMethod.MLS, LookupMethod.EXACT])
def test_what_is_no_table_is_refused(tmp_path, method):
    with pytest.raises(LutFormatError, match="cannot be read"):
        answer(tmp_path / "none.h5", 1.0, 0.0, 0.0, method=method)


@pytest.mark.parametrize("method", [LookupMethod.MLS, LookupMethod.EXACT])
def test_batches_are_joined_and_told(lut, monkeypatch, method):
    asked = points(np.linspace(0.4, 2.0, 11), 0.2, 1.0)
    at_once = lookup(LookupRequest(lut, asked, method))
    told = []
    monkeypatch.setattr(lookup_module, "BATCH", 4)
    in_batches = lookup(LookupRequest(lut, asked, method, jobs=2), lambda *done: told.append(done))
    assert told == [(4, 11), (8, 11), (11, 11)]
    for name in (*ANSWERS, "status"):
        np.testing.assert_array_equal(getattr(in_batches, name), getattr(at_once, name))


def test_columns_and_counts(lut):
    found = answer(lut, [1.0, 9.0, 2.0], [0.2, 0.2, CURVATURE[-1]], [1.0, 1.0, HEADING[9]])
    columns = answer_columns(found)
    assert list(columns) == [
        "sprocket_rate_left_radps",
        "sprocket_rate_right_radps",
        "track_speed_left_mps",
        "track_speed_right_mps",
        "sideslip_rad",
        "slip_left",
        "slip_right",
        "status",
    ]
    assert columns["status"] == ["converged", "outside_table", "infeasible_grip"]
    np.testing.assert_allclose(
        columns["track_speed_left_mps"][0],
        columns["sprocket_rate_left_radps"][0] * VEHICLE.sprocket_radius,
        rtol=1e-15,
    )
    counts = status_counts(found)
    assert list(counts) == [status.label for status in LookupStatus]
    assert {word: count for word, count in counts.items() if count} == dict.fromkeys(columns["status"], 1)
