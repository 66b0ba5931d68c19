"""One pose, solved: the plan's blocks one after the other, then rates, accelerations and jerks.

This is the function that NumPy runs on arrays and that `parakin.compile` traces into machine
code, line for line the same. It has no branches on values: a pose that cannot be reached comes
out as NaN, one close to singular with a small `conditioning`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from parakin.algebra.dual import dual_functions, rate_of
from parakin.algebra.linear import solve
from parakin.algebra.spatial import FLOATS, Functions, Scalar, Vector, add, as_float, dot, mul, sub
from parakin.kernel.connectivity import (
    System,
    jacobian,
    signed_square,
    solve_blocks,
    unsolved_volume,
)
from parakin.kernel.outputs import Outputs
from parakin.kinematics import loops
from parakin.kinematics.closure import canonical_rows, cosines
from parakin.kinematics.cones import cone_angle
from parakin.kinematics.configuration import circuits_at
from parakin.kinematics.readings import read, read_rates
from parakin.kinematics.recursion import (
    Circuits,
    Turn,
    point_acceleration,
    point_velocity,
    slide,
    turn,
)
from parakin.planning import forms
from parakin.planning.forms import Iterated
from parakin.planning.plan import Block, Plan

ROUNDING = 2.0**-53

# A block's gaps and their derivatives by its unknowns, at given values of these.
Equations = Callable[[Sequence[Scalar]], tuple[list[Scalar], list[list[Scalar]]]]
Refiner = Callable[[Block, Equations, list[Scalar]], list[Scalar]]


def solve_pose(
    plan: Plan,
    orders: Sequence[Sequence[Scalar]],
    guess: Sequence[Scalar],
    functions: Functions,
    outputs: Outputs,
    steps: int = 2,
    refine: Refiner | None = None,
) -> list[Scalar]:
    """Solve one pose (or an array of them); see `Outputs` for what is returned.

    orders: driven positions, then as many derivatives of them as are asked for, each one scalar
    per driven coordinate. guess: one per coordinate of `Plan.iterated`. refine: what brings the
    guess of a block nearer before Newton's steps.
    """
    circuits = Circuits(plan.graph, plan.tree)
    angles = _Angles(plan, functions)
    quality = _Quality([], [])
    for k in plan.affine:
        angles.give(circuits, k, _rule(plan, k, orders[0]))
    guesses = {k: add(value, plan.offset(k)) for k, value in zip(plan.iterated, guess, strict=True)}
    moves: list[Scalar] = []
    for block in plan.blocks:
        if isinstance(block.form, Iterated):
            last, figure = _newton(circuits, block, angles, guesses, steps, refine)
            moves += last
            if outputs.derivatives == 0:
                side = _lock_sign(plan, block, circuits, functions)
                quality.of(block).append(mul(side, signed_square(figure, functions)))
        else:
            _closed_form(circuits, block, angles, quality)
    moving = circuits
    if outputs.derivatives > 0:
        moving = _moving(plan, circuits, orders[: 1 + outputs.derivatives], functions, quality)
    columns = [
        _output(plan, circuits, moving, name, angles, outputs.derivatives)
        for name in outputs.coordinates
    ]
    results = [column[order] for order in range(1 + outputs.derivatives) for column in columns]
    if outputs.checks:
        results += _checks(plan, circuits, moves, quality, functions)
    for body, place in outputs.points:
        results += _motion_of(circuits, body, place)
    return results


def _rule(plan: Plan, k: int, driven: Sequence[Scalar]) -> Scalar:
    """A coordinate that is affine in the driven ones."""
    value: Scalar = plan.affine[k].constant
    for j, factor in plan.affine[k].factors:
        counted = add(driven[plan.driven.index(j)], plan.offset(j))
        value = add(value, mul(factor, counted))
    return value


def _moving(
    plan: Plan,
    circuits: Circuits,
    orders: Sequence[Sequence[Scalar]],
    functions: Functions,
    quality: _Quality,
) -> Circuits:
    """Set the rates of all coordinates, and of the orders given their accelerations (eq. 10 and its
    derivative). Returns the circuits with their own rates in time, if jerks are given too.
    """
    rest: dict[int, Scalar] = dict.fromkeys(plan.unknowns, 0.0)
    systems = [System.of(circuits, block) for block in plan.blocks]
    circuits.rates |= {k: _mix(plan, k, orders[1]) for k in plan.affine} | rest
    drifts = [system.rates(circuits) for system in systems]
    rates, figures = solve_blocks(plan, systems, drifts, functions)
    circuits.set_rates(rates=rates)
    for block, figure in figures:
        quality.of(block).append(mul(_lock_sign(plan, block, circuits, functions), figure))
    if len(orders) > 2:
        circuits.second |= {k: _mix(plan, k, orders[2]) for k in plan.affine} | rest
        drifts = [system.accelerations(circuits) for system in systems]
        circuits.set_rates(second=solve_blocks(plan, systems, drifts, functions)[0])
    if len(orders) < 4:
        return circuits
    third = {k: _mix(plan, k, orders[3]) for k in plan.affine}
    moving = circuits.with_jerk(third | rest)
    drifts = [
        [rate_of(row.acceleration(moving, loops.ends(moving, row.cut))) for row in block.rows]
        for block in plan.blocks
    ]
    return circuits.with_jerk(third | solve_blocks(plan, systems, drifts, functions)[0])


def _checks(
    plan: Plan,
    circuits: Circuits,
    moves: Sequence[Scalar],
    quality: _Quality,
    functions: Functions,
) -> list[Scalar]:
    """Residual, conditioning, the last step of iteration, size, and the unsigned figures."""
    if plan.unsolved:
        at_home = circuits_at(plan.graph, plan.tree, plan.home)
        unit = 1.0 / as_float(unsolved_volume(plan, at_home, FLOATS))
        quality.unsigned.append(mul(unit, unsolved_volume(plan, circuits, functions)))
    step: Scalar = 0.0
    for move in moves:
        step = add(step, mul(move, move))
    residual, size = _residual(plan, circuits, functions)
    product: Scalar = 1.0
    for figure in quality.unsigned:
        product = mul(product, figure)
    least = _least([*quality.signed, *quality.unsigned], functions)
    return [
        residual,
        _signed_root(least, functions),
        functions.sqrt(step) if moves else 0.0,
        size,
        functions.sqrt(product),
    ]


class _Quality(NamedTuple):
    """Figures of conditioning, squared: those whose sign tells branches apart, or whose root does,
    and those that are as large on either side of a singularity.
    """

    signed: list[Scalar]
    unsigned: list[Scalar]

    def of(self, block: Block) -> list[Scalar]:
        """Where the figure of a block belongs that is iterated."""
        return self.unsigned if block.form.unsigned else self.signed


def _least(figures: Sequence[Scalar], functions: Functions) -> Scalar:
    least: Scalar = 1.0
    for figure in figures:
        least = functions.minimum(least, figure)
    return least


def _signed_root(a: Scalar, functions: Functions) -> Scalar:
    root: Scalar = functions.copysign(functions.sqrt(functions.sqrt(mul(a, a))), a)
    return root


def _motion_of(circuits: Circuits, body: int, place: Vector) -> list[Scalar]:
    X_WB, V_WB, A_WB = circuits.pose(body), circuits.twist(body), circuits.accel(body)
    p = X_WB.p + X_WB.R @ place
    v, a = point_velocity(X_WB, V_WB, p), point_acceleration(X_WB, V_WB, A_WB, p)
    return [*p, *X_WB.R[0], *X_WB.R[1], *X_WB.R[2], *v, *V_WB.w, *a, *A_WB.alpha]


def _mix(plan: Plan, k: int, rates: Sequence[Scalar]) -> Scalar:
    total: Scalar = 0.0
    for j, factor in plan.affine[k].factors:
        total = add(total, mul(factor, rates[plan.driven.index(j)]))
    return total


class _Angles:
    """The values of coordinates, an angle found as cosine and sine being worked out on demand.

    Such an angle comes out within half a turn of its home value.
    """

    def __init__(self, plan: Plan, functions: Functions) -> None:
        self.plan = plan
        self.functions = functions
        self.values: dict[int, Scalar] = {}
        self.found: dict[int, tuple[Scalar, Scalar]] = {}

    def give(self, circuits: Circuits, k: int, value: Scalar) -> None:
        self.values[k] = value
        circuits.turns[k] = self.turn(k, value)

    def set(self, circuits: Circuits, k: int, found: Turn) -> None:
        """A coordinate that was found by a closed form: a slide, or an angle's cosine and sine."""
        circuits.turns[k] = found
        if found.value is None:
            self.found[k] = (found.sine, found.cosine)
        else:
            self.values[k] = found.value

    def turn(self, k: int, value: Scalar) -> Turn:
        if self.plan.graph.coordinates[k].angle:
            return turn(value, self.functions)
        return slide(value)

    def value(self, k: int) -> Scalar:
        if k not in self.values:
            sine, cosine = self.found[k]
            home = float(self.plan.home[k])
            c, s = (1.0, 0.0) if home == 0.0 else (math.cos(home), math.sin(home))
            ahead = add(mul(cosine, c), mul(sine, s))
            across = sub(mul(sine, c), mul(cosine, s))
            self.values[k] = add(home, self.functions.atan2(across, ahead))
        return self.values[k]


def _closed_form(circuits: Circuits, block: Block, angles: _Angles, quality: _Quality) -> None:
    """One unknown by the form of its block."""
    (k,) = block.unknowns
    # Coordinates still to come cannot matter (the plan has made sure); zeros make short code.
    later = {n: forms.AHEAD for path in circuits.path.values() for n in path}
    base = circuits.with_coordinates({n: t for n, t in later.items() if n not in circuits.turns})
    assert not isinstance(block.form, Iterated)
    found = block.form.solve(base, k, block.rows, angles.functions)
    angles.set(circuits, k, found.turn)
    quality.signed.extend(found.signed)
    quality.unsigned.extend(found.unsigned)


def _newton(
    circuits: Circuits,
    block: Block,
    angles: _Angles,
    guesses: Mapping[int, Scalar],
    steps: int,
    refine: Refiner | None,
) -> tuple[list[Scalar], Scalar]:
    """A block of several unknowns: a fixed number of Newton steps from the guess.

    Returns the last step and the conditioning met there.
    """
    later = {
        n: forms.AHEAD
        for path in circuits.path.values()
        for n in path
        if n not in circuits.turns and n not in block.unknowns
    }
    base = circuits.with_coordinates(later)

    def system(values: Sequence[Scalar]) -> tuple[list[Scalar], list[list[Scalar]]]:
        """Gaps of the block's rows, and their derivatives by its unknowns."""
        known = zip(block.unknowns, values, strict=True)
        there = base.with_coordinates({k: angles.turn(k, value) for k, value in known})
        gaps = [row.value(there, loops.ends(there, row.cut)) for row in block.rows]
        return gaps, jacobian(there, block, set(later))

    form = block.form
    assert isinstance(form, Iterated)
    values = [guesses[k] for k in block.unknowns]
    if refine is not None:
        values = refine(block, system, values)
    moves: list[Scalar] = []
    figure: Scalar = 1.0
    for _ in range(steps):
        gaps, derivatives = system(values)
        solved = solve(derivatives, [gaps], angles.functions, form.lengths)
        moves = solved.solutions[0]
        figure = mul(form.sign / form.reference, solved.conditioning)
        values = [sub(value, move) for value, move in zip(values, moves, strict=True)]
    for k, value in zip(block.unknowns, values, strict=True):
        angles.give(circuits, k, value)
    return moves, figure


def _lock_sign(plan: Plan, block: Block, circuits: Circuits, functions: Functions) -> Scalar:
    """1, or -1 where the block's determinant has changed its sign only because three of its angles
    are beyond where they lock: it has the volume that their axes span as a factor.
    """
    side: Scalar = 1.0
    for joint in plan.graph.joints:
        if len(joint.turns) == 3 and set(block.unknowns).issuperset(joint.turns):
            k = joint.turns[1]
            now, home = circuits.turns[k], turn(float(plan.home[k]), FLOATS)
            proper = joint.proper
            volume = mul(home.sine, now.sine) if proper else mul(home.cosine, now.cosine)
            side = mul(side, functions.copysign(1.0, volume))
    return side


def _output(
    plan: Plan,
    circuits: Circuits,
    moving: Circuits,
    name: int | str,
    angles: _Angles,
    derivatives: int,
) -> tuple[Scalar, ...]:
    """Value and derivatives of a coordinate; `moving` are the circuits with their rates in time."""
    graph, functions = plan.graph, angles.functions
    if isinstance(name, str):
        cone = plan.cones[name]
        found: tuple[Scalar, ...] = cone_angle(circuits, cone, functions, derivatives=derivatives)
        if derivatives > 2:
            changing = cone_angle(moving, cone, dual_functions(functions), derivatives=2)[2]
            return *found, rate_of(changing)
        return found
    if name in circuits.turns:
        value = sub(angles.value(name), plan.offset(name))
        orders = [circuits.rates, circuits.second][:derivatives]
        found = (value, *(order[name] for order in orders))
        return (*found, rate_of(moving.second[name])) if derivatives > 2 else found
    cut = graph.coordinates[name].joint
    end = loops.ends(circuits, cut)
    reading = read(circuits, cut, end, functions)
    angles.values.update(reading.slides)
    angles.found.update(reading.turns)
    value = sub(angles.value(name), plan.offset(name))
    if derivatives == 0:
        return (value,)
    rates, second = read_rates(circuits, cut, end, reading, accelerations=derivatives > 1)
    found = (value, rates[name], second.get(name, 0.0))
    if derivatives > 2:
        end = loops.ends(moving, cut)
        reading = read(moving, cut, end, dual_functions(functions))
        changing = read_rates(moving, cut, end, reading, accelerations=True)[1][name]
        return *found, rate_of(changing)
    return found


def _residual(plan: Plan, circuits: Circuits, functions: Functions) -> tuple[Scalar, Scalar]:
    """The norm of all closure rows [m], redundant ones too, and the size of what they subtract.

    Cosines count at the characteristic length. What is lost to rounding by subtracting large
    numbers counts as not closed; so do axes that are parallel, but point against each other.
    """
    length = plan.graph.length
    total: Scalar = 0.0
    square: Scalar = length * length
    for cut in plan.tree.cuts:
        end = loops.ends(circuits, cut)
        rows = canonical_rows(plan.graph.joints[cut], cut)
        if rows:
            square = add(square, dot(end.X_WM.p, end.X_WM.p))
        for row in rows:
            gap = mul(row.per_length(plan.graph), row.value(circuits, end))
            total = add(total, mul(gap, gap))
        for cosine in cosines(circuits, cut, end):
            gap = mul(length, sub(1.0, cosine))
            total = add(total, mul(gap, gap))
    lost = mul(ROUNDING * ROUNDING, square)
    return functions.sqrt(add(total, lost)), functions.sqrt(square)
