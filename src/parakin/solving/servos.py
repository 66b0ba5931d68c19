"""Servos: what holds an actuated coordinate at a target, by data."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from parakin.arrays import FloatArray
from parakin.errors import InputError
from parakin.files.motion_csv import read_efforts, read_histories
from parakin.model.units import Dimension
from parakin.motion.laws import Law

_ROUNDING = 1e-9  # [s] beyond recorded targets


class Servo(NamedTuple):
    """An effort, and beside it stiffness (target - q) + damping (target's rate - q'), in all no
    more than `most` either way. effort, target: numbers or laws of time.
    """

    effort: Law | float
    target: Law | float = 0.0
    stiffness: float = 0.0
    damping: float = 0.0
    most: float = np.inf

    @property
    def acts(self) -> bool:
        """Whether it is more than an effort."""
        return bool(self.stiffness or self.damping or np.isfinite(self.most))

    @property
    def laws(self) -> tuple[Law | float, Law | float]:
        return self.effort, self.target

    @property
    def gains(self) -> tuple[float, float, float]:
        return self.stiffness, self.damping, self.most

    def at(self, time: float) -> float:
        """What it would exert at a coordinate of zero that rests."""
        effort, _ = _both(self.effort, time)
        target, rate = _both(self.target, time)
        return effort + self.stiffness * target + self.damping * rate


def _both(law: Law | float, time: float) -> tuple[float, float]:
    """Value and rate at a time."""
    if not callable(law):
        return law, 0.0
    value, rate, *_ = law(np.array([time]))
    return float(value[0]), float(rate[0])


def is_servo(given: Any) -> bool:
    """Whether a table of an effort is a servo's, and not a law's."""
    return isinstance(given, Mapping) and "law" not in given and bool(given)


def recorded(path: Path, name: str, dimension: Dimension, *, effort: bool = False) -> Law:
    """Recorded positions of a coordinate, or efforts, a cubic spline between them. Raises
    InputError; its law does on times beyond them.
    """
    from scipy.interpolate import CubicSpline

    read = read_efforts if effort else read_histories
    time, (values,) = read(path, {name: dimension})
    spline = CubicSpline(time, values)

    def law(t: FloatArray) -> tuple[FloatArray, ...]:
        if not (time[0] - _ROUNDING <= t.min() and t.max() <= time[-1] + _ROUNDING):
            what = "efforts" if effort else "targets"
            found = f"{what} from {time[0]:g} s to {time[-1]:g} s"
            raise InputError(str(path), found, "from the start of the simulation to its end")
        return tuple(spline(t, order) for order in range(3))

    return law
