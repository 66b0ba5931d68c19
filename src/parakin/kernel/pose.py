"""One pose, solved: the plan's blocks one after the other, then rates, accelerations and jerks.

This is the function that NumPy runs on arrays and that `parakin.compile` traces into machine
code, line for line the same. It has no branches on values: a pose that cannot be reached comes
out as NaN, one close to singular with a small `conditioning`.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from parakin.algebra.dual import dual_functions, rate_of
from parakin.algebra.linear import solve
from parakin.algebra.spatial import (
    FLOATS,
    Functions,
    Scalar,
    Vector,
    add,
    apply,
    dot,
    mul,
    plus,
    sub,
)
from parakin.kernel.connectivity import (
    System,
    jacobian,
    signed_square,
    substituted,
    unsolved_volume,
)
from parakin.kernel.rows import Outputs
from parakin.kinematics import closure
from parakin.kinematics.assembly import circuits_at
from parakin.kinematics.closure import Row
from parakin.kinematics.recursion import (
    Circuits,
    Turn,
    point_acceleration,
    point_velocity,
    slide,
    turn,
)
from parakin.planning.plan import Block, Plan

ROUNDING = 2.0**-53

# A block's gaps and their derivatives by its unknowns, at given values of these.
Equations = Callable[[Sequence[Scalar]], tuple[list[Scalar], list[list[Scalar]]]]
Lead = Callable[[Block, Equations, list[Scalar]], list[Scalar]]


def newton_unknowns(plan: Plan) -> list[int]:
    """Coordinates found by iteration, for which a guess must be given, in the order of input."""
    return [k for block in plan.blocks if block.form == "newton" for k in block.unknowns]


def trace(
    plan: Plan,
    orders: Sequence[Sequence[Scalar]],
    guess: Sequence[Scalar],
    functions: Functions,
    outputs: Outputs,
    steps: int = 2,
    lead: Lead | None = None,
) -> list[Scalar]:
    """Solve one pose (or an array of them); see `Outputs` for what is returned.

    orders: driven positions, then as many derivatives of them as are asked for, each one scalar
    per driven coordinate. guess: one per coordinate of `newton_unknowns`. lead: what brings the
    guess of a block nearer before Newton's steps.
    """
    driven = orders[0]
    circuits = Circuits(plan.graph, plan.tree)
    angles = _Angles(plan, functions)
    for k, entry in plan.affine.items():
        value: Scalar = entry.constant
        for j, factor in entry.factors:
            counted = add(driven[plan.driven.index(j)], plan.offset(j))
            value = add(value, mul(factor, counted))
        angles.give(circuits, k, value)
    guesses = {
        k: add(value, plan.offset(k)) for k, value in zip(newton_unknowns(plan), guess, strict=True)
    }
    quality = _Quality([], [])
    moves: list[Scalar] = []
    for block in plan.blocks:
        if block.form == "newton":
            last, figure = _newton(circuits, block, angles, guesses, steps, lead)
            moves += last
            if outputs.derivatives == 0:
                side = _side(plan, block, circuits, functions)
                quality.of(block).append(mul(side, signed_square(figure, functions)))
        else:
            _closed_form(circuits, block, angles, quality)
    moving = circuits
    if outputs.derivatives > 0:
        systems = [System.of(circuits, block) for block in plan.blocks]
        circuits.rates |= {k: _mix(plan, k, orders[1]) for k in plan.affine}
        circuits.rates |= dict.fromkeys(unknowns_of(plan), 0.0)
        drifts = [system.drifts(circuits, closure.rate) for system in systems]
        rates, figures = substituted(plan, systems, drifts, functions)
        circuits.set_rates(rates=rates)
        for block, figure in figures:
            quality.of(block).append(mul(_side(plan, block, circuits, functions), figure))
        if outputs.derivatives > 1:
            circuits.second |= {k: _mix(plan, k, orders[2]) for k in plan.affine}
            circuits.second |= dict.fromkeys(unknowns_of(plan), 0.0)
            drifts = [system.drifts(circuits, closure.acceleration) for system in systems]
            circuits.set_rates(second=substituted(plan, systems, drifts, functions)[0])
        if outputs.derivatives > 2:
            third = {k: _mix(plan, k, orders[3]) for k in plan.affine}
            moving = circuits.with_jerk(third | dict.fromkeys(unknowns_of(plan), 0.0))
            drifts = [
                [
                    rate_of(closure.acceleration(moving, row, closure.ends(moving, row.cut)))
                    for row in block.rows
                ]
                for block in plan.blocks
            ]
            moving = circuits.with_jerk(third | substituted(plan, systems, drifts, functions)[0])
    columns = [
        _output(plan, circuits, moving, name, angles, outputs.derivatives)
        for name in outputs.coordinates
    ]
    results: list[Scalar] = []
    for order in range(outputs.derivatives + 1):
        results += [column[order] for column in columns]
    if outputs.checks:
        if plan.unsolved:
            at_home = circuits_at(plan.graph, plan.tree, plan.home)
            unit = 1.0 / float(unsolved_volume(plan, at_home, FLOATS))
            quality.unsigned.append(mul(unit, unsolved_volume(plan, circuits, functions)))
        step: Scalar = 0.0
        for move in moves:
            step = add(step, mul(move, move))
        residual, size = _residual(plan, circuits, functions)
        results.append(residual)
        least = _least([*quality.signed, *quality.unsigned], functions)
        results.append(_signed_root(least, functions))
        results.append(functions.sqrt(step) if moves else 0.0)
        results.append(size)
        results.append(functions.sqrt(functools.reduce(mul, quality.unsigned, 1.0)))
    for body, place in outputs.points:
        results += _motion_of(circuits, body, place)
    return results


class _Quality(NamedTuple):
    """Figures of conditioning, squared: those whose sign tells branches apart, or whose root does,
    and those that are as large on either side of a singularity.
    """

    signed: list[Scalar]
    unsigned: list[Scalar]

    def of(self, block: Block) -> list[Scalar]:
        """Where the figure of a block belongs that is iterated."""
        return self.unsigned if len(block.rows) > len(block.unknowns) else self.signed


def _least(figures: Sequence[Scalar], functions: Functions) -> Scalar:
    least: Scalar = 1.0
    for figure in figures:
        least = functions.minimum(least, figure)
    return least


def _signed_root(a: Scalar, functions: Functions) -> Scalar:
    size = functions.sqrt(mul(a, a))
    return functions.copysign(functions.sqrt(size), a)


def _motion_of(circuits: Circuits, body: int, place: Vector) -> list[Scalar]:
    pose, twist, accel = circuits.pose(body), circuits.twist(body), circuits.accel(body)
    p = plus(pose.p, apply(pose.R, place))
    v, a = point_velocity(pose, twist, p), point_acceleration(pose, twist, accel, p)
    return [*p, *pose.R[0], *pose.R[1], *pose.R[2], *v, *twist.w, *a, *accel.alpha]


def unknowns_of(plan: Plan) -> list[int]:
    """All that is solved for, in order of solution."""
    return [k for block in plan.blocks for k in block.unknowns]


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
    """One unknown, one row: linear or quadratic in a slide, linear in an angle's (cos, sin).

    The sign that tells the two roots apart is that of the row's derivative at home.
    """
    (k,) = block.unknowns
    row = block.rows[0]
    functions = angles.functions
    # Coordinates still to come cannot matter (the plan has made sure); zeros make short code.
    later = {n: Turn(0.0, 1.0, 0.0) for path in circuits.path.values() for n in path}
    base = circuits.varied({n: t for n, t in later.items() if n not in circuits.turns})

    def row_at(t: Turn, row: Row = row) -> Scalar:
        there = base.varied({k: t})
        return closure.value(there, row, closure.ends(there, row.cut))

    def linear(row: Row) -> tuple[Scalar, Scalar, Scalar]:
        """a, b and c of a row's value a cos + b sin + c."""
        ahead, behind = row_at(Turn(0.0, 1.0, 0.0), row), row_at(Turn(0.0, -1.0, 0.0), row)
        a, c = mul(0.5, sub(ahead, behind)), mul(0.5, add(ahead, behind))
        return a, sub(row_at(Turn(0.0, 0.0, 1.0), row), c), c

    if block.form in ("linear", "quadratic"):
        rest = base.varied({k: slide(0.0)})
        end = closure.ends(rest, row.cut)
        c = closure.value(rest, row, end)
        b = closure.derivative(rest, row, end, k, closure.loop(rest, row.cut)[k])
        if block.form == "linear":
            angles.give(circuits, k, -c / b)
            if not block.regular:
                u = closure.direction(rest, row, end)
                quality.unsigned.append(mul(b, b) / dot(u, u))
            return
        u, side, _ = closure.arm(rest, row, end, k, closure.loop(rest, row.cut)[k])
        reach = sub(mul(b, b), mul(2.0 * side, c))
        root = functions.sqrt(reach)
        angles.give(circuits, k, mul(side, sub(mul(block.sign, root), b)))
        if not block.regular:
            aside = sub(dot(u, u), mul(b, b))  # the square of the centre's distance from the slide
            quality.signed.append(reach / add(reach, aside))
        return
    if block.form == "turn by two":
        (a, b, c), (d, e, f) = (linear(row) for row in block.rows)
        across = sub(mul(a, e), mul(b, d))
        cosine, sine = sub(mul(b, f), mul(c, e)), sub(mul(c, d), mul(a, f))
        # Both are over `across`, whose sign has to be kept when they are brought to length one.
        size = add(mul(cosine, cosine), mul(sine, sine))
        scale = functions.copysign(1.0 / functions.sqrt(size), across)
        cosine, sine = mul(scale, cosine), mul(scale, sine)
        lengths = mul(add(mul(a, a), mul(b, b)), add(mul(d, d), mul(e, e)))
        quality.unsigned.append(mul(across, across) / lengths)
        angles.found[k] = (sine, cosine)
        circuits.turns[k] = Turn(None, cosine, sine)
        return
    if block.form == "turn":  # a cos + b sin = 0
        a, b = row_at(Turn(0.0, 1.0, 0.0)), row_at(Turn(0.0, 0.0, 1.0))
        size = add(mul(a, a), mul(b, b))
        scale = block.sign / functions.sqrt(size)
        cosine, sine = mul(b, scale), -mul(a, scale)
    else:  # a cos + b sin + c = 0
        a, b, c = linear(row)
        size = add(mul(a, a), mul(b, b))
        reach = sub(size, mul(c, c))
        root = mul(block.sign, functions.sqrt(reach))
        inverse = 1.0 / size
        cosine = mul(inverse, sub(mul(b, root), mul(a, c)))
        sine = -mul(inverse, add(mul(b, c), mul(a, root)))
        quality.signed.append(mul(reach, inverse))
    if not block.regular:  # an arm that shrinks leaves its angle undetermined
        quality.signed.append(mul(1.0 / block.reference**2, size))
    angles.found[k] = (sine, cosine)
    circuits.turns[k] = Turn(None, cosine, sine)


def _newton(
    circuits: Circuits,
    block: Block,
    angles: _Angles,
    guesses: Mapping[int, Scalar],
    steps: int,
    lead: Lead | None,
) -> tuple[list[Scalar], Scalar]:
    """A block of several unknowns: a fixed number of Newton steps from the guess.

    Returns the last step and the conditioning met there.
    """
    later = {
        n: Turn(0.0, 1.0, 0.0)
        for path in circuits.path.values()
        for n in path
        if n not in circuits.turns and n not in block.unknowns
    }
    base = circuits.varied(later)

    def system(values: Sequence[Scalar]) -> tuple[list[Scalar], list[list[Scalar]]]:
        """Gaps of the block's rows, and their derivatives by its unknowns."""
        known = zip(block.unknowns, values, strict=True)
        there = base.varied({k: angles.turn(k, value) for k, value in known})
        gaps = [closure.value(there, row, closure.ends(there, row.cut)) for row in block.rows]
        return gaps, jacobian(there, block, set(later))

    values = [guesses[k] for k in block.unknowns]
    if lead is not None:
        values = lead(block, system, values)
    moves: list[Scalar] = []
    figure: Scalar = 1.0
    for _ in range(steps):
        gaps, derivatives = system(values)
        solved = solve(derivatives, [gaps], angles.functions, block.lengths)
        moves = solved.solutions[0]
        figure = mul(block.sign / block.reference, solved.conditioning)
        values = [sub(value, move) for value, move in zip(values, moves, strict=True)]
    for k, value in zip(block.unknowns, values, strict=True):
        angles.give(circuits, k, value)
    return moves, figure


def _side(plan: Plan, block: Block, circuits: Circuits, functions: Functions) -> Scalar:
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
        cut = graph.cones[name][0]
        end = closure.ends(circuits, cut)
        found = closure.cone(circuits, cut, end, functions, derivatives=derivatives)
        if derivatives > 2:
            end, known = closure.ends(moving, cut), dual_functions(functions)
            changing = closure.cone(moving, cut, end, known, derivatives=2)[2]
            return *found, rate_of(changing)
        return found
    if name in circuits.turns:
        value = sub(angles.value(name), plan.offset(name))
        orders = [circuits.rates, circuits.second][:derivatives]
        found = (value, *(order[name] for order in orders))
        return (*found, rate_of(moving.second[name])) if derivatives > 2 else found
    cut = graph.coordinates[name].joint
    end = closure.ends(circuits, cut)
    reading = closure.read(circuits, cut, end, functions)
    angles.values.update(reading.slides)
    angles.found.update(reading.turns)
    value = sub(angles.value(name), plan.offset(name))
    if derivatives == 0:
        return (value,)
    rates, second = closure.read_rates(circuits, cut, end, reading, accelerations=derivatives > 1)
    found = (value, rates[name], second.get(name, 0.0))
    if derivatives > 2:
        end = closure.ends(moving, cut)
        reading = closure.read(moving, cut, end, dual_functions(functions))
        changing = closure.read_rates(moving, cut, end, reading, accelerations=True)[1][name]
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
        end = closure.ends(circuits, cut)
        rows = closure.canonical_rows(plan.graph.joints[cut], cut)
        if rows:
            square = add(square, dot(end.M.p, end.M.p))
        for row in rows:
            gap = closure.value(circuits, row, end)
            gap = mul(closure.per_length(plan.graph, row), gap)
            total = add(total, mul(gap, gap))
        for cosine in closure.cosines(circuits, cut, end):
            gap = mul(length, sub(1.0, cosine))
            total = add(total, mul(gap, gap))
    lost = mul(ROUNDING * ROUNDING, square)
    return functions.sqrt(add(total, lost)), functions.sqrt(square)


def has_unsigned(plan: Plan) -> bool:
    """Whether some figure of conditioning keeps no sign where it passes zero."""
    return bool(plan.unsolved) or any(
        block.form == "turn by two"
        or (block.form == "linear" and not block.regular)
        or (block.form == "newton" and len(block.rows) > len(block.unknowns))
        for block in plan.blocks
    )
