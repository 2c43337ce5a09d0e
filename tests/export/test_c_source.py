import ctypes
import math
import shutil
import subprocess
from dataclasses import fields, replace

import numpy as np
import pytest
from solved_tables import SLOPE
from table_variants import queries, scattered, variants

from trackctl.export.c_choices import CMethod, Precision
from trackctl.export.c_source import CTarget, c_source, comment, is_prefix
from trackctl.lut.axes import FULL_CIRCLE
from trackctl.lut.interpolation import LookupResult, LookupStatus, interpolant, look_up
from trackctl.lut.shape_functions import Method

STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Wconversion", "-Wshadow", "-Wdouble-promotion")
NAMES = [field.name for field in fields(LookupResult) if field.name != "status"]
NUMBERS = {Precision.DOUBLE: ctypes.c_double, Precision.FLOAT: ctypes.c_float}
TABLES = variants()

needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")


def gcc(*words):
    subprocess.run(["gcc", *map(str, words)], check=True)


def written(folder, table, precision, method=CMethod.LINEAR, prefix="robot"):
    """Header and source of a table in a folder."""
    found = c_source(table, CTarget(precision, prefix, "robot.h", method), {"vehicle": table.vehicle.description})
    (folder / "robot.h").write_text(found.header, encoding="ascii")
    (folder / "robot.c").write_text(found.source, encoding="ascii")
    return found


def compiled(folder, table, precision, method=CMethod.LINEAR):
    """What answers points of shape (4, n) by the compiled source: arrays by name, and status."""
    written(folder, table, precision, method)
    gcc(*STRICT, "-O2", "-shared", "-fPIC", folder / "robot.c", "-o", folder / "robot.so", "-lm")
    number = NUMBERS[precision]
    answer = type("Answer", (ctypes.Structure,), {"_fields_": [(name, number) for name in NAMES]})
    look = ctypes.CDLL(str(folder / "robot.so")).robot_lookup
    look.argtypes = [number] * 4 + [ctypes.POINTER(answer)]

    def answers(points):
        status, found = np.empty(points.shape[1], np.uint8), np.empty((len(NAMES), points.shape[1]))
        for k, point in enumerate(points.T.tolist()):
            into = answer(*[math.nan] * len(NAMES))
            status[k] = look(*point, ctypes.byref(into))
            found[:, k] = [getattr(into, name) for name in NAMES]
        return dict(zip(NAMES, found, strict=True)), status

    return answers


@pytest.fixture(scope="module", params=list(TABLES))
def table(request):
    return TABLES[request.param]


def expected(table, points, method=CMethod.LINEAR):
    return look_up(interpolant(table), *points, method=Method(method.value))


@needs_gcc
@pytest.mark.parametrize("method", list(CMethod))
def test_double_answers_as_lookup(tmp_path, table, method):
    points = queries(table, 2000)
    found, status = compiled(tmp_path, table, Precision.DOUBLE, method)(points)
    wanted = expected(table, points, method)
    np.testing.assert_array_equal(status, wanted.status)
    for name in NAMES:
        # Sums of 16 products of order 1, rates of 10, in another order; NaN there is 0 here.
        np.testing.assert_allclose(found[name], np.nan_to_num(getattr(wanted, name), nan=0.0), rtol=1e-13, atol=1e-13)


def test_the_points_meet_every_status_of_the_tables():
    met = set().union(*(expected(table, queries(table, 2000)).status.tolist() for table in TABLES.values()))
    stored = set().union(*(table.status.ravel().tolist() for table in TABLES.values()))
    only_queries = {LookupStatus.OUTSIDE_TABLE, LookupStatus.NEAR_INFEASIBLE, LookupStatus.ACTUATOR_LIMIT}
    assert met == stored | only_queries
    assert LookupStatus.INFEASIBLE_GRIP in stored


@needs_gcc
@pytest.mark.parametrize("method", list(CMethod))
def test_float_answers_as_lookup_to_six_digits(tmp_path, table, method):
    points = scattered(table, np.random.default_rng(2), 3000).astype(np.float32).astype(np.float64)
    found, status = compiled(tmp_path, table, Precision.FLOAT, method)(points)
    # An axis of one node is met by its rounding.
    for row, nodes in enumerate((table.axes.slope, table.axes.velocity, table.axes.curvature, table.axes.heading)):
        points[row] = nodes[0] if nodes.size == 1 else points[row]
    wanted = expected(table, points, method)
    np.testing.assert_array_equal(status, wanted.status)
    for name in NAMES:
        np.testing.assert_allclose(found[name], np.nan_to_num(getattr(wanted, name), nan=0.0), rtol=1e-6, atol=1e-6)


@needs_gcc
def test_float_meets_the_nodes_of_both_turns_and_of_other_circles(tmp_path):
    table = TABLES["two slopes"]
    axes = table.axes
    nodes = np.stack(
        [nodes.ravel() for nodes in np.meshgrid(axes.slope, axes.velocity, axes.curvature, axes.heading, indexing="ij")]
    )
    answers = compiled(tmp_path, table, Precision.FLOAT)
    for sides, turns in ((1.0, 0.0), (-1.0, 0.0), (1.0, 1.0), (1.0, -2.0)):
        points = nodes * np.array([1.0, 1.0, sides, sides])[:, None]
        points[3] += FULL_CIRCLE * turns
        found, status = answers(points)
        wanted = expected(table, points)
        np.testing.assert_array_equal(status, wanted.status)
        np.testing.assert_allclose(found["sideslip"], np.nan_to_num(wanted.sideslip, nan=0.0), atol=1e-6)


@needs_gcc
@pytest.mark.parametrize("precision", list(Precision))
def test_what_is_no_number_is_outside(tmp_path, precision):
    table = TABLES["symmetric"]
    answers = compiled(tmp_path, table, precision)
    points = np.tile([[SLOPE], [1.0], [0.2], [1.0]], 12)
    for k, worse in enumerate((math.nan, math.inf, -math.inf)):
        points[np.arange(4), 4 * k + np.arange(4)] = worse
    found, status = answers(points)
    assert set(status.tolist()) == {LookupStatus.OUTSIDE_TABLE}
    np.testing.assert_array_equal(expected(table, points).status, status)
    assert all((values == 0.0).all() for values in found.values())


CPP = """
#include "robot.h"
#include <cstdio>
int main() {
    robot_answer answer;
    if (robot_lookup(ROBOT_SLOPE_MIN, 1.0, 0.5 * ROBOT_CURVATURE_MAX, 0.0, &answer) != ROBOT_CONVERGED) return 1;
    std::printf("%.17g %ld", answer.sprocket_rate_left, ROBOT_TABLE_BYTES);
}
"""


@needs_gcc
@pytest.mark.skipif(shutil.which("g++") is None, reason="needs g++")
def test_cpp_uses_it(tmp_path):
    table = TABLES["symmetric"]
    size = written(tmp_path, table, Precision.DOUBLE).size
    (tmp_path / "main.cpp").write_text(CPP)
    gcc(*STRICT, "-c", tmp_path / "robot.c", "-o", tmp_path / "robot.o")
    linked = ["g++", "-std=c++11", *STRICT[1:], tmp_path / "main.cpp", tmp_path / "robot.o", "-o", tmp_path / "main"]
    subprocess.run([*map(str, linked), "-lm"], check=True)
    rate, bytes_ = subprocess.run([tmp_path / "main"], capture_output=True, text=True, check=True).stdout.split()
    (wanted,) = expected(table, np.array([[SLOPE], [1.0], [1.0], [0.0]])).sprocket_rate_left
    assert float(rate) == pytest.approx(wanted, rel=1e-13)
    assert int(bytes_) == size


@needs_gcc
def test_the_size_stated_is_that_of_the_object(tmp_path):
    sizes = {precision: written(tmp_path, TABLES["symmetric"], precision).size for precision in Precision}
    cells, nodes = TABLES["symmetric"].axes.size, 1 + 4 + 6 + 13
    assert sizes == {each: cells + (3 * cells + nodes) * each.size for each in Precision}
    gcc(*STRICT, "-Os", "-c", tmp_path / "robot.c", "-o", tmp_path / "robot.o")
    listed = subprocess.run(["size", tmp_path / "robot.o"], capture_output=True, text=True, check=True).stdout
    text, data, bss = map(int, listed.splitlines()[1].split()[:3])
    # Code, and four axes of pointers; nothing that changes.
    assert sizes[Precision.DOUBLE] < text + data < sizes[Precision.DOUBLE] + 3000
    assert bss == 0


@needs_gcc
def test_header_and_source_of_two_exports_do_not_compile(tmp_path):
    written(tmp_path, TABLES["symmetric"], Precision.DOUBLE)
    header = (tmp_path / "robot.h").read_text()
    written(tmp_path, TABLES["two slopes"], Precision.DOUBLE)
    (tmp_path / "robot.h").write_text(header)
    command = ["gcc", "-std=c99", "-c", str(tmp_path / "robot.c"), "-o", str(tmp_path / "robot.o")]
    refused = subprocess.run(command, capture_output=True, text=True, check=False)
    assert refused.returncode != 0
    assert "header and source are of different exports" in refused.stderr


@needs_gcc
def test_two_tables_link_into_one_program(tmp_path):
    written(tmp_path, TABLES["symmetric"], Precision.DOUBLE)
    gcc(*STRICT, "-c", tmp_path / "robot.c", "-o", tmp_path / "first.o")
    written(tmp_path, TABLES["two slopes"], Precision.FLOAT, prefix="Steep_2")
    gcc(*STRICT, "-c", tmp_path / "robot.c", "-o", tmp_path / "second.o")
    gcc("-shared", tmp_path / "first.o", tmp_path / "second.o", "-o", tmp_path / "both.so", "-lm")


@needs_gcc
def test_no_text_of_a_user_breaks_out_of_the_comment(tmp_path):
    text = "*/ #error /* ??/ \\ \n // \u202e über \x07"
    assert "*/" not in comment({"vehicle": text})
    assert comment({"vehicle": text}).isascii()
    (tmp_path / "comment.c").write_text(f"/*\n{comment({'vehicle': text, 'table': ''})}\n */\nextern int nothing;\n")
    gcc(*STRICT, "-fsyntax-only", tmp_path / "comment.c")


def test_nodes_that_single_precision_cannot_tell_apart_are_refused():
    table = TABLES["symmetric"]
    close = replace(table, axes=replace(table.axes, velocity=np.array([0.5, 1.0, 1.5, 1.5 + 1e-9])))
    with pytest.raises(ValueError, match="two nodes of velocity are one"):
        c_source(close, CTarget(Precision.FLOAT, "robot", "robot.h"), {"vehicle": ""})
    assert c_source(close, CTarget(Precision.DOUBLE, "robot", "robot.h"), {"vehicle": ""}).size


def test_prefixes():
    assert all(map(is_prefix, ("a", "trackctl", "M113_hard", "a" * 24)))
    assert not any(map(is_prefix, ("", "_a", "1a", "a-b", "a b", "ä", "a\n", "a" * 25)))
