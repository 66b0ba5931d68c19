"""From a mechanism to a solver: assembled, planned for what is driven, and compiled."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from parakin.errors import AssemblyError, DrivenError, InputError, nearest
from parakin.files.reading import loaded
from parakin.kinematics.assembly import CLOSED, assembled, close
from parakin.kinematics.configuration import Configuration
from parakin.model.evaluation import graph_of
from parakin.model.expressions import Value
from parakin.model.graph import Graph
from parakin.model.mechanism import Mechanism
from parakin.planning.ordering import plan_of
from parakin.solving import kept
from parakin.solving.recipes import Recipe, branch_tree, made, restored
from parakin.solving.solver import Solver


def compile(
    mechanism: Mechanism | str | Path,
    driven: Sequence[str] | str | None = None,
    *,
    coordinates: Sequence[str] | str | None = None,
    derivatives: int = 2,
    checks: bool = True,
    cut: Sequence[str] = (),
    near: Mapping[str, float] | str | None = None,
    machine_code: bool | None = None,
    parameters: Mapping[str, Value] | None = None,
    free: Sequence[str] | str | None = (),
) -> Solver:
    """Compile a mechanism for a choice of driven coordinates.

    mechanism: a `Mechanism`, a name in the catalogue, or a file.
    driven: a name, or as many as the mobility; the mechanism's own choice by default.
    coordinates: which to report. By default those of a spanning tree and the platform's pose;
    "all" adds those of the joints outside the tree and the cone angles of spherical joints. Where
    iterated ones are left out, a guess must be a `Tick`, which contains them.
    derivatives: how many, 0 to 3; the third is the jerk.
    checks: False leaves out residual and conditioning; only NaN is then flagged. A solver that
    iterates needs them and keeps them.
    cut: joints to leave out of the spanning tree that is solved; by default those that make the
    smallest systems. Affects the speed, not the result.
    near: another assembly mode: its coordinates, as in a `Mode`, or its name, as found by
    `parakin.modes`. The solver's home is the closed configuration nearest to it, and motions stay
    on its branch.
    machine_code: False runs on NumPy arrays; None uses machine code if heyoka is installed.
    parameters: overrides by name.
    free: names of parameters to be left open, so that `Solver.at` can be asked for other designs;
    home of a design is found by walking from the file's own.
    What is compiled in machine code is kept in the user's cache, if near and free are not given:
    the next process has it at once (see the guide on where, and how to switch that off).
    A pickled solver contains only what it was compiled from, and where it stands; it is compiled
    again when it is unpickled, once in each process (of those that came, the last 16 are kept).
    Raises InputError, AssemblyError, DrivenError.
    """
    mechanism = loaded(mechanism, parameters)
    if derivatives not in range(4):
        raise InputError("derivatives", f"{derivatives}", "0, 1, 2 or 3")
    if coordinates is not None and not isinstance(coordinates, str):
        coordinates = tuple(coordinates)
        if not coordinates:
            raise InputError("coordinates", "none", "at least one")
    names, free = _driven(mechanism, driven), _free(free)
    asked = names, coordinates, derivatives, checks, tuple(cut), machine_code
    key = None
    if near is None and not free and machine_code is not False:
        key = kept.key_of(mechanism, *asked)
    known = None if key is None else kept.found(key, mechanism)
    if known is not None:
        return restored(Recipe(mechanism, *asked, known.own, None), known)
    graph = graph_of(mechanism)
    numbers = [graph.index(name, f"{mechanism.where}: driven") for name in names]
    own = assembled(graph)
    if isinstance(near, str):
        near = _mode(graph, numbers, own, near)
    if free and near is not None:
        raise InputError("near", "another mode, with parameters left open", "one of the two")
    home = None if near is None else _near(graph, own, numbers, near)
    at, at_home = tuple(own.q.tolist()), None if home is None else tuple(home.q.tolist())
    solver = made(graph, Recipe(mechanism, *asked, at, at_home, free))
    if key is not None:
        chart = solver.chart
        ours = kept.Kept(at, chart.plan, chart.outputs, chart.reported, chart.kernel)
        kept.keep(key, mechanism, ours)
    return solver


def _free(names: Sequence[str] | str | None) -> tuple[str, ...]:
    """Names of parameters. Raises InputError on what are none."""
    given = (names,) if isinstance(names, str) else names or ()
    if not isinstance(given, Sequence) or not all(isinstance(name, str) for name in given):
        raise InputError("free", repr(names), "names of parameters")
    return tuple(given)


def _driven(mechanism: Mechanism, driven: Sequence[str] | str | None) -> tuple[str, ...]:
    """The names of driven coordinates. Raises DrivenError on none, and on repetition."""
    driven = mechanism.driven if driven is None else driven
    names = (driven,) if isinstance(driven, str) else tuple(driven)
    if not names:
        raise DrivenError(f"{mechanism.where}: no driven coordinates are given")
    if len(set(names)) < len(names):
        raise DrivenError(f"{mechanism.where}: a coordinate is driven twice: {', '.join(names)}")
    return names


def _mode(
    graph: Graph, driven: Sequence[int], home: Configuration, name: str
) -> Mapping[str, float]:
    """The coordinates of an assembly mode. Raises InputError on an unknown name."""
    from parakin.solving.modes import modes_of

    search = modes_of(plan_of(graph, driven, home, everywhere=True))
    named = {mode.name: mode.coordinates for mode in search.modes}
    if name not in named:
        raise InputError("near", f"unknown assembly mode {name!r}", nearest(name, named))
    return named[name]


def _near(
    graph: Graph, home: Configuration, driven: Sequence[int], near: Mapping[str, float]
) -> Configuration:
    """The closed configuration nearest to given coordinates. Raises AssemblyError."""
    start = home.q.copy()
    for name, value in near.items():
        k = graph.index(name, "near")
        start[k] = value + (home.q[k] if k in graph.from_home else 0.0)
    at, norm = close(graph, branch_tree(graph, driven), start, held=driven)
    if norm > CLOSED:
        raise AssemblyError(f"{graph.mechanism.where}: no closed configuration near the one given")
    return at
