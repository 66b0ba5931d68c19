"""Loop closures: what a joint left out of the tree demands of the two bodies it joins.

A closure is a set of rows, each a scalar that vanishes when the loop is closed. Three kinds do
for every joint: the gap `d = p_M - p_F` measured along a direction, the gap measured as a
difference of distances from a joint's centre, and two axes that must stay perpendicular. Rows of
the first two kinds say the same thing in different directions; which of them are solved is a
matter of cost (`parakin.planning.ordering`), what is reported is always the canonical set.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

from parakin.algebra.spatial import (
    Functions,
    Matrix,
    Scalar,
    Vector,
    add,
    apply,
    column,
    compose,
    cross,
    dot,
    minus,
    mul,
    plus,
    sub,
    times,
    transpose,
)
from parakin.kinematics.recursion import (
    Circuits,
    Pose,
    pair_velocity,
    point_acceleration,
    point_velocity,
)
from parakin.model.graph import Graph, Tree
from parakin.model.joints import GraphJoint


class Row(NamedTuple):
    """One scalar equation of the cut joint `cut`.

    "frame": gap along axis `a` of the joint's frame F; "child": of its frame M; "base": of the
    base. "pair": along the axis of coordinate `a`. "centre": half the difference of the squared
    distances of the two points from a point on that axis. "align": axis `a` of F is
    perpendicular to axis `b` of M. "rod": half of what the square of the gap differs from the
    square of the rod's length.
    """

    cut: int
    kind: Literal["frame", "child", "base", "pair", "centre", "align", "rod"]
    a: int
    b: int = 0


_POINT = (("frame", 0, 0), ("frame", 1, 0), ("frame", 2, 0))
_SLIDE = (("frame", 0, 0), ("frame", 1, 0))
_AXIS = (("align", 0, 2), ("align", 1, 2))
_TURNLESS = (("align", 0, 1), ("align", 1, 2), ("align", 2, 0))
_CANONICAL: dict[str, tuple[tuple[str, int, int], ...]] = {
    "revolute": _POINT + _AXIS,
    "prismatic": _SLIDE + _TURNLESS,
    "cylindrical": _SLIDE + _AXIS,
    "universal": (*_POINT, ("align", 2, 2)),
    "spherical": _POINT,
    "fixed": _POINT + _TURNLESS,
    "planar": (("frame", 2, 0), *_AXIS),
    "helical": (),
    "free": (),
    "rod": (("rod", 0, 0),),
}


def canonical_rows(joint: GraphJoint, cut: int) -> list[Row]:
    """All rows of a cut joint: six less its freedom."""
    return [Row(cut, kind, a, b) for kind, a, b in _CANONICAL[joint.kind]]  # type: ignore[arg-type]


def all_rows(graph: Graph, tree: Tree) -> list[Row]:
    """The canonical rows of all joints that a tree leaves out."""
    return [row for cut in tree.cuts for row in canonical_rows(graph.joints[cut], cut)]


def per_length(graph: Graph, row: Row) -> float:
    """What turns a row's gap into metres; a cosine counts at the characteristic length."""
    if row.kind == "rod":
        return 1.0 / graph.joints[row.cut].length
    return graph.length if row.kind == "align" else 1.0


def closes_point(joint: GraphJoint) -> bool:
    """Whether the joint holds two points together, so that its gap vanishes in all directions."""
    return _CANONICAL[joint.kind][:3] == _POINT


_FACING = {  # axes of the two bodies that must not only be parallel, but point the same way
    "revolute": (2,),
    "cylindrical": (2,),
    "planar": (2,),
    "prismatic": (0, 1, 2),
    "fixed": (0, 1, 2),
}


def cosines(circuits: Circuits, cut: int, end: Ends) -> list[Scalar]:
    """Between axes of a cut joint that have to point the same way: 1 where they do."""
    axes = _FACING.get(circuits.graph.joints[cut].kind, ())
    return [dot(column(end.F.R, a), column(end.M.R, a)) for a in axes]


class Ends(NamedTuple):
    """The cut joint's frames as its two bodies carry them, and the points' gap d = p_M - p_F."""

    parent: int
    child: int
    F: Pose
    M: Pose
    d: Vector


def ends(circuits: Circuits, cut: int) -> Ends:
    joint = circuits.graph.joints[cut]
    P, C = circuits.pose(joint.parent), circuits.pose(joint.child)
    F = Pose(compose(P.R, joint.F.R), plus(P.p, apply(P.R, joint.F.p)))
    M = Pose(compose(C.R, joint.M.R), plus(C.p, apply(C.R, joint.M.p)))
    return Ends(joint.parent, joint.child, F, M, minus(M.p, F.p))


def loop(circuits: Circuits, cut: int) -> dict[int, float]:
    """Coordinates on the cut joint's loop: +1 on the child's side, -1 on the parent's."""
    joint = circuits.graph.joints[cut]
    ahead, behind = circuits.path[joint.child], circuits.path[joint.parent]
    signs = {k: 1.0 for k in ahead if k not in behind}
    return signs | {k: -1.0 for k in behind if k not in ahead}


def _axis_of(circuits: Circuits, end: Ends, coordinate: int) -> tuple[Vector, Vector]:
    side = end.child if coordinate in circuits.path[end.child] else end.parent
    axis, _ = circuits.axes(side)[coordinate]
    return axis.direction, axis.point


def arm(
    circuits: Circuits, row: Row, end: Ends, coordinate: int, side: float
) -> tuple[Vector, float, Vector]:
    """How a "centre" or "rod" row sees a coordinate: the arm, the sign of its square in the row,
    and the point that the coordinate moves.

    The coordinate moves the point on its own side about a fixed centre, or, where the centre is
    beyond it on the same side, moves the centre and with it the arm to the point opposite.
    """
    own = end.M.p if side > 0 else end.F.p
    if row.kind == "rod":
        return end.d, 1.0, own
    path = circuits.path[end.child if side > 0 else end.parent]
    carried = row.a in path and path.index(coordinate) < path.index(row.a)
    sign = -side if carried else side
    centre = _axis_of(circuits, end, row.a)[1]
    return minus(end.M.p if sign > 0 else end.F.p, centre), sign, centre if carried else own


def direction(circuits: Circuits, row: Row, end: Ends) -> Vector:
    """The direction in which a gap row measures (for "centre": from there to the gap's middle)."""
    if row.kind == "rod":
        return end.d
    if row.kind == "frame":
        return column(end.F.R, row.a)
    if row.kind == "child":
        return column(end.M.R, row.a)
    if row.kind == "base":
        return (float(row.a == 0), float(row.a == 1), float(row.a == 2))
    along, point = _axis_of(circuits, end, row.a)
    if row.kind == "pair":
        return along
    return minus(times(0.5, plus(end.M.p, end.F.p)), point)


def value(circuits: Circuits, row: Row, end: Ends) -> Scalar:
    """The row's gap: metres, for "centre" square metres, for "align" a cosine."""
    if row.kind == "align":
        return dot(column(end.F.R, row.a), column(end.M.R, row.b))
    if row.kind == "centre":
        _, point = _axis_of(circuits, end, row.a)
        ahead, behind = minus(end.M.p, point), minus(end.F.p, point)
        return mul(0.5, sub(dot(ahead, ahead), dot(behind, behind)))
    if row.kind == "rod":
        length = circuits.graph.joints[row.cut].length
        return mul(0.5, sub(dot(end.d, end.d), length * length))
    return dot(direction(circuits, row, end), end.d)


def turns_with_parent(circuits: Circuits, row: Row) -> bool:
    """Whether the row's direction turns with the parent while its gap is not zero."""
    return row.kind == "frame" and not closes_point(circuits.graph.joints[row.cut])


def carries(circuits: Circuits, row: Row, end: Ends, coordinate: int, side: float) -> bool:
    """Whether the direction in which a gap row measures turns with a coordinate of its loop."""
    if row.kind != "pair":
        return (row.kind, side) in (("frame", -1.0), ("child", 1.0))
    path = circuits.path[end.child if side > 0 else end.parent]
    return row.a in path and path.index(coordinate) < path.index(row.a)


def derivative(
    circuits: Circuits, row: Row, end: Ends, coordinate: int, side: float, *, open_: bool = False
) -> Scalar:
    """The row's derivative by one coordinate of its loop, on the closed loop; with `open_` on an
    open one too, whose gap counts where the row's direction turns.
    """
    body = end.child if side > 0 else end.parent
    axis, sign = circuits.axes(body)[coordinate]
    if row.kind == "align":
        w, _ = pair_velocity(axis, sign * side, end.F.p)
        u, v = column(end.F.R, row.a), column(end.M.R, row.b)
        return dot(w, cross(v, u))
    if row.kind in ("centre", "rod"):  # exact on open loops in any case
        u, _, moved = arm(circuits, row, end, coordinate, side)
        return dot(u, pair_velocity(axis, sign * side, moved)[1])
    u, moved = direction(circuits, row, end), end.M.p if side > 0 else end.F.p
    w, v = pair_velocity(axis, sign * side, moved)
    slope = dot(u, v)
    # (w is minus the rate at which F turns with the parent.)
    if (open_ or turns_with_parent(circuits, row)) and carries(
        circuits, row, end, coordinate, side
    ):
        slope = add(slope, mul(side, dot(cross(w, u), end.d)))
    return slope


def rate(circuits: Circuits, row: Row, end: Ends) -> Scalar:
    """The row's time derivative from the bodies' twists, on the closed loop (eq. 10)."""
    P, C = circuits.twist(end.parent), circuits.twist(end.child)
    if row.kind == "align":
        u, v = column(end.F.R, row.a), column(end.M.R, row.b)
        return dot(minus(C.w, P.w), cross(v, u))
    u = direction(circuits, row, end)
    v = gap_velocity(circuits, end)
    if not turns_with_parent(circuits, row):
        return dot(u, v)
    return add(dot(u, v), dot(cross(P.w, u), end.d))


def gap_velocity(circuits: Circuits, end: Ends) -> Vector:
    ahead = point_velocity(circuits.pose(end.child), circuits.twist(end.child), end.M.p)
    behind = point_velocity(circuits.pose(end.parent), circuits.twist(end.parent), end.F.p)
    return minus(ahead, behind)


def gap_acceleration(circuits: Circuits, end: Ends) -> Vector:
    C, P = end.child, end.parent
    return minus(
        point_acceleration(circuits.pose(C), circuits.twist(C), circuits.accel(C), end.M.p),
        point_acceleration(circuits.pose(P), circuits.twist(P), circuits.accel(P), end.F.p),
    )


def acceleration(circuits: Circuits, row: Row, end: Ends) -> Scalar:
    """The row's second time derivative from the bodies' accelerations, on the closed loop."""
    P, C = circuits.twist(end.parent), circuits.twist(end.child)
    p, c = circuits.accel(end.parent), circuits.accel(end.child)
    if row.kind == "align":
        u, v = column(end.F.R, row.a), column(end.M.R, row.b)
        turning = plus(cross(cross(C.w, v), u), cross(v, cross(P.w, u)))
        relative = dot(minus(c.alpha, p.alpha), cross(v, u))
        return add(relative, dot(minus(C.w, P.w), turning))
    u = direction(circuits, row, end)
    along = dot(u, gap_acceleration(circuits, end))
    if row.kind == "rod":
        v = gap_velocity(circuits, end)
        return add(along, dot(v, v))
    if not turns_with_parent(circuits, row):
        return along
    swing = cross(P.w, u)
    swung = plus(cross(p.alpha, u), cross(P.w, swing))
    coriolis = mul(2.0, dot(swing, gap_velocity(circuits, end)))
    return add(along, add(dot(swung, end.d), coriolis))


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
        k: dot(column(end.F.R, pair.axis), end.d)
        for k, pair in zip(joint.coordinates, joint.pairs, strict=True)
        if pair.slides
    }
    axes = _turning(joint)
    if not axes:
        return Reading(slides, {})
    R = compose(compose(transpose(end.F.R), end.M.R), transpose(joint.tail))
    return Reading(slides, _turns(R, axes, functions))


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
    found = [column(end.F.R, axes[0][1])] if axes else []
    if len(axes) == 2:
        found.append(column(end.M.R, 2))
    elif len(axes) == 3:
        last = column(end.M.R, axes[2][1])
        across = times(_parity(axes) / middle, cross(last, found[0]))
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
    P, C = circuits.twist(end.parent), circuits.twist(end.child)
    directions = _directions(joint, end, middle)
    turning = [k for k, _ in _turning(joint)]
    rates = dict(zip(turning, _resolved(minus(C.w, P.w), directions), strict=True))
    second: dict[int, Scalar] = {}
    if accelerations and turning:
        bias = minus(circuits.accel(end.child).alpha, circuits.accel(end.parent).alpha)
        w = P.w
        for k, e in zip(turning, directions, strict=True):
            bias = minus(bias, times(rates[k], cross(w, e)))
            w = plus(w, times(rates[k], e))
        second = dict(zip(turning, _resolved(bias, directions), strict=True))
    for k, pair in zip(joint.coordinates, joint.pairs, strict=True):
        if pair.slides:
            u, v = column(end.F.R, pair.axis), gap_velocity(circuits, end)
            swing = cross(P.w, u)
            rates[k] = add(dot(u, v), dot(swing, end.d))
            if accelerations:
                swung = plus(cross(circuits.accel(end.parent).alpha, u), cross(P.w, swing))
                along = dot(u, gap_acceleration(circuits, end))
                coriolis = mul(2.0, dot(swing, v))
                second[k] = add(along, add(dot(swung, end.d), coriolis))
    return rates, second


def cone(
    circuits: Circuits, cut: int, end: Ends, functions: Functions, *, derivatives: int
) -> tuple[Scalar, Scalar, Scalar]:
    """The angle between a spherical joint's two z axes, and its derivatives (undefined at 0)."""
    row = Row(cut, "align", 2, 2)
    z, cosine = cross(column(end.F.R, 2), column(end.M.R, 2)), value(circuits, row, end)
    square = dot(z, z)
    sine = functions.sqrt(square)
    angle = functions.atan2(sine, cosine)
    if derivatives < 1 or (type(square) is float and square == 0.0):  # zero in every pose
        return angle, 0.0, 0.0
    first = -rate(circuits, row, end) / sine
    if derivatives < 2:
        return angle, first, 0.0
    second = -(acceleration(circuits, row, end) + cosine * first * first) / sine
    return angle, first, second
