import sys
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
sys.path.insert(0, str(DOCS))

from write_pages import FOLDER, pages  # noqa: E402

PAGES = pages()


def words(text):
    """Without line breaks, which typer's versions set differently."""
    return text.split()


def test_every_command_has_a_page_and_every_page_a_command():
    assert {path.name for path in FOLDER.glob("*.md")} == PAGES.keys()


@pytest.mark.parametrize("name", PAGES)
def test_a_page_says_what_help_says(name):
    """To write the pages anew: python docs/write_pages.py."""
    assert words((FOLDER / name).read_text(encoding="utf-8")) == words(PAGES[name])
