"""Exception tree: each error carries its data and says what to change."""

from __future__ import annotations

from pathlib import Path


class TrackctlError(Exception):
    """Root of all errors that a user can mend."""


class TrackctlWarning(UserWarning):
    """What a user should know though the work goes on."""


class UsageError(TrackctlError):
    """An option or argument has a value that is not allowed.

    Parameters
    ----------
    option
        The option as typed, such as ``--radius-m``.
    value
        What was given; None where the option is needed and missing.
    allowed
        What would be accepted, as a phrase.
    """

    def __init__(self, option: str, value: object, allowed: str) -> None:
        self.option = option
        self.value = value
        self.allowed = allowed
        wrong = "is missing" if value is None else f"{value!s} is not allowed"
        super().__init__(f"{option}: {wrong}; allowed: {allowed}")


class InputFileError(TrackctlError):
    """A file cannot be read as what it should be.

    Parameters
    ----------
    file
        The file, or ``<stdin>``.
    problem
        What is wrong, as a phrase.
    line
        Line number from 1, where known.
    """

    def __init__(self, file: Path | str, problem: str, line: int | None = None) -> None:
        self.file = file
        self.problem = problem
        self.line = line
        where = f"{file}" if line is None else f"{file}, line {line}"
        super().__init__(f"{where}: {problem}")


class KeyedFileError(InputFileError):
    """A file of keys and values holds one that is not allowed.

    Parameters
    ----------
    file
        The file at fault.
    problem
        What is wrong, naming key, value and what is allowed.
    line
        Line number from 1, where known.
    key
        The key at fault, where one is.
    value
        Its value.
    """

    def __init__(
        self,
        file: Path | str,
        problem: str,
        line: int | None = None,
        key: str | None = None,
        value: object = None,
    ) -> None:
        self.key = key
        self.value = value
        super().__init__(file, problem, line)


class ProfileError(KeyedFileError):
    """A vehicle or terrain profile holds a key or value that is not allowed."""


class MapError(KeyedFileError):
    """A map, an image or elevation grid of one, or what it lays down for a plan is not allowed."""


class LutFormatError(InputFileError):
    """A file is no look-up table that this version can read."""


class LutMismatchError(InputFileError):
    """A look-up table was made for another vehicle, terrain or gravity than asked for."""


class OutputError(TrackctlError):
    """An output file cannot be written.

    Parameters
    ----------
    file
        The output file.
    problem
        What is wrong and what to do, as a phrase.
    """

    def __init__(self, file: Path | str, problem: str) -> None:
        self.file = file
        self.problem = problem
        super().__init__(f"{file}: {problem}")


class MissingLibraryError(TrackctlError):
    """A library is not installed that a command needs and others do not.

    Parameters
    ----------
    library
        Its name.
    purpose
        What it is needed for, as a phrase.
    command
        What installs it.
    """

    def __init__(self, library: str, purpose: str, command: str) -> None:
        self.library = library
        super().__init__(f"{purpose} needs {library}, which is not installed; to install it: {command}")


class WorkerError(TrackctlError):
    """Workers on this or other machines cannot do their part."""


class NoAnswerError(TrackctlError):
    """The question was well put and has no answer (exit code 1)."""
