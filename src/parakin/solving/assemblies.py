"""Assemblies from random starts: all combinations of the signs of closed forms' roots, and Newton's
method from random guesses of what is iterated, in one batch.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from parakin.algebra.spatial import ARRAYS, as_array
from parakin.arrays import BoolArray, FloatArray
from parakin.kernel.motion import Refiner
from parakin.kernel.outputs import Outputs
from parakin.kernel.pose import solve_pose
from parakin.kinematics import loops
from parakin.kinematics.closure import canonical_rows
from parakin.kinematics.configuration import circuits_at, coordinate_scales
from parakin.planning.forms import TwoRoots
from parakin.planning.plan import Block, Plan
from parakin.solving.descent import descent
from parakin.solving.walking import CLOSED as AT_ONCE

CLOSED = 1e-10  # of the characteristic length
_STEPS = 4  # and undamped ones after these
_DRAWS = 12  # of signs, as long as loops stay open
_FAR = 3.0  # characteristic lengths: how far from home starts lie
_POLISHED = 3  # times, the first of which is enough where it is regular


def assembled_from(
    plan: Plan,
    driven: FloatArray,
    home: FloatArray,
    outputs: Outputs,
    rng: np.random.Generator,
    n: int,
) -> FloatArray:
    """Outputs (rows, n) reached from that many random starts, the first of which is home."""
    graph, iterated = plan.graph, plan.iterated
    scales = coordinate_scales(graph)
    # A mirror image of home is as far away again as home is from what mirrors it.
    spread = np.array(
        [np.pi if graph.coordinates[k].angle else _FAR * graph.length for k in iterated]
    )
    guess = home[iterated, None] + spread[:, None] * rng.uniform(-1, 1, (len(iterated), n))
    if len(iterated):
        guess[:, 0] = home[iterated]
    out = np.empty((outputs.count, n))
    offsets = np.array([plan.offset(k) for k in range(len(home))])
    signs = [_either(block, rng, n) for block in plan.blocks]
    given = list(np.repeat(driven[:, None], n, axis=1))
    refine: Refiner | None = descent(scales)
    for _ in range(_DRAWS):
        pairs = list(zip(plan.blocks, signs, strict=True))
        loose = replace(plan, blocks=tuple(_with_sign(*pair) for pair in pairs))
        with np.errstate(all="ignore"):  # what cannot be reached is NaN
            results = solve_pose(loose, [given], list(guess), ARRAYS, outputs, _STEPS, refine)
            for row, result in enumerate(results):
                out[row] = as_array(result)
            open_ = _open(plan, out[outputs.order(0)] + offsets[:, None])
        for block, sign in pairs:
            if sign is not None:  # the loop may want the other root: a joint's angles go together
                wrong = open_[block.rows[0].cut]
                sign[wrong] = rng.choice([-1.0, 1.0], int(wrong.sum()))
        if len(iterated):
            guess, refine = out[iterated], None
    if len(iterated):
        _polish(plan, signs, given, outputs, out)
    return out


def _polish(
    plan: Plan,
    signs: Sequence[FloatArray | None],
    given: Sequence[FloatArray],
    outputs: Outputs,
    out: FloatArray,
) -> None:
    """Bring to round-off what closes: once more, and again what has only just come near."""
    for repeat in range(_POLISHED):
        residual, size = out[outputs.residual], out[outputs.size]
        rough = residual <= CLOSED * plan.graph.length
        if repeat:
            rough &= ~(residual <= AT_ONCE * size)
        rough = np.flatnonzero(rough)
        if not len(rough):
            return
        chosen = [None if sign is None else sign[rough] for sign in signs]
        blocks = tuple(map(_with_sign, plan.blocks, chosen))
        y, guess = [row[rough] for row in given], list(out[np.ix_(np.array(plan.iterated), rough)])
        with np.errstate(all="ignore"):
            found = solve_pose(replace(plan, blocks=blocks), [y], guess, ARRAYS, outputs, _STEPS)
            for row, result in enumerate(found):
                out[row, rough] = as_array(result)


def _with_sign(block: Block, sign: FloatArray | None) -> Block:
    if sign is None:
        return block
    return replace(block, form=replace(block.form, sign=sign))  # type: ignore[arg-type]


def _either(block: Block, rng: np.random.Generator, n: int) -> FloatArray | None:
    """Random signs for a closed form's root, the first that of home; none if it has one root."""
    if not isinstance(block.form, TwoRoots):
        return None
    signs = rng.choice([-1.0, 1.0], n)
    signs[0] = block.form.sign
    return signs


def _open(plan: Plan, q: FloatArray) -> dict[int, BoolArray]:
    """By cut joint, the configurations (columns of q) in which its loop is open."""
    circuits = circuits_at(plan.graph, plan.tree, q)
    found = {}
    for cut in plan.tree.cuts:
        end = loops.ends(circuits, cut)
        closed = np.ones(q.shape[1], dtype=bool)
        for row in canonical_rows(plan.graph.joints[cut], cut):
            gap = row.per_length(plan.graph) * as_array(row.value(circuits, end))
            closed &= np.abs(gap) <= CLOSED * plan.graph.length
        found[cut] = ~closed
    return found
