"""The hexapod's dimensions; those of the flight simulator are in `benchmarks.baselines`."""

import numpy as np

STROKE_0 = 1.0
_BASE = np.radians([-10, 10, 110, 130, 230, 250])
_TOP = np.radians([-50, 50, 70, 170, 190, -70])
_FLAT = np.zeros(6)

FEET = 1.2 * np.column_stack((np.cos(_BASE), np.sin(_BASE), _FLAT))
TOPS = 0.7 * np.column_stack((np.cos(_TOP), np.sin(_TOP), _FLAT))

# Of each universal joint: x outwards, y downwards, z along its first axis. After the turns about z
# and then x, z is along the leg.
AXES = np.stack(
    (
        np.column_stack((np.cos(_BASE), np.sin(_BASE), _FLAT)),
        np.column_stack((_FLAT, _FLAT, _FLAT - 1)),
        np.column_stack((-np.sin(_BASE), np.cos(_BASE), _FLAT)),
    ),
    axis=2,
)
