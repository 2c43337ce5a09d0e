"""`plot`: the right picture for a file that the tool wrote, told by its content."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

import numpy as np

from trackctl.errors import InputFileError, UsageError
from trackctl.files.atomic import whole_file
from trackctl.files.csv_table import CsvTable, cell_error, column, find_header, read_csv
from trackctl.files.lut_details import read_sensitivity
from trackctl.files.lut_reader import is_hdf5, read_lut
from trackctl.lut.axes import Array
from trackctl.plots import style
from trackctl.plots.forces import draw_forces
from trackctl.plots.identification import draw_identification
from trackctl.plots.lookup import draw_lookup
from trackctl.plots.plan import draw_plan
from trackctl.plots.prediction import draw_prediction
from trackctl.plots.saving import save
from trackctl.plots.sensitivity import draw_sensitivity
from trackctl.plots.simulation import draw_simulation
from trackctl.plots.style import Columns, Picture
from trackctl.plots.sweep import draw_sweep
from trackctl.plots.sweep_summary import draw_sweep_summary
from trackctl.plots.table import draw_table
from trackctl.sensitivity.pawn import PawnIndex, Statistic
from trackctl.units import split_suffix
from trackctl.workflows.operating_points import read_points


class FileKind(StrEnum):
    """What a file holds."""

    TABLE = "look-up table"
    SENSITIVITY = "sensitivity analysis"
    SWEEP = "sweep"
    SWEEP_SUMMARY = "summary of a sweep"
    SIMULATION = "simulation"
    PLAN = "plan"
    FORCES = "track forces"
    IDENTIFICATION = "identification"
    PREDICTION = "prediction"
    LOOKUP = "looked-up commands"


@dataclass(frozen=True, slots=True)
class CsvPicture:
    """A kind of CSV table and its picture.

    Attributes
    ----------
    kind
        What it holds.
    signature
        Headers that no other kind has together.
    whole
        Columns that must be full of finite numbers.
    gapped
        Columns that may hold empty cells and infinities.
    draw
        From the columns in SI, by their names without unit.
    optional
        Columns that may be missing, and hold empty cells.
    texts
        Columns of words, of which only the changes matter.
    """

    kind: FileKind
    signature: tuple[str, ...]
    whole: tuple[str, ...]
    gapped: tuple[str, ...]
    draw: Callable[[Columns], Picture]
    optional: tuple[str, ...] = ()
    texts: tuple[str, ...] = ()


PARAMETERS = tuple(f"p{number}" for number in range(1, 10))
PICTURES = (
    CsvPicture(
        FileKind.SWEEP,
        ("track_speed_inner_mps", "theoretical_radius_m"),
        ("slope_rad", "velocity_mps", "radius_m", "heading_rad"),
        (
            *(f"{name}_{side}" for name in ("track_speed", "body_speed") for side in ("inner_mps", "outer_mps")),
            "slip_inner",
            "slip_outer",
            "theoretical_radius_m",
        ),
        draw_sweep,
    ),
    CsvPicture(
        FileKind.SWEEP_SUMMARY,
        ("rmse_inner_mps", "max_radius_m"),
        ("slope_rad", "velocity_mps", "radius_m", "infeasible_count"),
        (
            "rmse_inner_mps",
            "rmse_outer_mps",
            "max_radius_m",
            "max_radius_heading_rad",
            "min_radius_m",
            "min_radius_heading_rad",
        ),
        draw_sweep_summary,
    ),
    CsvPicture(
        FileKind.SIMULATION,
        ("load_left_n", "yaw_rate_radps"),
        ("time_s", "x_m", "y_m", "yaw_rad", "forward_velocity_mps", "lateral_velocity_mps"),
        (
            "track_speed_left_mps",
            "track_speed_right_mps",
            "slip_left",
            "slip_right",
            "load_left_n",
            "load_right_n",
        ),
        draw_simulation,
    ),
    CsvPicture(
        FileKind.PLAN,
        ("segment", "sideslip_rad"),
        ("time_s", "x_m", "y_m", "yaw_rad", "velocity_mps"),
        ("sprocket_rate_left_radps", "sprocket_rate_right_radps", "sideslip_rad", "slip_left", "slip_right"),
        draw_plan,
        texts=("segment",),
    ),
    CsvPicture(
        FileKind.FORCES,
        ("force_difference_n", "friction_moment_nm"),
        ("arc_length_m", "x_m", "y_m", "speed_mps", "feasible"),
        (
            "slip_angle_rad",
            "yaw_gradient_1pm",
            "icr_offset_m",
            "force_total_n",
            "force_difference_n",
            "force_left_n",
            "force_right_n",
            "friction_moment_nm",
        ),
        draw_forces,
        optional=(
            "simulated_x_m",
            "simulated_y_m",
            "simulated_speed_mps",
            "simulated_yaw_rate_radps",
            "simulated_slip_angle_rad",
        ),
    ),
    CsvPicture(
        FileKind.IDENTIFICATION,
        ("icr_left_m", "innovation_x_m"),
        ("time_s", "accepted"),
        (
            *("icr_left_m", "icr_right_m", "icr_x_m", "innovation_x_m", "innovation_y_m"),
            *PARAMETERS,
            *(f"{name}_std" for name in PARAMETERS),
            *("position_error_m", "yaw_error_rad", "no_slip_position_error_m", "no_slip_yaw_error_rad"),
        ),
        draw_identification,
        optional=("icr_left_std_m", "icr_right_std_m", "icr_x_std_m"),
    ),
    CsvPicture(
        FileKind.PREDICTION,
        ("horizon_s", "yaw_std_rad"),
        ("time_s", "horizon_s"),
        ("x_m", "y_m", "yaw_rad", "x_std_m", "y_std_m", "yaw_std_rad"),
        draw_prediction,
        optional=(
            *("position_error_m", "yaw_error_rad", "no_slip_position_error_m", "no_slip_yaw_error_rad"),
            *("start_x_m", "start_y_m", "no_slip_x_m", "no_slip_y_m", "actual_x_m", "actual_y_m"),
        ),
    ),
    CsvPicture(
        FileKind.LOOKUP,
        ("sprocket_rate_left_radps", "track_speed_left_mps"),
        (),
        ("sprocket_rate_left_radps", "sprocket_rate_right_radps", "slip_left", "slip_right", "sideslip_rad"),
        draw_lookup,
    ),
)
#: Larger numbers are beyond what axes and their ticks can be computed for.
LARGEST = 1e30
SENSITIVITY_SIGNATURE = ("statistic", "index", "dummy")


@dataclass(frozen=True, slots=True)
class PlotRequest:
    """What to draw, and where to.

    Attributes
    ----------
    file
        The input, ``-`` for a CSV table on standard input.
    output
        The picture; its suffix tells the format.
    force
        Whether an existing picture is replaced.
    slope, velocity
        What is shown of a look-up table, the nearest node being taken; by default its first slope and middle speed.
        [rad], [m/s]
    sensitivity
        Draw the sensitivity analysis inside a look-up table in place of the table.
    """

    file: Path
    output: Path
    force: bool = False
    slope: float | None = None
    velocity: float | None = None
    sensitivity: bool = False


def plot(request: PlotRequest) -> FileKind:
    """Draw a file; the same file gives the same bytes.

    Raises
    ------
    InputFileError
        If the file cannot be read, or holds nothing that there is a picture for.
    UsageError
        If an option does not fit the file.
    OutputError
        If the picture cannot be written.
    """
    with style.applied():
        kind, figure = drawn(request)
        with whole_file(request.output, request.force) as path:
            save(figure, path)
    return kind


def drawn(request: PlotRequest) -> tuple[FileKind, Picture]:
    """What a file holds, and its picture, in the style that is applied."""
    if is_hdf5(request.file):
        if request.sensitivity:
            return FileKind.SENSITIVITY, draw_sensitivity(stored_indices(request.file))
        table = read_lut(request.file)
        slope = shown_node(table.axes.slope, request.slope, "--slope-deg", float(np.degrees(1.0)), 0)
        middle = table.axes.velocity.size // 2
        velocity = shown_node(table.axes.velocity, request.velocity, "--velocity-mps", 1.0, middle)
        return FileKind.TABLE, draw_table(table, slope, velocity)
    refuse_table_options(request)
    return csv_picture(read_csv(request.file))


def stored_indices(path: Path) -> tuple[PawnIndex, ...]:
    """The sensitivity analysis in a look-up table."""
    stored = read_sensitivity(path)
    if stored is None:
        raise InputFileError(path, "holds no sensitivity analysis, as its steps come from elsewhere")
    return stored.indices


def shown_node(nodes: Array, wanted: float | None, option: str, factor: float, default: int) -> int:
    """Index of the node nearest to a wanted value, which must lie among them; `factor` is to the option's unit."""
    if wanted is None:
        return default
    slack = 1e-9 * (1.0 + abs(wanted))
    if not nodes[0] - slack <= wanted <= nodes[-1] + slack:
        allowed = f"{factor * nodes[0]:g} to {factor * nodes[-1]:g}, the range of the table"
        raise UsageError(option, f"{factor * wanted:g}", allowed)
    return int(np.abs(nodes - wanted).argmin())


def refuse_table_options(request: PlotRequest) -> None:
    """Refuse the options that choose from a look-up table beside another file."""
    given = {
        "--slope-deg": request.slope if request.slope is None else f"{math.degrees(request.slope):g}",
        "--velocity-mps": request.velocity,
        "--sensitivity": request.sensitivity or None,
    }
    for option, value in given.items():
        if value is not None:
            raise UsageError(option, value, f"only beside a look-up table, which {request.file} is none")


def csv_picture(table: CsvTable) -> tuple[FileKind, Picture]:
    """What a CSV table holds, and its picture."""
    if has(table, SENSITIVITY_SIGNATURE):
        return FileKind.SENSITIVITY, draw_sensitivity(read_indices(table))
    for picture in PICTURES:
        if has(table, picture.signature):
            asked = asked_points(table) if picture.kind is FileKind.LOOKUP else {}
            return picture.kind, picture.draw(asked | columns_of(table, picture))
    raise InputFileError(
        table.file,
        f"holds nothing that there is a picture for: columns {', '.join(table.columns)}; "
        f"allowed: a file of {', '.join(FileKind)}",
    )


def has(table: CsvTable, headers: tuple[str, ...]) -> bool:
    """Whether a table has all of some columns, in whatever unit."""
    return all(find_header(table, header) is not None for header in headers)


def columns_of(table: CsvTable, picture: CsvPicture) -> dict[str, Array]:
    """The columns that a picture is drawn from, in SI, by their names without unit."""
    gapped = picture.gapped + tuple(header for header in picture.optional if find_header(table, header) is not None)
    found = {header: column(table, header) for header in picture.whole}
    found |= {header: column(table, header, may_be_empty=True, may_be_infinite=True) for header in gapped}
    for header, values in found.items():
        for row in np.flatnonzero(np.isfinite(values) & (np.abs(values) > LARGEST)):
            raise cell_error(table, str(find_header(table, header)), int(row), f"up to {LARGEST:g} either way in SI")
    columns = {split_suffix(header)[0]: values for header, values in found.items()}
    for header in picture.texts:
        _, codes = np.unique(table.columns[header], return_inverse=True)
        columns[header] = codes.astype(np.float64)
    return columns


def asked_points(table: CsvTable) -> dict[str, Array]:
    """The operating points that answers were looked up for, in SI."""
    points = read_points(table)
    return {"velocity": points.velocity, "curvature": points.curvature, "heading": points.heading}


def read_indices(table: CsvTable) -> list[PawnIndex]:
    """The indices in a CSV table."""
    for header in ("output", "input"):
        if header not in table.columns:
            raise InputFileError(table.file, f"column {header} is missing; there are: {', '.join(table.columns)}")
    statistics = [read_statistic(table, row) for row in range(len(table.lines))]
    numbers = (column(table, name).tolist() for name in ("index", "ci_low", "ci_high", "dummy"))
    rows = zip(table.columns["output"], table.columns["input"], statistics, *numbers, strict=True)
    return [PawnIndex(*row) for row in rows]


def read_statistic(table: CsvTable, row: int) -> Statistic:
    """The statistic in a row."""
    cell = table.columns["statistic"][row]
    if cell not in list(Statistic):
        raise cell_error(table, "statistic", row, ", ".join(Statistic))
    return Statistic(cell)
