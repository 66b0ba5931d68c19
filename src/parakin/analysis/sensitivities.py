"""Sensitivities: how whatever a solver tells changes with driven coordinates and dimensions."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from parakin.arrays import ORDERS, FloatArray, StatusArray
from parakin.errors import InputError, nearest
from parakin.kernel.backends import Kernel, compiled, input_count
from parakin.kernel.designs import SensitivityRows
from parakin.kernel.outputs import Outputs
from parakin.solving import columns
from parakin.solving.inputs import stacked
from parakin.solving.locks import begun_at, locks_of
from parakin.solving.status import SOLVED, are

if TYPE_CHECKING:
    from parakin.model.expressions import Value
    from parakin.solving.charts import Chart
    from parakin.solving.solver import Solver
    from parakin.solving.tick import Tick

_CLOSED = 1e-9  # characteristic lengths by which loops may open, per unit of what is largest
_STEPS = 2  # of Newton's method from a pose that is closed already


class Sensitivities(NamedTuple):
    """Derivatives of a quantity of each coordinate, at one pose or n: `by_driven` (rows, k) or
    (rows, k, n), and `by_parameter` (rows, m) or (rows, m, n), SI throughout. `status` of the pose;
    where it is not solved they are NaN, and so they are where a coordinate is undefined, and by a
    parameter that cannot change alone, since the loops would not close any more.
    """

    coordinates: tuple[str, ...]
    driven: tuple[str, ...]
    parameters: tuple[str, ...]
    by_driven: FloatArray
    by_parameter: FloatArray
    status: int | StatusArray

    def of(self, coordinate: str, by: str) -> float | FloatArray:
        """The derivative of a coordinate by a driven coordinate or parameter: a number, or (n,).
        Raises InputError on unknown names.
        """
        if coordinate not in self.coordinates:
            expected = nearest(coordinate, self.coordinates)
            raise InputError("coordinate", repr(coordinate), expected)
        if by not in (*self.driven, *self.parameters):
            raise InputError("by", repr(by), nearest(by, (*self.driven, *self.parameters)))
        table, names = self.by_driven, self.driven
        if by not in names:
            table, names = self.by_parameter, self.parameters
        found = table[self.coordinates.index(coordinate), names.index(by)]
        return found if np.ndim(found) else float(found)


def sensitivities(
    solver: Solver,
    y: ArrayLike,
    yd: ArrayLike | None = None,
    ydd: ArrayLike | None = None,
    guess: ArrayLike | None = None,
    *,
    parameters: Mapping[str, Value | ArrayLike] | None = None,
    quantity: str = "position",
) -> Sensitivities:
    """How the reported coordinates change with each driven coordinate, and with each parameter that
    was left `free`, all others of these being kept: exact, by dual numbers in the kernel, at one
    pose or many.

    y, yd, ydd, guess, parameters: as of `Solver.at`. quantity: "position", "velocity" or
    "acceleration": what is differentiated, rates and second rates of what is driven being kept.
    Raises InputError.
    """
    known = ORDERS[: 1 + min(2, solver.derivatives)]
    if quantity not in known:
        raise InputError("quantity", repr(quantity), nearest(str(quantity), known))
    order = known.index(quantity)
    if solver.free and parameters is None:
        parameters = {}
    tick = solver.at(y, yd, ydd, guess, parameters=parameters)
    inputs = stacked(len(solver.driven), order, y, (yd, ydd)[:order])
    asked = Asked.of(solver, inputs, tick, parameters, order)
    status = np.atleast_1d(np.asarray(tick.status))
    out = asked.run()
    out[:, ~are(SOLVED, status)] = np.nan
    count, n = len(solver.coordinates), len(status)
    seeds = len(out) // (count + 1)
    table = out[: seeds * count].reshape(seeds, count, n).transpose(1, 0, 2)
    opening = out[seeds * count :] / solver.graph.length
    tied = ~(opening <= _CLOSED * (1.0 + np.abs(np.nan_to_num(table)).max(axis=0, initial=0.0)))
    table = np.where(tied, np.nan, table)
    undefined = np.isnan(tick.position.reshape(count, n))
    table = np.where(undefined[:, None, :], np.nan, table)
    if tick.position.ndim == 1:
        table = table[..., 0]
    k = len(solver.driven)
    return Sensitivities(
        solver.coordinates, solver.driven, solver.free, table[:, :k], table[:, k:], tick.status
    )


class Asked(NamedTuple):
    """A kernel of sensitivities, what it takes (i, n), and how many rows it returns."""

    kernel: Kernel
    inputs: FloatArray
    rows: int

    @staticmethod
    def of(
        solver: Solver,
        driven: FloatArray,
        tick: Tick,
        parameters: Mapping[str, Value | ArrayLike] | None,
        order: int,
    ) -> Asked:
        """driven: positions and rates (orders k,) or (orders k, n); tick: what `at` returned."""
        chart, n = solver.opened, np.size(tick.status)
        columns = np.broadcast_to(driven if driven.ndim == 2 else driven[:, None], (len(driven), n))
        found = begun_at(locks_of(solver.plan), solver.layout, tick)
        found = found.reshape(len(solver.plan.iterated), n)
        outputs = Outputs(solver.reported.coordinates, order, checks=False)
        given, changes = _of_designs(solver, parameters, outputs, n)
        rows = SensitivityRows(chart.plan, outputs, order)
        kernel = chart.kept(("sensitivities", order), partial(_made, chart, rows))
        inputs = np.ascontiguousarray(np.concatenate([columns, given, found, changes]))
        return Asked(kernel, inputs, rows.seeds * (len(outputs.coordinates) + 1))

    def run(self) -> FloatArray:
        return columns.run(self.kernel, self.inputs, self.rows)


def _made(chart: Chart, rows: SensitivityRows) -> Kernel:
    changes = rows.changes
    count = input_count(chart.plan, rows.outputs) + changes
    return compiled(partial(rows.at, _STEPS), count, machine_code=chart.machine_code)


def _of_designs(
    solver: Solver, parameters: Mapping[str, Value | ArrayLike] | None, outputs: Outputs, n: int
) -> tuple[FloatArray, FloatArray]:
    """What tells a kernel the designs (g, n), and how homes change with parameters (c, n)."""
    if not solver.free:
        return np.empty((0, n)), np.empty((0, n))
    designs, plan = solver.designs, solver.opened.plan
    given = designs.given(designs.values(parameters or {}), n)
    standing = plan.standing(outputs.coordinates)
    changes = designs.homes.changes(given.parameters, given.home, standing)
    told = given.rows(plan, outputs.coordinates)
    return told, changes.transpose(1, 0, 2).reshape(len(standing) * designs.designs.count, n)
