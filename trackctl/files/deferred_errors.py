"""A file for HDF5 to write to that reports errors only when asked.

HDF5 cannot close a file whose disk is full: it keeps it half open, and may crash the program at exit. The same goes
for a Ctrl-C inside its callbacks.
"""

from __future__ import annotations

import errno
import io
import os
from collections.abc import Buffer
