"""Assembly modes: the real assemblies of a mechanism for given driven values.

A search, not a proof: many random starts and all combinations of signs of the closed forms' roots,
in one batch. With the platform driven its answers are the working modes, with the actuators driven
the assembly modes.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from parakin.algebra.angles import nearest_angle
from parakin.arrays import BoolArray, FloatArray, IndexArray
from parakin.errors import InputError, nearest
from parakin.kernel.outputs import Outputs
from parakin.kinematics.assembly import close
from parakin.kinematics.configuration import circuits_at, configure, coordinate_scales
from parakin.kinematics.free_motions import free_motions
from parakin.kinematics.recursion import Circuits
from parakin.model.graph import Graph
from parakin.planning.ordering import plan_of
from parakin.planning.plan import Plan
from parakin.solving.assemblies import CLOSED, assembled_from
from parakin.solving.solver import Solver
from parakin.solving.status import SINGULAR
from parakin.solving.stops import keeps
from parakin.solving.usability import limits_exceeded, turned_through
from parakin.solving.walking import CLOSED as AT_ONCE

_AT_HOME = 1e-4  # radians and characteristic lengths: farther away is another mode
_SAME = 1e-6  # radians and characteristic lengths: how much two copies of one assembly may differ
_RESTS = 1e-9  # rates below this are none
_LOCKED = 1e-6  # cosine of the second of three angles: the others are not well defined


@dataclass(frozen=True)
class Mode:
    """One assembly mode: its name ("home" for that of home), all coordinates, the conditioning, how
    often it was found, in how many variants of passive joints, which limits it exceeds, and which
    legs are turned through themselves: actuated slides whose two joint centres have passed one
    another since home.
    """

    name: str
    coordinates: Mapping[str, float]
    conditioning: float
    found: int
    variants: int
    limits_exceeded: tuple[str, ...]
    turned_through: tuple[str, ...]

    @property
    def usable(self) -> bool:
        """Whether it is within its limits, and no leg is turned through itself."""
        return not (self.limits_exceeded or self.turned_through)


@dataclass(frozen=True)
class Search:
    """What `modes` found: the modes, usable ones first, and among these those nearest home; the
    names of the coordinates that tell them apart; how many starts there were and how many closed;
    and `unseen`, the Good-Turing estimate of how likely one more start that closes is to find
    something new. `singular` counts
    closed starts left out: there the driven coordinates do not determine the rest, and assemblies
    may form a continuum.
    """

    modes: tuple[Mode, ...]
    distinguished_by: tuple[str, ...]
    starts: int
    closed: int
    unseen: float
    singular: int = 0

    @property
    def usable(self) -> tuple[Mode, ...]:
        """The modes that are usable."""
        return tuple(mode for mode in self.modes if mode.usable)

    @property
    def summary(self) -> str:
        """How much was found, and how likely it is that this is all."""
        odds = f"about {self.unseen:.1g}" if self.unseen else f"under {1 / max(self.closed, 1):.1g}"
        return (
            f"{len(self.modes)} distinct, {len(self.usable)} of them usable, among {self.closed:,} "
            f"assemblies found from {self.starts:,} random starts. A search, not a proof: one more "
            f"would be new with probability {odds}."
        )


def modes(solver: Solver, values: Mapping[str, float] | None = None, starts: int = 8192) -> Search:
    """The assembly modes for driven values (home's by default), searched for from random starts.

    With the platform driven these are the working modes. It is a search, not a proof: the result's
    `unseen` estimates how likely one more is. `compile(..., near=mode.coordinates)` makes a solver
    that starts from another mode. Raises InputError on names that are not driven.
    """
    for name in values or {}:
        if name not in solver.driven:
            raise InputError("values", f"{name!r}", nearest(name, solver.driven))
    graph, plan = solver.graph, solver.plan
    home = configure(plan.graph, plan.tree, plan.home)
    home = configure(graph, graph.posed_tree(), home.q[: len(graph.coordinates)])
    found = plan_of(graph, plan.driven, home, own_home=plan.own_home, everywhere=True)
    return modes_of(found, values, starts)


def modes_of(
    plan: Plan, values: Mapping[str, float] | None = None, starts: int = 8192, seed: int = 0
) -> Search:
    """Search for the assemblies that a plan allows.

    values: of driven coordinates, as they are counted; home's where not given. Told apart by
    actuated and platform coordinates that are not driven, or by all where there are none.
    """
    graph = plan.graph
    numbers = range(len(graph.coordinates))
    home = np.array([plan.home[k] - plan.offset(k) for k in numbers])
    offsets = np.array([plan.offset(k) for k in numbers])
    driven = np.array([(values or {}).get(graph.coordinates[k].name, home[k]) for k in plan.driven])
    rng = np.random.default_rng(seed)
    outputs = Outputs(tuple(numbers), derivatives=0)
    out = assembled_from(plan, driven, home, outputs, rng, starts)
    q = out[outputs.order(0)]
    residual, conditioning = out[outputs.residual], out[outputs.conditioning]
    real = residual <= CLOSED * graph.length
    at_rest = np.where(real, q + offsets[:, None], plan.home[:, None])
    turned = _orientation(circuits_at(graph, plan.tree, at_rest), starts)
    if turned is not None:
        _name_again(graph, turned, q)
        real &= ~_only_folded(graph, plan, q, home)
    regular = np.abs(conditioning) > SINGULAR
    closed = np.flatnonzero(real & regular)
    rough = residual[closed] > AT_ONCE * out[outputs.size, closed]
    distinguished_by = _distinguishing(graph, plan)
    found = _sorted_out(
        plan,
        q[:, closed],
        np.abs(conditioning[closed]),
        rough,
        _of(turned, closed),
        home,
        distinguished_by,
    )
    once = sum(1 for mode in found if mode.found == 1)
    return Search(
        found,
        tuple(graph.coordinates[k].name for k in distinguished_by),
        starts,
        len(closed),
        once / len(closed) if len(closed) else 1.0,
        int((real & ~regular).sum()),
    )


def _sorted_out(
    plan: Plan,
    q: FloatArray,
    conditioning: FloatArray,
    rough: BoolArray,
    turned: FloatArray | None,
    home: FloatArray,
    distinguished_by: Sequence[int],
) -> tuple[Mode, ...]:
    """The distinct ones among closed configurations (columns of q): usable ones first, and among
    these, those nearest to home. rough: which are not closed to round-off.
    """
    graph = plan.graph
    scales = coordinate_scales(graph)
    everything = list(range(len(graph.plain.coordinates)))
    found: list[tuple[float, Mode]] = []
    for members in _groups(graph, q, distinguished_by, turned):
        at = q[:, members]
        steps = _wrapped(graph, (at - home[:, None]).T).T / scales[:, None]
        nearest = int(np.argmin(np.linalg.norm(steps, axis=0)))
        away = np.linalg.norm(steps[distinguished_by], axis=0)
        position = home + _wrapped(graph, at[:, nearest] - home)
        if rough[members[nearest]]:
            position = _to_round_off(plan, position)
        if float(away[nearest]) >= _AT_HOME:
            position = _named_as_read(plan, position, home)
            position = _turned_within_limits(plan, position)
        mode = Mode(
            "",
            {graph.coordinates[k].name: float(position[k]) for k in everything},
            min(1.0, float(conditioning[members[nearest]])),
            len(members),
            len(_groups(graph, at, everything, _of(turned, members))),
            limits_exceeded(plan, position),
            turned_through(plan, position),
        )
        found.append((float(away[nearest]), mode))
    # Mirror images are as far from home as each other: let chance not decide which comes first.
    names = [graph.coordinates[k].name for k in distinguished_by]
    found.sort(
        key=lambda pair: (
            not pair[1].usable,
            round(pair[0], 6),
            [round(pair[1].coordinates[n], 4) for n in names],
        )
    )
    return tuple(
        replace(mode, name="home" if distance < _AT_HOME else str(number))
        for number, (distance, mode) in enumerate(found, start=1)
    )


def _named_as_read(plan: Plan, q: FloatArray, home: FloatArray) -> FloatArray:
    """Coordinates with the platform's angles named as a solver that reads them off names them, the
    second within 90° of zero, unless one of them is driven.
    """
    angles = _platform_angles(plan.graph)
    if not angles or {*angles} & {*plan.driven} or math.cos(q[angles[1]]) >= 0.0:
        return q
    named = q.copy()
    named[angles] = q[angles[0]] + math.pi, math.pi - q[angles[1]], q[angles[2]] + math.pi
    named[angles] = nearest_angle(named[angles], to=home[angles])
    return named


def _turned_within_limits(plan: Plan, q: FloatArray) -> FloatArray:
    """Coordinates with angles that exceed a limit turned full turns to where they keep it, if there
    is such a turn. (A screw's turns are not all the same.)
    """
    graph, turned = plan.graph, q.copy()
    numbers = {c.name: k for k, c in enumerate(graph.coordinates)}
    for limit in graph.limited:
        k = numbers.get(limit.coordinate)
        if limit.order or k is None or k in plan.driven or not graph.coordinates[k].angle:
            continue
        if graph.joints[graph.coordinates[k].joint].kind == "helical":
            continue
        least = turned[k] + 2 * math.pi * math.ceil((limit.low - turned[k]) / (2 * math.pi))
        if not keeps(graph, limit, float(turned[k])) and math.isfinite(least):
            turned[k] = least if keeps(graph, limit, least) else turned[k]
    return turned


def _to_round_off(plan: Plan, q: FloatArray) -> FloatArray:
    """Coordinates, as they are counted, closed as well as numbers can."""
    graph = plan.graph
    offsets = np.array([plan.offset(k) for k in range(len(q))])
    tree = graph.tree(first={graph.coordinates[k].joint for k in plan.driven})
    at, norm = close(graph, tree, q + offsets, held=plan.driven)
    return at.q[: len(q)] - offsets if norm <= AT_ONCE * graph.length else q


def _distinguishing(graph: Graph, plan: Plan) -> list[int]:
    chosen = [k for k, c in enumerate(graph.coordinates) if c.actuated]
    if graph.platform is not None:
        chosen += graph.joints[graph.platform].coordinates
    chosen = [k for k in chosen if k not in plan.affine]
    return chosen or [k for k in range(len(graph.plain.coordinates)) if k not in plan.affine]


def _platform_angles(graph: Graph) -> list[int]:
    if graph.platform is None:
        return []
    return list(graph.joints[graph.platform].coordinates)[3:]


def _platform_axes(graph: Graph) -> list[int]:
    joint = graph.joints[graph.platform or 0]
    return [pair.axis for pair in joint.pairs[3:]]


def _wrapped(graph: Graph, difference: FloatArray) -> FloatArray:
    """Differences of angles within half a turn; coordinates along the last axis."""
    angle = np.array([c.angle for c in graph.coordinates])
    turned: FloatArray = np.where(angle, nearest_angle(difference), difference)
    return turned


def _orientation(circuits: Circuits, n: int) -> FloatArray | None:
    """R_WB of the platform, (n, 3, 3): three angles have several names for one orientation."""
    graph = circuits.graph
    if graph.platform is None:
        return None
    R = circuits.pose(graph.joints[graph.platform].child).R
    stacked = [[np.broadcast_to(np.asarray(x, dtype=float), n) for x in row] for row in R]
    return np.array(stacked).transpose(2, 0, 1)


def _of(turned: FloatArray | None, chosen: IndexArray | list[int]) -> FloatArray | None:
    return None if turned is None else turned[chosen]


def _name_again(graph: Graph, turned: FloatArray, q: FloatArray) -> None:
    """Choose angles again where they are undefined, having been read off rounding errors."""
    angles = _platform_angles(graph)
    sequence = "".join("XYZ"[axis] for axis in _platform_axes(graph))
    held = np.cos(q[angles[1]]) if sequence[0] != sequence[2] else np.sin(q[angles[1]])
    locked = np.flatnonzero(np.abs(held) < _LOCKED)
    if len(locked):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # gimbal lock: one of many names will do
            named = Rotation.from_matrix(turned[locked]).as_euler(sequence)
        for k, row in zip(angles, named.T, strict=True):
            q[k, locked] = row


def _only_folded(graph: Graph, plan: Plan, q: FloatArray, home: FloatArray) -> BoolArray:
    """Where angles of the platform that never move differ from home's only in that the same
    orientation has two names, so that a driven one has moved: no assembly for the driven values.
    """
    angles = _platform_angles(graph)
    sequence = "".join("XYZ"[axis] for axis in _platform_axes(graph))
    driven = np.isin(angles, plan.driven)
    tree = graph.posed_tree()
    motions = free_motions(graph, tree, configure(graph, tree, plan.home))[angles]
    if not driven.any() or driven.all() or np.abs(motions[~driven]).max(initial=0.0) > _RESTS:
        return np.zeros(q.shape[1], dtype=bool)
    a, b, c = q[angles]
    other = np.array([a + np.pi, -b if sequence[0] == sequence[2] else np.pi - b, c + np.pi])

    def as_home(values: FloatArray) -> BoolArray:
        away = nearest_angle(values - home[angles, None])
        rests: BoolArray = np.abs(away[~driven]).max(axis=0) < _SAME
        return rests

    return as_home(other) & ~as_home(q[angles])


def _groups(
    graph: Graph,
    q: FloatArray,
    by: Sequence[int],
    orientation: FloatArray | None,
) -> list[list[int]]:
    """Columns of q that agree in the coordinates `by`, angles modulo a turn, and orientation."""
    if not q.shape[1]:
        return []
    turned = _platform_angles(graph)
    whole = set(turned) <= set(by)  # three angles: one orientation has several names
    features = [
        row
        for k in by
        if not (whole and k in turned)
        for row in (
            (np.cos(q[k]), np.sin(q[k])) if graph.coordinates[k].angle else (q[k] / graph.length,)
        )
    ]
    if whole and turned:
        assert orientation is not None
        features += list(orientation.reshape(-1, 9).T)
    points = np.array(features).T
    left = np.arange(len(points))
    groups: list[list[int]] = []
    while len(left):
        same = np.abs(points[left] - points[left[0]]).max(axis=1) < _SAME
        groups.append(left[same].tolist())
        left = left[~same]
    return groups
