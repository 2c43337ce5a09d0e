import doctest
import math
import subprocess
import sys
import tomllib
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields
from importlib import import_module
from pathlib import Path

import api_sample
import numpy as np
import pytest
from solved_tables import SLOPE, TERRAIN, VEHICLE, solved_table

import trackctl
from trackctl.errors import LutFormatError, NoAnswerError, OutputError, ProfileError, TrackctlError, UsageError
from trackctl.files.lut_writer import write_lut
from trackctl.lut.interpolation import LookupResult, LookupStatus
from trackctl.lut.table import Status
from trackctl.simulation.track_force_drive import TrackForces

MODULES = [import_module(f"trackctl.api.{name}") for name in ("profiles", "tables", "motion", "planning")]
SAMPLE = Path(api_sample.__file__).resolve()
ROOT = Path(__file__).resolve().parent.parent
FUNCTIONS = [name for name in trackctl.__all__ if name.islower()]
# Documented where the workflows are.
ELSEWHERE = {"arc_path", "clothoid_path", "constant_speeds"}


def examples():
    """Docstrings with examples, by the name of what they document; what writes a table or a map first."""
    found = {test.name: test for module in MODULES for test in doctest.DocTestFinder().find(module) if test.examples}
    return dict(sorted(found.items(), key=lambda item: not item[0].endswith(("compile_table", "load_map"))))


EXAMPLES = examples()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("api")
    write_lut(folder / "lut.h5", solved_table())
    write_lut(folder / "slopes.h5", solved_table(slopes=(0.0, SLOPE)))
    return folder


@pytest.fixture(scope="module")
def opened(folder):
    return trackctl.open_table(folder / "lut.h5")


@pytest.fixture(scope="module")
def example_folder(tmp_path_factory):
    return tmp_path_factory.mktemp("examples")


@pytest.mark.parametrize("name", list(EXAMPLES))
def test_the_examples_run(example_folder, monkeypatch, capsys, name):
    monkeypatch.chdir(example_folder)
    runner = doctest.DocTestRunner(verbose=False)
    runner.run(EXAMPLES[name])
    assert runner.failures == 0, capsys.readouterr().out


def test_every_function_has_examples():
    assert {name.rpartition(".")[-1] for name in EXAMPLES} >= set(FUNCTIONS) - ELSEWHERE
    assert "trackctl.api.tables.LookupTable.lookup" in EXAMPLES


def test_everything_offered_is_documented():
    for name in trackctl.__all__:
        assert getattr(trackctl, name).__doc__


def fresh(code):
    """What a new interpreter prints."""
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()


def test_importing_loads_nothing():
    heavy = (
        "[name for name in sys.modules if name.split('.')[0] in ('numpy', 'numba', 'scipy', 'h5py', 'yaml', 'typer')"
    )
    assert fresh(f"import sys, trackctl; print(*{heavy} or name.startswith('trackctl.')])") == []


def test_profiles_load_no_kernels():
    code = "import sys, trackctl; trackctl.load_vehicle('m113'); print('numba' in sys.modules)"
    assert fresh(code) == ["False"]


def test_rooms_and_names_do_not_hide_each_other():
    code = (
        "import pkgutil, trackctl; "
        "rooms = {module.name for module in pkgutil.iter_modules(trackctl.__path__)}; "
        "rooms |= {path.name for path in __import__('pathlib').Path(trackctl.__path__[0]).iterdir()}; "
        "print(*rooms & set(trackctl.__all__))"
    )
    assert fresh(code) == []


def test_the_names_are_those_of_the_modules():
    offered = set().union(*(module.__all__ for module in MODULES))
    errors = {"TrackctlError", "UsageError", "InputFileError", "NoAnswerError"}
    assert sorted(trackctl.__all__) == sorted(offered | errors)
    assert set(trackctl.__all__) <= set(dir(trackctl))
    assert trackctl.__version__
    with pytest.raises(AttributeError, match="module 'trackctl' has no attribute 'plann'"):
        trackctl.plann  # noqa: B018


def test_the_sample_runs_without_a_word(folder, capfd):
    rate, status = api_sample.commands(folder)
    friction, x = api_sample.motions(folder)
    assert rate > 0.0
    assert status.tolist() == [LookupStatus.CONVERGED, LookupStatus.OUTSIDE_TABLE]
    assert 0.0 < friction < 1.0
    assert 0.3 < x < 0.5
    assert "no vehicle profile has this name" in api_sample.refused()
    assert capfd.readouterr() == ("", "")


def test_the_type_checker_reads_the_sample():
    """As strictly as the package: that a typo or a wrong type in it would be an error is asserted there."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["mypy"]
    assert settings["strict"]
    assert settings["warn_unused_ignores"]
    assert str(SAMPLE.relative_to(ROOT)) in settings["files"]
    assert (ROOT / "trackctl" / "py.typed").is_file()


def test_answers_have_the_shape_of_the_arguments(opened):
    grid = [[1.0], [1.5]], [0.0, 0.2, 0.5], (2, 3)
    for velocity, curvature, shape in ((1.0, 0.2, ()), ([1.0, 1.5], 0.2, (2,)), grid):
        for found in (
            opened.lookup(velocity, curvature, 1.0),
            opened.lookup(velocity, curvature, 1.0, method=trackctl.LookupMethod.EXACT),
            trackctl.solve_point(VEHICLE, TERRAIN, velocity, curvature, 1.0, SLOPE),
        ):
            assert {getattr(found, field.name).shape for field in fields(LookupResult)} == {shape}


def test_table_and_model_agree_at_the_nodes(opened):
    axes = opened.table.axes
    nodes = np.meshgrid(axes.velocity, axes.curvature[:4], axes.heading, indexing="ij")
    solved = trackctl.solve_point(VEHICLE, TERRAIN, *nodes, slope=SLOPE)
    for method in trackctl.LookupMethod:
        found = opened.lookup(*nodes, method=method)
        np.testing.assert_allclose(found.sideslip, solved.sideslip, atol=1e-8)
    np.testing.assert_allclose(
        solved.sprocket_rate_left, opened.table.values["sprocket_rate_left"][0, :, :4], atol=1e-8
    )


def test_a_point_outside_a_table_is_still_solved(opened):
    assert opened.lookup(0.2, 0.1, 0.0).status == LookupStatus.OUTSIDE_TABLE
    assert opened.lookup(np.nan, 0.1, 0.0).status == LookupStatus.OUTSIDE_TABLE
    assert trackctl.solve_point(VEHICLE, TERRAIN, 0.2, 0.1, 0.0, SLOPE).status == Status.CONVERGED


def test_one_of_several_slopes_is_named(folder):
    several = trackctl.open_table(folder / "slopes.h5")
    assert several.lookup(1.0, 0.2, 0.0, SLOPE).status == Status.CONVERGED
    with pytest.raises(UsageError, match="slope: is missing; allowed: a slope, as the table has 2"):
        several.lookup(1.0, 0.2, 0.0)


def circle(**words):
    target = {"radius": 2.0, "speed": 0.5, "laps": 1, "steering": trackctl.Steering.PATH} | words
    return trackctl.CircleTarget(**target)


def forced():
    time = np.array([0.0, 1.0])
    return trackctl.DriveCommands(TrackForces(time, time, time), None)


def solve(**words):
    return trackctl.solve_point(VEHICLE, TERRAIN, **{"velocity": 1.0, "curvature": 0.2, "heading": 0.0} | words)


def compiled(path, **words):
    return trackctl.compile_table(VEHICLE, TERRAIN, path, **{"slope": 0.1} | words)


def drive(target=None, **words):
    return trackctl.simulate(VEHICLE, TERRAIN, target or trackctl.constant_speeds(0.5, 0.5, 1.0), **words)


def forces(**words):
    return trackctl.nominal_forces(VEHICLE, trackctl.arc_path(5.0, 1.0), **words)


STEPS = {"velocity": 0.5, "radius": 5.0, "heading": 1.0}


@pytest.mark.parametrize(
    ("call", "option"),
    [
        (lambda: solve(velocity=0.0), "velocity"),
        (lambda: solve(velocity=[1.0, math.nan]), "velocity"),
        (lambda: solve(curvature=math.inf), "curvature"),
        (lambda: solve(heading=math.nan), "heading"),
        (lambda: solve(slope=0.25 * math.pi), "slope"),
        (lambda: solve(slope=-0.1), "slope"),
        (lambda: solve(gravity=0.0), "gravity"),
        (lambda: solve(velocity=[1.0, 2.0], curvature=[0.0, 0.1, 0.2]), "slope, velocity, curvature, heading"),
        (lambda: solve(velocity="fast"), "slope, velocity, curvature, heading"),
        (lambda: compiled("none.h5", slope=[0.2, 0.1]), "slope"),
        (lambda: compiled("none.h5", slope=[]), "slope"),
        (lambda: compiled("none.h5", gravity=math.nan), "gravity"),
        (lambda: compiled("none.h5", steps={"velocity": 0.5}), "steps"),
        (lambda: compiled("none.h5", steps=STEPS, budget=1000), "steps"),
        (lambda: compiled("none.h5", budget=0), "budget"),
        (lambda: compiled("none.h5", tolerance=1.0), "tolerance"),
        (lambda: compiled("-"), "--output"),
        (lambda: compiled("none.h5", radius=(0.1, 5.0)), "--radius-m"),
        (lambda: drive(slope=1.0), "slope"),
        (lambda: drive(uphill_yaw=math.nan), "uphill_yaw"),
        (lambda: drive(gravity=-1.0), "gravity"),
        (lambda: drive(duration=0.0), "duration"),
        (lambda: drive(tolerance=0.1), "tolerance"),
        (lambda: drive(interval=0.0), "interval"),
        (lambda: drive(feedback=trackctl.Measured.POSE), "feedback"),
        (lambda: drive(lut="lut.h5"), "lut"),
        (lambda: drive(circle(radius=0.1)), "radius"),
        (lambda: drive(circle(speed=0.0)), "speed"),
        (lambda: drive(circle(laps=0)), "laps"),
        (lambda: drive(circle(steering=trackctl.Steering.NO_SLIP), lut="lut.h5"), "lut"),
        (lambda: drive(forced(), slope=0.1), "slope"),
        (lambda: forces(speed=trackctl.SpeedRequest(None, 0.2, 0.0)), "speed"),
        (lambda: forces(speed=trackctl.SpeedRequest(None, -1.0, 1.0)), "speed"),
        (lambda: forces(slope=1.0), "slope"),
        (lambda: forces(uphill_yaw=math.inf), "uphill_yaw"),
        (lambda: forces(gravity=0.0), "gravity"),
        (lambda: forces(order=-1), "order"),
        (lambda: forces(step=0.0), "step"),
        (lambda: trackctl.load_path("path.csv", tolerance=-1.0), "tolerance"),
        (lambda: trackctl.load_path("path.csv", transition=0.0), "transition"),
        (lambda: trackctl.arc_path(0.0, 1.0), "--arc-deg"),
        (lambda: trackctl.export_table("lut.h5", "lut.csv"), "--output"),
        (lambda: trackctl.identify("log.csv", VEHICLE, horizon=-1.0), "--horizon-s"),
    ],
)
def test_an_argument_out_of_range_is_named(call, option):
    with pytest.raises(UsageError) as refused:
        call()
    assert refused.value.option == option
    assert refused.value.allowed


def test_other_errors_are_of_one_family(folder, tmp_path):
    for call, kind in (
        (lambda: trackctl.load_vehicle(tmp_path / "none.yaml"), ProfileError),
        (lambda: trackctl.load_terrain("mud-of-mars"), ProfileError),
        (lambda: trackctl.open_table(tmp_path / "none.h5"), LutFormatError),
        (lambda: trackctl.compile_table(VEHICLE, TERRAIN, folder / "lut.h5", slope=0.1), OutputError),
        (lambda: trackctl.load_path(tmp_path / "none.csv"), trackctl.InputFileError),
        (lambda: trackctl.identify(tmp_path / "none.csv", VEHICLE), trackctl.InputFileError),
        (lambda: compiled(tmp_path / "steep.h5", slope=0.78, velocity=(50.0, 60.0), steps=STEPS), NoAnswerError),
    ):
        with pytest.raises(kind) as refused:
            call()
        assert isinstance(refused.value, TrackctlError)
    assert list(tmp_path.iterdir()) == []


def test_a_budget_chooses_the_steps_and_progress_is_told(tmp_path):
    told = []
    table = compiled(
        tmp_path / "lut.h5", budget=3000, radius=(2.0, 10.0), progress=lambda done, total: told.append((done, total))
    ).table
    assert table.axes.size <= 3000
    assert "PAWN" in str(table.attributes["step_reason"])
    assert str(table.attributes["history"]).endswith(f"trackctl {trackctl.__version__}: trackctl.compile_table")
    columns = table.axes.curvature.size
    assert told == [(k, columns) for k in range(columns + 1)]


def test_identify_tells_its_updates(folder):
    api_sample.motions(folder)
    told = []
    result = trackctl.identify(folder / "log.csv", VEHICLE, horizon=1.0, on_updates=told.append)
    assert sum(columns["time_s"].size for columns in told) == result.updates


def test_a_table_compiled_by_an_executor_is_the_same(tmp_path, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "0")
    steps = {"velocity": 0.5, "radius": 5.0, "heading": math.radians(90.0)}
    asked = {"slope": SLOPE, "velocity": (0.5, 1.0), "radius": (5.0, 10.0), "steps": steps}
    trackctl.compile_table(VEHICLE, TERRAIN, tmp_path / "here.h5", **asked)
    with ThreadPoolExecutor(1) as pool:
        trackctl.compile_table(VEHICLE, TERRAIN, tmp_path / "there.h5", **asked, executor=pool, workers=2)
    assert (tmp_path / "here.h5").read_bytes() == (tmp_path / "there.h5").read_bytes()
