"""Types of arrays, and the names of a motion's orders, used everywhere."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]
IndexArray = NDArray[np.intp]
StatusArray = NDArray[np.int8]

ORDERS = ("position", "velocity", "acceleration", "jerk")
PER_TIME = ("", "/s", "/s²", "/s³")  # their units, per that of position
