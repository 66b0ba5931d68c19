"""What goes free at a pose, and which kind of singularity that makes.

After Gosselin and Angeles (1990), and Zlatanov, Fenton and Benhabib (1995): what moves while the
driven coordinates are held gives the kind, as `parakin.singularities` has them along a motion.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from parakin.algebra.spatial import as_array
from parakin.analysis.twists import moving, names, platform_axes, platform_motion
from parakin.arrays import FloatArray
from parakin.errors import InputError
from parakin.kernel.connectivity import jacobian
from parakin.kinematics.closure import all_rows
from parakin.kinematics.configuration import circuits_at, configure, coordinate_scales
from parakin.kinematics.free_motions import free_motions
from parakin.model.graph import Graph
from parakin.planning.plan import Block, Plan

if TYPE_CHECKING:
    from parakin.solving.solver import Solver

Kind = Literal["type 1", "type 2", "constraint", "passive", "driven", "angles"]

RANK = 1e-8  # of the largest singular value: what counts as none
LOST = 1e-3  # of its best value: a rank that is lost
_STILL = 1e-3  # of what moves most: what rests


def outputs_of(solver: Solver) -> list[str]:
    """The coordinates that the actuated ones move: those of the platform that the file drives or
    that move most freely at home, or without a platform the last passive ones at the base.

    Raises InputError where there are not as many actuated coordinates, or outputs, as driven ones.
    """
    return [solver.plan.graph.coordinates[k].name for k in sets_of(solver).outputs]


class Sets(NamedTuple):
    """Numbers of coordinates: actuated, outputs, and the platform's six."""

    actuated: list[int]
    outputs: list[int]
    pose: list[int]

    @property
    def turned(self) -> list[int]:
        """Where the platform's angles stand among actuated coordinates and outputs, all or none."""
        whole = set(self.pose[3:]) <= set(self.outputs)
        return [len(self.actuated) + self.outputs.index(k) for k in self.pose[3:]] if whole else []


def sets_of(solver: Solver) -> Sets:
    """The actuated coordinates, and the outputs: those of the platform that the file drives or
    that move most freely at home, or without a platform the last passive ones at the base.

    Raises InputError where there are not as many of either as are driven.
    """
    graph, count = solver.plan.graph, len(solver.driven)
    actuated = [k for k, c in enumerate(graph.coordinates) if c.actuated]
    pose = [] if graph.platform is None else list(graph.joints[graph.platform].coordinates)
    where = solver.mechanism.where
    if len(actuated) != count:
        raise InputError(
            where,
            f"{len(actuated)} actuated coordinates and {count} driven",
            "as many motors (actuated = true) as the mobility, to tell singularities apart",
        )
    by_file = [graph.index(n, "driven") for n in solver.mechanism.driven]
    outputs = [k for k in by_file if k not in actuated]
    if len(outputs) != count and pose:
        outputs = _freest(solver, pose, count)
    elif len(outputs) != count:
        named = [graph.index(n, "coordinates") for n in solver.coordinates if n not in graph.cones]
        grounded = [k for k in named if graph.joints[graph.coordinates[k].joint].parent == 0]
        outputs = [k for k in grounded if k not in actuated][-count:]
    if len(outputs) != count:
        raise InputError(
            where,
            f"{len(outputs)} outputs and {count} actuated coordinates",
            "a [platform], or as many passive coordinates at the base",
        )
    return Sets(actuated, outputs, pose)


def _freest(solver: Solver, among: list[int], count: int) -> list[int]:
    """The `count` coordinates that move most independently at home."""
    graph, plan = solver.plan.graph, solver.plan
    at = configure(graph, plan.tree, plan.home)
    motions = free_motions(graph, plan.tree, at) / coordinate_scales(graph)[:, None]
    left = motions[among]
    chosen: list[int] = []
    for _ in range(count):
        sizes = np.linalg.norm(left, axis=1)
        k = int(np.argmax(sizes))
        if sizes[k] > RANK:
            chosen.append(among[k])
            left = left - np.outer(left @ left[k], left[k]) / sizes[k] ** 2
    return sorted(chosen)


class Freedom(NamedTuple):
    """What moves most easily at a pose while the driven coordinates are held: the kind of
    singularity that it makes, in words; rates of all coordinates, slides in characteristic
    lengths; and how firmly it is `held`, 0 where it is free.
    """

    kind: Kind
    words: str
    rates: FloatArray
    held: float

    @property
    def description(self) -> str:
        """In words, as what stops a motion."""
        if self.kind == "angles":
            return self.words
        kind = {"driven": "", "passive": "passive-joint "}.get(self.kind, f"{self.kind} ")
        return f"a {kind}singularity, where {self.words}"


def freedom_at(solver: Solver, q: FloatArray) -> Freedom:
    """What can move at a pose near a singularity; the rank of the rows is that at home.

    q: all coordinates, as the joints count. Where kinds cannot be told apart (`sets_of` raises
    InputError), it is of kind "driven". Raises LinAlgError.
    """
    try:
        sets = sets_of(solver)
    except InputError:
        sets = None
    (values,) = whole_values(solver.plan, np.asarray(solver.plan.home)[:, None])
    rank = int((values > RANK * values[0]).sum())
    return freedom(solver, sets, q, rank, float(values[rank - 1] / values[0]))


def freedom(solver: Solver, sets: Sets | None, q: FloatArray, rank: int, best: float) -> Freedom:
    """What moves most easily at a pose, and the kind of singularity that makes.

    rank: of all closure rows where nothing is singular. best: there, the least of that many
    singular values over the largest.
    """
    graph, plan = solver.plan.graph, solver.plan
    if graph.platform is not None and abs(_spread(graph, q)) < LOST:
        words = (
            "the platform's three angles are undefined there; about other axes they may be defined"
        )
        return Freedom("angles", words, np.zeros(len(q)), 0.0)
    (values,) = whole_values(plan, q[:, None])
    lost_rank = bool(values[rank - 1] < LOST * best * values[0])
    at = configure(graph, plan.tree, q)
    motions = free_motions(graph, plan.tree, at, rank=rank - lost_rank)
    motions = motions / coordinate_scales(graph)[:, None]
    _, held, right = np.linalg.svd(motions[[*plan.driven, *plan.idle]])
    free = motions @ right[-1]
    firm = float(held[-1]) if motions.shape[1] == len(held) else 0.0
    free[list(plan.driven)] = 0.0  # or nearly so
    return Freedom(*_judged(graph, sets, free, q, constraint=lost_rank), free, firm)


def whole_values(plan: Plan, q: FloatArray) -> FloatArray:
    """Singular values of all closure rows by all coordinates of the tree, (n, values)."""
    graph, tree = plan.graph, plan.tree
    inside, rows = graph.tree_coordinates(tree), all_rows(graph, tree)
    if not rows:
        return np.ones((q.shape[1], 1))
    slopes = jacobian(circuits_at(graph, tree, q), Block(tuple(inside), tuple(rows)))
    matrix = np.empty((q.shape[1], len(rows), len(inside)))
    scales = coordinate_scales(graph)
    for i, row in enumerate(rows):
        for j, k in enumerate(inside):
            matrix[:, i, j] = (
                row.per_length(graph) / graph.length * scales[k] * as_array(slopes[i][j])
            )
    values: FloatArray = np.asarray(np.linalg.svd(matrix, compute_uv=False), dtype=np.float64)
    return values


def _spread(graph: Graph, q: FloatArray) -> float:
    """The volume that the axes of the platform's three angles span, 0 in gimbal lock."""
    return float(np.linalg.det(platform_axes(graph, q[:, None])[0][0]))


def _judged(
    graph: Graph, sets: Sets | None, free: FloatArray, q: FloatArray, *, constraint: bool
) -> tuple[Kind, str]:
    """Which kind: by what moves while the driven coordinates rest."""
    every = moving(graph, free, range(len(free)))
    locked = f"{every} with the driven coordinates locked"
    if sets is None:
        return "driven", locked
    still = _STILL * float(np.abs(free).max())
    if constraint:
        whole = sets._replace(outputs=sets.pose or sets.outputs)
        carried = bool((np.abs(free[whole.outputs]) > still).any())
        loose = _outputs(graph, whole, free, q) if carried else every
        return "constraint", f"{loose}, whatever is driven"
    rest = [bool((np.abs(free[part]) < still).all()) for part in (sets.actuated, sets.outputs)]
    if all(rest):
        return "passive", f"{every} while all else rests"
    if rest[0]:
        return "type 2", freed(graph, sets, free, q)
    if rest[1]:
        return "type 1", type1_words(graph, sets, free)
    return "driven", locked


def _outputs(graph: Graph, sets: Sets, rates: FloatArray, q: FloatArray) -> str:
    return platform_motion(graph, rates, q, sets.outputs) or moving(graph, rates, sets.outputs)


def freed(graph: Graph, sets: Sets, rates: FloatArray, q: FloatArray) -> str:
    """Type 2 in words."""
    actuators = names(graph, sets.actuated)
    return f"{_outputs(graph, sets, rates, q)} with the actuators locked ({actuators})"


def type1_words(graph: Graph, sets: Sets, rates: FloatArray) -> str:
    """Type 1 in words."""
    rests = "the platform" if set(sets.outputs) <= set(sets.pose) else names(graph, sets.outputs)
    return f"{moving(graph, rates, sets.actuated)} while {rests} rests"
