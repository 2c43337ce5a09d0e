"""What became of a table's cells, and how far interpolation between them errs."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from trackctl.errors import NoAnswerError
from trackctl.lut.axes import Array
from trackctl.lut.certificate import (
    ErrorCertificate,
    SwarmCheck,
    certify,
    check_by_swarm,
    random_arcs,
    random_near_straight,
)
from trackctl.lut.interpolation import Interpolant, interpolant_of
from trackctl.lut.table import Status
from trackctl.workflows.table_request import TableRequest

__all__ = ["ErrorCertificate", "TableSummary", "certificate_of", "count_status", "ready_for_lookup", "summary_of"]

#: Points of the error certificate, and between straight driving and the largest radius; cells of the swarm check.
CERTIFICATE_POINTS = 2000
NEAR_STRAIGHT_POINTS = 500
CHECKED_CELLS = 250


@dataclass(frozen=True, slots=True)
class TableSummary:
    """What became of a table.

    Attributes
    ----------
    cells
        Number of cells.
    status_counts
        Cells of each status.
    certificate, near_straight
        Interpolation error on turns of the table's radii, and between the largest radius and straight driving.
    swarm_check
        Sample of cells solved again.
    """

    cells: int
    status_counts: dict[Status, int]
    certificate: ErrorCertificate
    near_straight: ErrorCertificate
    swarm_check: SwarmCheck

    def attributes(self) -> dict[str, object]:
        """Root attributes that state it in the file."""
        named = {
            "certificate": asdict(self.certificate),
            "certificate_near_straight": asdict(self.near_straight),
            "swarm_check": asdict(self.swarm_check),
        }
        return {f"{group}_{key}": value for group, values in named.items() for key, value in values.items()}


def count_status(status: NDArray[np.uint8]) -> dict[Status, int]:
    """Cells of each status.

    Raises
    ------
    NoAnswerError
        If none has converged.
    """
    counted = np.bincount(status.ravel(), minlength=len(Status))
    counts = {each: int(counted[each]) for each in Status}
    if counts[Status.CONVERGED] == 0:
        reasons = ", ".join(f"{count} {each.name.lower()}" for each, count in counts.items() if count)
        raise NoAnswerError(f"no cell of the table is feasible: {reasons}")
    return counts


def ready_for_lookup(request: TableRequest, unknowns: Array, status: NDArray[np.uint8]) -> Interpolant:
    """Solved cells as a table without actuator limits; `unknowns` are overwritten where there is no answer."""
    return interpolant_of(request.axes, unknowns, status, request.vehicle, math.inf)


def certificate_of(table: Interpolant, request: TableRequest, jobs: int) -> ErrorCertificate:
    """Error on turns of the table's radii; the points depend on ranges and seed only."""
    points = random_arcs(request.axes, CERTIFICATE_POINTS, np.random.default_rng(request.seed))
    return certify(table, request.model, points, request.seed, jobs)


def near_straight_certificate_of(table: Interpolant, request: TableRequest, jobs: int) -> ErrorCertificate:
    """Error between the largest radius and straight driving."""
    points = random_near_straight(request.axes, NEAR_STRAIGHT_POINTS, np.random.default_rng(request.seed))
    return certify(table, request.model, points, request.seed, jobs)


def summary_of(request: TableRequest, unknowns: Array, status: NDArray[np.uint8], jobs: int) -> TableSummary:
    """Count the cells, check a sample of them and certify the interpolation.

    Parameters
    ----------
    request
        Of the table.
    unknowns, status
        Its cells, shapes (*axes.shape, 3) and axes.shape; the first is overwritten where there is no answer.
    jobs
        Threads.

    Raises
    ------
    NoAnswerError
        If no cell has converged.
    """
    counts = count_status(status)
    swarm = check_by_swarm(request.model, request.axes, unknowns, status, CHECKED_CELLS, request.seed, jobs)
    table = ready_for_lookup(request, unknowns, status)
    return TableSummary(
        cells=status.size,
        status_counts=counts,
        certificate=certificate_of(table, request, jobs),
        near_straight=near_straight_certificate_of(table, request, jobs),
        swarm_check=swarm,
    )
