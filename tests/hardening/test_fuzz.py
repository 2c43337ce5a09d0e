"""Real files, damaged at random: a reader gives an answer or one error of ours, nothing else."""

import subprocess
import sys

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from patience import PATIENCE
from readers import READERS, real_files

from trackctl.errors import TrackctlError

#: What tends to hurt readers.
NASTY = (
    b"", b"\0", b"\xff", b"\xef\xbb\xbf", b"\r", b"\n\n", b",", b'"', b";", b"\t", b"nan", b"-inf", b"1e999", b"-0",
    b"1" * 400, b"0x1p3", b"1_000", "١".encode(), b"[" * 100, b"{", b"&a ", b"*a", b"!!python/name:os.system ",
    b"---\n", b"#", b": ", b"- ", b"? ", b"|\n", b"\xf0\x9f\x98\x80",
)  # fmt: skip
#: Changes of a file: where, as a share of its length, how much of it goes, and what comes in its place.
CHANGES = st.lists(
    st.tuples(st.floats(0.0, 1.0), st.integers(0, 60), st.one_of(st.sampled_from(NASTY), st.binary(max_size=8))),
    min_size=1,
    max_size=6,
)


def changed(content, changes):
    for share, gone, put in changes:
        place = int(share * len(content))
        content = content[:place] + put + content[place + gone :]
    return content


def refusal(read, path):
    """What a reader tells; of a file that it takes, only the name."""
    try:
        read(str(path))
    except TrackctlError as error:
        return str(error)
    return str(path)


@pytest.fixture(scope="module")
def real(inputs, tmp_path_factory):
    return real_files(inputs, tmp_path_factory.mktemp("real"))


@pytest.mark.parametrize("reader", READERS)
def test_the_real_file_is_read(reader, real, tmp_path):
    read, name = READERS[reader]
    (tmp_path / name).write_bytes(real[name])
    read(str(tmp_path / name))


@pytest.mark.parametrize("reader", READERS)
@settings(max_examples=150)
@given(changes=CHANGES)
@example(changes=[(0.0, 10**6, b"")])
def test_a_damaged_file_is_read_or_refused(reader, real, tmp_path, changes):
    read, name = READERS[reader]
    path = tmp_path / name
    path.write_bytes(changed(real[name], changes))
    told = refusal(read, path)
    assert told.startswith(str(path))
    assert "\n" not in told


@pytest.mark.parametrize("reader", READERS)
@settings(max_examples=60)
@given(content=st.binary(max_size=300))
def test_any_bytes_are_read_or_refused(reader, tmp_path, content):
    read, name = READERS[reader]
    path = tmp_path / name
    path.write_bytes(content)
    assert refusal(read, path).startswith(str(path))


DAMAGED_TABLES = """
import random, sys
from pathlib import Path
from trackctl.errors import LutFormatError
from trackctl.files.lut_reader import read_lut, read_lut_header

content, path, seed = Path(sys.argv[1]).read_bytes(), Path(sys.argv[2]), int(sys.argv[3])
chance, refused = random.Random(seed), 0
for _ in range(int(sys.argv[4])):
    damaged = bytearray(content)
    for _ in range(chance.randint(1, 8)):
        place = chance.randrange(len(damaged))
        size = chance.choice((1, 1, 2, 8, 64))
        damaged[place : place + size] = chance.choice((bytes(size), b"\\xff" * size, chance.randbytes(size)))
    if chance.random() < 0.2:
        del damaged[chance.randrange(len(damaged)) :]
    path.write_bytes(damaged)
    for read in (read_lut, read_lut_header):
        try:
            read(path)
        except LutFormatError as error:
            assert str(path) in str(error)
            refused += 1
print(refused)
"""


def test_damaged_tables_neither_crash_nor_raise_anything_else(inputs, tmp_path):
    """In a process of its own, as HDF5 is C."""
    words = (inputs["lut"], str(tmp_path / "damaged.h5"), "1", "300")
    run = subprocess.run(
        [sys.executable, "-c", DAMAGED_TABLES, *words], capture_output=True, text=True, timeout=PATIENCE
    )
    assert run.returncode == 0, run.stderr[-2000:]
    assert int(run.stdout) > 100
