import io
import os
import sys
import threading

import numpy as np
import pytest

from trackctl.errors import InputFileError
from trackctl.files.log_stream import BLOCK_BYTES, LONGEST_LINE, Source, log_sources, read_blocks

HEADER = "time_s,track_speed_left_mps,track_speed_right_mps,x_m,y_m,yaw_rad\n"
SOURCES = log_sources(0.1)


@pytest.fixture
def read(tmp_path):
    def read(content, sources=SOURCES):
        path = tmp_path / "log.csv"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return np.concatenate(list(read_blocks(path, sources)))

    return read


def test_numbers_and_empty_cells(read):
    rows = read(HEADER + "0,1,2,3,4,5\n0.1,1,2,,,\n\n0.2,1e-1,-2,nan, ,inf\n")
    expected = [[0, 1, 2, 3, 4, 5], [0.1, 1, 2, np.nan, np.nan, np.nan], [0.2, 0.1, -2, np.nan, np.nan, np.inf]]
    assert np.array_equal(rows, expected, equal_nan=True)


def test_other_units_other_order_and_other_columns(read):
    rows = read(
        "note;yaw_deg;x_mm;y_m;time_ms;sprocket_rate_left_rpm;track_speed_right_kmph\na_b;90;1000;2;500;30;3.6\n"
    )
    assert rows[0] == pytest.approx([0.5, 0.1 * np.pi, 1.0, 1.0, 2.0, np.pi / 2])


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_line_ends_and_byte_order_mark(read, end):
    lines = [HEADER.strip(), *(f"{i},1,2,3,4,5" for i in range(9000))]
    content = ("\ufeff" + end.join(lines) + end).encode()
    assert len(content) > 2 * BLOCK_BYTES
    assert np.array_equal(read(content)[:, 0], np.arange(9000))
    assert np.array_equal(read(content.removesuffix(end.encode()))[:, 0], np.arange(9000))


def test_optional_columns_are_nan(read):
    rows = read("time_s\n1\n2\n", (Source((("time_s", 1.0),)), Source((("x_m", 1.0),), optional=True)))
    assert np.array_equal(rows, [[1, np.nan], [2, np.nan]], equal_nan=True)


@pytest.mark.parametrize(
    ("content", "line", "words"),
    [
        ("", None, "is empty"),
        ("\n \n", None, "is empty"),
        (HEADER, None, "no rows"),
        (HEADER + "\n\n", None, "no rows"),
        ("0,1,2,3,4,5\n", 1, "begins with numbers"),
        (HEADER.replace("x_m", "y_m"), 1, "there twice"),
        (HEADER.replace("x_m", "x"), None, "column 'x' has no unit"),
        (HEADER.replace("x_m", "x_s"), None, "column 'x_s' has no unit"),
        (HEADER.replace("x_m", "z"), None, "column x_m or x_mm or x_cm or x_km is missing"),
        (HEADER.replace("x_m", "x_m,yaw_deg") + "0,0,0,0,0,0,0\n", None, "mean the same"),
        (HEADER.replace("x_m", "x_m,sprocket_rate_left_radps") + "0,0,0,0,0,0,0\n", None, "mean the same"),
        (HEADER + "0,1,2,3,4,5\n0,1,2\n", 3, "has 3 cells; the header has 6"),
        (HEADER + "0,1,2,3,4,5\n\n0,1,one,3,4,5\n", 4, "column track_speed_right_mps: 'one' is not allowed"),
        (HEADER + "0,1,1_000,3,4,5\n", 2, "column track_speed_right_mps: '1_000' is not allowed"),
        (HEADER.encode() + b"0,1,2,3,4,5\n\xff,1,2,3,4,5\n", 3, "is no UTF-8 text"),
        (HEADER.encode() + b"0,1,2,3,4,5\n\0,1,2,3,4,5\n", None, "is binary or UTF-16"),
        (HEADER.encode("utf-16"), 1, "is binary or UTF-16"),
        (b"x" * (LONGEST_LINE + BLOCK_BYTES + 1), 1, "line longer than"),
        (HEADER + "0" * 200_000 + '",1,2,3,4,5\n', 2, "is no CSV"),
    ],
)
def test_what_is_no_log_is_refused(read, content, line, words):
    with pytest.raises(InputFileError, match=r"log\.csv") as error:
        read(content)
    assert words in str(error.value)
    assert line is None or error.value.line == line


def test_lines_are_counted_over_blocks(read):
    count = 3 * BLOCK_BYTES // 12
    with pytest.raises(InputFileError) as error:
        read(HEADER + "0,1,2,3,4,5\n" * count + "0,1,2,3,4,x\n")
    assert error.value.line == count + 2


def test_rows_before_a_fault_are_yielded(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(HEADER + "0,1,2,3,4,5\n" * BLOCK_BYTES + "x\n")
    blocks = read_blocks(path, SOURCES)
    assert len(next(blocks))
    with pytest.raises(InputFileError):
        list(blocks)


@pytest.mark.parametrize("kind", ["missing", "folder"])
def test_unreadable_files(tmp_path, kind):
    path = tmp_path / "log.csv" if kind == "missing" else tmp_path
    with pytest.raises(InputFileError, match="cannot be read"):
        next(read_blocks(path, SOURCES))


def test_a_pipe_is_read_as_it_comes(monkeypatch):
    """Rows are there before the pipe ends."""
    reader, writer = os.pipe()
    with open(reader, "rb") as stream, open(writer, "wb", buffering=0) as pipe:
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(stream))
        pipe.write((HEADER + "0,1,2,3,4,5\n1,1,2").encode())
        blocks = read_blocks("-", SOURCES)
        assert next(blocks).tolist() == [[0, 1, 2, 3, 4, 5]]
        threading.Timer(0.05, lambda: (pipe.write(b",3,4,5\n"), pipe.close())).start()
        assert [block.tolist() for block in blocks] == [[[1, 1, 2, 3, 4, 5]]]
