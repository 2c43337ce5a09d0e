"""A thread's solver, with all that it calls."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackctl.lut.branch import follow_there
from trackctl.lut.cell import cell_solver, improve_there, linearise_there, residuals_there
from trackctl.lut.swarm_search import search_there
from trackctl.mechanics.parameters import TrackModel


def solver(model: TrackModel) -> NDArray[np.void]:
    """A thread's solver of a model's cells, shape (1,), which also follows branches and searches with a swarm."""
    memory = cell_solver(model)
    memory["follow"], memory["search"] = follow_there.address, search_there.address
    return memory


def load_procedures() -> None:
    """Compile what a solver calls by address, or load it."""
    for procedure in (linearise_there, residuals_there, improve_there, follow_there, search_there):
        procedure.load()
