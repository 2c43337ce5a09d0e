"""Outputs do not depend on language, encoding or time zone; memory grows with the rows of a table and no faster."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

#: Writes one file of each kind, and what goes to standard output, into the current folder.
OUTPUTS = """
import os, sys
from pathlib import Path
from typer.testing import CliRunner
from trackctl.cli.app import app

inputs, = sys.argv[1:]
profile = os.fsdecode("{}/Gel\\u00e4nde.yaml".format(inputs).encode())
for name, words in {
    "lookup.csv": ["lookup", f"{inputs}/lut.h5", f"{inputs}/points.csv", "-o", "lookup.csv"],
    "lut.h5": ["compute-lut", "--steps", "velocity=.5,radius=9,heading=60", "--velocity-mps", "1:2", "--radius-m",
               "1:10", "--terrain", profile, "-o", "lut.h5"],
    "forces.csv": ["forces", "-o", "forces.csv"],
    "sweep.csv": ["sweep", "--slope-deg", "3", "--heading-deg", "0:360:60", "-o", "sweep.csv"],
    "show.txt": ["profiles", "show", profile],
    "info.txt": ["info", f"{inputs}/lut.h5", "--json"],
}.items():
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 0, (name, result.stderr, result.exception)
    if not Path(name).exists():
        Path(name).write_bytes(result.stdout_bytes)
"""
SURROUNDINGS = {
    "plain": {"LC_ALL": "C.UTF-8", "TZ": "UTC"},
    "ascii": {"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0", "TZ": "Asia/Kathmandu"},
    "german": {"LC_ALL": "de_DE.UTF-8", "LANG": "de_DE.UTF-8", "LANGUAGE": "de", "TZ": "America/St_Johns"},
}


@pytest.fixture(scope="module")
def files(inputs, tmp_path_factory):
    """Contents of the files written in each of the surroundings."""
    folder = Path(inputs["lut"]).parent
    profile = (Path(__file__).parents[2] / "terrains" / "grass.yaml").read_text("utf-8")
    (folder / "Gelände.yaml").write_text(profile.replace("description: ", "description: Gelände, ", 1), "utf-8")
    found = {}
    for name, variables in SURROUNDINGS.items():
        here = tmp_path_factory.mktemp(name)
        environment = os.environ | {"SOURCE_DATE_EPOCH": "86400", "PYTHONPATH": os.pathsep.join(sys.path)} | variables
        run = subprocess.run(
            [sys.executable, "-c", OUTPUTS, str(folder)], cwd=here, env=environment, capture_output=True, text=True
        )
        assert run.returncode == 0, run.stderr
        found[name] = {path.name: path.read_bytes() for path in here.iterdir()}
    return found


@pytest.mark.parametrize("name", ["ascii", "german"])
def test_language_encoding_and_time_zone_change_no_byte(files, name):
    assert len(files["plain"]) == 6
    assert files[name] == files["plain"]


MEMORY = """
import re, sys
from pathlib import Path
from typer.testing import CliRunner
from trackctl.cli.app import app

def peak(rows):
    "Memory after a lookup of so many rows. [bytes]"
    with open("points.csv", "w") as stream:
        stream.write("velocity_mps,radius_m,heading_rad\\n")
        stream.writelines(f"{0.5 + row % 100 / 100:.6f},{1 + row % 17:.6f},{row % 6:.6f}\\n" for row in range(rows))
    result = CliRunner().invoke(app, ["lookup", sys.argv[1], "points.csv", "-o", "out.csv", "--force"])
    assert result.exit_code == 0, result.stderr
    # `getrusage` would count what the parent held when it started this process, too.
    return 1024 * int(re.search(r"VmHWM:\\s+(\\d+)", Path("/proc/self/status").read_text())[1])

few = peak(1000)  # compiled, as the many are
print((peak(100_000) - few) / 100_000)
"""


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="where Linux tells a process's peak memory")
def test_a_long_table_takes_little_memory_a_row(inputs, tmp_path):
    """A million rows take 608 MB, of which 150 MB are the program; the bound leaves twice as much."""
    run = subprocess.run([sys.executable, "-c", MEMORY, inputs["lut"]], cwd=tmp_path, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert 100.0 < float(run.stdout) < 900.0
