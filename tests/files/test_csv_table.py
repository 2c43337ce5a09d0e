import io
import math
import os
import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from patience import PATIENCE
from system_words import IS_FOLDER, NO_FILE, NO_FOLDER
from systems import needs_pipe

from trackctl.errors import InputFileError
from trackctl.files.csv_table import column, find_header, read_csv

SIMPLE = "velocity_mps,heading_deg,note\n1,90,a\n2.5,-180,b\n"


@pytest.fixture
def table_of(tmp_path):
    def read(content):
        path = tmp_path / "points.csv"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return read_csv(path)

    return read


def test_columns_are_raw_text(table_of):
    table = table_of(SIMPLE)
    assert table.columns == {
        "velocity_mps": ["1", "2.5"],
        "heading_deg": ["90", "-180"],
        "note": ["a", "b"],
    }
    assert table.lines == [2, 3]
    assert table.file.endswith("points.csv")


@pytest.mark.parametrize(
    "content",
    [
        SIMPLE.encode("utf-8-sig"),
        SIMPLE.replace("\n", "\r\n").encode(),
        SIMPLE.replace("\n", "\r").encode(),
        SIMPLE.replace(",", ";").encode(),
        SIMPLE.replace(",", "\t").encode(),
        SIMPLE.removesuffix("\n").encode(),
        SIMPLE.replace("velocity_mps,", " velocity_mps , ").encode(),
        SIMPLE.replace("note", '"note"').replace("a\n", '"a"\n').encode(),
    ],
    ids=["bom", "windows", "old mac", "semicolon", "tab", "no last line end", "blanks", "quotes"],
)
def test_dialects(table_of, content):
    assert table_of(content).columns == table_of(SIMPLE).columns


def test_commas_in_the_header_decide(table_of):
    assert table_of('a,"b;c"\n1,2;3\n').columns == {"a": ["1"], "b;c": ["2;3"]}


def test_empty_lines_are_skipped_but_counted(table_of):
    table = table_of("\na,b\n\n1,2\n\n\n3,4\n\n")
    assert table.columns["a"] == ["1", "3"]
    assert table.lines == [4, 7]


def test_a_quoted_line_end_counts(table_of):
    assert table_of('a,b\n1,"x\ny"\n2,z\n').lines == [3, 4]


def test_there_are_no_comments(table_of):
    assert table_of("a,b\n#1,2\n").columns["a"] == ["#1"]


@pytest.mark.parametrize("rows", [255, 256, 257, 1000])
def test_any_number_of_rows(table_of, rows):
    table = table_of("a,b\n" + "".join(f"{row},{-row}\n" for row in range(rows)))
    np.testing.assert_array_equal(column(table, "b"), -np.arange(rows))
    assert table.lines == list(range(2, rows + 2))


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        ("", "is empty"),
        ("\n\n", "is empty"),
        (",,\n1,2,3\n", "is empty"),
        ("a,b\n", "has a header but no rows"),
        ("1,2.5\n3,4\n", r"line 1: begins with numbers \(1,2\.5\); allowed: a header"),
        ("a,b,a\n1,2,3\n", "line 1: column 'a' is there twice"),
        ("a,b\n1,2\n3\n", "line 3: has 1 cells; the header has 2"),
        ("a,b\n1,2,3\n", "line 2: has 3 cells; the header has 2"),
        ('a,b\n1,"2\n', "line 2: is no CSV"),
        ("a,b\n1," + "x" * 200_000, "line 2: is no CSV"),
        (b"a,b\n1,\0\n", "is binary or UTF-16"),
        (SIMPLE.encode("utf-16"), "is binary or UTF-16"),
        (b"a,b\n1,2\n3,\xff\n", "line 3: is no UTF-8 text"),
    ],
)
def test_what_is_no_table(table_of, content, problem):
    with pytest.raises(InputFileError, match=rf"points\.csv.*{problem}"):
        table_of(content)


@pytest.mark.parametrize(
    ("path", "problem"),
    [("none.csv", NO_FILE), ("", IS_FOLDER), ("file/x.csv", NO_FOLDER)],
)
def test_what_cannot_be_read(tmp_path, path, problem):
    (tmp_path / "file").touch()
    with pytest.raises(InputFileError, match=problem):
        read_csv(tmp_path / path)


def test_standard_input(monkeypatch):
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(SIMPLE.encode())))
    table = read_csv("-")
    assert table.file == "<stdin>"
    assert table.columns["note"] == ["a", "b"]


@needs_pipe
def test_a_pipe(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    writer = threading.Thread(target=pipe.write_text, args=(SIMPLE,), daemon=True)
    writer.start()
    assert read_csv(pipe).columns["note"] == ["a", "b"]
    writer.join(timeout=PATIENCE)


@pytest.mark.parametrize(
    ("header", "key", "factor"),
    [
        ("heading_rad", "heading_rad", 1.0),
        ("heading_deg", "heading_rad", math.pi / 180.0),
        ("velocity_kmph", "velocity_mps", 1.0 / 3.6),
        ("slip_left", "slip_left", 1.0),
    ],
)
def test_numbers_in_si(table_of, header, key, factor):
    values = column(table_of(f"{header}\n1\n-2.5e1\n"), key)
    np.testing.assert_array_equal(values, np.array([1.0, -25.0]) * factor)
    assert values.dtype == np.float64


def test_empty_cells(table_of):
    table = table_of("x_m,y_m\n1,2\n,3\n nan , 4 \n")
    np.testing.assert_array_equal(column(table, "x_m", may_be_empty=True), [1.0, np.nan, np.nan])
    np.testing.assert_array_equal(column(table, "y_m"), [2.0, 3.0, 4.0])
    with pytest.raises(InputFileError, match=r"line 3: column x_m: '' is not allowed; allowed: a number"):
        column(table, "x_m")


def test_infinite_cells(table_of):
    table = table_of("radius_m\n5\ninf\n-inf\n")
    np.testing.assert_array_equal(column(table, "radius_m", may_be_infinite=True), [5.0, np.inf, -np.inf])
    with pytest.raises(InputFileError, match=r"line 3: column radius_m: 'inf' .* a finite number"):
        column(table, "radius_m")


@pytest.mark.parametrize("cell", ["x", "1_0", "1 2", "0x1", '"1,5"', "1e", "--1", "1.2.3"])
def test_what_is_no_number(table_of, cell):
    table = table_of(f"x_m,y_m\n1,2\n,3\n{cell},4\n5,6\n")
    with pytest.raises(InputFileError) as error:
        column(table, "x_m", may_be_empty=True)
    assert f"line 4: column x_m: {cell.strip(chr(34))!r} is not allowed; allowed: a number" in str(error.value)


def test_a_missing_column(table_of):
    table = table_of(SIMPLE)
    assert find_header(table, "slope_rad") is None
    assert find_header(table, "heading_rad") == "heading_deg"
    with pytest.raises(InputFileError, match=r"column slope_rad or slope_deg.* is missing; there are: velo"):
        column(table, "slope_rad")


@pytest.mark.parametrize("header", ["heading", "heading_m", "heading_degrees", "heading_"])
def test_a_column_in_no_unit_of_the_quantity(table_of, header):
    table = table_of(f"{header},heading_rate_degps\n1,2\n")
    for look in (find_header, column):
        with pytest.raises(InputFileError, match=f"column '{header}' has no unit of heading; .*heading_deg"):
            look(table, "heading_rad")


def test_a_column_in_two_units(table_of):
    with pytest.raises(InputFileError, match="columns heading_deg and heading_rad mean the same"):
        find_header(table_of("heading_deg,heading_rad\n1,2\n"), "heading_rad")


@settings(deadline=None)  # reads a file
@given(st.binary(max_size=60))
def test_any_bytes_are_a_table_or_an_error(tmp_path_factory, content):
    path = tmp_path_factory.getbasetemp() / "any.csv"
    path.write_bytes(content)
    try:
        table = read_csv(path)
    except InputFileError:
        return
    assert all(len(cells) == len(table.lines) for cells in table.columns.values())
