import math
from pathlib import Path

import numpy as np
import plot_examples
import pytest
from solved_tables import SLOPE, solved_table

from trackctl.errors import InputFileError, LutFormatError, OutputError, UsageError
from trackctl.files.csv_table import read_csv
from trackctl.files.lut_writer import write_lut
from trackctl.plots import style
from trackctl.plots.plan import draw_plan
from trackctl.workflows.plot import (
    PICTURES,
    FileKind,
    PlotRequest,
    columns_of,
    csv_picture,
    drawn,
    plot,
    shown_node,
)

KINDS = {
    FileKind.SIMULATION: plot_examples.simulation,
    FileKind.PLAN: plot_examples.plan,
    FileKind.FORCES: plot_examples.forces,
    FileKind.IDENTIFICATION: plot_examples.identification,
    FileKind.PREDICTION: plot_examples.prediction,
    FileKind.LOOKUP: plot_examples.lookup,
}


def picture_of(kind):
    return next(picture for picture in PICTURES if picture.kind is kind)


@pytest.fixture
def lut(tmp_path):
    path = tmp_path / "lut.h5"
    write_lut(path, solved_table(slopes=(0.0, SLOPE)))
    return path


@pytest.mark.parametrize("kind", KINDS)
def test_a_file_is_known_by_its_columns(tmp_path, kind):
    path = plot_examples.write(tmp_path / "any.csv", KINDS[kind]())
    with style.applied():
        assert drawn(PlotRequest(path, tmp_path / "any.png"))[0] is kind


@pytest.mark.parametrize("kind", KINDS)
def test_numbers_arrive_as_they_are_in_the_file(tmp_path, kind):
    path = plot_examples.write(tmp_path / "any.csv", KINDS[kind]())
    columns = columns_of(read_csv(path), picture_of(kind))
    for name, values in plot_examples.by_name(KINDS[kind]()).items():
        if name in columns:
            np.testing.assert_array_equal(columns[name], values)


@pytest.mark.parametrize("kind", KINDS)
def test_other_units_mean_the_same(tmp_path, kind):
    columns = KINDS[kind]()
    other = {
        {"x_m": "x_cm", "time_s": "time_ms", "yaw_rad": "yaw_deg"}.get(name, name): np.asarray(values)
        * {"x_m": 100.0, "time_s": 1000.0, "yaw_rad": math.degrees(1.0)}.get(name, 1.0)
        for name, values in columns.items()
    }
    paths = [plot_examples.write(tmp_path / name, each) for name, each in (("a.csv", columns), ("b.csv", other))]
    first, second = (columns_of(read_csv(path), picture_of(kind)) for path in paths)
    for name in first:
        np.testing.assert_allclose(first[name], second[name], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_each_column_of_a_picture_is_needed(tmp_path, kind):
    columns, picture = KINDS[kind](), picture_of(kind)
    for header in set(picture.whole + picture.gapped) - set(picture.signature):
        rest = {name: values for name, values in columns.items() if name != header}
        path = plot_examples.write(tmp_path / "part.csv", rest)
        with pytest.raises(InputFileError, match=f"part.csv: column {header} .*is missing; there are: "):
            csv_picture(read_csv(path))


def test_segments_may_be_words(tmp_path):
    columns = plot_examples.plan()
    columns["segment"] = ["forward"] * 40 + ["reverse"] * 40 + ["forward"] * 21
    path = plot_examples.write(tmp_path / "plan.csv", columns)
    with style.applied():
        axes = draw_plan(columns_of(read_csv(path), picture_of(FileKind.PLAN))).axes[0]
    (ends,) = (line for line in axes.get_lines() if line.get_label() == "end of a segment")
    np.testing.assert_array_equal(ends.get_xdata(), columns["x_m"][[40, 80]])


def test_a_table_and_what_is_shown_of_it(lut, tmp_path):
    picture = tmp_path / "lut.png"
    with style.applied():
        kind, figure = drawn(PlotRequest(lut, picture))
        _, other = drawn(PlotRequest(lut, picture, slope=SLOPE, velocity=0.8))
    assert kind is FileKind.TABLE
    assert figure.get_suptitle() == "utv-61cm on asphalt, slope 0°"
    assert figure.axes[4].get_title("left") == "(e) No answer at 1.5 m/s"
    assert other.get_suptitle() == "utv-61cm on asphalt, slope 12°"
    assert other.axes[4].get_title("left") == "(e) No answer at 1 m/s"


def test_nodes_are_chosen_within_the_table_only():
    nodes = np.array([0.1, 0.2, 0.4])
    assert [shown_node(nodes, value, "--a", 1.0, 1) for value in (None, 0.1, 0.29, 0.31, 0.4)] == [1, 0, 1, 2, 2]
    with pytest.raises(UsageError, match=r"--a: 41 is not allowed; allowed: 10 to 40, the range of the table"):
        shown_node(nodes, 0.41, "--a", 100.0, 0)
    with pytest.raises(UsageError, match="--a: nan"):
        shown_node(nodes, math.nan, "--a", 1.0, 0)


def test_a_table_without_an_analysis(lut, tmp_path):
    with pytest.raises(InputFileError, match="holds no sensitivity analysis"):
        plot(PlotRequest(lut, tmp_path / "a.png", sensitivity=True))


@pytest.mark.parametrize(
    ("options", "problem"),
    [({"slope": 0.1}, "--slope-deg"), ({"velocity": 1.0}, "--velocity-mps"), ({"sensitivity": True}, "--sensitivity")],
)
def test_options_of_tables_are_refused_beside_other_files(tmp_path, options, problem):
    path = plot_examples.write(tmp_path / "plan.csv", plot_examples.plan())
    with pytest.raises(UsageError, match=f"{problem}: .*allowed: only beside a look-up table, which .*plan.csv"):
        plot(PlotRequest(path, tmp_path / "a.png", **options))


SENSITIVITY = "output,input,statistic,index,ci_low,ci_high,dummy\na,b,{},{},0.1,0.3,0.1\n"


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        ("", "is empty"),
        ("a,b\n1,2\n", "holds nothing that there is a picture for: columns a, b; allowed: a file of look-up table"),
        (SENSITIVITY.format("mean", 0.2), "line 2: column statistic: 'mean' is not allowed; allowed: median, max"),
        (SENSITIVITY.format("max", "nan"), "line 2: column index: 'nan' is not allowed; allowed: a number"),
        (SENSITIVITY.format("max", 0.2).replace("output", "out"), "column output is missing"),
        ("time_s,load_left_n,yaw_rate_radps\n1,2,3\n", "column x_m or x_mm or x_cm or x_km is missing"),
        ("rmse_inner_mps,max_radius_furlong\n1,2\n", "column 'max_radius_furlong' has no unit of max_radius"),
        ("\0\1\2", "is binary"),
    ],
)
def test_files_that_cannot_be_drawn(tmp_path, content, problem):
    path = tmp_path / "wrong.csv"
    path.write_text(content)
    with pytest.raises(InputFileError, match=problem):
        plot(PlotRequest(path, tmp_path / "a.png"))
    assert not (tmp_path / "a.png").exists()


@pytest.mark.parametrize(("value", "cell"), [(np.nan, "''"), (np.inf, "'inf'"), (-1e308, "'-1e\\+308'")])
def test_cells_that_cannot_be_drawn(tmp_path, value, cell):
    columns = plot_examples.simulation()
    columns["x_m"][7] = value
    path = plot_examples.write(tmp_path / "simulation.csv", columns)
    with pytest.raises(InputFileError, match=f"simulation.csv, line 9: column x_m: {cell} is not allowed"):
        plot(PlotRequest(path, tmp_path / "a.png"))


def test_damaged_tables(lut, tmp_path):
    content = lut.read_bytes()
    lut.write_bytes(content[: len(content) // 2])
    with pytest.raises(LutFormatError, match="is damaged or cut off"):
        plot(PlotRequest(lut, tmp_path / "a.png"))


@pytest.mark.parametrize("file", ["missing.csv", "."])
def test_missing_files_and_folders(tmp_path, file):
    with pytest.raises(InputFileError, match="cannot be read"):
        plot(PlotRequest(tmp_path / file, tmp_path / "a.png"))


def test_an_existing_picture_stays_without_force(tmp_path):
    path = plot_examples.write(tmp_path / "plan.csv", plot_examples.plan())
    picture = tmp_path / "plan.png"
    picture.write_text("mine")
    with pytest.raises(OutputError, match="exists already"):
        plot(PlotRequest(path, picture))
    assert picture.read_text() == "mine"
    assert plot(PlotRequest(path, picture, force=True)) is FileKind.PLAN
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_the_same_file_gives_the_same_bytes(tmp_path, lut):
    pictures = [tmp_path / "first.svg", tmp_path / "second.svg"]
    for picture in pictures:
        plot(PlotRequest(lut, picture))
    assert pictures[0].read_bytes() == pictures[1].read_bytes()
    assert not list(Path(tmp_path).glob(".trackctl-*"))
