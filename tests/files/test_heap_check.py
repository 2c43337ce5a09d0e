import numpy as np
import pytest
from lut_examples import example_table

from trackctl.errors import LutFormatError
from trackctl.files.heap_check import has_endless_heap, heaps
from trackctl.files.lut_reader import read_lut
from trackctl.files.lut_writer import write_lut


@pytest.fixture
def path(tmp_path):
    write_lut(tmp_path / "lut.h5", example_table())
    return tmp_path / "lut.h5"


def test_a_real_file_ends(path):
    assert list(heaps(path.read_bytes()))
    assert not has_endless_heap(path)


@pytest.mark.parametrize(("index", "size"), [(0, 0), (0, 2**63), (1, 2**63), (1, 2**64 - 16)])
def test_an_object_without_room_is_seen_before_hdf5_loops_on_it(path, index, size):
    """Free room of no size, and sizes that overflow."""
    content = bytearray(path.read_bytes())
    start = next(heaps(content)) + 16
    content[start : start + 16] = np.array([index, size], "<u8").tobytes()
    path.write_bytes(content)
    assert has_endless_heap(path)
    with pytest.raises(LutFormatError, match="is damaged"):
        read_lut(path)


def test_a_heap_cut_off_or_of_another_kind_is_left_to_hdf5(path):
    path.write_bytes(b"GCOL")
    assert not has_endless_heap(path)
    path.write_bytes(b"GCOL" + bytes(40))
    assert not has_endless_heap(path)
