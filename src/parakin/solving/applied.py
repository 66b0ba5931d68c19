"""What acts in a simulation: efforts of actuators over time, of servos, or what a function says."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from parakin.arrays import FloatArray
from parakin.errors import InputError, nearest
from parakin.files.motion_csv import read_efforts
from parakin.files.motion_toml import law_from_table
from parakin.files.parsing import parse_toml, read_text
from parakin.model.expressions import Parameters
from parakin.model.graph import Graph
from parakin.model.masses import amount
from parakin.model.motors import effort_per
from parakin.model.units import ANGLE, FORCE, LENGTH, TORQUE, Dimension
from parakin.solving.forces import is_finite
from parakin.solving.servos import Servo, is_servo, recorded

Efforts: TypeAlias = (
    "Mapping[str, Any] | str | Path | Callable[[State], Mapping[str, float]] | None"
)
_A_SAMPLE = 4  # spacings of recorded efforts at most in a step of integration


class State(NamedTuple):
    """A moment of a simulation: time [s]; positions and velocities of all coordinates, by name.
    Angles of joints outside the spanning tree that are not actuated are within half a turn of home.
    """

    time: float
    position: Mapping[str, float]
    velocity: Mapping[str, float]


class Applied(NamedTuple):
    """What tells efforts of m actuated coordinates at a time [s] and a state (None unless asked):
    efforts (m,) or, with `servos`, efforts, stiffness, damping and bounds (4 m,), as of
    `ForwardRows`. step: how long it may go unseen [s]; infinite if it is constant. bounded: whether
    some servo gives no more than so much.
    """

    of: Callable[[float, State | None], FloatArray]
    asks: bool = False
    servos: bool = False
    step: float = np.inf
    bounded: bool = False


def applied(
    graph: Graph,
    actuated: Sequence[int],
    given: Efforts,
    home: Mapping[str, float],
    sample: float,
    held: Mapping[str, float],
) -> Applied:
    """What `Solver.simulate` takes as `efforts`. home: positions by name, where servos hold unless
    they are told otherwise. sample: the time between samples [s]. held: efforts of those that are
    not told, by name; others are zero. Raises InputError.
    """
    names = [graph.coordinates[k].name for k in actuated]
    units = {graph.coordinates[k].name: _unit(graph, k) for k in actuated}
    if given is None:
        given = {}
    if isinstance(given, (str, Path)) and Path(given).suffix.lower() == ".toml":
        path = Path(given)
        tables = parse_toml(read_text(path), str(given))
        if set(tables) != {"efforts"} or not isinstance(tables["efforts"], Mapping):
            raise InputError(str(given), f"keys {', '.join(tables) or 'none'}", "a table `efforts`")
        read = _Tables(graph, units, home, sample, held, f"{given}: efforts.", path.parent)
        return read.applied(tables["efforts"])
    if isinstance(given, (str, Path)):
        time, values = read_efforts(Path(given), units)
        step = min(sample, _A_SAMPLE * float(np.diff(time).min()))
        return Applied(_from_samples(str(given), time, values), step=step)
    if callable(given):
        return Applied(_by_function(names, held, given), asks=True, step=sample)
    if not isinstance(given, Mapping):
        expected = "a table by actuated coordinate, a CSV or TOML file, or a function of a State"
        raise InputError("efforts", type(given).__name__, expected)
    return _Tables(graph, units, home, sample, held, "efforts of ", Path()).applied(given)


def _unit(graph: Graph, k: int) -> Dimension:
    return TORQUE if graph.coordinates[k].angle else FORCE


class _Tables(NamedTuple):
    """Reads efforts by name. places: what a message puts before the name; folder: of files."""

    graph: Graph
    units: Mapping[str, Dimension]
    home: Mapping[str, float]
    sample: float
    held: Mapping[str, float]
    places: str
    folder: Path

    @property
    def parameters(self) -> Parameters:
        mechanism = self.graph.mechanism
        return Parameters(mechanism.parameters, mechanism.where)

    def applied(self, given: Mapping[str, Any]) -> Applied:
        for name in given:
            if name not in self.units:
                where = self.places.removesuffix(".").removesuffix(" of ")
                raise InputError(where, f"{name!r}, not actuated", nearest(str(name), self.units))
        rows = [
            self._servo(name, given[name])
            if is_servo(given.get(name))
            else Servo(self._over_time(self._told(given, name), self.units[name], name))
            for name in self.units
        ]
        servos = any(row.acts for row in rows)
        changing = [law for row in rows for law in row.laws if callable(law)]
        fixed = np.array([row.gains for row in rows]).T.ravel()

        def efforts(time: float, _: State | None) -> FloatArray:
            asked = np.array([row.at(time) for row in rows])
            return np.concatenate([asked, fixed]) if servos else asked

        bounded = any(np.isfinite(row.most) for row in rows)
        if changing:
            return Applied(efforts, servos=servos, step=self.sample, bounded=bounded)
        known = efforts(0.0, None)
        return Applied(lambda _t, _s: known, servos=servos, bounded=bounded)

    def _told(self, table: Mapping[str, Any], name: str, key: str | None = None) -> Any:
        return table.get(key or name, self.held.get(name, 0.0))

    def _over_time(self, value: Any, unit: Dimension, name: str, home: float = 0.0) -> Any:
        """A number, or a law of time, about home."""
        place = f"{self.places}{name}"
        if isinstance(value, Mapping):
            return law_from_table(value, self.parameters, unit, place, home)
        return self.parameters.evaluate(value, unit, place)

    def _recorded(
        self, name: str, key: str, value: Any, dimension: Dimension, home: float = 0.0
    ) -> Any:
        """A number, a law of time, or what a CSV file has of it."""
        if isinstance(value, str) and Path(value).suffix.lower() == ".csv":
            return recorded(self.folder / value, name, dimension, effort=key == "effort")
        return self._over_time(value, dimension, f"{name}.{key}", home)

    def _servo(self, name: str, table: Mapping[str, Any]) -> Servo:
        known = ("stiffness", "damping", "target", "effort", "most")
        for key in table:
            if key not in known:
                raise InputError(f"{self.places}{name}", f"{key!r}", nearest(str(key), known))
        angle = self.units[name] == TORQUE

        def gain(key: str, dimension: Dimension, without: float) -> float:
            if key not in table:
                return without
            return amount(table[key], self.parameters, dimension, f"{self.places}{name}.{key}")

        home = self.home.get(name, 0.0)
        return Servo(
            self._recorded(name, "effort", self._told(table, name, "effort"), self.units[name]),
            self._recorded(
                name, "target", table.get("target", home), ANGLE if angle else LENGTH, home
            ),
            gain("stiffness", effort_per(angle, 0), 0.0),
            gain("damping", effort_per(angle, 1), 0.0),
            gain("most", self.units[name], np.inf),
        )


def _from_samples(
    place: str, known: FloatArray, values: FloatArray
) -> Callable[[float, State | None], FloatArray]:
    """Linear between samples. Raises InputError on times beyond them."""

    def efforts(time: float, _: State | None) -> FloatArray:
        if not known[0] - 1e-9 <= time <= known[-1] + 1e-9:
            found = f"efforts from {known[0]:g} s to {known[-1]:g} s"
            raise InputError(place, found, "from the start of the simulation to its end")
        return np.array([np.interp(time, known, row) for row in values])

    return efforts


def _all_finite(given: Any, shape: tuple[int, ...]) -> bool:
    """Whether it is an array of one finite number for each run."""
    known = isinstance(given, np.ndarray) and given.shape == shape != ()
    return known and given.dtype.kind in "fiu" and bool(np.isfinite(given).all())


def _by_function(
    names: Sequence[str],
    held: Mapping[str, float],
    function: Callable[[State], Mapping[str, float]],
) -> Callable[[float, State | None], FloatArray]:
    known = set(names)

    def efforts(time: float, state: State | None) -> FloatArray:
        assert state is not None
        found = function(state)
        if not isinstance(found, Mapping) or not known.issuperset(found):
            expected = f"efforts by actuated coordinate: {', '.join(names)}"
            raise InputError(f"efforts at {time:g} s", repr(found), expected)
        shape = np.shape(next(iter(state.position.values())))
        if not all(is_finite(each) or _all_finite(each, shape) for each in found.values()):
            expected = f"finite numbers, or arrays {shape}" if shape else "finite numbers"
            raise InputError(f"efforts at {time:g} s", repr(found), expected)
        rows = [np.broadcast_to(found.get(name, held.get(name, 0.0)), shape) for name in names]
        return np.array(rows, dtype=float).reshape(len(names), *shape)

    return efforts
