import errno
import os
import stat
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from patience import PATIENCE
from system_words import NO_SPACE
from systems import FULL_DISK, needs_devices, needs_full_disk, needs_pipe

from trackctl.errors import OutputError
from trackctl.files import atomic
from trackctl.files.atomic import check_output, whole_file, whole_files

OLD, NEW = "old", "new"


def write(path, text=NEW, force=False):
    with whole_file(path, force) as temporary:
        temporary.write_text(text)


def test_a_file_appears_when_the_block_ends(tmp_path):
    output = tmp_path / "out.csv"
    with whole_file(output, force=False) as temporary:
        temporary.write_text(NEW)
        assert not output.exists()
        assert temporary.parent == tmp_path
        assert temporary.suffix == ".csv"
    assert output.read_text() == NEW
    assert os.listdir(tmp_path) == ["out.csv"]


def test_permissions_are_those_of_any_new_file(tmp_path):
    (tmp_path / "plain").touch()
    write(tmp_path / "out")
    modes = {stat.S_IMODE((tmp_path / name).stat().st_mode) for name in ("plain", "out")}
    assert len(modes) == 1


@pytest.mark.parametrize("error", [KeyboardInterrupt, ValueError, SystemExit])
def test_nothing_changes_when_the_block_fails(tmp_path, error):
    output = tmp_path / "out.csv"
    output.write_text(OLD)

    def fail():
        with whole_file(output, force=True) as temporary:
            temporary.write_text(NEW)
            raise error

    with pytest.raises(error):
        fail()
    assert output.read_text() == OLD
    assert os.listdir(tmp_path) == ["out.csv"]


def test_an_existing_file_needs_force(tmp_path):
    output = tmp_path / "out.csv"
    output.write_text(OLD)
    for refuse in (check_output, write):
        with pytest.raises(OutputError, match=r"out\.csv: exists already; --force"):
            refuse(output, force=False)
    check_output(output, force=True)
    write(output, force=True)
    assert output.read_text() == NEW


def test_a_file_that_came_meanwhile_is_kept(tmp_path):
    output = tmp_path / "out.csv"
    with pytest.raises(OutputError, match="exists already"), whole_file(output, force=False):
        output.write_text(OLD)
    assert output.read_text() == OLD


def test_a_check_leaves_nothing(tmp_path):
    check_output(tmp_path / "out.csv", force=False)
    assert not os.listdir(tmp_path)


@pytest.mark.parametrize("force", [False, True])
@pytest.mark.parametrize(
    ("path", "problem"),
    [
        ("missing/out.csv", "there is no folder"),
        ("file/out.csv", "there is no folder"),
        ("folder", "is a folder"),
        ("x" * 300, "cannot be written: " + ("File name too long" if os.name == "posix" else "")),
    ],
)
def test_impossible_places(tmp_path, path, problem, force):
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").touch()
    for refuse in (check_output, write):
        with pytest.raises(OutputError, match=problem):
            refuse(tmp_path / path, force=force)


@pytest.mark.skipif(not Path("/proc/sys").is_dir(), reason="a folder that not even root can write to")
def test_a_folder_that_is_not_writable():
    with pytest.raises(OutputError, match="cannot be written"):
        check_output(Path("/proc/sys/out.csv"), force=False)


@pytest.mark.skipif(sys.platform == "win32", reason="where not every user may make a link")
def test_a_link_keeps_pointing_to_the_new_content(tmp_path):
    (tmp_path / "folder").mkdir()
    target, link = tmp_path / "folder" / "target", tmp_path / "link"
    target.write_text(OLD)
    link.symlink_to(target)
    write(link, force=True)
    assert link.is_symlink()
    assert target.read_text() == NEW


@needs_pipe
def test_a_pipe_is_written_directly(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    read = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_text()), daemon=True)
    reader.start()
    write(pipe)
    reader.join(timeout=PATIENCE)
    assert read == [NEW]


@needs_devices
def test_a_redirected_standard_output_is_written_directly(tmp_path):
    script = (
        "from pathlib import Path\n"
        "from trackctl.files.atomic import whole_file\n"
        "with whole_file(Path('/dev/stdout'), force=False) as path: path.write_text('new')"
    )
    with (tmp_path / "out.csv").open("w") as stream:
        subprocess.run([sys.executable, "-c", script], stdout=stream, check=True)
    assert (tmp_path / "out.csv").read_text() == NEW
    assert Path("/dev/stdout").is_symlink()


@needs_full_disk
def test_a_full_disk():
    with pytest.raises(OutputError, match=f"/dev/full: cannot be written: {NO_SPACE}"):
        write(FULL_DISK)


def test_a_closed_pipe_stays_what_it_is(tmp_path):
    with pytest.raises(BrokenPipeError), whole_file(tmp_path / "out.csv", force=False):
        raise BrokenPipeError


def test_writers_of_one_output_do_not_mix(tmp_path):
    output = tmp_path / "out.csv"
    texts = [letter * 100_000 for letter in "abcd"]
    writers = [threading.Thread(target=write, args=(output, text, True)) for text in texts]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join()
    assert output.read_text() in texts
    assert os.listdir(tmp_path) == ["out.csv"]


def write_pair(folder, force=False):
    paths = [folder / "pair.h", folder / "pair.c"]
    with whole_files(paths, force) as temporaries:
        for path, temporary in zip(paths, temporaries, strict=True):
            assert temporary.suffix == path.suffix
            temporary.write_text(NEW)
        assert not any(path.exists() and path.read_text() == NEW for path in paths)


def test_files_that_belong_together_appear_together(tmp_path):
    write_pair(tmp_path)
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"pair.h": NEW, "pair.c": NEW}


@pytest.mark.parametrize("taken", ["pair.h", "pair.c"])
def test_of_files_that_belong_together_none_appears_where_one_is_taken(tmp_path, taken):
    (tmp_path / taken).write_text(OLD)
    with pytest.raises(OutputError, match=r"exists already; --force"):
        write_pair(tmp_path)
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {taken: OLD}
    write_pair(tmp_path, force=True)
    assert {path.read_text() for path in tmp_path.iterdir()} == {NEW}


@pytest.mark.parametrize("suffix", [".h", ".c"])
def test_of_files_that_belong_together_none_appears_where_the_disk_has_no_room_for_one(tmp_path, monkeypatch, suffix):
    flush = atomic.flush_to_disk

    def full(path):
        if path.suffix == suffix:
            raise OSError(28, NO_SPACE)
        flush(path)

    monkeypatch.setattr(atomic, "flush_to_disk", full)
    with pytest.raises(OutputError, match=rf"pair\{suffix}: cannot be written: {NO_SPACE}"):
        write_pair(tmp_path)
    assert list(tmp_path.iterdir()) == []


@needs_pipe
def test_files_that_belong_together_are_no_pipes(tmp_path):
    os.mkfifo(tmp_path / "pair.c")
    with pytest.raises(OutputError, match=r"pair\.c: is a device or a pipe"):
        write_pair(tmp_path)
    assert os.listdir(tmp_path) == ["pair.c"]


def test_only_one_of_many_writers_takes_a_free_name(tmp_path, monkeypatch):
    """All of them find the name free twice, before and after their work; only one may have it."""
    output, ready, calls, refused = tmp_path / "out.csv", threading.Barrier(4), threading.local(), []
    refuse = atomic.refuse_occupied

    def refuse_together(path, force):
        refuse(path, force)
        calls.count = getattr(calls, "count", 0) + 1
        if calls.count <= 2:
            ready.wait(timeout=PATIENCE)

    def take(text):
        try:
            write(output, text)
        except OutputError:
            refused.append(text)

    monkeypatch.setattr(atomic, "refuse_occupied", refuse_together)
    writers = [threading.Thread(target=take, args=(letter,)) for letter in "abcd"]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join()
    assert len(refused) == 3
    assert sorted([*refused, output.read_text()]) == list("abcd")
    assert os.listdir(tmp_path) == ["out.csv"]


def test_where_files_have_one_name_only_the_output_still_appears(tmp_path, monkeypatch):
    def refuse(source, target):
        raise PermissionError(errno.EPERM, "Operation not permitted")

    monkeypatch.setattr(os, "link", refuse)
    write(tmp_path / "out.csv")
    assert (tmp_path / "out.csv").read_text() == NEW
    assert os.listdir(tmp_path) == ["out.csv"]
