"""Memory that the solvers work in, made once for a thread.

It is a numpy record: compiled functions pass it as one pointer, where a tuple of arrays would be copied field by field.
"""

from __future__ import annotations

from typing import Any

import numpy as np

#: A record of the type `workspace(n)`. After a solve, `residual` and `jacobian` hold those of the returned point.
Workspace = Any


def workspace(n: int) -> np.dtype[np.void]:
    """Scratch memory for a system of n equations in n unknowns."""
    return np.dtype(
        [
            ("residual", np.float64, (n,)),
            ("jacobian", np.float64, (n, n)),
            ("trial", np.float64, (n,)),
            ("trial_residual", np.float64, (n,)),
            ("trial_jacobian", np.float64, (n, n)),
            ("matrix", np.float64, (n, n)),
            ("step", np.float64, (n,)),
        ],
        align=True,
    )
