"""Ordering: which joints to cut, which rows to solve, and in which order, worked out once.

With some coordinates driven, a closed mechanism falls into small systems solved one after the
other: crank by crank, leg by leg. To find them, the closure rows may be measured in any
direction (`kinematics.closure`): along the axes of the cut joint or of any joint on its loop, or as
distances from those joints' centres. A distance from the centre of a universal joint, say, knows
the length of the leg and not its angles, so that a leg falls into three systems of one unknown.
What depends on what is found in numbers, at closed configurations near home.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from parakin.algebra.spatial import as_array, as_float, matrix
from parakin.arrays import BoolArray, FloatArray
from parakin.errors import DrivenError
from parakin.kinematics import loops
from parakin.kinematics.assembly import neighbours
from parakin.kinematics.closure import Row, candidate_rows
from parakin.kinematics.configuration import (
    Configuration,
    as_turn,
    circuits_at,
    configure,
    coordinate_scales,
    loop_signs,
    row_wrench,
)
from parakin.model.designs import alike
from parakin.model.graph import Graph, Tree
from parakin.planning.closed_forms import choose_closed_forms, merge_paradoxical_loops, signed
from parakin.planning.driven import affine_in, check_driven
from parakin.planning.elimination import eliminated
from parakin.planning.plan import Affine, Block, Plan

_ZERO = 1e-9  # a derivative this small, in scaled units, is none
_LEVEL = 0.3  # volume of a joint's three axes below which other angles are used inside
_FAINT = 0.1  # of the characteristic length: by less, per radian, a row hardly changes
_SPREAD = 0.7  # how far coordinates are thrown to see what a row does not depend on


def plan_of(
    graph: Graph,
    driven: Sequence[int],
    home: Configuration,
    cut: Sequence[int] = (),
    *,
    own_home: FloatArray | None = None,
    everywhere: bool = False,
    avoid: Collection[Row] = (),
    others: Sequence[Configuration] = (),
) -> Plan:
    """Choose tree, rows and order for these driven coordinates.

    cut: joints to leave out of the tree; if none are given, the cheapest tree is searched for.
    own_home: the mechanism's own home, if `home` is another.
    others: configurations of other designs, in which the plan has to serve too.
    everywhere: assume nothing that holds on home's branch but may not hold on others.
    avoid: rows to do without; then also those that hardly change, such as a distance near zero.
    Raises DrivenError where the driven coordinates do not determine the motion at home, or where
    no tree leaves out those joints and keeps the driven ones.
    """
    plain, whole = graph.plain, home
    graph, home = with_twins(plain, home, driven)
    samples = neighbours(graph, graph.posed_tree(), home, 3) or [home]
    idle = check_driven(graph, driven, home, samples)
    firmly = [k for k in idle if k < len(plain.coordinates)]
    opened, apart = _split_driven_joints(plain, (*driven, *firmly), whole)
    if opened is not plain:
        return plan_of(
            opened,
            driven,
            apart,
            cut,
            own_home=own_home,
            everywhere=everywhere,
            avoid=avoid,
            others=others,
        )
    in_tree = {graph.coordinates[k].joint for k in (*driven, *idle)}
    tree = _first_tree(graph, in_tree, cut)
    elsewhere = [_alike(graph, at) for at in others]
    samples = [*samples, *elsewhere]
    affine = affine_in(graph, driven, idle, home, samples)
    given = {k: entry for k, entry in affine.items() if k in (*driven, *idle)}
    affine = given if everywhere else affine
    # Rows are chosen at home; what they depend on is found around it too.
    how = _How(driven, affine, [home, *samples], avoid)
    best = _analysed(graph, tree, how)
    if not cut:
        best = _cheapest(graph, best, in_tree, how)
    tree, blocks, dependence = best
    around = [*samples, *_turned(graph, home), home]
    blocks = choose_closed_forms(graph, tree, blocks, dependence, around)
    here = configure(graph, tree, home.q)
    signs = loop_signs(graph, tree)
    blocks = merge_paradoxical_loops(graph, tree, signs, blocks, here)
    blocks = [signed(graph, signs, block, here) for block in blocks]
    # Nothing would check a rule of a cut joint: its coordinates are read off instead.
    inside = set(graph.tree_coordinates(tree))
    affine = {k: rule for k, rule in affine.items() if k in inside or k in given}
    return Plan(
        graph,
        tree,
        tuple(driven),
        home.q,
        home.q if own_home is None else own_home,
        affine,
        tuple(blocks),
        tuple(idle),
        tuple(sorted(inside & (affine.keys() - given))),
    )


def _alike(graph: Graph, at: Configuration) -> Configuration:
    """A configuration of another design, with the twins and split joints of a graph."""
    q = np.concatenate([at.q, np.zeros(len(graph.coordinates) - len(at.q))])
    return with_twins_read(alike(graph, at.circuits.graph), q)


def with_twins_read(graph: Graph, q: FloatArray) -> Configuration:
    """The configuration at coordinates q (N,) of all joints but twins, which are read off."""
    tree = graph.plain.posed_tree()
    return configure(graph, Tree(tree.steps, (*tree.cuts, *graph.twins.values())), q)


def _turned(graph: Graph, home: Configuration) -> list[Configuration]:
    """Configurations after turns of screws, where rows must serve too."""
    if not any(joint.kind == "helical" for joint in graph.joints):
        return []
    return neighbours(graph, graph.posed_tree(), home, 6, size=4.0, seed=2)


def _first_tree(graph: Graph, in_tree: set[int], cut: Sequence[int]) -> Tree:
    """A tree with some joints in it and others cut. Raises DrivenError where there is none."""
    where = graph.mechanism.where
    tree = graph.tree(first=in_tree, last=cut)
    if not set(cut) <= set(tree.cuts):
        kept = sorted(graph.joints[k].name for k in set(cut) - set(tree.cuts))
        raise DrivenError(
            f"{where}: {', '.join(kept)} cannot be left out of the tree: without "
            "them some body would be reached by no joint, or they are driven"
        )
    if not in_tree <= {k for k, _ in tree.steps}:
        loose = sorted(graph.joints[k].name for k in in_tree & set(tree.cuts))
        raise DrivenError(
            f"{where}: the joints of the driven coordinates form a closed loop "
            f"({', '.join(loose)}); drive coordinates of other joints"
        )
    screws = [graph.joints[k].name for k in tree.cuts if graph.joints[k].kind == "helical"]
    if screws:
        raise DrivenError(
            f"{where}: every joint of the loop of {screws[0]} is helical or "
            "driven, and a helical joint cannot be left out of the tree"
        )
    return tree


def with_twins(graph: Graph, at: Configuration, held: Sequence[int]) -> tuple[Graph, Configuration]:
    """The graph with a twin for each joint whose three angles are nearly undefined and not held."""
    q = at.q
    for k, joint in enumerate(graph.joints):
        turns = joint.turns
        if len(turns) != 3 or set(turns) & set(held):
            continue
        if abs(np.linalg.det(at.screws[:3, turns])) > _LEVEL:
            continue
        end = at.ends[k]
        graph = graph.recentred(k, matrix(as_array(end.X_WF.R.T @ end.X_WM.R).tolist()))
        slides = [n for n in joint.coordinates if n not in turns]
        q = np.concatenate([q, at.q[slides], np.zeros(3)])
    return (graph, configure(graph, graph.posed_tree(), q)) if graph.twins else (graph, at)


def _split_driven_joints(
    graph: Graph, driven: Sequence[int], home: Configuration
) -> tuple[Graph, Configuration]:
    """Split joints so that one can be cut where joints with driven coordinates close a loop: those
    of several freedoms, some of them passive.
    """
    while True:
        in_tree = {graph.coordinates[k].joint for k in driven}
        cuts = in_tree & set(graph.tree(first=in_tree).cuts)
        several = [
            k for k in sorted(in_tree) if len(graph.joints[k].pairs) > 1 and k != graph.platform
        ]
        if not cuts or not several:
            return graph, home
        graph = graph.split(next((k for k in several if k in cuts), several[0]))
        home = configure(graph, graph.posed_tree(), home.q)


class _How(NamedTuple):
    """What a tree is analysed for."""

    driven: Sequence[int]
    affine: Mapping[int, Affine]
    samples: Sequence[Configuration]
    avoid: Collection[Row]


Analysed = tuple[Tree, list[Block], dict[Row, frozenset[int]]]


def _cheapest(graph: Graph, best: Analysed, in_tree: set[int], how: _How) -> Analysed:
    """The cheapest tree with some joints in it, starting from one."""
    best = _improved(graph, best, in_tree, how)
    if graph.platform is None or _cost(best[1]) <= len(best[1]):
        return best
    # Where nothing much is gained by it, a block iterates better on the platform's pose than on
    # some limb's angles.
    held = in_tree | {graph.twins.get(graph.platform, graph.platform)}
    posed = _analysed(graph, graph.tree(first=held), how)
    posed = _improved(graph, posed, held, how)
    return posed if _cost(posed[1]) < 2 * _cost(best[1]) else best


def _improved(graph: Graph, best: Analysed, in_tree: set[int], how: _How) -> Analysed:
    """The tree, made cheaper by exchanging one cut after another as long as that helps."""
    improved = True
    while improved and _cost(best[1]) > sum(len(b.unknowns) for b in best[1]):
        improved = False
        for other in _exchanges(graph, best[0], in_tree, best[1]):
            candidate = _analysed(graph, other, how)
            if _cost(candidate[1]) < _cost(best[1]):
                best, improved = candidate, True
                break
    return best


def _cost(blocks: Sequence[Block]) -> int:
    return sum(len(block.unknowns) ** 3 for block in blocks)


def _exchanges(graph: Graph, tree: Tree, in_tree: set[int], blocks: Sequence[Block]) -> list[Tree]:
    """Trees with one joint of a coupled loop cut in place of the one cut now."""
    kept = [k for k, _ in tree.steps]
    signs = loop_signs(graph, tree)
    coupled = {row.cut for block in blocks if len(block.unknowns) > 1 for row in block.rows}
    trees = []
    for cut in tree.cuts:
        if cut not in coupled:
            continue
        on_loop = {graph.coordinates[n].joint for n in np.flatnonzero(signs[cut])}
        screws = {k for k in on_loop if graph.joints[k].kind == "helical"}
        if graph.joints[cut].kind == "rod":
            continue
        for k in sorted(on_loop - in_tree - screws):
            trees.append(graph.tree_of([cut if other == k else other for other in kept]))
    return trees


def _analysed(graph: Graph, tree: Tree, how: _How) -> Analysed:
    """The blocks of one tree: independent rows, sparsest first, matched and sorted.

    Also returned: every row that could be used, and the unknowns it depends on.
    """
    signs = loop_signs(graph, tree)
    scales = coordinate_scales(graph)
    samples = how.samples
    known = {*how.driven, *how.affine}
    unknowns = [n for n in graph.tree_coordinates(tree) if n not in known]
    if not unknowns:
        return tree, [], {}
    rows: list[Row] = []
    for cut in tree.cuts:
        on_loop = [int(n) for n in np.flatnonzero(signs[cut])]
        candidates = candidate_rows(graph, cut, on_loop)
        if how.avoid:
            left = [row for row in candidates if row not in how.avoid]
            candidates = [row for row in left if _changes(graph, row, samples[0], signs[cut])]
        rows += candidates
    jacobians = np.array(
        [
            [(row_wrench(at, row) @ at.screws) * signs[row.cut] * scales for row in rows]
            for at in samples
        ]
    )[:, :, unknowns]
    pattern = np.abs(jacobians).max(axis=0) > _ZERO * graph.length
    # Once in each design, whose graphs differ.
    for at in {at.design: at for at in reversed(samples)}.values():
        pattern |= _open_loop_dependence(tree, rows, unknowns, at, pattern)
    sizes = np.linalg.norm(jacobians[0], axis=1, keepdims=True)
    # A row that does not change at home but by rounding says nothing there.
    scaled = jacobians[0] / np.where(sizes > _ZERO * graph.length, sizes, np.inf)
    blocks = eliminated(scaled, pattern)
    if blocks is None:
        raise DrivenError(
            f"{graph.mechanism.where}: the loops leave some passive coordinates undetermined"
        )
    dependence = {
        row: frozenset(unknowns[j] for j in np.flatnonzero(pattern[i]))
        for i, row in enumerate(rows)
    }
    named = [
        Block(tuple(unknowns[j] for j in members), tuple(rows[i] for i in chosen))
        for members, chosen in blocks
    ]
    return tree, named, dependence


def _changes(graph: Graph, row: Row, at: Configuration, signs: FloatArray) -> bool:
    """Whether a row changes with some coordinate by more than a small part of what is usual."""
    changes = (row_wrench(at, row) @ at.screws) * signs * coordinate_scales(graph)
    return bool(np.abs(changes).max() * row.per_length(graph) > _FAINT * graph.length)


def _open_loop_dependence(
    tree: Tree,
    rows: Sequence[Row],
    unknowns: Sequence[int],
    at: Configuration,
    pattern: BoolArray,
) -> BoolArray:
    """What rows depend on when loops are open, as later ones still are while a block is solved.

    Coordinates are changed one at a time, away from closure. A row whose value changes depends on
    that coordinate, even if its derivative vanishes on the closed loop.
    """
    rng, graph = np.random.default_rng(7), at.circuits.graph
    q = at.q + _SPREAD * rng.uniform(0.3, 1.0, len(at.q)) * coordinate_scales(graph)
    base = circuits_at(graph, tree, q)
    by_cut: dict[int, list[int]] = {}
    for i, row in enumerate(rows):
        by_cut.setdefault(row.cut, []).append(i)
    depends = np.zeros_like(pattern)
    for cut, numbers in by_cut.items():
        end = loops.ends(base, cut)
        before = [as_float(rows[i].value(base, end)) for i in numbers]
        loop = loops.sides(base, cut)
        for j, k in enumerate(unknowns):
            if k not in loop or all(pattern[i, j] for i in numbers):
                continue
            moved = base.with_coordinates({k: as_turn(graph, k, q[k] + 0.4)})
            there = loops.ends(moved, cut)
            for i, old in zip(numbers, before, strict=True):
                if not pattern[i, j]:
                    new = as_float(rows[i].value(moved, there))
                    depends[i, j] = abs(new - old) > 1e-12 * graph.length**2
    return depends
