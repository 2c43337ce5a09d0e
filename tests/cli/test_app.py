import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
import typer
from patience import PATIENCE
from system_words import NO_SPACE
from typer.testing import CliRunner

from trackctl import __version__
from trackctl.cli import options
from trackctl.cli.app import app, exit_codes
from trackctl.errors import NoAnswerError, UsageError
from trackctl.mechanics.parameters import STANDARD_GRAVITY

HEAVY = {"numpy", "numba", "scipy", "h5py", "yaml", "rich", "matplotlib"}
FULL_DISK = Path("/dev/full")
TRACKCTL = [sys.executable, "-m", "trackctl"]


def heed_interrupts():
    """For a command that is to be interrupted, though these tests may run in the background, where nothing is."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def start(*words, **streams):
    return subprocess.Popen(
        [*TRACKCTL, *words], stderr=subprocess.PIPE, text=True, **streams, preexec_fn=heed_interrupts
    )


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


@pytest.mark.skipif(not FULL_DISK.exists(), reason="this system has no full disk to try")
@pytest.mark.parametrize("words", [["--help"], ["profiles", "list"]])
def test_a_full_disk_is_told(words):
    with FULL_DISK.open("w") as full:
        process = start(*words, stdout=full)
        assert process.communicate()[1] == f"Error: input or output: {NO_SPACE}\n"
    assert process.returncode == 2


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs a named pipe")
def test_ctrl_c_exits_130_without_a_traceback(tmp_path):
    fifo = tmp_path / "never.yaml"
    os.mkfifo(fifo)
    process = start("profiles", "check", str(fifo), stdout=subprocess.PIPE)
    with fifo.open("w"):  # returns once the command reads
        process.send_signal(signal.SIGINT)
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
