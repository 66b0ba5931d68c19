"""Assembly: from a rough guess to a closed mechanism, and to other closed ones near it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from parakin.algebra.angles import nearest_angle
from parakin.algebra.spatial import as_float
from parakin.arrays import FloatArray
from parakin.errors import AssemblyError, InputError
from parakin.kinematics import chains
from parakin.kinematics.closure import Perpendicular, canonical_rows, cosines
from parakin.kinematics.configuration import (
    Configuration,
    closure_system,
    configure,
    coordinate_scales,
    loop_signs,
)
from parakin.kinematics.free_motions import free_motions
from parakin.model.designs import Designs
from parakin.model.graph import Graph, Tree

_NOTHING = 1e-14  # a home value this small is round-off of zero; exact zeros make shorter code
CLOSED = 1e-12  # of the characteristic length
_SHAKES = (0.02, 0.1, *(0.3, 1.0, 3.0) * 16)  # of starts around a guess [rad]
_TRIES = 3  # of these, as long as the loops do not close at all
_STRAY = 1e-6  # a step longer than this from closed loops only follows round-off
_WORK = 6000  # steps of closing times coordinates: some three seconds
_RANK = 1e-8  # singular values below this part of the largest count as zero
_NEARER = 8  # times that another design comes half the way back
_NEARBY_STEPS = 60  # ten are enough, except at a singularity


def close(
    graph: Graph, tree: Tree, start: FloatArray, held: Sequence[int] = (), steps: int = 200
) -> tuple[Configuration, float]:
    """Close the loops from `start`, holding some coordinates: damped Gauss-Newton, least motion.

    steps: the most to take; fewer for large mechanisms. Returns the configuration reached and the
    norm of its scaled gaps, closed or not.
    """
    steps = min(steps, max(20, _WORK // max(1, len(graph.coordinates))))
    with np.errstate(all="ignore"):  # absurd dimensions end as not closed
        return _closed(graph, tree, start, held, steps)


def _closed(
    graph: Graph, tree: Tree, start: FloatArray, held: Sequence[int], steps: int
) -> tuple[Configuration, float]:
    signs = loop_signs(graph, tree)
    scales = coordinate_scales(graph)
    free = [n for n in graph.tree_coordinates(tree) if n not in set(held)]
    at = configure(graph, tree, start)
    gaps, jacobian, _ = closure_system(graph, tree, at, signs)
    best, damping = float(np.linalg.norm(gaps)), 0.0
    settled = 0
    for _ in range(steps):
        J = jacobian[:, free] * scales[free]
        if damping == 0.0:
            least = chains.least_step(J, gaps)
            step = -(np.linalg.lstsq(J, gaps, rcond=_RANK)[0] if least is None else least)
        else:
            step = -np.linalg.solve(J.T @ J + damping * np.eye(len(free)), J.T @ gaps)
        size = float(np.abs(step).max(initial=0.0))
        if best < CLOSED and size > _STRAY:
            break
        q = at.q.copy()
        q[free] += step * scales[free] * min(1.0, 0.5 / size if size else 1.0)
        trial = configure(graph, tree, q)
        gaps_there, jacobian_there, _ = closure_system(graph, tree, trial, signs)
        norm = float(np.linalg.norm(gaps_there))
        if best < CLOSED:  # at round-off already: stop when another step gains nothing
            settled += 1
            if norm >= best or settled > 3:
                break
        if norm < best:
            at, gaps, jacobian, best = trial, gaps_there, jacobian_there, norm
            damping = 0.0 if damping < 1e-9 else damping * 0.2
        elif size < 1e-14 or damping > 1e6:
            break
        else:
            damping = max(4.0 * damping, 1e-6)
    return at, best


def assembled(graph: Graph) -> Configuration:
    """Home, closed at round-off. Raises AssemblyError."""
    return home_of(graph, home_tree(graph))


def home_tree(graph: Graph) -> Tree:
    """The tree that home is found on: of joints whose values are given."""
    held = {graph.coordinates[k].joint for k in graph.home}
    guessed = {graph.coordinates[k].joint for k in (*graph.guess, *graph.stated)}
    return graph.tree(first=held, second=guessed)


def home_of(graph: Graph, tree: Tree) -> Configuration:
    """The home configuration: closed at round-off, on the branch nearest the guess.

    Raises AssemblyError naming the joint with the largest gap, in mm and degrees.
    """
    start = np.zeros(len(graph.coordinates))
    for values in (graph.guess, graph.stated, graph.home):
        for k, value in values.items():
            start[k] = value
    in_tree = set(graph.tree_coordinates(tree))
    held = [k for k in graph.home if k in in_tree]
    at, norm = min(
        (close(graph, tree, begin, held) for begin in _starts(graph, start)),
        key=lambda found: (
            found[1] > CLOSED or bool(_opposed(tree, found[0])),
            _distance(graph, found[0].q, start),
        ),
    )
    at, norm = _shaken(graph, tree, start, held, at, norm)
    missed = [
        (abs(at.q[k] - value), k)
        for k, value in graph.home.items()
        if k not in in_tree and abs(at.q[k] - value) > 1e-9
    ]
    if missed:
        miss, k = max(missed)
        raise AssemblyError(
            f"{graph.mechanism.where}: home.{graph.coordinates[k].name} = {graph.home[k]:g} cannot "
            f"be held: its joint closes a loop of joints held at home (off by {miss:.3g})"
        )
    if norm > CLOSED:
        gaps = [(*joint_gap(at, k), graph.joints[k].name) for k in tree.cuts]
        mm, degrees, name = max(gaps, key=lambda g: g[0] / graph.length / 1e3 + math.radians(g[1]))
        raise AssemblyError(
            f"{graph.mechanism.where}: cannot be assembled from its guess; the largest gap left is "
            f"at joint {name}: {mm:.6g} mm and {degrees:.6g} degrees (a better [guess] may help, "
            "or these dimensions do not close at all)"
        )
    at.q[np.abs(at.q) < _NOTHING] = 0.0
    opposed = _opposed(tree, at)
    if opposed:
        raise AssemblyError(
            f"{graph.mechanism.where}: joint {graph.joints[opposed[0]].name} closes with its axes "
            "opposed; reverse the axis on one of its bodies, or correct the guess"
        )
    return at


def _shaken(
    graph: Graph,
    tree: Tree,
    start: FloatArray,
    held: Sequence[int],
    at: Configuration,
    norm: float,
) -> tuple[Configuration, float]:
    """A better configuration from starts around the guess, if the one found is open or has opposed
    axes. (A guess may be a stationary point, at right angles to what is wanted.)

    Where loops are closed but for opposed axes, one of these loops at a time starts again.
    """
    rng = np.random.default_rng(0)
    angles = np.array([c.angle for c in graph.coordinates])
    signs = loop_signs(graph, tree)
    for number, size in enumerate(_SHAKES):
        wrong = _opposed(tree, at)
        if norm <= CLOSED and not wrong:
            break
        if norm > CLOSED and number > _TRIES:
            break
        reach = np.where(angles, size, min(size, 0.3))
        shake = reach * rng.uniform(-1, 1, len(start)) * coordinate_scales(graph)
        shake[held] = 0.0
        begin = start
        if norm <= CLOSED:
            begin = at.q
            shake[signs[wrong[number % len(wrong)]] == 0] = 0.0
        other, there = close(graph, tree, begin + shake, held)
        closed = there <= CLOSED and len(_opposed(tree, other)) < len(wrong)
        if closed or (norm > CLOSED and there < norm):
            at, norm = other, there
    return at, norm


def _opposed(tree: Tree, at: Configuration) -> list[int]:
    """Cut joints whose rows vanish although two of their axes point in opposite directions."""
    return [
        cut
        for cut in tree.cuts
        if any(as_float(cosine) < 0 for cosine in cosines(at.circuits, cut, at.ends[cut]))
    ]


def _starts(graph: Graph, start: FloatArray) -> list[FloatArray]:
    """The guess; and the guess with the platform, where its pose is not given, put where the
    joints' guess leads.
    """
    if graph.platform is None:
        return [start]
    through_joints = configure(graph, graph.tree(last=[graph.platform]), start)
    led = start.copy()
    for k in graph.joints[graph.platform].coordinates:
        if k not in {**graph.guess, **graph.stated, **graph.home}:
            led[k] = through_joints.q[k]
    return [start] if np.array_equal(led, start) else [start, led]


def _distance(graph: Graph, q: FloatArray, start: FloatArray) -> float:
    """How far a configuration is from the guess; coordinates without a guess count little."""
    given = {**graph.guess, **graph.stated, **graph.home}
    away = (q - start) / coordinate_scales(graph)
    total = 0.0
    for k, coordinate in enumerate(graph.coordinates):
        if coordinate.joint == graph.platform and k not in given:
            continue
        step = away[k]
        if coordinate.angle:
            step = nearest_angle(step)
        total += (1.0 if k in given else 1e-3) * float(step) ** 2
    return total


def joint_gap(at: Configuration, cut: int) -> tuple[float, float]:
    """How far a cut joint is from closing: millimetres, degrees."""
    graph = at.circuits.graph
    end = at.ends[cut]
    mm = degrees = 0.0
    for row in canonical_rows(graph.joints[cut], cut):
        gap = as_float(row.value(at.circuits, end))
        if isinstance(row, Perpendicular):
            degrees = math.hypot(degrees, math.degrees(math.asin(max(-1.0, min(1.0, gap)))))
        else:
            mm = math.hypot(mm, 1e3 * gap * row.per_length(graph))
    return mm, degrees


def homes_of(designs: Designs, graph: Graph, home: Configuration) -> list[Configuration]:
    """Homes of other designs near the file's own, whose home is given, and configurations around
    them. A design that will not close is replaced by one that is nearer.
    """
    tree, found = home_tree(graph), []
    inside = set(graph.tree_coordinates(tree))
    held = [k for k in graph.home if k in inside]
    for values in designs.values[:, 1:].T:
        for halving in range(_NEARER):
            try:
                other = designs.graph_at(designs.own + 0.5**halving * (values - designs.own))
                other = replace(other, length=graph.length)
            except InputError:
                continue
            start = home.q.copy()
            start[held] = [other.home[k] for k in held]
            at, norm = close(other, tree, start, held, steps=_NEARBY_STEPS)
            if norm < CLOSED:
                around = neighbours(other, other.posed_tree(), at, 2)
                found += [*(n for n in around if n is not at), at]
                break
    return found


def home_and_around(
    graph: Graph, tree: Tree, home: Configuration, count: int
) -> list[Configuration]:
    """Home first, then closed configurations near it (see `neighbours`), all of them of `tree`."""
    around = neighbours(graph, graph.posed_tree(), home, count)
    return [configure(graph, tree, at.q) for at in (home, *around)]


def neighbours(
    graph: Graph, tree: Tree, home: Configuration, count: int, size: float = 0.08, seed: int = 1
) -> list[Configuration]:
    """Closed configurations a random step away from home, for what holds in general.

    Fewer than `count` where the loops will not close again near home.
    """
    rng = np.random.default_rng(seed)
    found: list[Configuration] = []
    motions = free_motions(graph, tree, home)
    if motions.shape[1] == 0:
        return [home] * count
    for attempt in range(4 * count):
        if len(found) == count or attempt >= count + 3 * len(found):
            break  # all there, or all but hopeless
        mix = rng.normal(size=motions.shape[1])
        move = motions @ mix
        move *= size * rng.uniform(0.3, 1.0) / np.abs(move / coordinate_scales(graph)).max()
        at, norm = close(graph, tree, home.q + move, steps=_NEARBY_STEPS)
        if norm < CLOSED:
            found.append(at)
    return found
