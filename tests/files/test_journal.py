import errno
import os
import subprocess
import sys
import tracemalloc
from itertools import islice

import pytest
from system_words import CANNOT_READ, FILE_TOO_LARGE, NO_FILE
from systems import disk_of, needs_file_limit

from trackctl.errors import InputFileError, OutputError, TrackctlWarning
from trackctl.files import journal
from trackctl.files.journal import Journal, journal_path

DIGEST = "d" * 64
REQUEST = {"vehicle": "utv-61cm", "steps": [0.5, 1.0]}
PAYLOADS = {7: b"seven", 0: b"", 3: bytes(range(256))}

KILLED = """
from pathlib import Path
import sys
import time
from trackctl.files.journal import Journal
journal = Journal.create(Path(sys.argv[1]), "d", {})
for block in range(20_000):
    journal.append(block, block.to_bytes(8, "little") * 1000)
    if block == 100:
        print("ready", flush=True)
time.sleep(3600)
"""


@pytest.fixture
def path(tmp_path):
    return journal_path(tmp_path / "lut.h5")


@pytest.fixture
def content(path):
    with Journal.create(path, DIGEST, REQUEST) as journal:
        for block, payload in PAYLOADS.items():
            journal.append(block, payload)
    return path.read_bytes()


def resumed(path):
    """All blocks of a resumed journal, after adding one more and resuming again."""
    with Journal.resume(path, DIGEST, REQUEST) as journal:
        found = {block: journal.read(block) for block in journal.blocks()}
        journal.append(99, b"more")
    with Journal.resume(path, DIGEST, REQUEST) as journal:
        assert {block: journal.read(block) for block in journal.blocks()} == found | {99: b"more"}
    return found


def test_it_lies_beside_the_output(tmp_path):
    assert journal_path(tmp_path / "lut.h5") == tmp_path / "lut.h5.partial"


def test_blocks_come_back(path, content):
    assert resumed(path) == PAYLOADS


def test_blocks_can_be_read_during_the_run(path):
    with Journal.create(path, DIGEST, REQUEST) as journal:
        for block, payload in PAYLOADS.items():
            journal.append(block, payload)
            assert journal.read(block) == payload
        assert journal.blocks() == set(PAYLOADS)


def test_a_later_record_of_a_block_counts(path):
    with Journal.create(path, DIGEST, REQUEST) as journal:
        journal.append(1, b"first")
        journal.append(1, b"second")
    assert resumed(path) == {1: b"second"}


def test_cut_off_at_any_byte(path, content):
    for size in range(len(content)):
        path.write_bytes(content[:size])
        found = resumed(path)
        assert found == dict(islice(PAYLOADS.items(), len(found)))
    assert len(found) == len(PAYLOADS) - 1


def test_a_damaged_byte_drops_its_record_and_what_follows(path, content):
    start = content.index(b"\n") + 1
    ends = []
    for payload in PAYLOADS.values():
        start += 20 + len(payload)
        ends.append(start)
    for place in range(content.index(b"\n") + 1, len(content)):
        damaged = bytearray(content)
        damaged[place] ^= 0x10
        path.write_bytes(damaged)
        whole = sum(end <= place for end in ends)
        assert resumed(path) == dict(islice(PAYLOADS.items(), whole))


def test_a_read_that_fails_is_no_torn_record(path, content, monkeypatch):
    def fail(stream):
        raise OSError(errno.EIO, CANNOT_READ)

    monkeypatch.setattr(journal, "whole_records", fail)
    with pytest.raises(InputFileError, match=f"cannot be read: {CANNOT_READ}"):
        Journal.resume(path, DIGEST, REQUEST)
    assert path.read_bytes() == content


def test_survives_being_killed(path):
    run = subprocess.Popen([sys.executable, "-c", KILLED, str(path)], stdout=subprocess.PIPE)
    with run:
        run.stdout.readline()
        try:
            with pytest.raises(OutputError, match="in use by another run"):
                Journal.resume(path, "d", {})
        finally:
            run.kill()
    with Journal.resume(path, "d", {}) as journal:
        assert journal.blocks() == set(range(len(journal.blocks())))
        assert len(journal.blocks()) > 100
        for block in journal.blocks():
            assert journal.read(block) == block.to_bytes(8, "little") * 1000


def test_resuming_nothing_starts(path):
    assert resumed(path) == {}


def test_work_is_dropped_only_when_forced(path, content):
    with pytest.raises(OutputError, match="--resume continues it, --force starts afresh"):
        Journal.create(path, DIGEST, REQUEST)
    assert path.read_bytes() == content
    with Journal.create(path, DIGEST, REQUEST, force=True) as journal:
        assert journal.blocks() == set()


def test_a_torn_header_is_no_work(path, content):
    path.write_bytes(content[:10])
    with Journal.create(path, DIGEST, REQUEST) as journal:
        assert journal.blocks() == set()


def test_another_request_is_refused(path, content):
    with pytest.raises(InputFileError, match=r"of another request.*--force"):
        Journal.resume(path, "e" * 64, REQUEST)
    assert path.read_bytes() == content


@pytest.mark.parametrize("foreign", [b"a,b\n1,2\n", b"{}\n", b"[1]\n", b"\0\n", b"\n", b"[" * 100_000, b"no end"])
def test_another_file_is_refused(path, foreign):
    path.write_bytes(foreign)
    with pytest.raises(InputFileError, match="no checkpoint"):
        Journal.resume(path, DIGEST, REQUEST)
    with pytest.raises(OutputError, match="--force"):
        Journal.create(path, DIGEST, REQUEST)
    assert path.read_bytes() == foreign


def test_another_version_is_refused(path, content):
    path.write_bytes(content.replace(b'"version": 1', b'"version": 2'))
    with pytest.raises(InputFileError, match="version 2; this trackctl reads 1"):
        Journal.resume(path, DIGEST, REQUEST)


def test_a_second_run_is_refused(path):
    with Journal.create(path, DIGEST, REQUEST):
        for start in (Journal.create, Journal.resume):
            with pytest.raises(OutputError, match="in use by another run"):
                start(path, DIGEST, REQUEST)
    Journal.resume(path, DIGEST, REQUEST).close()


def without_locks(monkeypatch, number):
    def refuse(descriptor, *, blocking):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr("filelock.lock_descriptor", refuse)


@pytest.mark.parametrize("number", [errno.ENOSYS, errno.ENOLCK, errno.EOPNOTSUPP])
def test_where_there_are_no_locks_it_says_so_and_goes_on(path, monkeypatch, number):
    without_locks(monkeypatch, number)
    with pytest.warns(TrackctlWarning) as told, Journal.create(path, DIGEST, REQUEST) as begun:
        begun.append(1, b"one")
    assert [str(each.message) for each in told] == [
        f"{path}: cannot be locked ({os.strerror(number)}); let no other run use it meanwhile"
    ]
    with pytest.warns(TrackctlWarning):
        assert resumed(path) == {1: b"one"}


@pytest.mark.filterwarnings("ignore:.*cannot be locked")
def test_what_another_run_has_written_over_is_not_taken_for_a_block(path, monkeypatch):
    without_locks(monkeypatch, errno.ENOLCK)
    with Journal.create(path, DIGEST, REQUEST) as first:
        for block, payload in enumerate((b"one", b"two")):
            first.append(block, payload)
        with Journal.create(path, DIGEST, REQUEST, force=True) as second:
            second.append(1, b"1st")
            for block in first.blocks():
                with pytest.raises(InputFileError, match="changed by another run"):
                    first.read(block)
            assert second.read(1) == b"1st"


def test_discard_removes_it(path):
    with Journal.create(path, DIGEST, REQUEST) as journal:
        journal.append(1, b"x")
        journal.discard()
    assert not path.exists()


def test_a_missing_folder(tmp_path):
    with pytest.raises(OutputError, match=NO_FILE):
        Journal.create(tmp_path / "missing" / "lut.h5.partial", DIGEST, REQUEST)


@needs_file_limit
def test_a_full_disk_keeps_the_blocks_before(path):
    with Journal.create(path, DIGEST, REQUEST) as journal:
        journal.append(1, b"x" * 1000)
        size = os.path.getsize(path)
        with disk_of(size + 100), pytest.raises(OutputError, match=FILE_TOO_LARGE):
            journal.append(2, b"y" * 1000)
        assert os.path.getsize(path) == size
        journal.append(3, b"z")
    assert resumed(path) == {1: b"x" * 1000, 3: b"z"}


def test_memory_holds_no_payloads(path):
    block = bytes(2**20)
    with Journal.create(path, DIGEST, REQUEST) as journal:
        for index in range(200):
            journal.append(index, block)
    tracemalloc.start()
    try:
        with Journal.resume(path, DIGEST, REQUEST) as journal:
            assert len(journal.blocks()) == 200
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    # 200 MiB are in the file, of which a piece of 1 MiB is read at a time.
    assert peak < 5 * 2**20
