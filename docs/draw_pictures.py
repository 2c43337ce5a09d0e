"""Draw the README's pictures with the tool itself.

Run from the repository: ``python docs/draw_pictures.py``. It needs the extra `plot`.
"""

from __future__ import annotations

import shlex
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image

FOLDER = Path(__file__).parent / "pictures"
WIDTH, COLOURS = 1000, 64
MAP = """\
bounds_m: [0, 0, 20, 20]
obstacles:
  circles: [[7.0, 8.8, 1.2], [10.5, 9.3, 0.4], [14.4, 10.7, 0.4], [14.9, 6.7, 0.7], [17.5, 4.1, 0.8], [5.9, 14.3, 0.6]]
  polygons: [[[8, 14], [12, 13], [12, 15], [9, 16]]]
start: [1.5, 1.5, 45]
goal: [18.5, 18.5, 45]
slope_deg: 12
"""
#: The commands of each picture, which the last one draws as `picture.png`.
PICTURES = {
    "table": (
        "compute-lut --vehicle m113 --terrain hard-soil --slope-deg 12.13 -o lut.h5",
        "plot lut.h5 --velocity-mps 4 -o picture.png",
    ),
    "simulation": (
        "simulate --track-speeds-mps 0.2567,0.5 --duration-s 70 -o drive.csv",
        "plot drive.csv -o picture.png",
    ),
    "plan": ("plan map.yaml --iterations 2000 -o plan.csv --plot picture.png",),
}


def draw(name: str) -> None:
    """Draw a picture, small enough for a repository."""
    with TemporaryDirectory() as folder:
        (Path(folder) / "map.yaml").write_text(MAP, encoding="utf-8")
        for command in PICTURES[name]:
            subprocess.run([sys.executable, "-m", "trackctl", *shlex.split(command)], cwd=folder, check=True)
        whole = Image.open(Path(folder) / "picture.png").convert("RGB")
        small = whole.resize((WIDTH, whole.height * WIDTH // whole.width), Image.Resampling.LANCZOS)
        small.quantize(COLOURS).save(FOLDER / f"{name}.png", optimize=True)


def main() -> None:
    FOLDER.mkdir(exist_ok=True)
    for name in PICTURES:
        draw(name)


if __name__ == "__main__":
    main()
