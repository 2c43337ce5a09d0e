import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest
import typer
from patience import PATIENCE
from system_words import NO_SPACE
from systems import FULL_DISK, TRACKCTL, interrupt, needs_full_disk, needs_pipe, start
from typer.testing import CliRunner

from trackctl import __version__
from trackctl.cli import options
from trackctl.cli.app import app, exit_codes
from trackctl.errors import NoAnswerError, UsageError
from trackctl.mechanics.parameters import STANDARD_GRAVITY

SHIPPED = Path(__file__).parents[2] / "terrains"
HEAVY = {"numpy", "numba", "scipy", "h5py", "yaml", "rich", "matplotlib"}


def commands(command=None, path=()):
    """All commands and groups of the command line, by the words that call them."""
    command = command or typer.main.get_command(app)
    yield pytest.param(path, command, id=" ".join(("trackctl", *path)))
    for name, inner in getattr(command, "commands", {}).items():
        yield from commands(inner, (*path, name))


def ending(error):
    """Exit code after an error inside a command."""
    with pytest.raises(typer.Exit) as ended, exit_codes():
        raise error
    return ended.value.exit_code


def test_version():
    result = CliRunner().invoke(app, ["--version"])
    assert (result.exit_code, result.output) == (0, f"trackctl {__version__}\n")


@pytest.mark.parametrize(("path", "command"), list(commands()))
def test_every_command_has_help_with_an_example(path, command):
    result = CliRunner().invoke(app, [*path, "--help"])
    assert result.exit_code == 0
    assert command.help
    before, _, example = result.output.partition("Example:\n")
    assert before
    assert example.strip().startswith(" ".join(("trackctl", *path)[:2]))


def test_help_imports_nothing_heavy():
    code = f"import sys, trackctl.cli.app; print(*{HEAVY} & set(sys.modules))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert loaded.stdout.split() == []


@pytest.mark.parametrize("words", ["nonsense", "--nonsense", "profiles nonsense", "profiles show"])
def test_wrong_usage_exits_2(words):
    result = CliRunner().invoke(app, words.split())
    assert result.exit_code == 2
    assert "Error: " in result.stderr


def test_errors_become_messages_and_exit_codes(capsys):
    assert ending(NoAnswerError("no path")) == 1
    assert ending(UsageError("--radius-m", -1, "above 0")) == 2
    assert ending(OSError(28, NO_SPACE, "out.csv")) == 2
    assert ending(KeyboardInterrupt()) == 130
    out, err = capsys.readouterr()
    assert out == ""
    assert err.splitlines() == [
        "Error: no path",
        "Error: --radius-m: -1 is not allowed; allowed: above 0",
        f"Error: out.csv: {NO_SPACE}",
    ]


def test_a_defect_is_not_hidden():
    with pytest.raises(ZeroDivisionError), exit_codes():
        raise ZeroDivisionError


@pytest.mark.parametrize("words", [["--help"], ["profiles", "list"], ["profiles", "show", "m113"]])
def test_a_closed_pipe_ends_quietly(words):
    reading, writing = os.pipe()
    os.close(reading)
    process = start(*words, stdout=writing)
    os.close(writing)
    assert process.communicate()[1] == ""


def test_a_closed_pipe_ends_quietly_where_a_write_to_it_is_called_invalid(monkeypatch):
    dropped = []
    monkeypatch.setattr("trackctl.cli.app._drop_standard_output", lambda: dropped.append(True))
    monkeypatch.setattr(sys, "platform", "win32")
    assert ending(OSError(errno.EINVAL, "Invalid argument")) == 0
    assert ending(OSError(errno.EINVAL, "Invalid argument", "a?b.csv")) == 2
    assert dropped == [True]


@pytest.mark.parametrize("encoding", ["ascii", "cp1252", "utf-16"])
def test_standard_output_is_utf_8_whatever_the_system_has(tmp_path, encoding):
    file = tmp_path / "ground.yaml"
    text = (SHIPPED / "grass.yaml").read_text(encoding="utf-8").replace("description: ", "description: Gelände ≤ 20°, ")
    file.write_text(text, encoding="utf-8")
    environment = os.environ | {"PYTHONIOENCODING": encoding}
    shown = subprocess.run([*TRACKCTL, "profiles", "show", file], env=environment, stdout=subprocess.PIPE, check=True)
    assert shown.stdout.decode("utf-8").splitlines() == text.splitlines()


@pytest.mark.skipif(sys.platform != "linux", reason="needs names of files that are any bytes")
def test_a_name_that_is_no_text_can_be_told(tmp_path):
    file = tmp_path / os.fsdecode(b"\xff.yaml")
    file.write_bytes((SHIPPED / "grass.yaml").read_bytes())
    checked = subprocess.run([*TRACKCTL, "profiles", "check", file], stdout=subprocess.PIPE, check=True)
    assert checked.stdout.decode() == f"{tmp_path}/\\udcff.yaml: ok, terrain grass\n"


@pytest.mark.parametrize(
    ("stream", "words", "code"),
    [("stdin", "profiles check -", 2), ("stdout", "profiles list", 0), ("stderr", "profiles check missing.yaml", 2)],
)
def test_a_stream_may_be_closed(stream, words, code):
    run = f"import sys; sys.{stream} = None; import trackctl.__main__"
    done = subprocess.run([sys.executable, "-c", run, *words.split()], capture_output=True, text=True)
    assert done.returncode == code
    assert "Traceback" not in done.stderr
    assert ("<stdin>: is empty" in done.stderr) == (stream == "stdin")


@needs_full_disk
@pytest.mark.parametrize("words", [["--help"], ["profiles", "list"]])
def test_a_full_disk_is_told(words):
    with FULL_DISK.open("w") as full:
        process = start(*words, stdout=full)
        assert process.communicate()[1] == f"Error: input or output: {NO_SPACE}\n"
    assert process.returncode == 2


@needs_pipe
def test_ctrl_c_exits_130_without_a_traceback(tmp_path):
    fifo = tmp_path / "never.yaml"
    os.mkfifo(fifo)
    process = start("profiles", "check", str(fifo), stdout=subprocess.PIPE)
    with fifo.open("w"):  # returns once the command reads
        interrupt(process)
        _, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    assert "Traceback" not in err


def test_completion_is_offered():
    assert "--install-completion" in CliRunner().invoke(app, ["--help"]).output


def complete(words):
    """What bash would offer for the last of some words."""
    request = {
        "_TRACKCTL_COMPLETE": "complete_bash",
        "COMP_WORDS": words,
        "COMP_CWORD": str(words.count(" ")),
    }
    done = subprocess.run(TRACKCTL, env=os.environ | request, capture_output=True, text=True, check=True)
    return done.stdout.split()


def test_profile_names_complete():
    assert complete("trackctl profiles show m") == ["m113", "marder"]
    assert complete("trackctl profiles new ") == ["vehicle", "terrain"]
    assert options.complete_vehicle("utv") == ["utv-61cm"]
    assert options.complete_terrain("utv") == []


def with_options(*words):
    """The shared numbers as a command gets them: gravity, seed, jobs."""
    probe = typer.Typer(rich_markup_mode=None)

    @probe.command()
    def show(
        gravity: options.Gravity = options.DEFAULT_GRAVITY,
        seed: options.Seed = options.DEFAULT_SEED,
        jobs: options.Jobs = options.DEFAULT_JOBS,
    ) -> None:
        typer.echo(f"{gravity} {seed} {jobs}")

    return CliRunner().invoke(probe, words)


def test_shared_options_have_the_documented_defaults():
    gravity, seed, jobs = with_options().output.split()
    assert (float(gravity), int(seed)) == (STANDARD_GRAVITY, 0)
    assert int(jobs) >= 1
    assert "all cores" in " ".join(with_options("--help").output.split())


def test_shared_options_are_passed_on():
    words = ("--gravity-mps2", "1.62", "--seed", "7", "--jobs", "3")
    assert with_options(*words).output == "1.62 7 3\n"


@pytest.mark.parametrize(
    ("option", "value"),
    [
        *(("--gravity-mps2", value) for value in ("0", "-9.81", "100.1", "nan", "inf", "heavy")),
        *(("--seed", value) for value in ("-1", "0.5", "9" * 30)),
        *(("--jobs", value) for value in ("0", "-2", "many")),
    ],
)
def test_values_out_of_range_are_refused(option, value):
    result = with_options(option, value)
    assert result.exit_code == 2
    assert option in result.stderr
