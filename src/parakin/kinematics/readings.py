"""Readings: coordinates of joints outside the tree, from the bodies' motion."""

from __future__ import annotations

from typing import NamedTuple

from parakin.algebra.spatial import (
    IDENTITY,
    ZERO,
    Functions,
    Matrix,
    Scalar,
    Vector,
    add,
    cross,
    dot,
    mul,
    sub,
)
from parakin.kinematics.closure import Wrench, slide_acceleration, slide_rate
from parakin.kinematics.loops import Ends
from parakin.kinematics.recursion import Circuits
from parakin.model.joints import GraphJoint


class Reading(NamedTuple):
    """A cut joint's coordinates read off its two bodies: slides, and (sine, cosine) of turns,
    each pair scaled by the same positive number.
    """

    slides: dict[int, Scalar]
    turns: dict[int, tuple[Scalar, Scalar]]


def _turning(joint: GraphJoint) -> list[tuple[int, int]]:
    return [(k, joint.pairs[k - joint.first].axis) for k in joint.turns]


def _parity(axes: list[tuple[int, int]]) -> float:
    return 1.0 if (axes[1][1] - axes[0][1]) % 3 == 1 else -1.0


def read(circuits: Circuits, cut: int, end: Ends, functions: Functions) -> Reading:
    """The coordinates of a joint outside the tree, from the poses of its bodies."""
    joint = circuits.graph.joints[cut]
    slides = {
        k: dot(end.X_WF.R.column(pair.axis), end.d)
        for k, pair in zip(joint.coordinates, joint.pairs, strict=True)
        if pair.slides
    }
    axes = _turning(joint)
    if not axes:
        return Reading(slides, {})
    R_FM = end.X_WF.R.T @ end.X_WM.R @ joint.tail.T
    return Reading(slides, _turns(R_FM, axes, functions))


def _turns(
    R: Matrix, axes: list[tuple[int, int]], functions: Functions
) -> dict[int, tuple[Scalar, Scalar]]:
    first, i = axes[0]
    j, k = (i + 1) % 3, (i + 2) % 3
    if len(axes) == 1:
        return {first: (R[k][j], R[j][j])}
    if len(axes) == 2:  # universal: about z, then about x
        return {first: (R[1][0], R[0][0]), axes[1][0]: (R[2][1], R[2][2])}
    sign = _parity(axes)
    j, k = axes[1][1], axes[2][1]
    middle = functions.sqrt(add(mul(R[i][i], R[i][i]), mul(R[i][j], R[i][j])))
    return {
        first: (mul(-sign, R[j][k]), R[k][k]),
        axes[1][0]: (mul(sign, R[i][k]), middle),
        axes[2][0]: (mul(-sign, R[i][j]), R[i][i]),
    }


def _directions(joint: GraphJoint, end: Ends, middle: Scalar) -> list[Vector]:
    axes = _turning(joint)
    found = [end.X_WF.R.column(axes[0][1])] if axes else []
    if len(axes) == 2:
        found.append(end.X_WM.R.column(2))
    elif len(axes) == 3:
        last = end.X_WM.R.column(axes[2][1])
        across = cross(last, found[0]) * (_parity(axes) / middle)
        found += [across, last]
    return found


def _resolved(w: Vector, directions: list[Vector]) -> list[Scalar]:
    """The components of an angular velocity along the axes of one, two or three turns."""
    parts = [dot(w, e) for e in directions]
    if len(parts) == 3:
        lean = dot(directions[0], directions[2])
        scale = 1.0 / sub(1.0, mul(lean, lean))
        first, last = parts[0], parts[2]
        parts[0] = mul(scale, sub(first, mul(lean, last)))
        parts[2] = mul(scale, sub(last, mul(lean, first)))
    return parts


def read_rates(
    circuits: Circuits, cut: int, end: Ends, reading: Reading, *, accelerations: bool
) -> tuple[dict[int, Scalar], dict[int, Scalar]]:
    """First and second derivatives of a cut joint's coordinates, which have been `read`."""
    joint = circuits.graph.joints[cut]
    cosines = [cosine for _, cosine in reading.turns.values()]
    middle = cosines[1] if len(cosines) == 3 else 1.0
    w_WP, w_WC = circuits.twist(end.parent).w, circuits.twist(end.child).w
    directions = _directions(joint, end, middle)
    turning = [k for k, _ in _turning(joint)]
    rates = dict(zip(turning, _resolved(w_WC - w_WP, directions), strict=True))
    second: dict[int, Scalar] = {}
    if accelerations and turning:
        bias = circuits.accel(end.child).alpha - circuits.accel(end.parent).alpha
        w = w_WP
        for k, e in zip(turning, directions, strict=True):
            bias -= cross(w, e) * rates[k]
            w += e * rates[k]
        second = dict(zip(turning, _resolved(bias, directions), strict=True))
    for k, pair in zip(joint.coordinates, joint.pairs, strict=True):
        if pair.slides:
            u = end.X_WF.R.column(pair.axis)
            rates[k] = slide_rate(circuits, u, end)
            if accelerations:
                second[k] = slide_acceleration(circuits, u, end)
    return rates, second


def rate_wrenches(
    circuits: Circuits, cut: int, end: Ends, functions: Functions
) -> dict[int, Wrench]:
    """For each coordinate of a cut joint the wrench whose power on the relative motion of its two
    bodies is the coordinate's rate: what a unit effort exerts on the child, and against the parent.
    """
    joint = circuits.graph.joints[cut]
    found = {}
    for k, pair in zip(joint.coordinates, joint.pairs, strict=True):
        if pair.slides:
            u = end.X_WF.R.column(pair.axis)
            found[k] = Wrench(cross(end.X_WM.p, u), u)
    middle: Scalar = 1.0
    if len(joint.turns) == 3:
        middle = list(read(circuits, cut, end, functions).turns.values())[1][1]
    directions = _directions(joint, end, middle)
    units = [_resolved(Vector(axis), directions) for axis in IDENTITY]  # linear in w
    for number, k in enumerate(joint.turns):
        found[k] = Wrench(Vector(tuple(unit[number] for unit in units)), ZERO)
    return found
