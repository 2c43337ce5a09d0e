import io

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from trackctl.files.csv_table import column, read_csv
from trackctl.files.csv_writer import write_csv


def written(columns):
    stream = io.StringIO(newline="")
    write_csv(stream, columns)
    return stream.getvalue()


def test_types():
    columns = {
        "number": np.array([0.1, np.nan, -np.inf]),
        "count": np.array([1, 2, 3]),
        "feasible": np.array([True, False, True]),
        "note": ["plain", "with, comma", ""],
    }
    assert written(columns) == ('number,count,feasible,note\n0.1,1,1,plain\n,2,0,"with, comma"\n-inf,3,1,\n')


def test_no_rows():
    assert written({"a": np.empty(0), "b": []}) == "a,b\n"


def test_columns_of_unequal_length():
    with pytest.raises(ValueError):  # noqa: PT011
        written({"a": np.zeros(3), "b": np.zeros(2)})


@pytest.mark.parametrize("rows", [255, 256, 257])
def test_all_rows(rows):
    assert written({"a": np.arange(rows)}).split() == ["a", *map(str, range(rows))]


@settings(deadline=None)  # writes a file
@given(st.lists(st.floats(allow_nan=False), min_size=1))
def test_numbers_come_back_to_the_last_bit(tmp_path_factory, values):
    path = tmp_path_factory.getbasetemp() / "numbers.csv"
    path.write_text(written({"x_m": np.array(values), "y_m": np.array(values)}))
    np.testing.assert_array_equal(column(read_csv(path), "x_m", may_be_infinite=True), values)


# A line end inside a cell is left out: universal line ends would change it.
@settings(deadline=None)  # writes a file
@given(st.lists(st.text(st.characters(codec="utf-8", exclude_characters="\r\n\0"), min_size=0), min_size=1))
def test_text_comes_back_verbatim(tmp_path_factory, texts):
    path = tmp_path_factory.getbasetemp() / "texts.csv"
    path.write_bytes(written({"note": texts, "other": texts}).encode())
    assert read_csv(path).columns == {"note": texts, "other": texts}
