"""Every command that writes: onto a full disk, into a closed folder, over an existing file."""

from pathlib import Path

import pytest
from systems import disk_of, needs_file_limit
from writing_commands import COMMANDS

CLOSED = Path("/proc/sys")


def told_once(result, path):
    """Whether a run ended with exit code 2 and one message that names a path."""
    told = result.stderr.partition("Error: ")[2]
    return result.exit_code == 2 and "Traceback" not in result.output and str(path) in told and told.count("\n") == 1


@needs_file_limit
@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
def test_a_full_disk_leaves_what_was_there(tmp_path, run, inputs, command):
    output = tmp_path / f"out{command.suffix}"
    line = command.line(inputs, output)
    first = run(line)
    assert first.exit_code == 0, first.stderr
    whole = output.read_bytes()
    with disk_of(len(whole) // 2):
        assert told_once(run([*line, "--force"]), output)
    assert output.read_bytes() == whole
    output.unlink()
    with disk_of(0):
        assert told_once(run([*line, "--force"]), output)
    assert {path.name for path in tmp_path.iterdir()} <= {"out.h5.partial"}


@pytest.mark.skipif(not CLOSED.is_dir(), reason="a folder that not even root can write to")
@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
def test_a_closed_folder_is_told(run, inputs, command):
    output = CLOSED / f"out{command.suffix}"
    assert told_once(run(command.line(inputs, output)), output)


@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
def test_an_existing_file_is_told_and_kept(tmp_path, run, inputs, command):
    output = tmp_path / f"out{command.suffix}"
    output.write_text("mine")
    assert told_once(run(command.line(inputs, output)), output)
    assert output.read_text() == "mine"
