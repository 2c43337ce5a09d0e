import pytest

from trackctl.plots import style


@pytest.fixture(autouse=True)
def styled():
    """Draw as the command does."""
    with style.applied():
        yield
