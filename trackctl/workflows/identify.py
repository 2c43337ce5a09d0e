"""`identify`: learn a vehicle's slip from a log of track speeds and poses, as it comes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from trackctl.errors import NoAnswerError, UsageError
from trackctl.files.log_stream import log_sources, read_blocks
from trackctl.identification.identifier import FilterSettings, LearnedSlip, LogFilter, Noise, Updates
from trackctl.identification.slip_model import FilterKind, SlipModel
from trackctl.profiles.vehicle import VehicleProfile
from trackctl.workflows.update_columns import Columns, ErrorMeans, identify_columns

#: Drift of the model that is saved, in prior variances a second: it is of the ground of half a minute rather than of
#: the last turn, and predicts other stretches of a log better. [1/s]
LASTING_DRIFT = 5e-4
#: Largest window and horizon. [s]
LONGEST = 60.0
SHORTEST_WINDOW = 0.02

Emit = Callable[[Columns], None]


@dataclass(frozen=True, slots=True)
class IdentifyRequest:
    """What to learn from.

    Attributes
    ----------
    log
        File, or ``-`` for standard input.
    vehicle
        Whose gauge and sprocket radius count.
    model, kind, window, horizon
        See `FilterSettings`.
    saves
        Whether a lasting model is wanted, too.
    """

    log: str
    vehicle: VehicleProfile
    model: SlipModel = SlipModel.PARAMETRIC
    kind: FilterKind = FilterKind.WINDOW
    window: float | None = None
    horizon: float = 2.0
    saves: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class IdentifyResult:
    """What was learned, and how well it predicts.

    Attributes
    ----------
    slip
        The parameters at the end of the log.
    lasting
        The same from a filter that drifts less, `LASTING_DRIFT`; as `slip` if it was not wanted.
    updates, rejected
        Number of poses used, and of those among them that were refused.
    skipped_rows, held_poses, gaps, resets
        Rows without a time or out of order, poses that only repeat the last, gaps in the track speeds, and how often
        what was learned had to be forgotten.
    errors
        Means of the prediction errors, see `ErrorMeans.summary`.
    """

    slip: LearnedSlip
    lasting: LearnedSlip
    updates: int
    rejected: int
    skipped_rows: int
    held_poses: int
    gaps: int
    resets: int
    errors: dict[str, object]


def identify(request: IdentifyRequest, emit: Emit = lambda columns: None) -> IdentifyResult:
    """Learn from a log.

    Parameters
    ----------
    request
        What to learn from.
    emit
        Told the columns of each batch of updates, as soon as they are settled.

    Raises
    ------
    UsageError
        If window or horizon are out of range.
    InputFileError
        If the log is none.
    NoAnswerError
        If it has no pose.
    """
    check_horizon(request.horizon, 0.0)
    if request.window is not None and not SHORTEST_WINDOW <= request.window <= LONGEST:
        raise UsageError("--window-s", request.window, f"from {SHORTEST_WINDOW:g} to {LONGEST:g}")
    settings = FilterSettings(request.vehicle.track_gauge, request.model, request.kind, request.window, request.horizon)
    filter_ = LogFilter(settings)
    lasting = LogFilter(replace(settings, noise=Noise(drift=LASTING_DRIFT))) if request.saves else filter_
    means, count, rejected = ErrorMeans(), 0, 0
    for updates in filtered(filter_, request.log, request.vehicle.sprocket_radius, lasting):
        means.add(updates)
        count += len(updates)
        rejected += int(np.count_nonzero(~updates["accepted"]))
        emit(identify_columns(updates, request.model))
    if not count:
        raise NoAnswerError(f"{request.log}: there is no row with a time and a pose")
    return IdentifyResult(
        filter_.learned(),
        lasting.learned(), count, rejected, filter_.skipped, filter_.held, filter_.gaps, filter_.resets,
        means.summary(),
    )  # fmt: skip


def check_horizon(horizon: float, least: float) -> None:
    """Refuse a horizon out of range."""
    if not (least <= horizon <= LONGEST and (horizon == 0.0 or horizon >= SHORTEST_WINDOW)):
        zero = " (or 0 for no predictions)" if least == 0.0 else ""
        raise UsageError("--horizon-s", horizon, f"from {SHORTEST_WINDOW:g} to {LONGEST:g}{zero}")


def filtered(
    filter_: LogFilter, log: str, sprocket_radius: float, beside: LogFilter | None = None
) -> Iterator[Updates]:
    """Batches of updates of a log, those of its last poses at its end; none of them empty.

    Another filter `beside` is fed with the same rows.
    """
    for rows in read_blocks(log, log_sources(sprocket_radius)):
        if beside not in (None, filter_):
            beside.feed(rows)
        updates = filter_.feed(rows)
        if len(updates):
            yield updates
    updates = filter_.finish()
    if len(updates):
        yield updates


def slip_summary(request: IdentifyRequest, result: IdentifyResult) -> dict[str, object]:
    """The result for a script."""
    slip = result.slip
    std = np.sqrt(np.maximum(np.diag(slip.covariance), 0.0))
    return {
        "model": request.model.value,
        "filter": request.kind.value,
        "horizon_s": request.horizon,
        "updates": result.updates,
        "rejected": result.rejected,
        **result.errors,
        "parameters": {f"p{i + 1}": {"value": float(slip.p[i]), "std": float(std[i])} for i in request.model.learned},
        "model_error": {"position": slip.position_error, "heading": slip.heading_error},
        "skipped_rows": result.skipped_rows,
        "held_poses": result.held_poses,
        "gaps": result.gaps,
        "resets": result.resets,
    }
