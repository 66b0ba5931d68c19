"""An oracle of its own: what closes, how far a slow hand gets, what coarse sampling makes of it.

Nothing of the engine is used but a mechanism's data: joint frames in numbers, names, home. Run
`python tests/oracles/oracle.py SEED ...` for a short campaign on these seeds, with `--long` for a
long one (some minutes a seed), with `--only NAME ...` on some mechanisms of the catalogue.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from random_mechanisms import MOVES, UNIVERSAL, Pose

import parakin
from parakin.algebra.spatial import Pose as Placement
from parakin.model.joints import GraphJoint
from parakin.motion.laws import Law, from_laws, sines
from parakin.motion.motion import Motion

Array = NDArray[np.float64]
BALLS = ("spherical", "free")
IDENTITY_POSE = Pose(np.eye(3), np.zeros(3))


def moves_of(solver: parakin.Solver, joint: GraphJoint) -> list[tuple[str, int, int]]:
    """A joint's slides "p", turns "r" and screws "h", each with its axis and its coordinate."""
    moves: Sequence[str] = MOVES.get(joint.kind, ())
    platform = solver.mechanism.platform
    if joint.name == "platform" and joint.kind == "free" and platform is not None:
        moves = [*moves[:3], *(f"r{axis}" for _, axis in platform.angles)]
    along = zip(moves, joint.coordinates, strict=True)
    return [(move[0], "xyz".index(move[1]), k) for move, k in along]


def turned(axis: int, angle: Array | float) -> Array:
    """Rotations (..., 3, 3) about an axis of the frame."""
    b, c = (axis + 1) % 3, (axis + 2) % 3
    R: Array = np.zeros((*np.shape(angle), 3, 3))
    R[..., axis, axis] = 1.0
    R[..., b, b] = R[..., c, c] = np.cos(angle)
    R[..., c, b] = np.sin(angle)
    R[..., b, c] = -np.sin(angle)
    return R


def framed(place: Placement) -> Pose:
    return Pose(np.array(place.R, dtype=np.float64), np.array(place.p, dtype=np.float64))


def across(solver: parakin.Solver, joint: GraphJoint, q: Array) -> Pose:
    """The child's frame M as the parent's F sees it, for all coordinates (k, n)."""
    R, p = np.broadcast_to(np.eye(3), (q.shape[1], 3, 3)), np.zeros((q.shape[1], 3))
    for move, axis, k in moves_of(solver, joint):
        way = {"p": 1.0, "r": 0.0, "h": joint.pairs[0].pitch}[move]
        p = p + R[:, :, axis] * (way * q[k])[:, None]
        R = R if move == "p" else R @ turned(axis, q[k])
    return Pose(R @ UNIVERSAL if joint.kind == "universal" else R, p)


def ordered(solver: parakin.Solver) -> Iterator[tuple[GraphJoint, bool]]:
    """All joints from the base outwards, rods last, and whether each closes a loop."""
    waiting, seen = list(solver.graph.joints), {0}
    while waiting:
        firm = [j for j in waiting if j.kind != "rod" and {j.parent, j.child} & seen]
        joint = (firm or [j for j in waiting if {j.parent, j.child} <= seen])[0]
        waiting.remove(joint)
        yield joint, {joint.parent, joint.child} <= seen
        seen |= {joint.parent, joint.child}


def offsets(solver: parakin.Solver) -> Array:
    """What coordinates counted from home have there, as their joints count; of others zero."""
    names = [c.name for c in solver.graph.coordinates]
    at = [float(solver.plan.home[k]) - solver.home[n] for k, n in enumerate(names)]
    numbers: Array = np.array(at)
    return numbers


def units(solver: parakin.Solver) -> Array:
    """Of all coordinates: 1 for angles, else the characteristic length."""
    return np.array([1.0 if c.angle else solver.graph.length for c in solver.graph.coordinates])


def counted(solver: parakin.Solver, position: Array) -> Array:
    """All coordinates (k, n) as their joints count them, from positions as reported."""
    rows = [solver.coordinates.index(c.name) for c in solver.graph.coordinates]
    q: Array = np.asarray(position, dtype=float)[rows] + offsets(solver)[:, None]
    return q


def placed(solver: parakin.Solver, position: Array) -> tuple[dict[int, Pose], Array, Array]:
    """Poses of bodies; worst gaps of points [m] and of rotation matrix entries, by sample."""
    q = counted(solver, position)
    n = q.shape[1]
    poses = {0: Pose(np.broadcast_to(np.eye(3), (n, 3, 3)), np.zeros((n, 3)))}
    far, skew = np.zeros(n), np.zeros(n)
    for joint, closing in ordered(solver):
        F, M = framed(joint.F), framed(joint.M)
        if joint.kind == "rod":
            between = (poses[joint.parent] @ F).p - (poses[joint.child] @ M).p
            far = np.maximum(far, np.abs(np.linalg.norm(between, axis=1) - joint.length))
            continue
        X = F @ across(solver, joint, q) @ M.inverse()
        if joint.parent not in poses:
            poses[joint.parent] = poses[joint.child] @ X.inverse()
            continue
        there = poses[joint.parent] @ X
        if closing:
            here = poses[joint.child]
            skew = np.maximum(skew, np.abs(there.R - here.R).max(axis=(1, 2)))
            far = np.maximum(far, np.abs(there.p - here.p).max(axis=1))
        poses[joint.child] = there
    return poses, far, skew


def gaps(solver: parakin.Solver, position: Array) -> tuple[Array, Array]:
    """Worst gap of points [m] and of rotation matrix entries of each sample (column)."""
    return placed(solver, position)[1:]


def closes(solver: parakin.Solver, position: Array) -> NDArray[np.bool_]:
    """Which samples (columns) close, to round-off; NaN does not."""
    far, skew = gaps(solver, position)
    good: NDArray[np.bool_] = (far <= 1e-9 * solver.graph.length) & (skew <= 1e-8)
    return good


# ---- a slow hand


def exponential(w: Array) -> Array:
    """The rotation by a vector."""
    angle = float(np.linalg.norm(w))
    K = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
    half = np.sinc(angle / (2 * np.pi))
    R: Array = np.eye(3) + np.sinc(angle / np.pi) * K + 0.5 * half * half * (K @ K)
    return R


def logarithm(R: Array) -> Array:
    """The vector of a rotation by less than half a turn."""
    w = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    s = float(np.linalg.norm(w))
    angle = np.arctan2(s, 0.5 * (np.trace(R) - 1.0))
    vector: Array = w * (angle / s if s > 1e-12 else 1.0)
    return vector


@dataclass
class State:
    """Coordinates as joints count them, and orientations of joints of three turns."""

    q: Array
    balls: dict[str, Array]


class Hand:
    """All loops of a mechanism, by all joint coordinates but those driven.

    Three turns none of which is driven count as increments of the orientation, R exp(delta), so
    that they are never locked.
    """

    def __init__(self, solver: parakin.Solver) -> None:
        self.solver, joints = solver, solver.graph.joints
        self.order = list(ordered(solver))
        self.moves = {j.name: moves_of(solver, j) for j in joints}
        names = [c.name for c in solver.graph.coordinates]
        self.driven = [names.index(name) for name in solver.driven]
        self.free = [k for k in range(len(names)) if k not in self.driven]
        self.units, self.offset = units(solver), offsets(solver)
        q = np.array([float(solver.plan.home[k]) for k in range(len(names))])
        self.turns = {
            j.name: list(j.coordinates[-3:])
            for j in joints
            if j.kind in BALLS and not set(j.coordinates[-3:]) & set(self.driven)
        }
        balls = {}
        for name in self.turns:
            a, b, c = (turned(axis, q[k]) for _, axis, k in self.moves[name][-3:])
            balls[name] = a @ b @ c
        self.home = State(q, balls)
        sizes = np.linalg.svd(self.loops(self.home)[1][:, self.free], compute_uv=False)
        self.rank = int((sizes > 1e-7 * sizes.max(initial=1e-300)).sum())

    def moved(self, state: State, step: Array) -> State:
        """step: of all coordinates, in units; of three turns, the increment's vector."""
        q, balls = state.q + step * self.units, dict(state.balls)
        for name, turns in self.turns.items():
            balls[name], q[turns] = balls[name] @ exponential(step[turns]), 0.0
        return State(q, balls)

    def screws(self, joint: GraphJoint, F: Pose, state: State) -> tuple[Pose, Array]:
        """M in the world, and the twists (6, all) of its coordinates, at the world's origin."""
        R, p = F.R, F.p
        S: Array = np.zeros((6, len(state.q)))
        for move, number, k in self.moves[joint.name]:
            axis = R[:, number]
            if move == "p":
                S[3:, k] = axis
                p = p + axis * state.q[k]
            elif joint.name not in self.turns:
                pitch = joint.pairs[0].pitch if move == "h" else 0.0
                S[:3, k], S[3:, k] = axis, np.cross(p, axis) + pitch * axis
                p, R = p + axis * (pitch * state.q[k]), R @ turned(number, state.q[k])
        if joint.name in self.turns:
            turns, R = self.turns[joint.name], R @ state.balls[joint.name]
            S[:3, turns], S[3:, turns] = R, np.cross(p, R.T).T
        return Pose(R @ UNIVERSAL if joint.kind == "universal" else R, p), S * self.units

    def loops(self, state: State) -> tuple[Array, Array, dict[int, tuple[Pose, Array]]]:
        """Gaps of all loops, their Jacobian by all coordinates, and bodies with their twists.

        Lengths in characteristic lengths, coordinates in units.
        """
        length, count = self.solver.graph.length, len(state.q)
        bodies = {0: (IDENTITY_POSE, np.zeros((6, count)))}
        rest, rows = [np.zeros(0)], [np.zeros((0, count))]
        for joint, closing in self.order:
            F, M = framed(joint.F), framed(joint.M)
            if joint.parent not in bodies:
                child, T = bodies[joint.child]
                X = F @ self.screws(joint, IDENTITY_POSE, state)[0] @ M.inverse()
                parent = child @ X.inverse()
                bodies[joint.parent] = (parent, T - self.screws(joint, parent @ F, state)[1])
                continue
            parent, T = bodies[joint.parent]
            if joint.kind == "rod":
                a, b = (parent @ F).p, (bodies[joint.child][0] @ M).p
                D, size = bodies[joint.child][1], float(np.linalg.norm(a - b))
                speed = T[3:] + np.cross(T[:3].T, a).T - D[3:] - np.cross(D[:3].T, b).T
                rest.append(np.array([(size - joint.length) / length]))
                rows.append(((a - b) / size @ speed)[None, :] / length)
                continue
            end, S = self.screws(joint, parent @ F, state)
            there = end @ M.inverse()
            if closing:
                here, D = bodies[joint.child][0], bodies[joint.child][1] - T - S
                x = (here @ M).p
                rest += [logarithm(here.R @ there.R.T), (x - end.p) / length]
                rows += [D[:3], (D[3:] + np.cross(D[:3].T, x).T) / length]
            else:
                bodies[joint.child] = (there, T + S)
        return np.concatenate(rest), np.concatenate(rows), bodies

    def split(self, state: State) -> tuple[Array, Array, Array, Array, Array, float]:
        """Gaps, Jacobian by driven coordinates, that by the others as U, s, V of its rank, and its
        least singular value in proportion to the size of the whole.
        """
        rest, J, _ = self.loops(state)
        U, s, Vt = np.linalg.svd(J[:, self.free], full_matrices=False)
        r = self.rank
        least = float(s[r - 1] / np.linalg.norm(J, 2)) if r else 1.0
        return rest, J[:, self.driven], U[:, :r], s[:r], Vt[:r].T, least

    def corrected(self, state: State) -> tuple[State, float] | None:
        """The closed state nearby, and how far it was away; none where Newton does not settle."""
        total = np.zeros(len(self.free))
        for _ in range(7):
            rest, _, U, s, V, _ = self.split(state)
            if np.abs(rest).max(initial=0.0) < 1e-13 * (10 + np.abs(state.q).max()):
                return state, float(np.linalg.norm(total))
            step = np.zeros(len(state.q))
            with np.errstate(all="ignore"):
                step[self.free] = -V @ ((U.T @ rest) / s)
            if not np.abs(step).max() < 0.5:
                return None
            total += step[self.free]
            state = self.moved(state, step)
        return None


@dataclass(frozen=True)
class Reached:
    """How far along its path a hand gets, and how singular the mechanism is there.

    `least`: the least singular value of the Jacobian by coordinates not driven, in proportion to
    the largest of all, idle freedoms left out; `lowest` on the way. `bodies`, `values`: where the
    hand stands, but for what idle freedoms and undefined angles move.
    """

    part: float
    least: float
    bodies: Mapping[int, Pose]
    values: Mapping[str, float]
    lowest: float

    @property
    def singular(self) -> bool:
        return self.least < 1e-3


def reach(
    solver: parakin.Solver,
    path: Callable[[float], Array],
    *,
    tiny: float = 1e-9,
    widest: float = 0.1,
) -> Reached:
    """Go from home along driven values path(part), part from 0 to 1, until no more can be done.

    Steps shrink before singularities, so that one is never stepped over: the hand stops at it.
    widest: of a step, in units; more where coordinates are large.
    """
    hand = Hand(solver)
    offset = hand.offset[hand.driven]
    begun = hand.corrected(hand.home)
    assert begun is not None, "home is open"
    state, part, size, slope = begun[0], 0.0, 1e-4, 0.0
    _, Jd, U, s, V, least = hand.split(state)
    lowest = least
    while part < 1.0 and size > tiny and least > 1e-7:
        h = min(size, 1.0 - part, 0.01)
        if slope:
            h = min(h, 0.3 * least / abs(slope))
        size, target = h, (part + h if h < 1.0 - part else 1.0)
        if h < tiny < 1.0 - part:
            break
        step = np.zeros(len(state.q))
        driven = (path(target) + offset - state.q[hand.driven]) / hand.units[hand.driven]
        step[hand.driven] = driven
        step[hand.free] = -V @ ((U.T @ (Jd @ driven)) / s)
        way, bulk = float(np.linalg.norm(step)), float(np.abs(state.q / hand.units).max())
        found = hand.corrected(hand.moved(state, step)) if way < widest * (1.0 + bulk) else None
        if found is not None and found[1] <= 0.1 * way + 1e-9:
            _, Jd_, U_, s_, V_, least_ = hand.split(found[0])
            same = np.linalg.det(U.T @ U_) * np.linalg.det(V.T @ V_) > 0.0
            if same and 0.6 * least < least_ < 1.7 * least:
                slope = (least_ - least) / h
                state, part, least, Jd, U, s, V = found[0], target, least_, Jd_, U_, s_, V_
                size, lowest = 2.0 * h, min(lowest, least)
                continue
        size = 0.5 * h
    return _reached(hand, state, part, least, lowest)


def _reached(hand: Hand, state: State, part: float, least: float, lowest: float) -> Reached:
    graph = hand.solver.graph
    _, J, bodies = hand.loops(state)
    idle = np.linalg.svd(J[:, hand.free])[2][hand.rank :].T
    still = {
        k: pose
        for k, (pose, T) in bodies.items()
        if np.abs(T[:, hand.free] @ idle).max(initial=0.0) < 1e-6
    }
    loose = {hand.free[row] for row in np.flatnonzero((np.abs(idle) > 1e-6).any(axis=1))}
    loose |= {k for turns in hand.turns.values() for k in turns}
    values = {
        c.name: float(state.q[k] - hand.offset[k])
        for k, c in enumerate(graph.coordinates)
        if k not in loose
    }
    return Reached(part, least, still, values, lowest)


# ---- coarse against fine


def random_laws(solver: parakin.Solver, rng: np.random.Generator) -> dict[str, Law]:
    """One to three sines for each driven coordinate, small or large, from home."""
    laws = {}
    for name in solver.driven:
        k = [c.name for c in solver.graph.coordinates].index(name)
        unit = 1.0 if solver.graph.coordinates[k].angle else 0.5 * solver.graph.length
        size = unit * 10 ** rng.uniform(np.log10(0.03), np.log10(5.0))
        terms = [
            (size * rng.uniform(-1, 1), rng.uniform(0.2, 3.0), rng.uniform(0, 2 * np.pi))
            for _ in range(rng.integers(1, 4))
        ]
        center = solver.home[name] - sum(a * np.sin(phase) for a, _, phase in terms)
        laws[name] = sines(float(center), terms)
    return laws


def sampled(laws: Mapping[str, Law], n: int) -> Motion:
    return from_laws("random", laws, 1.0, n - 1.0)


def random_motion(solver: parakin.Solver, rng: np.random.Generator, samples: int) -> Motion:
    return sampled(random_laws(solver, rng), samples)


@dataclass(frozen=True)
class Compared:
    """Counts of samples; `first`: the first one that is wrong or missed, else -1."""

    samples: int
    flagged: int
    wrong: int
    missed: int
    first: int


def apart(solver: parakin.Solver, one: Array, other: Array) -> Array:
    """How far samples (columns) are apart, in units; joints of three turns as they stand."""
    graph = solver.graph
    worst: Array = np.zeros(one.shape[1])
    rows = {name: row for row, name in enumerate(solver.coordinates)}
    a, b = counted(solver, one), counted(solver, other)
    loose: list[int] = []
    for joint in (j for j in graph.joints if j.kind in BALLS):
        A, B = across(solver, joint, a).R, across(solver, joint, b).R
        worst = np.fmax(worst, np.abs(A - B).max(axis=(1, 2)))
        loose += joint.coordinates[-3:]
    off = np.delete(np.abs(a - b) / units(solver)[:, None], loose, axis=0)
    worst = np.fmax(worst, off.max(axis=0, initial=0.0))
    for name in graph.cones:
        worst = np.fmax(worst, np.abs(one[rows[name]] - other[rows[name]]))
    return worst


def compared(solver: parakin.Solver, laws: Mapping[str, Law], n: int, fine: int = 6001) -> Compared:
    """The same motion with n samples and with `fine` or more: who is elsewhere, who stops early."""
    times = -(-(fine - 1) // (n - 1))
    coarse, dense = (solver.solve(sampled(laws, m)) for m in (n, (n - 1) * times + 1))
    one = coarse.position.transpose("coordinate", "time").values
    other = dense.position.transpose("coordinate", "time").values[:, ::times]
    good = np.isin(coarse.status.values, (0, 5))
    reached = np.isin(dense.status.values[::times], (0, 5))
    wrong = good & ~reached
    wrong[good & reached] |= apart(solver, one[:, good & reached], other[:, good & reached]) > 1e-6
    missed = ~good & reached
    bad = wrong | missed
    first = int(np.argmax(bad)) if bad.any() else -1
    return Compared(n, int((~good).sum()), int(wrong.sum()), int(missed.sum()), first)


if __name__ == "__main__":
    from test_oracle import main

    main()
