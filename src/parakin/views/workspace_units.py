"""The units of a workspace: millimetres, degrees, or both."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from parakin.views.units import Unit, unit_of

if TYPE_CHECKING:
    import xarray as xr

    from parakin.arrays import FloatArray

_POWERS = ("", "", "²", "³")


def units_of(found: xr.Dataset) -> list[Unit]:
    """Of the coordinates moved."""
    return [unit_of(unit == "rad") for unit in found["over_unit"].values]


def are_mixed(found: xr.Dataset) -> bool:
    """Whether slides and angles are moved, so that there are no distances."""
    return len(set(found["over_unit"].values.tolist())) > 1


def per_si(found: xr.Dataset) -> FloatArray:
    """How many units make one in SI, of each coordinate moved (d,)."""
    return np.array([unit.per_si for unit in units_of(found)])


def size_unit(found: xr.Dataset) -> tuple[float, str]:
    """How many make one in SI, and its name: square or cubic metres or degrees, or "m deg²"."""
    units = found["over_unit"].values.tolist()
    counts = [(name, units.count(of)) for name, of in (("m", "m"), ("deg", "rad"))]
    name = " ".join(name + _POWERS[count] for name, count in counts if count)
    return float(np.degrees(1.0)) ** units.count("rad"), name


def comparable(found: xr.Dataset, points: FloatArray) -> FloatArray:
    """Points (..., d) as lengths and areas are measured between them: as they are, or, where slides
    and angles are mixed, as parts of the extents.
    """
    if not are_mixed(found):
        return points
    return np.asarray(points / np.diff(found["extent"].values, axis=1)[:, 0])
