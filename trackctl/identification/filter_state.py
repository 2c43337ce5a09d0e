"""Memory of the filter: constant in size, however long the log."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackctl.identification.kalman import ESTIMATE
from trackctl.identification.slip_model import PARAMETERS
from trackctl.identification.track_history import MOTION

#: Places in the ring of poses, and in that of the updates whose predictions are not settled.
POSES, UPDATES = 4096, 8192
#: Updates that may wait to be settled; the ring has room for as many more that wait to be fetched.
MOST_WAITING = UPDATES // 2
#: Rows taken between two fetches of finished updates.
ROWS_AT_ONCE = 2048

POSE = np.dtype(
    [
        ("time", np.float64),  # [s]
        ("x", np.float64),  # [m]
        ("y", np.float64),
        ("yaw", np.float64),  # [rad]
        ("has_position", np.bool_),
    ],
    align=True,
)

#: What a pose has brought, and what was predicted from it.
UPDATE = np.dtype(
    [
        ("pose", POSE),
        ("icr", np.float64, 3),  # y of the left and right track's, and their x, at the row's speeds [m]
        ("icr_std", np.float64, 3),
        ("p", np.float64, PARAMETERS),
        ("std", np.float64, PARAMETERS),
        ("innovation", np.float64, 3),  # [m, m, rad]; NaN where nothing was compared
        ("accepted", np.bool_),
        ("predicted", np.float64, 3),  # pose after the horizon, in the world [m, m, rad]
        ("predicted_std", np.float64, 3),
        ("no_slip", np.float64, 3),  # the same without slip
        ("actual", np.float64, 3),  # and the pose that came, interpolated; NaN where it is not known
        ("error", np.float64, 2),  # of position [m] and heading [rad]; NaN where the later pose is not known
        ("no_slip_error", np.float64, 2),
    ],
    align=True,
)

LOG_FILTER = np.dtype(
    [
        # Settings.
        ("gauge", np.float64),  # [m]
        ("window", np.float64),  # [s]
        ("shortest_window", np.float64),  # where the window follows the poses, its bounds
        ("longest_window", np.float64),
        ("horizon", np.float64),  # [s]
        ("resolution", np.float64),  # of the track history [s]
        ("position_variance", np.float64),  # of the sensors [m2]
        ("heading_variance", np.float64),  # [rad2]
        ("speed_variance", np.float64),  # [m2/s2]
        ("by_velocity", np.bool_),
        ("learns", np.bool_),
        ("gates", np.bool_),  # whether poses may be rejected
        # The log so far.
        ("started", np.bool_),
        ("now", np.float64),  # [s]
        ("speeds_at", np.float64),  # time of the last track speeds [s]
        ("interval", np.float64),  # mean time between track speeds [s]
        ("pose_interval", np.float64),  # and between poses
        ("continuous_since", np.float64),  # end of the last gap [s]
        ("left", np.float64),  # track speeds that hold now [m/s]
        ("right", np.float64),
        ("left_before", np.float64),  # and those before them
        ("right_before", np.float64),
        ("left_roughness", np.float64),  # mean deviation from the median of three [m/s]
        ("right_roughness", np.float64),
        ("rolled", np.float64),  # distance since the last pose [m]
        ("last", POSE),  # pose, and the last one that was not rejected
        ("trusted", POSE),
        ("updated_at", np.float64),  # [s]
        ("mean_error", np.float64, 2),  # recent mean errors of position [m] and heading [rad], and without slip
        ("mean_no_slip_error", np.float64, 2),
        # How many have been: intervals, accepted poses, updates, and updates settled.
        ("intervals", np.int64),
        ("poses", np.int64),
        ("updates", np.int64),
        ("settled", np.int64),
        ("held", np.int64),  # poses that only repeat the last
        ("skipped", np.int64),  # rows without a usable time or order
        ("gaps", np.int64),
        ("resets", np.int64),
        # Workspace.
        ("estimate", ESTIMATE),
        ("motion", MOTION),
        ("pose", POSE),
        ("window_began", np.float64),
        ("measured", np.float64, 3),
        ("after", np.float64, 3),
        ("no_slip", np.float64, PARAMETERS),  # zeros
    ],
    align=True,
)

#: Records of these types, and rings of them.
State = Any
Pose = Any
Update = Any
Ring = NDArray[np.void]
