"""Angles by whole turns."""

from __future__ import annotations

from typing import TypeVar

import numpy as np

from parakin.arrays import FloatArray

Angle = TypeVar("Angle", float, FloatArray)


def nearest_angle(angle: Angle, to: Angle | float = 0.0) -> Angle:
    """The angle plus the whole turns that bring it nearest to another, or to zero [rad]."""
    return angle + 2 * np.pi * np.round((to - angle) / (2 * np.pi))  # type: ignore[no-any-return]
