"""What limits how much of the boundary of a workspace."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from parakin.views.workspace_units import comparable

if TYPE_CHECKING:
    import xarray as xr

    from parakin.arrays import FloatArray, IndexArray


def shares(found: xr.Dataset) -> dict[str, float]:
    """The share of each thing that stops it, of the boundary of what is connected to the pose, the
    largest first. Each corner of a facet counts for its part of it. Where slides and angles are
    mixed, the boundary is measured as it is drawn: as wide as it is high.
    """
    own = found["boundary_connected"].values
    sizes = _sizes(comparable(found, found["boundary"].values[own]))
    numbers = found["boundary_stopped_by"].values[own]
    weights = np.repeat(sizes / numbers.shape[1], numbers.shape[1])
    total = np.bincount(numbers.ravel(), weights, minlength=found.sizes["stop"])
    words = found["stop"].values
    share = total / total.sum()
    order = np.argsort(-np.round(share, 3), kind="stable").tolist()  # those alike as in the file
    return {str(words[k]): float(share[k]) for k in order if share[k] > 0.0}


def decided(numbers: IndexArray) -> IndexArray:
    """What is told to limit each facet (p,), by what limits its corners (p, d): of a triangle's
    what two of them agree on, else the first.
    """
    if numbers.shape[1] == 2:
        return numbers[:, 0]
    found: IndexArray = np.where(numbers[:, 1] == numbers[:, 2], numbers[:, 1], numbers[:, 0])
    return found


def percent(share: float) -> str:
    """A share as it is printed: what is there is not 0 %."""
    return f"{100.0 * share:.0f} %" if share >= 0.005 else "< 1 %"


def _sizes(facets: FloatArray) -> FloatArray:
    """Lengths of lines (p, 2, 2), or areas of triangles (p, 3, 3)."""
    sides = facets[:, 1:] - facets[:, :1]
    square = np.linalg.det(sides @ sides.swapaxes(1, 2))
    found: FloatArray = np.sqrt(np.maximum(square, 0.0)) / (facets.shape[1] - 1)
    return found
