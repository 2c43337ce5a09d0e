"""What a table will cost, before it is compiled."""

from __future__ import annotations

import time

import numpy as np

from trackctl.lut.sweep import Seeding, solve
from trackctl.workflows.table_request import TableRequest

#: Bytes of a cell in the file: eight float64 variables and the status.
CELL_BYTES = 65
#: Rough time of a cell on one thread where it is not measured. [s]
CELL_TIME = {Seeding.CONTINUATION: 5e-6, Seeding.PSO: 1.5e-4}
#: Columns that the time is measured on.
SAMPLE = 3


def rough_estimate(cells: int, seeding: Seeding, jobs: int) -> dict[str, float]:
    """Cells, bytes of the file, and seconds of solving, without solving any."""
    return {"cells": cells, "bytes": cells * CELL_BYTES, "seconds": CELL_TIME[seeding] * cells / jobs}


def estimate(request: TableRequest, jobs: int) -> dict[str, float]:
    """Cells, bytes of the file, and seconds of solving, from a few columns of the table."""
    sweep = request.sweep
    columns = np.unique(np.linspace(0, sweep.column_count - 1, SAMPLE).astype(int))
    solve(sweep, int(columns[0]))
    started = time.perf_counter()
    for column in columns:
        solve(sweep, int(column))
    each = (time.perf_counter() - started) / columns.size
    cells = sweep.axes.size
    return {**rough_estimate(cells, request.seeding, jobs), "seconds": each * sweep.column_count / jobs}
