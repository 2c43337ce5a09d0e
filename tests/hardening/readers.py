"""Every reader of a file that a user may hand in, with a real file: a row here is fuzzed by `test_fuzz`."""

from pathlib import Path

from trackctl.files.csv_table import read_csv
from trackctl.files.elevation_file import read_elevation
from trackctl.files.journal import Journal, journal_path
from trackctl.files.log_stream import log_sources, read_blocks
from trackctl.files.map_file import read_planning_map
from trackctl.files.path_csv import read_waypoints
from trackctl.files.profile_yaml import load_terrain, load_vehicle
from trackctl.files.slip_yaml import read_slip
from trackctl.workflows.drive_commands import read_commands
from trackctl.workflows.operating_points import read_points
from trackctl.workflows.plot import csv_picture

ROOT = Path(__file__).parent.parent.parent
HEADER = b"NCOLS 5\nNROWS 8\nXLLCORNER 556440.0\nYLLCORNER 5394932.0\nCELLSIZE 1.0\nNODATA_VALUE -9999\n"
GROUND = HEADER + 8 * b"543.340026855468977 -9999 544 5.41e2 543.5\n"


def read_journal(path):
    Journal.resume(path, "digest", {}).close()


#: By name: the reader, and the name of its file among `real_files`.
READERS = {
    "vehicle": (load_vehicle, "vehicle.yaml"),
    "terrain": (load_terrain, "terrain.yaml"),
    "slip": (read_slip, "slip.yaml"),
    "csv": (read_csv, "points.csv"),
    "points": (lambda path: read_points(read_csv(path)), "points.csv"),
    "commands": (lambda path: read_commands(read_csv(path), 0.1), "commands.csv"),
    "picture": (lambda path: csv_picture(read_csv(path)), "sweep.csv"),
    "map": (read_planning_map, "map.yaml"),
    "elevation": (lambda path: read_elevation(Path(path)), "ground.asc"),
    "path": (read_waypoints, "path.csv"),
    "log": (lambda path: list(read_blocks(path, log_sources(0.1))), "log.csv"),
    "checkpoint": (lambda path: read_journal(Path(path)), "lut.h5.partial"),
}


def real_files(inputs, folder):
    """A real file of each name, as bytes."""
    with Journal.create(journal_path(folder / "lut.h5"), "digest", {}) as journal:
        for block in range(5):
            journal.append(block, bytes(range(50)))
    return {
        "vehicle.yaml": (ROOT / "vehicles" / "utv-61cm.yaml").read_bytes(),
        "terrain.yaml": (ROOT / "terrains" / "asphalt.yaml").read_bytes(),
        "slip.yaml": Path(inputs["slip"]).read_bytes(),
        "points.csv": Path(inputs["points"]).read_bytes(),
        "sweep.csv": Path(inputs["sweep"]).read_bytes(),
        "commands.csv": b"time_s,track_speed_left_mps,track_speed_right_mps\n0,0.1,0.2\n1,0.1,0.2\n2,0.3,0.1\n",
        "map.yaml": Path(inputs["map"]).read_bytes(),
        "ground.asc": GROUND,
        "path.csv": b"x_m,y_m,speed_mps\n0,0,1\n20,0,1\n40,10,1\n60,10,1\n",
        "log.csv": b"".join(Path(inputs["log"]).read_bytes().splitlines(keepends=True)[:40]),
        "lut.h5.partial": (folder / "lut.h5.partial").read_bytes(),
    }
