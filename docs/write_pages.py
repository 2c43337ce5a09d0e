"""Write a page for each command from its ``--help``; a test checks that they are what it says.

Run from the repository: ``python docs/write_pages.py``.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import typer
from typer.testing import CliRunner

from trackctl.cli.app import app

FOLDER = Path(__file__).parent / "commands"
INDEX = "README.md"


def command_words(command: Any = None, words: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """The words that call each command, those of a group before those of its commands."""
    command = command or typer.main.get_command(app)
    if words:
        yield words
    for name, inner in getattr(command, "commands", {}).items():
        yield from command_words(inner, (*words, name))


def page(words: tuple[str, ...]) -> str:
    """The page of a command."""
    text = CliRunner(env={"COLUMNS": "80"}).invoke(app, [*words, "--help"]).output.strip("\n")
    return f"# trackctl {' '.join(words)}\n\n```text\n{text}\n```\n"


def pages() -> dict[str, str]:
    """All pages by file name, an index among them."""
    named = {f"{'-'.join(words)}.md": words for words in command_words()}
    links = [f"- [`trackctl {' '.join(words)}`]({name})" for name, words in named.items()]
    index = "\n".join(
        ("# Commands", "", "What `--help` says of each; written by `docs/write_pages.py`.", "", *links, "")
    )
    return {INDEX: index, **{name: page(words) for name, words in named.items()}}


def main() -> None:
    FOLDER.mkdir(exist_ok=True)
    for old in FOLDER.glob("*.md"):
        old.unlink()
    for name, text in pages().items():
        (FOLDER / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
