"""One pose, solved: the plan's blocks one after the other, then rates, accelerations and jerks.

This is the function that NumPy runs on arrays and that `parakin.compile` traces into machine
code, line for line the same. It has no branches on values: a pose that cannot be reached comes
out as NaN, one close to singular with a small `conditioning`.
"""

from __future__ import annotations

from collections.abc import Sequence

from parakin.algebra.spatial import FLOATS, Functions, Scalar, Vector, add, as_float, dot, mul, sub
from parakin.kernel.connectivity import unsolved_volume
from parakin.kernel.coordinates import coordinate
from parakin.kernel.efforts import forces
from parakin.kernel.motion import Moved, Refiner, solve_motion
from parakin.kernel.outputs import Outputs
from parakin.kinematics import loops
from parakin.kinematics.closure import canonical_rows, cosines
from parakin.kinematics.configuration import circuits_at
from parakin.kinematics.recursion import Circuits, point_acceleration, point_velocity
from parakin.planning.plan import Plan

ROUNDING = 2.0**-53


def solve_pose(
    plan: Plan,
    orders: Sequence[Sequence[Scalar]],
    guess: Sequence[Scalar],
    functions: Functions,
    outputs: Outputs,
    steps: int = 2,
    refine: Refiner | None = None,
    loads: Sequence[Scalar] = (),
) -> list[Scalar]:
    """Solve one pose (or an array of them); see `Outputs` for what is returned.

    orders: driven positions, then as many derivatives of them as are asked for, each one scalar
    per driven coordinate. guess: one per coordinate of `Plan.iterated`. refine: what brings the
    guess of a block nearer before Newton's steps. loads: what payloads and applied wrenches take,
    if forces are asked for.
    """
    moved = solve_motion(plan, orders[: 1 + outputs.derivatives], guess, functions, steps, refine)
    columns = [coordinate(plan, moved, name, outputs.derivatives) for name in outputs.coordinates]
    results = [column[order] for order in range(1 + outputs.derivatives) for column in columns]
    if outputs.checks:
        results += checks(plan, moved, functions)
    for body, place in outputs.points:
        results += _motion_of(moved.circuits, body, place)
    if outputs.forces is not None:
        results += forces(plan, moved, outputs.forces, loads, functions)
    return results


def checks(plan: Plan, moved: Moved, functions: Functions) -> list[Scalar]:
    """Residual, conditioning, the last step of iteration, size, and the unsigned figures."""
    least = conditioning(plan, moved, functions)
    step: Scalar = 0.0
    for move in moved.moves:
        step = add(step, mul(move, move))
    residual, size = _residual(plan, moved.circuits, functions)
    product: Scalar = 1.0
    for figure in moved.quality.unsigned:
        product = mul(product, figure)
    return [
        residual,
        _signed_root(least, functions),
        functions.sqrt(step) if moved.moves else 0.0,
        size,
        functions.sqrt(product),
    ]


def conditioning(plan: Plan, moved: Moved, functions: Functions) -> Scalar:
    """The least of all figures, squared; to the unsigned ones is added that of what is not solved
    for.
    """
    if plan.unsolved:
        own = plan if plan.opening is None else plan.opening.own
        at_home = circuits_at(own.graph, own.tree, own.home)
        unit = 1.0 / as_float(unsolved_volume(own, at_home, FLOATS))
        volume = unsolved_volume(plan, moved.circuits, functions)
        moved.quality.unsigned.append(mul(unit, volume))
    return moved.quality.least(functions)


def _signed_root(a: Scalar, functions: Functions) -> Scalar:
    root: Scalar = functions.copysign(functions.sqrt(functions.sqrt(mul(a, a))), a)
    return root


def _motion_of(circuits: Circuits, body: int, place: Vector) -> list[Scalar]:
    X_WB, V_WB, A_WB = circuits.pose(body), circuits.twist(body), circuits.accel(body)
    p = X_WB.p + X_WB.R @ place
    v, a = point_velocity(X_WB, V_WB, p), point_acceleration(X_WB, V_WB, A_WB, p)
    return [*p, *X_WB.R[0], *X_WB.R[1], *X_WB.R[2], *v, *V_WB.w, *a, *A_WB.alpha]


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
