"""Assembly: from a rough guess to a closed mechanism, and to other closed ones near it.

Plain dense numbers, a handful of configurations at a time. Everything here works with one
configuration seen as a set of screws: each coordinate's axis where it stands in space, and each
closure row as a functional on the relative twist of the two bodies it joins.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from parakin.algebra.spatial import ARRAYS, FLOATS, ZERO, Vector, as_array, as_float
from parakin.arrays import FloatArray
from parakin.errors import AssemblyError
from parakin.kinematics import loops
from parakin.kinematics.closure import Perpendicular, Row, all_rows, canonical_rows, cosines
from parakin.kinematics.readings import read
from parakin.kinematics.recursion import Axis, Circuits, Turn, pair_velocity, slide, step_pose, turn
from parakin.model.graph import Graph, Tree

_NOTHING = 1e-14  # a home value this small is round-off of zero; exact zeros make shorter code
CLOSED = 1e-12  # of the characteristic length
_SHAKES = (0.02, 0.1, *(0.3, 1.0, 3.0) * 16)  # of starts around a guess [rad]
_TRIES = 3  # of these, as long as the loops do not close at all
_RESTS = 1e-7  # rates below this, scaled, are none
_STRAY = 1e-6  # a step further than this, from where loops are closed, chases round-off
_WORK = 6000  # steps of closing times coordinates: some three seconds
_NEARBY_STEPS = 60  # ten will do, if not at a singularity
_RANK = 1e-8  # singular values below this part of the largest count as zero


@dataclass(frozen=True)
class Configuration:
    """Every joint and body of a mechanism at one moment, closed or not.

    `q`: all coordinates; `screws` (6, n): direction of motion per coordinate, angular part then
    velocity at the base's origin, angular parts scaled by nothing; `axes` of the coordinates where
    they stand; `ends`: each joint's frames on its two bodies. `turned` keeps what has been worked
    out with one coordinate turned: by cut joint and coordinate.
    """

    q: FloatArray
    screws: FloatArray
    axes: tuple[Axis, ...]
    circuits: Circuits
    ends: tuple[loops.Ends, ...]
    turned: dict[tuple[int, int], list[tuple[Circuits, loops.Ends]]] = field(default_factory=dict)


def circuits_at(graph: Graph, tree: Tree, q: Sequence[float] | FloatArray) -> Circuits:
    """The recursion with numbers for the tree's coordinates, or rows of many: (coordinates, n)."""
    circuits = Circuits(graph, tree)
    circuits.turns |= {k: as_turn(graph, k, q[k]) for k in graph.inside(tree)}
    return circuits


def as_turn(graph: Graph, coordinate: int, value: float | FloatArray) -> Turn:
    """A coordinate as the recursion needs it, from a number or an array of them."""
    if np.ndim(value) == 0:
        value = float(value)  # a plain number, so that literal zeros are known for what they are
    if not graph.coordinates[coordinate].angle:
        return slide(value)
    return turn(value, ARRAYS if np.ndim(value) else FLOATS)


def configure(graph: Graph, tree: Tree, q: FloatArray) -> Configuration:
    """The configuration given by the tree's coordinates; those of cut joints are read off.

    Angles of cut joints are taken within half a turn of their values in `q`.
    """
    circuits = circuits_at(graph, tree, q)
    q = np.array(q, dtype=float)
    ends = tuple(loops.ends(circuits, k) for k in range(len(graph.joints)))
    for k in tree.cuts:
        reading = read(circuits, k, ends[k], FLOATS)
        for n, (s, c) in reading.turns.items():
            angle = math.atan2(as_float(s), as_float(c))
            q[n] = angle + 2 * math.pi * round((q[n] - angle) / (2 * math.pi))
        for n, value in reading.slides.items():
            q[n] = as_float(value)
    axes: dict[int, Axis] = {}
    for joint in graph.joints:
        turns = {k: as_turn(graph, k, q[k]) for k in joint.coordinates}
        axes |= step_pose(circuits.pose(joint.parent), joint, False, turns)[1]
    located = tuple(axes[k] for k in range(len(q)))
    screws = [[*w, *v] for w, v in (pair_velocity(axis, 1.0, ZERO) for axis in located)]
    columns = np.ascontiguousarray(np.array(screws, dtype=float).reshape(-1, 6).T)
    return Configuration(q, columns, located, circuits, ends)


def full_screws(graph: Graph, at: Configuration, held: Collection[int] = ()) -> FloatArray:
    """Screws, those of joints of three turns, none of them held, about three axes at right angles
    whatever their angles.
    """
    screws = at.screws.copy()
    for k, joint in enumerate(graph.joints):
        if len(joint.turns) == 3 and not set(joint.turns) & set(held):
            centre = np.array(at.ends[k].M.p, dtype=float)
            for number, axis in zip(joint.turns, np.eye(3), strict=True):
                screws[:, number] = np.concatenate([axis, np.cross(centre, axis)])
    return screws


def loop_signs(graph: Graph, tree: Tree) -> dict[int, FloatArray]:
    """Per cut: how each coordinate's screw enters the relative twist of its two bodies."""
    circuits = Circuits(graph, tree)
    onward = np.ones(len(graph.coordinates))
    for k, reverse in tree.steps:
        if reverse:
            onward[list(graph.joints[k].coordinates)] = -1.0
    signs = {}
    for cut in tree.cuts:
        row = np.zeros(len(graph.coordinates))
        for k, side in loops.sides(circuits, cut).items():
            row[k] = side * onward[k]
        signs[cut] = row
    return signs


def loop_rank(graph: Graph, at: Configuration, numbers: Sequence[int]) -> int:
    """How many of a loop's screws, those of these coordinates, are independent."""
    screws = at.screws[:, list(numbers)] * coordinate_scales(graph)[list(numbers)]
    screws[3:] /= graph.length
    return int(np.linalg.matrix_rank(screws, tol=1e-7))


def functional(at: Configuration, row: Row) -> FloatArray:
    """The row as a functional on the relative twist (w, v at the base's origin), once closed."""
    wrench = row.wrench(at.ends[row.cut], at.axes.__getitem__)
    return np.array([*wrench.moment, *wrench.force], dtype=float)


def closure_system(
    graph: Graph, tree: Tree, at: Configuration, signs: Mapping[int, FloatArray]
) -> tuple[FloatArray, FloatArray, list[Row]]:
    """All canonical rows, scaled to one by the characteristic length: gaps, Jacobian, rows."""
    rows = all_rows(graph, tree)
    gaps = np.zeros(len(rows))
    jacobian = np.zeros((len(rows), len(graph.coordinates)))
    for i, row in enumerate(rows):
        end, sides = at.ends[row.cut], signs[row.cut]
        scale = row.per_length(graph) / graph.length
        gaps[i] = scale * as_float(row.value(at.circuits, end))
        moment, force, parent = row.wrench(end, at.axes.__getitem__)
        relative = np.array([*moment, *force], dtype=float)
        jacobian[i] = scale * (relative @ at.screws) * sides
        if parent != ZERO:
            behind = [k for k in at.circuits.path[end.parent] if sides[k]]
            turning = np.array(parent, dtype=float) @ at.screws[:3, behind]
            jacobian[i, behind] -= scale * turning * sides[behind]
    return gaps, jacobian, rows


def coordinate_scales(graph: Graph) -> FloatArray:
    """Coordinates in units of like size: radians, and slides in characteristic lengths."""
    return np.array([1.0 if c.angle else graph.length for c in graph.coordinates])


def close(
    graph: Graph, tree: Tree, start: FloatArray, held: Sequence[int] = (), steps: int = 200
) -> tuple[Configuration, float]:
    """Close the loops from `start`, holding some coordinates: damped Gauss-Newton, least motion.

    steps: at most so many, of large mechanisms fewer. Returns the configuration reached and the
    norm of its scaled gaps, closed or not.
    """
    steps = min(steps, max(20, _WORK // max(1, len(graph.coordinates))))
    with np.errstate(all="ignore"):  # dimensions beyond reason come out as not closed
        return _closed(graph, tree, start, held, steps)


def _closed(
    graph: Graph, tree: Tree, start: FloatArray, held: Sequence[int], steps: int
) -> tuple[Configuration, float]:
    signs = loop_signs(graph, tree)
    scales = coordinate_scales(graph)
    free = [n for n in graph.inside(tree) if n not in set(held)]
    at = configure(graph, tree, start)
    gaps, jacobian, _ = closure_system(graph, tree, at, signs)
    best, damping = float(np.linalg.norm(gaps)), 0.0
    settled = 0
    for _ in range(steps):
        J = jacobian[:, free] * scales[free]
        if damping == 0.0:
            step = -np.linalg.lstsq(J, gaps, rcond=_RANK)[0]
        else:
            step = -np.linalg.solve(J.T @ J + damping * np.eye(len(free)), J.T @ gaps)
        size = float(np.abs(step).max(initial=0.0))
        if best < CLOSED and size > _STRAY:
            break
        q = at.q.copy()
        q[free] += step * scales[free] * min(1.0, 0.5 / size if size else 1.0)
        trial = configure(graph, tree, q)
        gaps_there, jacobian_there, _ = closure_system(graph, tree, trial, signs)
        norm = float(np.linalg.norm(gaps_there))
        if best < CLOSED:  # at round-off already: stop when another step gains nothing
            settled += 1
            if norm >= best or settled > 3:
                break
        if norm < best:
            at, gaps, jacobian, best = trial, gaps_there, jacobian_there, norm
            damping = 0.0 if damping < 1e-9 else damping * 0.2
        elif size < 1e-14 or damping > 1e6:
            break
        else:
            damping = max(4.0 * damping, 1e-6)
    return at, best


def assembled(graph: Graph) -> Configuration:
    """Home, closed at round-off. Raises AssemblyError."""
    held = {graph.coordinates[k].joint for k in graph.home}
    guessed = {graph.coordinates[k].joint for k in (*graph.guess, *graph.stated)}
    return home_of(graph, graph.tree(first=held, second=guessed))


def home_of(graph: Graph, tree: Tree) -> Configuration:
    """The home configuration: closed at round-off, on the branch nearest the guess.

    Raises AssemblyError naming the joint with the largest gap, in mm and degrees.
    """
    start = np.zeros(len(graph.coordinates))
    for values in (graph.guess, graph.stated, graph.home):
        for k, value in values.items():
            start[k] = value
    in_tree = set(graph.inside(tree))
    held = [k for k in graph.home if k in in_tree]
    at, norm = min(
        (close(graph, tree, begin, held) for begin in _starts(graph, start)),
        key=lambda found: (
            found[1] > CLOSED or bool(_opposed(tree, found[0])),
            _distance(graph, found[0].q, start),
        ),
    )
    at, norm = _shaken(graph, tree, start, held, at, norm)
    missed = [
        (abs(at.q[k] - value), k)
        for k, value in graph.home.items()
        if k not in in_tree and abs(at.q[k] - value) > 1e-9
    ]
    if missed:
        miss, k = max(missed)
        raise AssemblyError(
            f"{graph.mechanism.where}: home.{graph.coordinates[k].name} = {graph.home[k]:g} cannot "
            f"be held: its joint closes a loop of joints held at home (off by {miss:.3g})"
        )
    if norm > CLOSED:
        gaps = [(*joint_gap(at, k), graph.joints[k].name) for k in tree.cuts]
        mm, degrees, name = max(gaps, key=lambda g: g[0] / graph.length / 1e3 + math.radians(g[1]))
        raise AssemblyError(
            f"{graph.mechanism.where}: cannot be assembled from its guess; the largest gap left is "
            f"at joint {name}: {mm:.6g} mm and {degrees:.6g} degrees (a better [guess] may help, "
            "or these dimensions do not close at all)"
        )
    at.q[np.abs(at.q) < _NOTHING] = 0.0
    opposed = _opposed(tree, at)
    if opposed:
        raise AssemblyError(
            f"{graph.mechanism.where}: joint {graph.joints[opposed[0]].name} closes with its axes "
            "opposed; turn the axis on one of its bodies round, or mend the guess"
        )
    return at


def _shaken(
    graph: Graph,
    tree: Tree,
    start: FloatArray,
    held: Sequence[int],
    at: Configuration,
    norm: float,
) -> tuple[Configuration, float]:
    """A better configuration from starts around the guess, if the one found is open or has axes
    that point against each other. (A guess may be stationary, at right angles to what is wanted.)

    Where loops are closed but for such axes, one of these loops at a time starts anew.
    """
    rng = np.random.default_rng(0)
    angles = np.array([c.angle for c in graph.coordinates])
    signs = loop_signs(graph, tree)
    for number, size in enumerate(_SHAKES):
        wrong = _opposed(tree, at)
        if norm <= CLOSED and not wrong:
            break
        if norm > CLOSED and number > _TRIES:
            break
        reach = np.where(angles, size, min(size, 0.3))
        shake = reach * rng.uniform(-1, 1, len(start)) * coordinate_scales(graph)
        shake[held] = 0.0
        begin = start
        if norm <= CLOSED:
            begin = at.q
            shake[signs[wrong[number % len(wrong)]] == 0] = 0.0
        other, there = close(graph, tree, begin + shake, held)
        closed = there <= CLOSED and len(_opposed(tree, other)) < len(wrong)
        if closed or (norm > CLOSED and there < norm):
            at, norm = other, there
    return at, norm


def _opposed(tree: Tree, at: Configuration) -> list[int]:
    """Cut joints whose rows vanish although axes of them point against each other."""
    return [
        cut
        for cut in tree.cuts
        if any(as_float(cosine) < 0 for cosine in cosines(at.circuits, cut, at.ends[cut]))
    ]


def _starts(graph: Graph, start: FloatArray) -> list[FloatArray]:
    """The guess; and the guess with the platform, where its pose is not given, put where the
    joints' guess leads.
    """
    if graph.platform is None:
        return [start]
    through_joints = configure(graph, graph.tree(last=[graph.platform]), start)
    led = start.copy()
    for k in graph.joints[graph.platform].coordinates:
        if k not in {**graph.guess, **graph.stated, **graph.home}:
            led[k] = through_joints.q[k]
    return [start] if np.array_equal(led, start) else [start, led]


def _distance(graph: Graph, q: FloatArray, start: FloatArray) -> float:
    """How far a configuration is from the guess; what is not given counts little."""
    given = {**graph.guess, **graph.stated, **graph.home}
    away = (q - start) / coordinate_scales(graph)
    total = 0.0
    for k, coordinate in enumerate(graph.coordinates):
        if coordinate.joint == graph.platform and k not in given:
            continue
        step = away[k]
        if coordinate.angle:
            step -= 2 * np.pi * np.round(step / (2 * np.pi))
        total += (1.0 if k in given else 1e-3) * float(step) ** 2
    return total


def joint_gap(at: Configuration, cut: int) -> tuple[float, float]:
    """How far a cut joint is from closing: millimetres, degrees."""
    graph = at.circuits.graph
    end = at.ends[cut]
    mm = degrees = 0.0
    for row in canonical_rows(graph.joints[cut], cut):
        gap = as_float(row.value(at.circuits, end))
        if isinstance(row, Perpendicular):
            degrees = math.hypot(degrees, math.degrees(math.asin(max(-1.0, min(1.0, gap)))))
        else:
            mm = math.hypot(mm, 1e3 * gap * row.per_length(graph))
    return mm, degrees


def freedoms(
    graph: Graph,
    tree: Tree,
    at: Configuration,
    rank: int | None = None,
) -> FloatArray:
    """The motions the closed loops allow, (n, mobility).

    They give the rate of every coordinate, those of cut joints too, in scaled units. rank: of all
    closure rows; found if not given.
    """
    signs = loop_signs(graph, tree)
    scales = coordinate_scales(graph)
    _, jacobian, _ = closure_system(graph, tree, at, signs)
    inside = graph.inside(tree)
    J = jacobian[:, inside] * scales[inside]
    _, sizes, right = np.linalg.svd(J, full_matrices=True) if J.size else (None, np.zeros(0), None)
    if rank is None:
        rank = int((sizes > _RANK * sizes.max(initial=1.0)).sum())
    kernel = right[rank:].T if right is not None else np.eye(len(inside))
    motions = np.zeros((len(graph.coordinates), kernel.shape[1]))
    motions[inside] = kernel * scales[inside][:, None]
    for cut in tree.cuts:
        relative = (at.screws * signs[cut]) @ motions
        own = list(graph.joints[cut].coordinates)
        if own:
            motions[own] = np.linalg.lstsq(at.screws[:, own], relative, rcond=None)[0]
    return motions


def is_idle(at: Configuration, motions: FloatArray) -> bool:
    """Whether these motions (scaled) leave platform and actuators alone and only spin bodies: legs
    between two spherical joints, or a crossbar on a hinge and on balls, about a line on which
    all joints of theirs lie.
    """
    graph = at.circuits.graph
    moved = {k for k in range(len(motions)) if np.abs(motions[k]).max(initial=0.0) > _RESTS}
    joints = [graph.joints[j] for j in {graph.coordinates[k].joint for k in moved}]
    if any(joint.actuated or joint.name == "platform" for joint in joints):
        return False
    hinges = [joint for joint in joints if joint.kind not in ("spherical", "cylindrical")]
    if not hinges:
        return True
    on = [body for joint in graph.joints for body in (joint.parent, joint.child)]
    carried = all(on.count(body) > 1 for j in hinges for body in (j.parent, j.child) if body)
    if not carried or any(joint.kind != "revolute" for joint in hinges):
        return False
    rates = motions * coordinate_scales(graph)[:, None]
    return not any(
        np.abs(_velocities(at.circuits, body, end.p, rates)).max() > _RESTS * graph.length
        for joint, ends in zip(graph.joints, at.ends, strict=True)
        for body, end in ((joint.parent, ends.F), (joint.child, ends.M))
    )


def _velocities(circuits: Circuits, body: int, point: Vector, rates: FloatArray) -> FloatArray:
    """Of a point on a body, (3, n), for n sets of rates."""
    total = np.zeros((3, rates.shape[1]))
    for k, (axis, sign) in circuits.axes(body).items():
        total += np.outer(as_array(pair_velocity(axis, sign, point)[1]), rates[k])
    return total


def holders(motions: FloatArray) -> list[int]:
    """One coordinate for each motion that, held, stops it: the largest, one after the other."""
    left = motions.copy()
    held: list[int] = []
    for _ in range(motions.shape[1]):
        k = int(np.argmax(np.linalg.norm(left, axis=1)))
        held.append(k)
        direction = left[k] / np.linalg.norm(left[k])
        left -= np.outer(left @ direction, direction)
    return held


def neighbours(
    graph: Graph, tree: Tree, home: Configuration, count: int, size: float = 0.08, seed: int = 1
) -> list[Configuration]:
    """Closed configurations a random step away from home, for what holds in general.

    Fewer than `count` where the loops will not close again near home.
    """
    rng = np.random.default_rng(seed)
    found: list[Configuration] = []
    motions = freedoms(graph, tree, home)
    if motions.shape[1] == 0:
        return [home] * count
    for attempt in range(4 * count):
        if len(found) == count or attempt >= count + 3 * len(found):
            break  # all there, or all but hopeless
        mix = rng.normal(size=motions.shape[1])
        move = motions @ mix
        move *= size * rng.uniform(0.3, 1.0) / np.abs(move / coordinate_scales(graph)).max()
        at, norm = close(graph, tree, home.q + move, steps=_NEARBY_STEPS)
        if norm < CLOSED:
            found.append(at)
    return found
