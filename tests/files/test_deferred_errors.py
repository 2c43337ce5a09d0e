import os
from io import FileIO

import pytest
from systems import needs_pipe

from trackctl.files.deferred_errors import DeferredErrorFile


class FailingFile(FileIO):
    error = OSError("no")

    def write(self, content):
        raise self.error


class InterruptedFile(FailingFile):
    error = KeyboardInterrupt()


@pytest.mark.parametrize("base", [FailingFile, InterruptedFile])
def test_an_error_waits_until_it_is_asked_for(tmp_path, base):
    class Failing(DeferredErrorFile, base):
        pass

    with Failing(tmp_path / "file") as file:
        assert file.write(b"abc") == 3
        assert file.truncate(10) == 10
        with pytest.raises(type(base.error)) as raised:
            file.raise_deferred()
    assert raised.value is base.error
    assert not (tmp_path / "file").read_bytes()


def test_writes_go_through(tmp_path):
    with DeferredErrorFile(tmp_path / "file") as file:
        file.write(b"abc")
        file.seek(1)
        file.write(b"x")
        file.truncate(5)
        file.raise_deferred()
    assert (tmp_path / "file").read_bytes() == b"axc\0\0"


@needs_pipe
def test_a_pipe_is_refused(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(OSError, match="no pipe"):
        DeferredErrorFile(tmp_path / "pipe")
