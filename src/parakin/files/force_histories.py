"""Forces over time: the laws and CSV files that a mechanism's wrenches name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from parakin.arrays import FloatArray
from parakin.errors import InputError
from parakin.files.motion_csv import read_histories
from parakin.files.motion_toml import law_from_table
from parakin.model.expressions import Parameters
from parakin.model.loads import BodyWrench
from parakin.model.mechanism import Mechanism
from parakin.model.units import BARE, FORCE, TORQUE
from parakin.motion.laws import Law

History = Callable[[FloatArray], FloatArray]
"""Times (n,) [s] to what a wrench takes: its law's factor (1, n), or force and moment (6, n)."""

_COLUMNS = dict.fromkeys(("fx", "fy", "fz"), FORCE) | dict.fromkeys(("mx", "my", "mz"), TORQUE)


def histories(mechanism: Mechanism, wrenches: Sequence[BodyWrench]) -> dict[str, History]:
    """By name, those that change with time. Raises InputError."""
    parameters = Parameters(mechanism.parameters, mechanism.where)
    found: dict[str, History] = {}
    for wrench in wrenches:
        place = f"{mechanism.where}: forces.{wrench.name}"
        if wrench.law is not None:
            law = law_from_table(wrench.law, parameters, BARE, f"{place}.law")
            found[wrench.name] = partial(_factor, law)
        elif wrench.csv is not None:
            found[wrench.name] = _from_csv(beside(mechanism, wrench.csv, f"{place}.csv"))
    return found


def beside(mechanism: Mechanism, name: str, place: str) -> Path:
    """A file that a mechanism's file names, in the same folder or below. Raises InputError on any
    other.
    """
    path = Path(name)
    if path.is_absolute() or ".." in path.parts:
        raise InputError(place, repr(name), "a file in the folder of the mechanism's, or below")
    return mechanism.folder / path


def _factor(law: Law, time: FloatArray) -> FloatArray:
    return np.asarray(law(time)[0], dtype=float)[None, :]


def _from_csv(path: Path) -> History:
    time, values = read_histories(path, _COLUMNS)
    return partial(_between, str(path), time, values)


def _between(place: str, known: FloatArray, values: FloatArray, time: FloatArray) -> FloatArray:
    """Linear between samples. Raises InputError on times beyond them."""
    slack = 1e-9 * (known[-1] - known[0])
    if len(time) and not (time.min() >= known[0] - slack and time.max() <= known[-1] + slack):
        found = f"forces from {known[0]:g} s to {known[-1]:g} s"
        expected = f"from {time.min():g} s to {time.max():g} s, as the motion"
        raise InputError(place, found, expected)
    return np.array([np.interp(time, known, row) for row in values])
