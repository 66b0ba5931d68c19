"""What acts in a simulation: efforts of actuators over time, or by what a function says."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from parakin.arrays import FloatArray
from parakin.errors import InputError, nearest
from parakin.files.motion_csv import read_histories
from parakin.files.motion_toml import law_from_table
from parakin.files.parsing import parse_toml, read_text
from parakin.model.expressions import Parameters
from parakin.model.graph import Graph
from parakin.model.units import FORCE, TORQUE
from parakin.solving.forces import is_finite

Efforts: TypeAlias = (
    "Mapping[str, Any] | str | Path | Callable[[State], Mapping[str, float]] | None"
)


class State(NamedTuple):
    """A moment of a simulation: time [s]; positions and velocities by coordinate, of all that the
    plan knows (those of a spanning tree).
    """

    time: float
    position: Mapping[str, float]
    velocity: Mapping[str, float]


class Applied(NamedTuple):
    """Efforts of the actuated coordinates, (m,), at a time [s] and a state (None unless asked)."""

    of: Callable[[float, State | None], FloatArray]
    asks: bool


def applied(graph: Graph, actuated: Sequence[int], given: Efforts) -> Applied:
    """What `Solver.simulate` takes as `efforts`. Raises InputError."""
    names = [graph.coordinates[k].name for k in actuated]
    units = {graph.coordinates[k].name: _unit(graph, k) for k in actuated}
    if given is None:
        return Applied(lambda _t, _s: np.zeros(len(names)), asks=False)
    if isinstance(given, (str, Path)) and Path(given).suffix.lower() == ".toml":
        tables = parse_toml(read_text(Path(given)), str(given))
        if set(tables) != {"efforts"} or not isinstance(tables["efforts"], Mapping):
            raise InputError(str(given), f"keys {', '.join(tables) or 'none'}", "a table `efforts`")
        return Applied(_by_laws(graph, units, tables["efforts"], f"{given}: efforts."), asks=False)
    if isinstance(given, (str, Path)):
        time, values = read_histories(Path(given), units)
        return Applied(_from_samples(str(given), time, values), asks=False)
    if callable(given):
        return Applied(_by_function(names, given), asks=True)
    if not isinstance(given, Mapping):
        expected = "a table by actuated coordinate, a CSV or TOML file, or a function of a State"
        raise InputError("efforts", type(given).__name__, expected)
    return Applied(_by_laws(graph, units, given, "efforts of "), asks=False)


def _unit(graph: Graph, k: int) -> Any:
    return TORQUE if graph.coordinates[k].angle else FORCE


def _by_laws(
    graph: Graph, units: Mapping[str, Any], given: Mapping[str, Any], places: str
) -> Callable[[float, State | None], FloatArray]:
    mechanism = graph.mechanism
    parameters = Parameters(mechanism.parameters, mechanism.where)
    for name in given:
        if name not in units:
            where = places.removesuffix(".").removesuffix(" of ")
            raise InputError(where, f"{name!r}, not actuated", nearest(str(name), units))
    constants = np.zeros(len(units))
    laws = {}
    for row, (name, unit) in enumerate(units.items()):
        value, place = given.get(name, 0.0), f"{places}{name}"
        if isinstance(value, Mapping):
            laws[row] = law_from_table(value, parameters, unit, place)
        else:
            constants[row] = parameters.evaluate(value, unit, place)

    def efforts(time: float, _: State | None) -> FloatArray:
        found = constants.copy()
        for row, law in laws.items():
            found[row] = law(np.array([time]))[0][0]
        return found

    return efforts


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


def _by_function(
    names: Sequence[str], function: Callable[[State], Mapping[str, float]]
) -> Callable[[float, State | None], FloatArray]:
    known = set(names)

    def efforts(time: float, state: State | None) -> FloatArray:
        assert state is not None
        found = function(state)
        if not isinstance(found, Mapping) or not known.issuperset(found):
            expected = f"efforts by actuated coordinate: {', '.join(names)}"
            raise InputError(f"efforts at {time:g} s", repr(found), expected)
        if not all(map(is_finite, found.values())):
            raise InputError(f"efforts at {time:g} s", repr(found), "finite numbers")
        return np.array([float(found.get(name, 0.0)) for name in names])

    return efforts
