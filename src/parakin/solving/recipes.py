"""A solver's recipe, which is all of it that is sent to other processes; and solvers made by it."""

from __future__ import annotations

import os
import pickle
import threading
from collections import OrderedDict
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple
from weakref import WeakValueDictionary

import numpy as np

from parakin.arrays import FloatArray
from parakin.errors import InputError, nearest
from parakin.kernel.backends import Kernel, has_machine_code
from parakin.kernel.outputs import Outputs
from parakin.kinematics.assembly import assembled, home_tree, homes_of
from parakin.kinematics.configuration import Configuration, configure
from parakin.model.designs import Designs
from parakin.model.evaluation import graph_of
from parakin.model.expressions import Value
from parakin.model.graph import Graph, Tree
from parakin.model.mechanism import Mechanism
from parakin.planning.ordering import plan_of
from parakin.planning.plan import Plan
from parakin.solving.charts import also_known
from parakin.solving.forces import is_finite, wound
from parakin.solving.homes import Homes
from parakin.solving.kept import Kept
from parakin.solving.solver import Solver

_KEPT = 16  # solvers that came to this process, though nothing else holds them any more


class Recipe(NamedTuple):
    """What a solver is compiled from: arguments of `compile`, and where it stands.

    own, home: all coordinates [m or rad], as their joints count, at the mechanism's own home and at
    the solver's, None if it is the same: to the last bit, wherever it is compiled.
    """

    mechanism: Mechanism
    driven: tuple[str, ...]
    coordinates: tuple[str, ...] | str | None
    derivatives: int
    checks: bool
    cut: tuple[str, ...]
    machine_code: bool | None
    own: tuple[float, ...]
    home: tuple[float, ...] | None
    free: tuple[str, ...] = ()


class _Kept:
    """Solvers by their pickled recipes: all that are alive, and those that came last."""

    def __init__(self) -> None:
        self.lock = threading.RLock()
        self.alive: WeakValueDictionary[bytes, Solver] = WeakValueDictionary()
        self.last: OrderedDict[bytes, Solver] = OrderedDict()


_kept = _Kept()


def _in_child() -> None:
    _kept.lock = threading.RLock()  # another thread of the parent may have held it


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_in_child)


def made(graph: Graph, recipe: Recipe) -> Solver:
    """The solver of a recipe. Raises InputError, DrivenError; and InputError on a mechanism that
    cannot be pickled.
    """
    return _made(graph, recipe, _sent(recipe))


def restored(recipe: Recipe, kept: Kept) -> Solver:
    """The solver of a recipe, of what was kept of it: one of a fixed design, at its own home."""
    return _known(recipe, _sent(recipe), *kept[1:4], machine_code=True, compiled=kept.kernel)


def _sent(recipe: Recipe) -> bytes:
    """Raises InputError on a mechanism that cannot be pickled."""
    try:
        return pickle.dumps(recipe, protocol=5)
    except Exception as error:  # whatever somebody else's object raises
        found = f"something that cannot be pickled: {error}"
        expected = "numbers, text, lists and tables"
        raise InputError(recipe.mechanism.where, found, expected) from None


def _made(graph: Graph, recipe: Recipe, sent: bytes) -> Solver:
    mechanism = recipe.mechanism
    numbers = [graph.index(name, f"{mechanism.where}: driven") for name in recipe.driven]
    own = home = _standing(graph, home_tree(graph), recipe.own)
    if recipe.home is not None:
        home = _standing(graph, branch_tree(graph, numbers), recipe.home)
    designs = Designs.of(mechanism, recipe.free) if recipe.free else None
    others = homes_of(designs, graph, own) if designs else []
    plan = plan_of(graph, numbers, home, _cut(graph, recipe.cut), own_home=own.q, others=others)
    checks = recipe.checks or bool(plan.iterated)
    chosen = _chosen(plan.graph.plain, recipe.coordinates)
    outputs = _outputs(plan, chosen, recipe.derivatives, checks=checks)
    code = has_machine_code() if recipe.machine_code is None else recipe.machine_code
    homes = None
    if designs:
        told = {*plan.driven, *plan.unknowns, *plan.standing(outputs.coordinates)}
        told |= {k for k in outputs.coordinates if isinstance(k, int)}
        known = sorted(k for k in told if k < len(graph.coordinates))
        if any(k not in known for k in plan.iterated):
            found = "a home where the three angles of some joint are all but undefined"
            raise InputError(f"{mechanism.where}: free", found, "another home, or a fixed design")
        homes = Homes.of(designs, graph, own, others, known, machine_code=code)
    return _known(recipe, sent, plan, outputs, len(chosen), machine_code=code, homes=homes)


def _known(
    recipe: Recipe,
    sent: bytes,
    plan: Plan,
    outputs: Outputs,
    reported: int,
    *,
    machine_code: bool,
    homes: Homes | None = None,
    compiled: Kernel | None = None,
) -> Solver:
    """The solver of a plan, which is among those that are not made again when they arrive."""
    solver = Solver(
        plan,
        outputs,
        reported,
        machine_code=machine_code,
        again=(arrived, (sent,)),
        elsewhere=partial(driven_by, recipe),
        other=partial(designed, recipe),
        homes=homes,
        compiled=compiled,
    )
    _kept.alive[sent] = solver
    return solver


def arrived(sent: bytes) -> Solver:
    """A solver sent to this process, compiled the first time it arrives, by one thread."""
    with _kept.lock:
        solver = _kept.alive.get(sent)
        if solver is None:
            recipe = Recipe(*pickle.loads(sent))
            solver = _made(graph_of(recipe.mechanism), recipe, sent)
        _kept.last[sent] = solver
        _kept.last.move_to_end(sent)
        if len(_kept.last) > _KEPT:
            _kept.last.popitem(last=False)
        return solver


def driven_by(recipe: Recipe, driven: tuple[str, ...], q: FloatArray) -> Solver:
    """A solver that others drive, at home at coordinates q (N,), closed. Raises DrivenError."""
    other = recipe._replace(driven=driven, home=tuple(q.tolist()), free=())
    return arrived(pickle.dumps(other, protocol=5))


def designed(recipe: Recipe, parameters: Mapping[str, Value]) -> Solver:
    """The solver of another design, assembled anew from the file's guess, with nothing left open.
    Raises InputError, AssemblyError, DrivenError.
    """
    if not isinstance(parameters, Mapping):
        raise InputError("parameters", repr(parameters), "values by the names of parameters")
    if recipe.home is not None:  # it would not be known which of the other's modes is meant
        found = "another design, of an assembly mode other than home's"
        raise InputError("parameters", found, "a solver compiled without near")
    given: dict[str, Value] = {}
    for name, value in parameters.items():
        if isinstance(value, bool) or not (isinstance(value, str) or is_finite(value)):
            found = "an array" if np.ndim(value) else repr(value)
            raise InputError(f"parameters.{name}", found, "a finite number, or text with a unit")
        given[str(name)] = value if isinstance(value, str) else float(value)
    mechanism = recipe.mechanism.with_parameters(given)
    own = assembled(graph_of(mechanism))
    q = tuple(own.q.tolist())
    return arrived(pickle.dumps(recipe._replace(mechanism=mechanism, own=q, free=()), protocol=5))


def branch_tree(graph: Graph, driven: Sequence[int]) -> Tree:
    """The tree that another branch is found on: of driven joints."""
    return graph.tree(first={graph.coordinates[k].joint for k in driven})


def _standing(graph: Graph, tree: Tree, q: Sequence[float]) -> Configuration:
    """A closed configuration, at these very coordinates: read off again, they might round."""
    return replace(configure(graph, tree, np.array(q)), q=np.array(q))


def _outputs(plan: Plan, chosen: Sequence[int | str], derivatives: int, *, checks: bool) -> Outputs:
    """The coordinates to report and, after them, whatever else is watched along a motion."""
    solved = plan.unknowns if checks and derivatives > 1 else plan.iterated
    hidden: list[int | str] = [k for k in wound(plan) if k not in chosen]
    if checks:
        hidden = also_known(plan, chosen, solved)
    return Outputs((*chosen, *hidden), derivatives, checks)


def _cut(graph: Graph, names: Sequence[str]) -> list[int]:
    """The numbers of joints to cut. Raises InputError on unknown names."""
    joints = [joint.name for joint in graph.joints]
    for name in names:
        if name not in joints:
            raise InputError("cut", f"unknown joint {name!r}", nearest(name, joints))
    return [joints.index(name) for name in names]


def _chosen(graph: Graph, coordinates: Sequence[str] | str | None) -> list[int | str]:
    if isinstance(coordinates, str) and coordinates != "all":
        coordinates = (coordinates,)
    if coordinates is None:
        inside = graph.tree_coordinates(graph.tree())
        if graph.platform is not None:
            inside += graph.joints[graph.platform].coordinates
        return sorted(set(inside))
    if coordinates == "all":
        return [*range(len(graph.plain.coordinates)), *graph.cones]
    return [
        name if name in graph.cones else graph.index(name, "coordinates") for name in coordinates
    ]
