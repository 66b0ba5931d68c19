"""Mobility: what the count of joints promises, what the closed loops allow, and who is to blame.

The instantaneous freedoms are the null space of all loops together: for every loop the screws of
its joints, weighted by their rates, add up to nothing (six equations a loop, whatever is cut).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from parakin.arrays import FloatArray
from parakin.kinematics.assembly import home_and_around
from parakin.kinematics.closure import canonical_rows
from parakin.kinematics.configuration import (
    Configuration,
    configure,
    coordinate_scales,
    full_screws,
    loop_rank,
    loop_signs,
    row_wrench,
)
from parakin.kinematics.free_motions import free_motions, holders, is_idle
from parakin.model.graph import Graph

_RANK = 1e-8
_NEARBY = 6


@dataclass(frozen=True)
class Loop:
    """A loop of the default tree: its joints, and how many of its six equations are independent.

    A planar or spherical loop has three, whatever the bodies: the others come for free, and are
    redundant as long as its axes stay parallel or concurrent.
    """

    joints: tuple[str, ...]
    rank: int


@dataclass(frozen=True)
class Mobility:
    """What `mobility` found.

    grubler: Grübler-Kutzbach's count 6 (bodies - 1 - joints) + freedoms, the base counted as a
    body. home: by rank at home. nearby: by rank at closed configurations around home, its
    generic value the smallest. tree_coordinates, rows, rank: of the loops cut open along the
    default tree. to_blame: joints which, were they spherical, would let the driven coordinates
    move; with `mobility_if_spherical`, the mobility then. idle: coordinates of free motions that
    move neither platform nor actuators. loops: of the default tree, with their ranks.
    """

    bodies: int
    joints: int
    grubler: int
    home: int
    nearby: tuple[int, ...]
    tree_coordinates: int
    rows: int
    rank: int
    cuts: tuple[str, ...]
    wanted: int
    to_blame: tuple[str, ...]
    mobility_if_spherical: int
    idle: tuple[str, ...] = ()
    loops: tuple[Loop, ...] = ()

    @property
    def generic(self) -> int:
        return min((self.home, *self.nearby))

    @property
    def special(self) -> bool:
        """Whether home has another mobility than configurations around it."""
        return bool(self.nearby) and self.home != min(self.nearby)

    @property
    def redundant(self) -> int:
        """Closure rows that say nothing new at home."""
        return self.rows - self.rank


def mobility(graph: Graph, home: Configuration, wanted: int = 0) -> Mobility:
    """Count and measure the mobility at home and around it.

    wanted: how many coordinates are to be driven; where fewer can move, the joints that hold
    them are looked for.
    """
    tree = graph.tree()
    real = [joint for joint in graph.joints if joint.name != "platform"]
    samples = home_and_around(graph, tree, home, _NEARBY)
    at, *nearby = samples
    cuts = [k for k in tree.cuts if k != graph.platform]
    rows = sum(len(canonical_rows(graph.joints[k], k)) for k in cuts)
    inside = len(graph.tree_coordinates(tree))
    by_rank = [mobility_at(graph, c) for c in samples]
    blamed: list[str] = []
    mobility_if_spherical = min(by_rank)
    if mobility_if_spherical < wanted:
        generic = samples[int(np.argmin(by_rank))]
        blamed, mobility_if_spherical = _blame(graph, generic, wanted)
    return Mobility(
        bodies=len(graph.bodies),
        joints=len(real),
        grubler=6 * (len(graph.bodies) - 1 - len(real)) + sum(joint.freedom for joint in real),
        home=by_rank[0],
        nearby=tuple(by_rank[1:]),
        tree_coordinates=inside,
        rows=rows,
        rank=inside - by_rank[0],
        cuts=tuple(graph.joints[k].name for k in cuts),
        wanted=wanted,
        to_blame=tuple(blamed),
        mobility_if_spherical=mobility_if_spherical,
        idle=tuple(graph.coordinates[k].name for k in idle_coordinates(graph, (*nearby, at))),
        loops=tuple(_loop(graph, (nearby or [at])[0], cut) for cut in cuts),
    )


def _loop(graph: Graph, at: Configuration, cut: int) -> Loop:
    signs = loop_signs(graph, graph.tree())[cut]
    inside = sorted({graph.coordinates[k].joint for k in np.flatnonzero(signs)} | {cut})
    numbers = [k for j in inside for k in graph.joints[j].coordinates]
    rank = 1 if graph.joints[cut].kind == "rod" else loop_rank(graph, at, numbers)
    return Loop(tuple(graph.joints[j].name for j in inside), rank)


def idle_coordinates(graph: Graph, samples: Sequence[Configuration]) -> list[int]:
    """A coordinate for each freedom left when platform and actuators rest, everywhere."""
    watched = [k for k, c in enumerate(graph.coordinates) if c.actuated]
    if graph.platform is not None:
        watched += graph.joints[graph.platform].coordinates
    found: list[int] | None = None
    tree = graph.posed_tree()
    for at in samples:
        there = configure(graph, tree, at.q)
        motions = free_motions(graph, tree, there)
        motions = motions / coordinate_scales(graph)[:, None]
        if not watched or not motions.shape[1]:
            return []
        _, sizes, right = np.linalg.svd(motions[watched])
        loose = motions @ right[int((sizes > 1e-7).sum()) :].T
        if not loose.shape[1] or not is_idle(there, loose):
            return []
        found = found or holders(loose)
    return found or []


def mobility_at(graph: Graph, at: Configuration, freed: Sequence[int] = ()) -> int:
    """The mobility by rank at a closed configuration; joints `freed` taken as spherical too."""
    tree = graph.tree()
    signs = loop_signs(graph, tree)
    scales = coordinate_scales(graph)
    scale = np.array([1.0] * 3 + [1.0 / graph.length] * 3)[:, None]
    extra = {k: _extra_screws(graph, at, k) for k in freed}
    width: int = len(graph.coordinates) + sum(screws.shape[1] for screws in extra.values())
    loops: list[FloatArray] = []
    onward = {k: -1.0 if reverse else 1.0 for k, reverse in tree.steps}
    leading = _leading(graph)
    screws_at = full_screws(graph, at)
    for cut in tree.cuts:
        weights = signs[cut].copy()
        weights[list(graph.joints[cut].coordinates)] = -1.0
        block = np.zeros((6, width))
        block[:, : len(scales)] = screws_at * weights * scales
        place = len(scales)
        for k, screws in extra.items():
            ahead, behind = leading[graph.joints[cut].child], leading[graph.joints[cut].parent]
            # How the twist of a joint enters the loop of the one that is cut.
            sign = -1.0 if k == cut else onward.get(k, 0.0) * ((k in ahead) - (k in behind))
            block[:, place : place + screws.shape[1]] = sign * screws
            place += screws.shape[1]
        if graph.joints[cut].kind == "rod":  # one row, not six: nothing but its length is kept
            (row,) = canonical_rows(graph.joints[cut], cut)
            block = row_wrench(at, row)[None, :] @ block / graph.joints[cut].length
            loops.append(block / graph.length)
        else:
            loops.append(scale * block)
    if not loops:
        return width
    sizes = np.linalg.svd(np.vstack(loops), compute_uv=False)
    return width - int((sizes > _RANK * sizes[0]).sum())


def _leading(graph: Graph) -> dict[int, set[int]]:
    """By body, the joints that lead to it from the base."""
    reached = {0: set[int]()}
    for k, reverse in graph.tree().steps:
        joint = graph.joints[k]
        near, far = (joint.child, joint.parent) if reverse else (joint.parent, joint.child)
        reached[far] = reached[near] | {k}
    return reached


def _extra_screws(graph: Graph, at: Configuration, k: int) -> FloatArray:
    """The turns about a joint's centre that it does not allow."""
    centre = np.array(at.ends[k].X_WF.p, dtype=float)
    own = full_screws(graph, at)[:3, list(graph.joints[k].coordinates)]
    _, sizes, right = np.linalg.svd(own.T) if own.size else (None, np.zeros(0), np.eye(3))
    axes = right[int((sizes > 1e-9).sum()) :]
    return np.array([np.concatenate([a, np.cross(centre, a)]) for a in axes]).reshape(-1, 6).T


def _blame(graph: Graph, at: Configuration, wanted: int) -> tuple[list[str], int]:
    """The fewest universal joints, those at the platform first, whose third turn is missing."""
    platform = graph.joints[graph.platform].child if graph.platform is not None else 0

    def order(k: int) -> tuple[bool, int]:
        joint = graph.joints[k]
        return (platform not in (joint.parent, joint.child), k)

    candidates = [k for k, joint in enumerate(graph.joints) if joint.kind == "universal"]
    freed: list[int] = []
    reached = mobility_at(graph, at)
    for k in sorted(candidates, key=order):
        if reached >= wanted:
            break
        gained = mobility_at(graph, at, [*freed, k])
        if gained > reached:
            freed.append(k)
            reached = gained
    return [graph.joints[k].name for k in freed], reached
