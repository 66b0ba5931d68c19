"""A pose and its rates: the plan's blocks one after the other, then velocities and accelerations.

Written once, for floats, arrays and expressions to be compiled. It has no branches on values: a
pose that cannot be reached comes out as NaN.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from parakin.algebra.dual import rate_of, value_of
from parakin.algebra.linear import solve
from parakin.algebra.spatial import FLOATS, Functions, Scalar, add, mul, sub
from parakin.kernel.connectivity import System, jacobian, signed_square, solve_blocks
from parakin.kinematics import loops
from parakin.kinematics.recursion import Circuits, Turn, slide, turn
from parakin.planning import forms
from parakin.planning.forms import Iterated
from parakin.planning.plan import Block, Plan

# A block's gaps and their derivatives by its unknowns, at given values of these.
Equations = Callable[[Sequence[Scalar]], tuple[list[Scalar], list[list[Scalar]]]]
Refiner = Callable[[Block, Equations, list[Scalar]], list[Scalar]]


class Moved(NamedTuple):
    """A pose that has been solved: circuits with all that is known of the tree's coordinates, these
    with their own rates in time if jerks are given, the blocks' systems (none for positions alone),
    angles, figures of conditioning, and the last steps of iteration.
    """

    circuits: Circuits
    moving: Circuits
    systems: list[System]
    angles: Angles
    quality: Quality
    moves: list[Scalar]


def solve_motion(
    plan: Plan,
    orders: Sequence[Sequence[Scalar]],
    guess: Sequence[Scalar],
    functions: Functions,
    steps: int,
    refine: Refiner | None = None,
) -> Moved:
    """Solve a pose and its rates. orders: driven positions, then as many derivatives as are known;
    guess, steps and refine as of `solve_pose`.
    """
    circuits = Circuits(plan.graph, plan.tree)
    angles = Angles(plan, functions)
    quality = Quality([], [])
    for k in plan.affine:
        angles.give(circuits, k, _rule(plan, k, orders[0]))
    guesses = {k: add(value, plan.offset(k)) for k, value in zip(plan.iterated, guess, strict=True)}
    moves: list[Scalar] = []
    for block in plan.blocks:
        if isinstance(block.form, Iterated):
            last, figure = _newton(circuits, block, angles, guesses, steps, refine)
            moves += last
            if len(orders) == 1:
                side = _lock_sign(plan, block, circuits, functions)
                quality.of(block).append(mul(side, signed_square(figure, functions)))
        else:
            _closed_form(circuits, block, angles, quality)
    if len(orders) == 1:
        return Moved(circuits, circuits, [], angles, quality, moves)
    systems = [System.of(circuits, block) for block in plan.blocks]
    moving = _moving(plan, circuits, systems, orders, functions, quality)
    return Moved(circuits, moving, systems, angles, quality, moves)


def motion_at(
    plan: Plan,
    driven: Sequence[Scalar],
    unknowns: Sequence[Scalar],
    rates: Sequence[Scalar],
    functions: Functions,
) -> Moved:
    """The motion where all coordinates of the tree are known, closed, and so no position is solved
    for: its rates at those of the driven coordinates, and the accelerations that are left where
    the driven coordinates have none.
    """
    circuits = Circuits(plan.graph, plan.tree)
    angles, quality = Angles(plan, functions), Quality([], [])
    for k in plan.affine:
        angles.give(circuits, k, _rule(plan, k, driven))
    for k, value in zip(plan.unknowns, unknowns, strict=True):
        angles.give(circuits, k, add(value, plan.offset(k)))
    systems = [System.of(circuits, block) for block in plan.blocks]
    orders = [driven, rates, [0.0] * len(rates)]
    moving = _moving(plan, circuits, systems, orders, functions, quality)
    return Moved(circuits, moving, systems, angles, quality, [])


def unit_motions(plan: Plan, moved: Moved, functions: Functions) -> list[Circuits]:
    """At the same pose, the motion at a rate of one in each driven coordinate."""
    found = []
    for number in range(len(plan.driven)):
        rates = [float(number == k) for k in range(len(plan.driven))]
        known: dict[int, Scalar] = {k: _mix(plan, k, rates) for k in plan.affine}
        moving = moved.circuits.with_coordinates(rates=known | dict.fromkeys(plan.unknowns, 0.0))
        drifts = [system.rates(moving) for system in moved.systems]
        moving.set_rates(rates=solve_blocks(plan, moved.systems, drifts, functions)[0])
        found.append(moving)
    return found


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
    systems: Sequence[System],
    orders: Sequence[Sequence[Scalar]],
    functions: Functions,
    quality: Quality,
) -> Circuits:
    """Set the rates of all coordinates, and of the orders given their accelerations (eq. 10 and its
    derivative). Returns the circuits with their own rates in time, if jerks are given too.
    """
    rest: dict[int, Scalar] = dict.fromkeys(plan.unknowns, 0.0)
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


class Quality(NamedTuple):
    """Figures of conditioning, squared: those whose sign tells branches apart, or whose root does,
    and those that are as large on either side of a singularity.
    """

    signed: list[Scalar]
    unsigned: list[Scalar]

    def of(self, block: Block) -> list[Scalar]:
        """Where the figure of a block belongs that is iterated."""
        return self.unsigned if block.form.unsigned else self.signed

    def least(self, functions: Functions) -> Scalar:
        """The least of them, at most 1."""
        least: Scalar = 1.0
        for figure in (*self.signed, *self.unsigned):
            least = functions.minimum(least, figure)
        return least


def _mix(plan: Plan, k: int, rates: Sequence[Scalar]) -> Scalar:
    total: Scalar = 0.0
    for j, factor in plan.affine[k].factors:
        total = add(total, mul(factor, rates[plan.driven.index(j)]))
    return total


class Angles:
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


def _closed_form(circuits: Circuits, block: Block, angles: Angles, quality: Quality) -> None:
    """One unknown by the form of its block."""
    (k,) = block.unknowns
    # Coordinates still to come cannot matter (the plan has made sure); zeros make short code.
    circuits.place()
    base = circuits.with_coordinates(
        {n: forms.AHEAD for n in circuits.coordinates if n not in circuits.turns}
    )
    assert not isinstance(block.form, Iterated)
    found = block.form.solve(base, k, block.rows, angles.functions)
    angles.set(circuits, k, found.turn)
    quality.signed.extend(found.signed)
    quality.unsigned.extend(found.unsigned)


def _newton(
    circuits: Circuits,
    block: Block,
    angles: Angles,
    guesses: Mapping[int, Scalar],
    steps: int,
    refine: Refiner | None,
) -> tuple[list[Scalar], Scalar]:
    """A block of several unknowns: a fixed number of Newton steps from the guess.

    Returns the last step and the conditioning met there.
    """
    later = {
        n: forms.AHEAD
        for n in circuits.coordinates
        if n not in circuits.turns and n not in block.unknowns
    }
    circuits.place()
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
        # Of dual numbers the last step's rates alone count: those of the implicit function.
        gaps, slopes = system([value_of(value) for value in values])
        derivatives = [[value_of(slope) for slope in row] for row in slopes]
        solved = solve(derivatives, [gaps], angles.functions, form.lengths)
        moves = solved.solutions[0]
        figure = mul(form.sign / form.reference, solved.conditioning)
        values = [sub(value_of(value), move) for value, move in zip(values, moves, strict=True)]
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
