"""What the driven coordinates determine: whether they do, and which others are affine in them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from parakin.errors import DrivenError
from parakin.kinematics.configuration import Configuration, configure, coordinate_scales
from parakin.kinematics.free_motions import free_motions, holders, is_idle
from parakin.model.graph import Graph
from parakin.planning.plan import Affine

_AFFINE = 1e-12  # slopes that differ by no more from place to place are the same


def check_driven(
    graph: Graph, driven: Sequence[int], home: Configuration, samples: Sequence[Configuration]
) -> list[int]:
    """Raises DrivenError unless the driven coordinates determine all others near home.

    Freedoms that move neither platform nor actuators, such as the spin of a leg between two
    spherical joints, are idle. Returns a coordinate for each, to be held at home.
    """
    name = graph.mechanism.where
    names = ", ".join(graph.coordinates[k].name for k in driven) or "none"
    tree = graph.posed_tree()
    count = "1 coordinate is" if len(driven) == 1 else f"{len(driven)} coordinates are"
    held: list[int] = []
    for at in (*samples, home):
        there = configure(graph, tree, at.q)
        motions = free_motions(graph, tree, there)
        scaled = motions / coordinate_scales(graph)[:, None]
        mobility = motions.shape[1]
        given = scaled[list(driven)]
        left, sizes, right = np.linalg.svd(given) if given.size else (None, np.zeros(0), None)
        rank = int((sizes > 1e-7).sum())
        where = "at home" if at is home else "near home"
        if rank < len(driven):
            reason = f"the mobility is {mobility}" if left is None else ""
            if left is not None:
                weights = np.abs(left[:, rank:]).max(axis=1)
                tied = [n for n, w in zip(names.split(", "), weights, strict=True) if w > 1e-6]
                reason = (
                    f"{tied[0]} cannot move"
                    if len(tied) == 1
                    else f"{', '.join(tied)} depend on one another"
                )
            raise DrivenError(
                f"{name}: {count} driven ({names}), but only {rank} can move "
                f"independently {where}: {reason} (mobility {mobility})"
            )
        if mobility == rank:
            continue
        loose = scaled @ (right[rank:].T if right is not None else np.eye(mobility))
        if is_idle(there, loose):
            held = held or holders(loose)
            continue
        moved = [
            c.name
            for c, row in zip(graph.coordinates, np.abs(loose).max(axis=1), strict=True)
            if row > 1e-6
        ]
        raise DrivenError(
            f"{name}: mobility is {mobility} {where}, but {count} driven ({names}); "
            f"not determined: {', '.join(moved)}"
        )
    return held


def affine_in(
    graph: Graph,
    driven: Sequence[int],
    idle: Sequence[int],
    home: Configuration,
    samples: Sequence[Configuration],
) -> dict[int, Affine]:
    """Coordinates whose rates are the same mix of the driven ones everywhere, as in eq. (5), in
    other designs too if there are samples of these.

    Those of idle freedoms rest at home.
    """
    tree = graph.posed_tree()
    maps = []
    for at in (*samples, home):
        own = at.circuits.graph
        motions = free_motions(own, tree, configure(own, tree, at.q))
        given = [*driven, *idle]
        maps.append(np.linalg.solve(motions[given].T, motions.T).T[:, : len(driven)])
    spread = np.ptp(np.array(maps), axis=0).max(axis=1)
    found = {}
    for k in range(len(graph.coordinates)):
        if k in driven:
            found[k] = Affine(0.0, ((k, 1.0),))
            continue
        lone = len(samples) < 2 and k not in given  # nothing to compare with
        if (spread[k] > _AFFINE and k not in given) or lone:
            continue
        mean = np.mean([m[k] for m in maps], axis=0)
        whole = np.round(mean)
        mean = np.where(np.abs(mean - whole) < _AFFINE, whole, mean)
        constant = float(home.q[k] - mean @ home.q[list(driven)])
        off = max(abs(at.q[k] - constant - mean @ at.q[list(driven)]) for at in samples)
        if k not in given and off > _AFFINE * coordinate_scales(graph)[k]:
            continue
        # What is left of cancelling home values is round-off.
        constant = 0.0 if abs(constant) < 1e-15 else constant
        factors = tuple((j, float(f)) for j, f in zip(driven, mean, strict=True) if f)
        found[k] = Affine(constant, factors)
    return found
