"""Small real inputs for every command."""

import pytest
from shear_log import shear_log
from slip_simulation import as_csv
from typer.testing import CliRunner
from writing_commands import SMALL_TABLE

from trackctl.cli.app import app

MAP = "obstacles:\n  circles: [[5, 5, 1.2]]\nbounds_m: [0, 0, 10, 10]\nstart: [2, 2, 0]\ngoal: [8, 8, 90]\n"
POINTS = "velocity_mps,radius_m,heading_deg\n1,5,90\n1,-5,90\n0.7,inf,0\n"


@pytest.fixture(scope="session")
def run():
    return lambda words: CliRunner().invoke(app, list(words))


@pytest.fixture(scope="session")
def inputs(run, tmp_path_factory):
    """Paths by name, as the words of `COMMANDS` want them."""
    folder = tmp_path_factory.mktemp("inputs")
    names = ("log.csv", "lut.h5", "map.yaml", "points.csv", "slip.yaml", "sweep.csv")
    paths = {name: folder / name for name in names}
    paths["log.csv"].write_text(as_csv(shear_log("utv-61cm", "asphalt", 1.8)[0]))
    paths["map.yaml"].write_text(MAP)
    paths["points.csv"].write_text(POINTS)
    for words in (
        ["compute-lut", *SMALL_TABLE.split(), "--jobs", "1", "-o", paths["lut.h5"]],
        ["identify", paths["log.csv"], "--vehicle", "utv-61cm", "--save", paths["slip.yaml"]],
        ["sweep", "--slope-deg", "3,5", "--heading-deg", "0:360:30", "-o", paths["sweep.csv"]],
    ):
        result = run(map(str, words))
        assert result.exit_code == 0, result.stderr
    return {name.partition(".")[0]: str(path) for name, path in paths.items()}
