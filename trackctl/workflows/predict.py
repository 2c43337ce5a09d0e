"""`predict`: where track speeds lead by a learned slip model, with uncertainty."""

from __future__ import annotations

from dataclasses import dataclass

from trackctl.errors import InputFileError, NoAnswerError
from trackctl.files.slip_yaml import SlipFile
from trackctl.identification.identifier import FilterSettings, LogFilter
from trackctl.profiles.vehicle import VehicleProfile
from trackctl.workflows.identify import Emit, check_horizon, filtered
from trackctl.workflows.update_columns import ErrorMeans, predict_columns

#: Gauges are the same within this, relative.
SAME_GAUGE = 1e-6


@dataclass(frozen=True, slots=True)
class PredictRequest:
    """What to predict.

    Attributes
    ----------
    log
        File, or ``-`` for standard input.
    slip
        The learned model.
    horizon
        How far ahead. [s]
    vehicle
        Refuse a slip model of another gauge; None to take it as it is.
    """

    log: str
    slip: SlipFile
    horizon: float = 2.0
    vehicle: VehicleProfile | None = None


@dataclass(frozen=True, slots=True)
class PredictResult:
    """Number of predictions, and the means of their errors, see `ErrorMeans.summary`."""

    predictions: int
    errors: dict[str, object]


def predict(request: PredictRequest, emit: Emit = lambda columns: None) -> PredictResult:
    """Predict from each pose of a log by the track speeds that follow it; the last ones hold on.

    Raises
    ------
    UsageError
        If the horizon is out of range.
    InputFileError
        If the log is none, or the slip model is of another vehicle.
    NoAnswerError
        If the log has no pose.
    """
    check_horizon(request.horizon, 1e-9)
    slip = request.slip
    if request.vehicle is not None and abs(request.vehicle.track_gauge / slip.track_gauge - 1.0) > SAME_GAUGE:
        problem = f"is of {slip.vehicle}, track gauge {slip.track_gauge:g} m; asked for is {request.vehicle.name}"
        raise InputFileError(slip.file, f"{problem}, {request.vehicle.track_gauge:g} m")
    filter_ = LogFilter(FilterSettings(slip.track_gauge, slip.model, horizon=request.horizon), slip.learned)
    means, count = ErrorMeans(), 0
    for updates in filtered(filter_, request.log, slip.sprocket_radius):
        means.add(updates)
        count += len(updates)
        emit(predict_columns(updates, request.horizon))
    if not count:
        raise NoAnswerError(f"{request.log}: there is no row with a time and a pose")
    return PredictResult(count, means.summary())
