"""Closed forms: which row serves a single unknown best, and what is to be known of it at home."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from parakin.algebra.spatial import as_float
from parakin.arrays import FloatArray
from parakin.errors import DrivenError
from parakin.kinematics import loops
from parakin.kinematics.closure import Row, canonical_rows
from parakin.kinematics.configuration import (
    Configuration,
    configure,
    coordinate_scales,
    loop_rank,
    row_wrench,
)
from parakin.model.graph import Graph, Tree
from parakin.planning import forms
from parakin.planning.forms import (
    CosineAngle,
    LinearSlide,
    QuadraticSlide,
    TangentAngle,
    TwoRowAngle,
)
from parakin.planning.plan import Block

_ZERO = 1e-9  # a derivative this small, in scaled units, is none
_CROSSING = 0.3  # sine of the angle at which two rows cross well enough to be solved together
_WORTH = 0.3  # of the best row's figure: one less good that is steadier
_STEADY = 1e-9  # volumes that differ by no more are the same
_FLAT = 1e-6  # a row this near to a singularity of its own, at home or near it, is of no use


def choose_closed_forms(
    graph: Graph,
    tree: Tree,
    blocks: Sequence[Block],
    dependence: Mapping[Row, frozenset[int]],
    samples: Sequence[Configuration],
) -> list[Block]:
    """Single unknowns get the row that suits them best, among all that know nothing later.

    Of two cranks in a dyad, the first takes a square root and the second then none. Best is the
    row furthest from a singularity of its own, then the one that needs least, among those that
    never come to say what the rows before say already.
    """
    at = [configure(sample.circuits.graph, tree, sample.q) for sample in samples]
    singles = {block.unknowns[0] for block in blocks if len(block.unknowns) == 1}
    waiting = [block for block in blocks if len(block.unknowns) > 1]
    solved: set[int] = set()
    ordered: list[Block] = []
    figures: dict[tuple[Row, int], tuple[float, Block]] = {}
    while singles or waiting:
        found: list[tuple[float, int, int, int, Block]] = []
        for i, (row, needs) in enumerate(dependence.items()):
            missing = needs - solved
            if len(missing) != 1 or not missing <= singles:
                continue
            (k,) = missing
            if (row, k) not in figures:
                figures[row, k] = _quality(graph, row, k, at)
            figure, block = figures[row, k]
            if figure > _FLAT:
                found.append((-round(figure, 2), len(needs), k, i, block))
        if found:
            block = _steadiest(graph, sorted(found, key=lambda f: f[:4]), ordered, at)
            if isinstance(block.form, CosineAngle):
                (k,) = block.unknowns
                block = _by_two(
                    graph, block, [r for r, n in dependence.items() if n - solved == {k}], at
                )
            singles -= set(block.unknowns)
        else:
            ready = [
                b
                for b in waiting
                if all(dependence[row] <= solved | set(b.unknowns) for row in b.rows)
            ]
            if not ready:  # a single unknown without a usable row of its own: iterate on it
                ready = [b for b in blocks if len(b.unknowns) == 1 and b.unknowns[0] in singles]
                singles -= set(ready[0].unknowns)
            else:
                waiting.remove(ready[0])
            block = ready[0]
        wanted = {k for row in block.rows for k in dependence[row]} & solved
        ordered.append(replace(block, needs=tuple(sorted(wanted))))
        solved |= set(block.unknowns)
    return ordered


def _steadiest(
    graph: Graph,
    candidates: Sequence[tuple[float, int, int, int, Block]],
    before: Sequence[Block],
    samples: Sequence[Configuration],
) -> Block:
    """The first of these blocks whose row stays as independent as it is of others before.

    What rows of one cut joint measure spans a volume. Where that is the same all around home it
    is so everywhere, being an analytic function of the configuration; any other may vanish
    somewhere, where the mechanism is as regular as ever: another root is then found beyond.
    """
    best = candidates[0][4]
    for figure, *_, block in candidates:
        if figure > _WORTH * candidates[0][0]:
            break
        (row,) = block.rows
        rows = [r for b in before for r in b.rows if r.cut == row.cut]
        if not rows or steady(graph, [*rows, row], samples):
            return block
    return best


def steady(graph: Graph, rows: Sequence[Row], samples: Sequence[Configuration]) -> bool:
    """Whether the volume that the rows of one cut joint span is the same in all configurations."""
    volumes: dict[tuple[float, ...], list[float]] = {}
    for at in samples:
        matrix = np.array([row_wrench(at, row) for row in rows])
        point = np.array(at.ends[rows[0].cut].X_WM.p, dtype=float)
        matrix[:, :3] -= np.cross(point, matrix[:, 3:])
        matrix[:, :3] /= graph.length
        sizes = np.linalg.norm(matrix, axis=1, keepdims=True)
        matrix = matrix / np.where(sizes > _ZERO, sizes, 1.0)
        volume = float(np.linalg.det(matrix @ matrix.T))
        volumes.setdefault(at.design, []).append(volume)
    return all(bool(np.ptp(of_design) < _STEADY) for of_design in volumes.values())


def _quality(
    graph: Graph, row: Row, k: int, samples: Sequence[Configuration]
) -> tuple[float, Block]:
    """How far a row is from being singular in its one unknown, 0 to 1, and the block it makes.

    The last sample is home.
    """
    angle = graph.coordinates[k].angle
    if _pitch(graph, k):
        return 0.0, Block((k,), (row,))  # neither its angle nor its advance alone: iterate
    arms = [_arm(graph, row, k, at)[:3] for at in samples]
    worst = min(slope / size if size > _ZERO * graph.length else 0.0 for slope, size, _ in arms)
    constant = max(constant / size if size else np.inf for _, size, constant in arms)
    reference, shortest = arms[-1][1], min(size for _, size, _ in arms)
    if not angle:
        regular = all(abs(slope - size) < 1e-12 * size for slope, size, _ in arms)
        if row.quadratic and regular and shortest < forms.NEAR * graph.length:
            worst *= (shortest / (forms.NEAR * graph.length)) ** 2
        slide = QuadraticSlide(regular) if row.quadratic else LinearSlide(regular)
        return worst, Block((k,), (row,), slide)
    longest = max(size for _, size, _ in arms)
    if shortest < 0.5 * longest:  # an arm that turns away with some other angle
        worst *= shortest / longest
    if shortest < 1e-3 * graph.length:  # hardly any arm to turn on
        worst *= shortest / (1e-3 * graph.length)
    sizes: dict[tuple[float, ...], list[float]] = {}
    for sample, (_, size, _) in zip(samples, arms, strict=True):
        sizes.setdefault(sample.design, []).append(size)
    regular = all(float(np.ptp(alike)) < 1e-12 * reference for alike in sizes.values())
    form = (TangentAngle if constant < 1e-12 else CosineAngle)(regular, reference)
    return worst, Block((k,), (row,), form)


def _pitch(graph: Graph, k: int) -> float:
    joint = graph.joints[graph.coordinates[k].joint]
    return joint.pairs[k - joint.first].pitch


def _by_two(
    graph: Graph, block: Block, rows: Sequence[Row], samples: Sequence[Configuration]
) -> Block:
    """An angle from two rows instead of one, where an overconstrained loop has two to give.

    Each row is linear in its cosine and sine and leaves two roots, that meet where its slope
    vanishes; two rows that cross well have but one.
    """
    (k,) = block.unknowns
    slopes = np.array([[_arm(graph, row, k, at)[3] for row in rows] for at in samples])
    sizes = np.linalg.norm(slopes, axis=2, keepdims=True)
    slopes = slopes / np.where(sizes > 1e-3 * graph.length, sizes, np.inf)
    a, b = slopes[..., 0], slopes[..., 1]
    across = np.abs(a[:, :, None] * b[:, None, :] - b[:, :, None] * a[:, None, :]).min(axis=0)
    i, j = (int(n) for n in np.unravel_index(int(np.argmax(across)), across.shape))
    if across[i, j] < _CROSSING:
        return block
    return Block((k,), (rows[i], rows[j]), TwoRowAngle())


_TURNS = (forms.AHEAD, forms.ACROSS, forms.BACK)


def _arm(
    graph: Graph, row: Row, k: int, at: Configuration
) -> tuple[float, float, float, tuple[float, float]]:
    """A row's slope in one coordinate, the most it could be, and, of an angle, its mean value and
    what it owes to cosine and sine.
    """
    end = at.ends[row.cut]
    side = loops.sides(at.circuits, row.cut)[k]
    slope = abs(as_float(row.derivative(at.circuits, end, k, side)))
    if not graph.coordinates[k].angle:
        return slope, float(np.linalg.norm(row_wrench(at, row)[3:])), 0.0, (0.0, 0.0)
    if (row.cut, k) not in at.turned:
        turned = [at.circuits.with_coordinates({k: turn}) for turn in _TURNS]
        at.turned[row.cut, k] = [(there, loops.ends(there, row.cut)) for there in turned]
    values = [as_float(row.value(there, end)) for there, end in at.turned[row.cut, k]]
    mean = (values[0] + values[2]) / 2
    cosine, sine = values[0] - mean, values[1] - mean
    return slope, float(np.hypot(cosine, sine)), abs(mean), (cosine, sine)


def merge_paradoxical_loops(
    graph: Graph,
    tree: Tree,
    signs: Mapping[int, FloatArray],
    blocks: Sequence[Block],
    home: Configuration,
) -> list[Block]:
    """Paradoxical loops that need iteration are iterated on as a whole, with all their rows.

    A loop is paradoxical where it moves only because of its dimensions, like Schatz's: opened, its
    axes are independent, closed they are not (those of a plane stay so). Rows that leave out some
    of its angles then may fail where all of them together do not.
    """
    ordered = list(blocks)
    for block in blocks:
        cuts = {row.cut for row in block.rows}
        if block not in ordered or len(block.unknowns) < 2 or len(cuts) != 1:
            continue
        (cut,) = cuts
        on_loop = np.flatnonzero(signs[cut]).tolist()
        place = ordered.index(block)
        merged = [b for b in ordered[place:] if set(b.unknowns) & set(on_loop)]
        unknowns = tuple(k for b in merged for k in b.unknowns)
        rows = tuple(canonical_rows(graph.joints[cut], cut))
        alone = all(row.cut == cut for b in merged for row in b.rows)
        if alone and len(rows) > len(unknowns) and _paradoxical(graph, tree, on_loop, cut, home):
            needs = {k for b in merged for k in b.needs} - set(unknowns)
            ordered = [b for b in ordered if b not in merged]
            ordered.insert(place, Block(unknowns, rows, needs=tuple(sorted(needs))))
    return ordered


def _paradoxical(
    graph: Graph, tree: Tree, on_loop: Sequence[int], cut: int, home: Configuration
) -> bool:
    numbers = [*on_loop, *graph.joints[cut].coordinates]
    throw = np.random.default_rng(3).uniform(0.3, 0.7, len(home.q)) * coordinate_scales(graph)
    opened = configure(graph, tree, home.q + throw)
    return loop_rank(graph, opened, numbers) > loop_rank(graph, home, numbers)


def signed(
    graph: Graph, signs: Mapping[int, FloatArray], block: Block, home: Configuration
) -> Block:
    """The block with the sign of its root at home and what its conditioning is measured by.

    Raises DrivenError where home is singular.
    """
    form = forms.signed(block.form, _slopes(signs, block, home))
    if form is None:
        names = ", ".join(graph.coordinates[k].name for k in block.unknowns)
        raise DrivenError(
            f"{graph.mechanism.where}: home is singular for these driven coordinates: {names} are "
            "not determined there"
        )
    return replace(block, form=form)


def _slopes(signs: Mapping[int, FloatArray], block: Block, at: Configuration) -> FloatArray:
    rows = [(row_wrench(at, row) @ at.screws) * signs[row.cut] for row in block.rows]
    slopes: FloatArray = np.array(rows)[:, list(block.unknowns)]
    return slopes
