"""Updates of a slip filter as columns of a CSV table, and the means of their prediction errors."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from trackctl.identification.identifier import Updates
from trackctl.identification.slip_model import GEOMETRIC, SlipModel

Array = NDArray[np.float64]
Columns = dict[str, Array | NDArray[np.bool_]]


def identify_columns(updates: Updates, model: SlipModel) -> Columns:
    """Columns of `identify`; those of the speed factors only where the model has them."""
    count = max(GEOMETRIC, model.learned.stop)
    columns: Columns = {"time_s": updates["pose"]["time"]}
    columns |= {f"icr_{name}_m": updates["icr"][:, i] for i, name in enumerate(("left", "right", "x"))}
    columns |= {f"p{i + 1}": updates["p"][:, i] for i in range(count)}
    columns |= {f"p{i + 1}_std": updates["std"][:, i] for i in range(count)}
    names = ("innovation_x_m", "innovation_y_m", "innovation_yaw_rad")
    columns |= {name: updates["innovation"][:, i] for i, name in enumerate(names)}
    columns |= {"accepted": updates["accepted"]} | error_columns(updates)
    return columns | {f"icr_{name}_std_m": updates["icr_std"][:, i] for i, name in enumerate(("left", "right", "x"))}


def predict_columns(updates: Updates, horizon: float) -> Columns:
    """Columns of `predict`."""
    columns: Columns = {"time_s": updates["pose"]["time"], "horizon_s": np.full(len(updates), horizon)}
    columns |= pose_columns("", updates["predicted"])
    columns |= {name: updates["predicted_std"][:, i] for i, name in enumerate(("x_std_m", "y_std_m", "yaw_std_rad"))}
    start = updates["pose"]
    columns |= error_columns(updates)
    columns |= {"start_x_m": start["x"], "start_y_m": start["y"], "start_yaw_rad": start["yaw"]}
    return columns | pose_columns("no_slip_", updates["no_slip"]) | pose_columns("actual_", updates["actual"])


def pose_columns(prefix: str, poses: Array) -> Columns:
    """Columns of poses, shape (n, 3)."""
    return {f"{prefix}{name}": poses[:, i] for i, name in enumerate(("x_m", "y_m", "yaw_rad"))}


def error_columns(updates: Updates) -> Columns:
    """Errors of the predictions, empty where the later pose is not known."""
    return {
        "position_error_m": updates["error"][:, 0],
        "yaw_error_rad": updates["error"][:, 1],
        "no_slip_position_error_m": updates["no_slip_error"][:, 0],
        "no_slip_yaw_error_rad": updates["no_slip_error"][:, 1],
    }


@dataclass(slots=True)
class ErrorMeans:
    """Running means of prediction errors, of position and heading, by the model and without slip."""

    sums: Array = field(default_factory=lambda: np.zeros((2, 2)))
    counts: Array = field(default_factory=lambda: np.zeros(2))

    def add(self, updates: Updates) -> None:
        """Take the errors that are known."""
        errors = np.stack((updates["error"], updates["no_slip_error"]))
        known = np.isfinite(errors).all(axis=0)
        self.sums += np.where(known, errors, 0.0).sum(axis=1)
        self.counts += known.sum(axis=0)

    def summary(self) -> dict[str, object]:
        """The means, and by how much the model reduces them; None where nothing is known."""
        return {"position_error_m": self._of(0), "heading_error_rad": self._of(1)}

    def _of(self, which: int) -> dict[str, float | None]:
        if not self.counts[which]:
            return dict.fromkeys(("model", "no_slip", "reduction_percent"))
        model, no_slip = (self.sums[:, which] / self.counts[which]).tolist()
        reduction = 100.0 * (1.0 - model / no_slip) if no_slip > 0.0 else None
        return {"model": model, "no_slip": no_slip, "reduction_percent": reduction}
