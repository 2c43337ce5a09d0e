import numpy as np
import pytest
from system_words import NO_FILE

from trackctl.errors import MapError
from trackctl.files.map_file import read_planning_map

SMALL = "type octile\nheight 2\nwidth 4\nmap\n.G@T\nSWO.\n"


def written(tmp_path, content):
    path = tmp_path / "grid.map"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return str(path)


def test_cells_of_all_kinds_the_top_row_last(tmp_path):
    for text in (SMALL, SMALL.replace("\n", "\r\n"), SMALL + "\n\n"):
        occupancy = read_planning_map(written(tmp_path, text)).occupancy
        assert occupancy.cells.tolist() == [[0, 100, 100, 0], [0, 0, 100, 100]]
        assert (occupancy.frame.resolution, occupancy.frame.x, occupancy.frame.y) == (1.0, 0.0, 0.0)


def test_a_map_of_every_letter(tmp_path):
    """The format's (x, y) = (column, row from the top)."""
    letters = np.random.default_rng(0).choice(list(".GS@OTW"), (23, 32))
    rows = "".join(f"{''.join(row)}\n" for row in letters)
    cells = read_planning_map(written(tmp_path, f"type octile\nheight 23\nwidth 32\nmap\n{rows}")).occupancy.cells
    assert np.array_equal(cells[::-1] == 0, np.isin(letters, [".", "G", "S"]))
    assert np.isin(cells, (0, 100)).all()


def test_a_room_of_the_benchmark(data_of_others):
    room = data_of_others("movingai/room-32-32-4.map")
    cells = read_planning_map(str(room)).occupancy.cells
    lines = room.read_text().splitlines()[4:]
    assert cells.shape == (32, 32)
    assert (cells == 0).sum() == 682
    for x, y in ((3, 22), (18, 13), (0, 0), (31, 31)):
        assert (cells[31 - y, x] == 0) == (lines[y][x] == ".")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("type octile", "type tile", "line 1: is no MovingAI map; allowed: the lines `type octile`"),
        ("height 2\nwidth 4", "width 4\nheight 2", "line 1: is no MovingAI map"),
        ("height 2", "height 3", "has 2 rows; allowed: its height of 3"),
        ("height 2", "height 1", "has 2 rows; allowed: its height of 1"),
        ("height 2", "height -2", "line 2: height -2 is not allowed; allowed: height and a number from 1"),
        ("width 4", "width 4 5", "line 3: width 4 5 is not allowed"),
        ("width 4", "width 99999999", "has 99999999 x 2 cells; allowed: up to 16000000"),
        ("width 4", "width 5", "line 5: has 4 cells; allowed: the width of 5"),
        ("SWO.", "SWX.", "line 6: 'X' in column 3 is no cell; allowed: . G S @ O T W"),
        (SMALL, "", "is no MovingAI map"),
    ],
)
def test_what_is_no_such_map_is_refused(tmp_path, old, new, words):
    path = written(tmp_path, SMALL.replace(old, new))
    with pytest.raises(MapError) as error:
        read_planning_map(path)
    assert words in str(error.value)
    assert path in str(error.value)


def test_damaged_maps_read_or_are_refused(tmp_path):
    random = np.random.default_rng(0)
    for _ in range(300):
        content = bytearray(SMALL.encode())
        for place in random.integers(0, len(content), random.integers(1, 5)):
            content[place] = random.integers(0, 256)
        try:
            read_planning_map(written(tmp_path, bytes(content)))
        except MapError as error:
            assert "\n" not in str(error)  # noqa: PT017


def test_a_missing_map_is_refused(tmp_path):
    with pytest.raises(MapError, match=NO_FILE):
        read_planning_map(str(tmp_path / "none.map"))
