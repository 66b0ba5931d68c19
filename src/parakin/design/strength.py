"""How hard actuators work at poses and along rays, and how firmly they hold."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from parakin.arrays import FloatArray
from parakin.design.bounds import effort_bounds, moved
from parakin.design.march import Node
from parakin.design.rays import Measure, Ray
from parakin.errors import InputError
from parakin.kinematics.configuration import coordinate_scales
from parakin.motion.motion import Samples
from parakin.solving.charts import Chart
from parakin.solving.solver import Solver

NO_BOUNDS = "no drive has a max_effort"


class Efforts:
    """The actuators' efforts of a solver under given loads, and their bounds. Raises InputError
    where there are none.

    loads: as of `Solver.solve`; wrenches that change with time and are not given are zero.
    """

    def __init__(self, solver: Solver, loads: Mapping[str, ArrayLike] | None = None) -> None:
        self.mechanics = solver.mechanics
        self.asked = self.mechanics.asked(
            reactions=False, energies=False, preload=None, indeterminate="nan"
        )
        self.bounds = effort_bounds(solver.graph, self.mechanics.actuated)
        wrenches = solver.graph.dynamics.wrenches
        resting = {w.name: np.zeros(w.inputs) for w in wrenches if w.inputs}
        self._loads = self.mechanics.loads(None, 1, resting | dict(loads or {}))

    @property
    def limited(self) -> bool:
        """Whether any actuator is."""
        return bool(np.isfinite(self.bounds.high).any())

    def words(self, number: int) -> str:
        """Of the lower bounds of all actuators, then of the upper ones: "P6.effort > 4000 N"."""
        upper, number = divmod(number, len(self.bounds.high))
        return self.bounds.words(number, upper=bool(upper))

    def of(
        self, chart: Chart, out: FloatArray, y: FloatArray, yd: FloatArray, ydd: FloatArray
    ) -> FloatArray:
        """Efforts (m, n) [N or N m], given driven values (k, n) and outputs (rows, n)."""
        n, reference = y.shape[1], self.mechanics.reference
        rows = self.mechanics.rows(self.asked, reference)
        angles = out[[chart.places[k] for k in rows.wound]]
        samples = Samples(np.zeros(n), y, yd, ydd)
        found, loads = out[chart.layout.iterated[0]], self._loads.repeat(n, axis=1)
        raw = chart.forces(self.asked, reference, samples, found, loads, angles, False)
        return self.mechanics.forces(self.asked, rows, raw).effort

    def shares(self, chart: Chart, out: FloatArray, y: FloatArray) -> FloatArray:
        """Efforts at rest as parts of the most that drives give (m, n), with their signs."""
        found: FloatArray = self.of(chart, out, y, 0.0 * y, 0.0 * y) / self.bounds.high[:, None]
        return found

    def beyond(self, ray: Ray) -> Measure:
        """How far efforts at rest are beyond their bounds along a ray, as parts of these (2m, n):
        the lower ones, then the upper.
        """

        def measure(chart: Chart, part: FloatArray, out: FloatArray) -> FloatArray:
            share = self.shares(chart, out, ray.driven(part))
            return np.concatenate([-share, share]) - 1.0

        return measure

    def by_acceleration(self, node: Node, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Efforts at rest (m,), and by the acceleration of each driven coordinate (m, k)."""
        k = len(y)
        still, ydd = np.zeros((k, k + 1)), np.zeros((k, k + 1))
        ydd[:, 1:] = np.eye(k)
        out = node.out[:, None].repeat(k + 1, axis=1)
        found = self.of(node.chart, out, y[:, None].repeat(k + 1, axis=1), still, ydd)
        return found[:, 0], found[:, 1:] - found[:, :1]


def limited_efforts(solver: Solver, loads: Mapping[str, ArrayLike] | None) -> Efforts:
    """Efforts that are to be kept within bounds. Raises InputError where none has any."""
    efforts = Efforts(solver, loads)
    if not efforts.limited:
        where = solver.graph.mechanism.where
        raise InputError(f"{where}: joints", NO_BOUNDS, "one at least, to be a limit")
    return efforts


def efforts_if_known(
    solver: Solver, loads: Mapping[str, ArrayLike] | None
) -> tuple[Efforts | None, str]:
    """The same where nobody asks for limits, or why there are none. Raises InputError on loads
    that are wrong, but not where nothing is asked.
    """
    try:
        efforts = Efforts(solver, loads)
    except InputError as error:
        if loads:
            raise
        return None, str(error)
    return (efforts, "") if efforts.limited else (None, NO_BOUNDS)


def rates_at(
    chart: Chart, out: FloatArray, y: FloatArray, coordinates: tuple[int, ...]
) -> FloatArray:
    """The rates of coordinates by those of the driven ones, (m, k, n), at poses y (k, n) with
    outputs (rows, n).
    """
    k, n = y.shape
    each = np.eye(k).repeat(n, axis=1)  # pose by pose for each driven coordinate
    guess = np.tile(out[chart.layout.iterated[0]], (1, k))
    found = chart.run(
        np.concatenate(
            [
                np.tile(y, (1, k)),
                each,
                np.zeros(((chart.outputs.derivatives - 1) * k, k * n)),
                guess,
            ]
        )
    )
    rates = np.empty((len(coordinates), k, n))
    for row, c in enumerate(coordinates):
        for i in range(k):
            mine = found[:, i * n : (i + 1) * n]
            rates[row, i] = moved(chart, c, mine, np.eye(k)[i], 1)
    return rates


_HELD = 1e-9  # a least singular value, of rates without dimension: what is below is a singularity


class Firmness:
    """How firmly a solver's mechanism is held: 1 at home, 0 at a singularity. The less of its
    conditioning, all that is driven being held, and of the least singular value of the actuators'
    rates by the driven ones, if these are others; NaN where the actuators are singular at home, by
    which nothing can be measured then.
    """

    def __init__(self, solver: Solver) -> None:
        plan, self.chart = solver.plan, solver.atlas.followed
        known = tuple(k for k, c in enumerate(solver.graph.coordinates) if c.actuated)
        self.actuated = known if len(known) >= len(plan.driven) else ()
        scales = coordinate_scales(plan.graph.plain)
        self._by = scales[list(plan.driven)][:, None]
        self._of = scales[list(self.actuated)][:, None]
        y = np.array([[solver.home[name]] for name in solver.driven])
        found = np.array([plan.home[k] - plan.offset(k) for k in plan.iterated]).reshape(-1, 1)
        self.home = 1.0
        at_home = float(self._held(self.chart, self.chart.at_rest(y, found), y)[0])
        self.home = at_home if abs(at_home) > _HELD else np.nan

    def check(self, solver: Solver) -> Firmness:
        """Itself. Raises InputError where nothing can be measured by home."""
        if np.isnan(self.home):
            found = "a home at which the actuators are singular"
            expected = "another home, by which to measure how firmly they hold"
            raise InputError(solver.mechanism.where, found, expected)
        return self

    def _held(self, chart: Chart, out: FloatArray, y: FloatArray) -> FloatArray:
        if not self.actuated:
            return np.full(y.shape[1], np.inf)
        rates = self.scaled(rates_at(chart, out, y, self.actuated))
        rates[:, :, ~np.isfinite(rates).all(axis=(0, 1))] = 0.0
        square = np.moveaxis(rates, 2, 0)
        sizes = np.linalg.svd(square, compute_uv=False)[:, -1]
        if square.shape[1] == square.shape[2]:
            sizes *= np.sign(np.linalg.det(square))
        return np.asarray(sizes / self.home, dtype=float)

    def scaled(self, rates: FloatArray) -> FloatArray:
        """The actuators' rates by the driven ones (m, k, n), slides in characteristic lengths."""
        found: FloatArray = rates / self._of[:, :, None] * self._by[None]
        return found

    def of(self, chart: Chart, out: FloatArray, y: FloatArray) -> FloatArray:
        """At poses y (k, n) with outputs (rows, n), (n,): below 0 beyond a singularity of as many
        actuators as there are freedoms.
        """
        loops = chart.relative_regularity * out[chart.outputs.conditioning]
        found: FloatArray = np.minimum(loops, self._held(chart, out, y))
        return found

    def below(self, ray: Ray, least: float) -> Measure:
        """How far it is below `least` along a ray, (1, n)."""

        def measure(chart: Chart, part: FloatArray, out: FloatArray) -> FloatArray:
            return least - self.of(chart, out, ray.driven(part))[None]

        return measure
