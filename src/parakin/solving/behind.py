"""The forces behind poses that `at` has solved."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from parakin.arrays import FloatArray, IndexArray
from parakin.errors import InputError
from parakin.motion.motion import Samples
from parakin.solving.charts import Chart
from parakin.solving.forces import Asked, Forces
from parakin.solving.locks import Locks, begun_at
from parakin.solving.status import SINGULAR, SOLVED, are
from parakin.solving.tick import Tick


def forces_behind(
    chart: Chart,
    locks: Locks,
    asked: Asked,
    inputs: FloatArray,
    tick: Tick,
    loads: Mapping[str, ArrayLike] | None,
    turning: IndexArray,
    *,
    parallel: bool,
) -> Forces:
    """Of a pose or a batch, NaN where it is not solved, or solved where the chart is singular.

    inputs: driven positions, velocities and accelerations. turning: the rows of `Tick.turned`.
    Raises InputError on derivatives that were not compiled.
    """
    if chart.outputs.derivatives < 2:
        raise InputError("solver", "one compiled without accelerations", "one with derivatives=2")
    columns = inputs[:, None] if inputs.ndim == 1 else inputs
    n, k = columns.shape[1], len(chart.plan.driven)
    position, velocity, acceleration = columns[: 3 * k].reshape(3, k, n)
    found = begun_at(locks, chart.layout, tick).reshape(-1, n)
    mechanics = chart.mechanics
    rows = mechanics.rows(asked, mechanics.reference)
    place = dict(zip(turning.tolist(), range(len(turning)), strict=True))
    angles = np.zeros((len(rows.wound), n))
    for number, c in enumerate(rows.wound):
        row = chart.places[c]
        angles[number] = tick.turned[place[row]] if row in place else tick.position[row]
    out = chart.forces(
        asked,
        mechanics.reference,
        Samples(np.zeros(n), position, velocity, acceleration),
        found,
        mechanics.loads(None, n, loads),
        angles,
        parallel,
    )
    solved = are(SOLVED, np.atleast_1d(np.asarray(tick.status)))
    solved &= out[rows.regular] >= SINGULAR**2  # else solved on another chart
    out[:, ~solved] = np.nan
    return mechanics.forces(asked, rows, out[:, 0] if inputs.ndim == 1 else out)
