"""Ordering: which joints to cut, which rows to solve, and in which order, worked out once.

With some coordinates driven, a closed mechanism falls into small systems solved one after the
other: crank by crank, leg by leg. To find them, the closure rows may be measured in any
direction (`kinematics.closure`): along the axes of the cut joint or of any joint on its loop, or as
distances from those joints' centres. A distance from the centre of a universal joint, say, knows
the length of the leg and not its angles, so that a leg falls into three systems of one unknown.
What depends on what is found in numbers, at closed configurations near home.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, maximum_bipartite_matching

from parakin.algebra.spatial import as_array, as_float, matrix
from parakin.arrays import BoolArray, FloatArray, IndexArray
from parakin.errors import DrivenError
from parakin.kinematics import loops
from parakin.kinematics.assembly import (
    Configuration,
    as_turn,
    circuits_at,
    configure,
    coordinate_scales,
    freedoms,
    functional,
    holders,
    is_idle,
    loop_signs,
    neighbours,
)
from parakin.kinematics.closure import Row, candidate_rows
from parakin.model.graph import Graph, Tree
from parakin.planning.closed_forms import paradoxes_whole, refined, signed
from parakin.planning.plan import Affine, Block, Plan

_ZERO = 1e-9  # a derivative this small, in scaled units, is none
_AFFINE = 1e-12  # slopes that differ by no more from place to place are the same
_LEVEL = 0.3  # volume of a joint's three axes below which it is told by other angles inside
_SPREAD = 0.7  # how far coordinates are thrown to see what a row does not depend on


def plan_of(
    graph: Graph,
    driven: Sequence[int],
    home: Configuration,
    cut: Sequence[int] = (),
    *,
    zero: FloatArray | None = None,
    everywhere: bool = False,
) -> Plan:
    """Choose tree, rows and order for these driven coordinates.

    cut: joints to leave out of the tree; without them the cheapest tree is looked for.
    zero: the mechanism's own home, if `home` is another.
    everywhere: take nothing for granted that holds on home's branch and may not on others.
    Raises DrivenError where the driven coordinates do not determine the motion at home, or where
    no tree leaves out those joints and keeps the driven ones.
    """
    plain, whole = graph.plain, home
    graph, home = unlocked(plain, home, driven)
    samples = neighbours(graph, graph.posed_tree(), home, 3) or [home]
    idle = check_driven(graph, driven, home, samples)
    firmly = [k for k in idle if k < len(plain.coordinates)]
    opened, apart = _with_room(plain, (*driven, *firmly), whole)
    if opened is not plain:
        return plan_of(opened, driven, apart, cut, zero=zero, everywhere=everywhere)
    in_tree = {graph.coordinates[k].joint for k in (*driven, *idle)}
    tree = graph.tree(first=in_tree, last=cut)
    if not set(cut) <= set(tree.cuts):
        kept = sorted(graph.joints[k].name for k in set(cut) - set(tree.cuts))
        raise DrivenError(
            f"{graph.mechanism.where}: {', '.join(kept)} cannot be left out of the tree: without "
            "them some body would be reached by no joint, or they are driven"
        )
    if not in_tree <= {k for k, _ in tree.steps}:
        loose = sorted(graph.joints[k].name for k in in_tree & set(tree.cuts))
        raise DrivenError(
            f"{graph.mechanism.where}: the joints of the driven coordinates form a closed loop "
            f"({', '.join(loose)}); drive coordinates of other joints"
        )
    screws = [graph.joints[k].name for k in tree.cuts if graph.joints[k].kind == "helical"]
    if screws:
        raise DrivenError(
            f"{graph.mechanism.where}: every joint of the loop of {screws[0]} is helical or "
            "driven, and a helical joint cannot be left out of the tree"
        )
    affine = _affine(graph, driven, idle, home, samples)
    given = {k: entry for k, entry in affine.items() if k in (*driven, *idle)}
    affine = given if everywhere else affine
    samples = [home, *samples]  # rows are chosen at home; what they depend on holds around it too
    best = _analysed(graph, tree, driven, affine, samples)
    if not cut:
        best = _improved(graph, best, in_tree, driven, affine, samples)
        if graph.platform is not None and _cost(best[1]) > len(best[1]):
            # Where nothing much is gained by it, a block iterates better on the platform's pose
            # than on some limb's angles.
            held = in_tree | {graph.twins.get(graph.platform, graph.platform)}
            posed = _analysed(graph, graph.tree(first=held), driven, affine, samples)
            posed = _improved(graph, posed, held, driven, affine, samples)
            best = min(best, posed, key=lambda found: _cost(found[1]) * (2 if found is best else 1))
    tree, blocks, dependence = best
    wide: list[Configuration] = []
    if any(joint.kind == "helical" for joint in graph.joints):  # what serves has to after turns too
        wide = neighbours(graph, graph.posed_tree(), home, 6, size=4.0, seed=2)
    blocks = refined(graph, tree, blocks, dependence, [*samples[1:], *wide, home])
    here = configure(graph, tree, home.q)
    signs = loop_signs(graph, tree)
    blocks = paradoxes_whole(graph, tree, signs, blocks, here)
    blocks = [signed(graph, signs, block, here) for block in blocks]
    # A rule of a joint that is cut would be checked by nothing: its coordinates are read off.
    inside = set(graph.inside(tree))
    affine = {k: rule for k, rule in affine.items() if k in inside or k in given}
    unsolved = sorted(inside & (affine.keys() - given))
    return Plan(
        graph,
        tree,
        tuple(driven),
        home.q,
        home.q if zero is None else zero,
        affine,
        tuple(blocks),
        tuple(idle),
        tuple(unsolved),
    )


def unlocked(graph: Graph, at: Configuration, held: Sequence[int]) -> tuple[Graph, Configuration]:
    """With a twin beside every joint whose three angles are nearly undefined, none of them held."""
    q = at.q
    for k, joint in enumerate(graph.joints):
        turns = joint.turns
        if len(turns) != 3 or set(turns) & set(held):
            continue
        if abs(np.linalg.det(at.screws[:3, turns])) > _LEVEL:
            continue
        end = at.ends[k]
        graph = graph.recentred(k, matrix(as_array(end.F.R.T @ end.M.R).tolist()))
        slides = [n for n in joint.coordinates if n not in turns]
        q = np.concatenate([q, at.q[slides], np.zeros(3)])
    return (graph, configure(graph, graph.posed_tree(), q)) if graph.twins else (graph, at)


def _with_room(
    graph: Graph, driven: Sequence[int], home: Configuration
) -> tuple[Graph, Configuration]:
    """Where joints with driven coordinates close a loop, none could be cut; but joints of several
    freedoms, some of them passive, can be once they are split.
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


Members = tuple[list[int], list[int]]  # unknowns, rows
Analysed = tuple[Tree, list[Block], dict[Row, frozenset[int]]]


def _improved(
    graph: Graph,
    best: Analysed,
    in_tree: set[int],
    driven: Sequence[int],
    affine: Mapping[int, Affine],
    samples: Sequence[Configuration],
) -> Analysed:
    """The tree made cheaper by exchanging one cut after the other, while that helps."""
    improved = True
    while improved and _cost(best[1]) > sum(len(b.unknowns) for b in best[1]):
        improved = False
        for other in _exchanges(graph, best[0], in_tree, best[1]):
            candidate = _analysed(graph, other, driven, affine, samples)
            if _cost(candidate[1]) < _cost(best[1]):
                best, improved = candidate, True
                break
    return best


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
    held: list[int] = []
    for at in (*samples, home):
        there = configure(graph, tree, at.q)
        motions = freedoms(graph, tree, there)
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
                f"{name}: {len(driven)} coordinates are driven ({names}), but only {rank} can move "
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
            f"{name}: mobility is {mobility} {where}, but {len(driven)} coordinates are driven "
            f"({names}); not determined: {', '.join(moved)}"
        )
    return held


def _affine(
    graph: Graph,
    driven: Sequence[int],
    idle: Sequence[int],
    home: Configuration,
    samples: Sequence[Configuration],
) -> dict[int, Affine]:
    """Coordinates whose rates are the same mix of the driven ones everywhere, as in eq. (5).

    Those of idle freedoms rest at home.
    """
    tree = graph.posed_tree()
    maps = []
    for at in (*samples, home):
        motions = freedoms(graph, tree, configure(graph, tree, at.q))
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


def _analysed(
    graph: Graph,
    tree: Tree,
    driven: Sequence[int],
    affine: Mapping[int, Affine],
    samples: Sequence[Configuration],
) -> Analysed:
    """The blocks of one tree: independent rows, sparsest first, matched and sorted.

    Also returned: every row that could be used, and the unknowns it depends on.
    """
    signs = loop_signs(graph, tree)
    scales = coordinate_scales(graph)
    known = set(driven) | set(affine)
    unknowns = [n for n in graph.inside(tree) if n not in known]
    if not unknowns:
        return tree, [], {}
    rows: list[Row] = []
    for cut in tree.cuts:
        on_loop = [int(n) for n in np.flatnonzero(signs[cut])]
        rows += candidate_rows(graph, cut, on_loop)
    jacobians = np.array(
        [
            [(functional(at, row) @ at.screws) * signs[row.cut] * scales for row in rows]
            for at in samples
        ]
    )[:, :, unknowns]
    pattern = np.abs(jacobians).max(axis=0) > _ZERO * graph.length
    pattern |= _lasting(graph, tree, rows, unknowns, samples[0], pattern)
    scaled = jacobians[0] / np.maximum(np.linalg.norm(jacobians[0], axis=1, keepdims=True), _ZERO)
    blocks = _eliminated(scaled, pattern)
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


def _lasting(
    graph: Graph,
    tree: Tree,
    rows: Sequence[Row],
    unknowns: Sequence[int],
    at: Configuration,
    pattern: BoolArray,
) -> BoolArray:
    """What rows depend on when their loops are open: blocks are solved while later ones still are.

    Coordinates are thrown about, one at a time and away from closure; a row whose value moves
    depends on that coordinate, even where its derivative vanishes on the closed loop.
    """
    rng = np.random.default_rng(7)
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
            moved = base.varied({k: as_turn(graph, k, q[k] + 0.4)})
            there = loops.ends(moved, cut)
            for i, old in zip(numbers, before, strict=True):
                if not pattern[i, j]:
                    new = as_float(rows[i].value(moved, there))
                    depends[i, j] = abs(new - old) > 1e-12 * graph.length**2
    return depends


def _eliminated(scaled: FloatArray, pattern: BoolArray) -> list[Members] | None:
    """Unknowns and rows in blocks, the smallest systems that can be solved first.

    A set of unknowns can be solved when rows that know nothing else (but what is solved already)
    have full rank in it. The sets tried are those that rows know, then unions of two of them.
    None where the rows leave something undetermined.
    """
    left = np.ones(pattern.shape[1], dtype=bool)
    blocks: list[Members] = []
    while left.any():
        known = np.unique(pattern[:, left], axis=0)
        sizes = known.sum(axis=1)
        known = known[(sizes > 0)][np.argsort(sizes[sizes > 0], kind="stable")]
        found = _smallest(scaled[:, left], pattern[:, left], known)
        if found is None and len(known) > 1:
            i, j = np.triu_indices(len(known), 1)
            unions = np.unique(known[i] | known[j], axis=0)
            unions = unions[np.argsort(unions.sum(axis=1), kind="stable")]
            found = _smallest(scaled[:, left], pattern[:, left], unions)
        if found is None:
            found = _smallest(scaled[:, left], pattern[:, left], np.ones((1, left.sum()), bool))
        if found is None:
            return None
        members, chosen = found
        numbers = np.flatnonzero(left)[members]
        blocks += _sorted(pattern, numbers, chosen)
        left[numbers] = False
    return blocks


def _smallest(scaled: FloatArray, pattern: BoolArray, sets: BoolArray) -> Members | None:
    """The first of the sets that rows knowing only it determine, and such rows."""
    for chosen_set in sets:
        rows = np.flatnonzero(pattern.any(axis=1) & ~(pattern & ~chosen_set).any(axis=1))
        members = np.flatnonzero(chosen_set)
        if len(rows) < len(members):
            continue
        picked = _independent(scaled[np.ix_(rows, members)], pattern[rows].sum(axis=1))
        if len(picked) == len(members):
            return members.tolist(), rows[picked].tolist()
    return None


def _independent(jacobian: FloatArray, counts: IndexArray) -> list[int]:
    """Rows that span all, those with the fewest unknowns first, the largest of equals."""
    chosen: list[int] = []
    basis = np.zeros((0, jacobian.shape[1]))
    usable = np.linalg.norm(jacobian, axis=1) > _ZERO
    for threshold in (0.05, 1e-5):  # well-conditioned choices first
        for count in sorted(set(counts[usable].tolist())):
            waiting = [i for i in np.flatnonzero((counts == count) & usable) if i not in chosen]
            while waiting and len(chosen) < jacobian.shape[1]:
                left = jacobian[waiting] - (jacobian[waiting] @ basis.T) @ basis
                left -= (left @ basis.T) @ basis
                norms = np.linalg.norm(left, axis=1)
                top = int(np.argmax(norms > 0.98 * norms.max()))  # the first of near equals
                if norms[top] < threshold:
                    break
                chosen.append(int(waiting[top]))
                basis = np.vstack([basis, left[top] / norms[top]])
                del waiting[top]
    return chosen


def _sorted(pattern: BoolArray, members: IndexArray, chosen: Sequence[int]) -> list[Members]:
    """One system's rows matched with its unknowns: its strongly connected components, in order."""
    square = pattern[np.array(chosen)][:, members]
    match = maximum_bipartite_matching(csr_array(square), perm_type="column")
    if len(members) == 1 or (match < 0).any():
        return [(members.tolist(), list(chosen))]
    needs = square[:, match]  # row i solves unknown match[i]; needs[i, j]: it needs that of row j
    _, labels = connected_components(csr_array(needs), directed=True, connection="strong")
    groups = [np.flatnonzero(labels == g).tolist() for g in sorted(set(labels.tolist()))]
    done: set[int] = set()
    blocks: list[Members] = []
    while len(done) < len(members):
        for group in groups:
            wanted = set(np.flatnonzero(needs[group].any(axis=0)).tolist()) - set(group)
            if group[0] not in done and wanted <= done:
                blocks.append((members[match[group]].tolist(), [chosen[i] for i in group]))
                done |= set(group)
    return blocks
