"""Random closed mechanisms for hypothesis, which close by construction.

Every body gets a pose at home, every joint a frame in the world; the joint's frame on the one body
is that frame as the body sees it, its frame on the other the same after the joint's own motion at
known home values. Nothing here comes from parakin's recursion: `closed_by` walks a mechanism's
joints with SciPy's rotations, and says how far coordinates are from closing it.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from parakin import Body, Frame, Joint, Mechanism
from parakin.kinematics.assembly import assembled
from parakin.kinematics.configuration import coordinate_scales
from parakin.kinematics.free_motions import free_motions
from parakin.model.evaluation import graph_of
from parakin.model.mechanism import Kind, Platform

Array = NDArray[np.float64]

# Coordinates of each kind: turns "r" about and slides "p" along the moving axes.
MOVES: dict[str, tuple[str, ...]] = {
    "revolute": ("rz",),
    "prismatic": ("pz",),
    "cylindrical": ("rz", "pz"),
    "helical": ("hz",),
    "universal": ("rz", "rx"),
    "spherical": ("rx", "ry", "rz"),
    "planar": ("px", "py", "rz"),
    "rod": (),
    "free": ("px", "py", "pz", "rx", "ry", "rz"),
}
FREEDOM = {kind: len(moves) for kind, moves in MOVES.items()} | {"rod": 5}
UNIVERSAL = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
STYLES = ("generic", "generic", "round", "parallel", "concurrent")


@dataclass(frozen=True)
class Pose:
    """Rotation matrices (..., 3, 3) and places (..., 3)."""

    R: Array
    p: Array

    def __matmul__(self, other: Pose) -> Pose:
        return Pose(self.R @ other.R, self.p + np.einsum("...ij,...j->...i", self.R, other.p))

    def inverse(self) -> Pose:
        back = np.swapaxes(self.R, -1, -2)
        return Pose(back, -np.einsum("...ij,...j->...i", back, self.p))


def moved(kind: str, q: Array, pitch: float = 0.0) -> Pose:
    """The child's frame as the parent's sees it; q (k, ...): a value for each coordinate."""
    shape = q.shape[1:]
    pose = Pose(np.broadcast_to(np.eye(3), (*shape, 3, 3)), np.zeros((*shape, 3)))
    for move, value in zip(MOVES[kind], q, strict=True):
        axis = np.eye(3)["xyz".index(move[1])]
        along = value if move[0] == "p" else value * pitch / (2 * math.pi)
        turn = np.eye(3)
        if move[0] != "p":
            flat = Rotation.from_rotvec(np.multiply.outer(np.ravel(value), axis))
            turn = flat.as_matrix().reshape(*shape, 3, 3)
        place = np.multiply.outer(along, axis) if move[0] != "r" else np.zeros((*shape, 3))
        pose = pose @ Pose(np.broadcast_to(turn, (*shape, 3, 3)), place)
    return Pose(pose.R @ UNIVERSAL, pose.p) if kind == "universal" else pose


def names_of(joint: Joint) -> list[str]:
    n = len(MOVES[joint.kind])
    return [joint.name] if n == 1 else [f"{joint.name}.{k}" for k in range(1, n + 1)]


def closed_by(mechanism: Mechanism, values: Mapping[str, Array]) -> Array:
    """The largest gap (m, or rad nearly) that these coordinates leave at any joint, per sample."""
    shape = next(iter(values.values())).shape
    placed = {"base": Pose(np.broadcast_to(np.eye(3), (*shape, 3, 3)), np.zeros((*shape, 3)))}
    waiting = list(mechanism.joints)
    worst = np.zeros(shape)
    while waiting:
        ready = (
            j
            for rods in (False, True)
            for j in waiting
            if (j.kind == "rod") == rods and (rods or {j.parent, j.child} & set(placed))
        )
        joint = next(ready)
        waiting.remove(joint)
        F, M = (_framed(f) for f in (joint.on_parent, joint.on_child))
        if joint.kind == "rod":
            gap = (placed[joint.parent] @ F).p - (placed[joint.child] @ M).p
            assert isinstance(joint.length, float)
            worst = np.fmax(worst, np.abs(np.linalg.norm(gap, axis=-1) - joint.length))
            continue
        q = np.array([values[name] for name in names_of(joint)])
        across = F @ moved(joint.kind, q, float(joint.pitch or 0.0)) @ M.inverse()
        if joint.parent not in placed:
            placed[joint.parent] = placed[joint.child] @ across.inverse()
        elif joint.child not in placed:
            placed[joint.child] = placed[joint.parent] @ across
        else:
            there, here = placed[joint.child], placed[joint.parent] @ across
            for gap in (there.R - here.R, there.p - here.p):
                worst = np.fmax(worst, np.abs(gap).reshape(*shape, -1).max(axis=-1))
    return worst


def _framed(frame: Frame) -> Pose:
    assert frame.axis is not None
    assert frame.x is not None
    z, x = np.array(frame.axis, dtype=float), np.array(frame.x, dtype=float)
    return Pose(np.column_stack([x, np.cross(z, x), z]), np.array(frame.at, dtype=float))


def _frame(pose: Pose) -> Frame:
    return Frame(
        at=tuple(pose.p.tolist()), axis=tuple(pose.R[:, 2].tolist()), x=tuple(pose.R[:, 0].tolist())
    )


@dataclass(frozen=True)
class Example:
    """A mechanism, its home by construction, and coordinates to drive (`other`: to drive next)."""

    mechanism: Mechanism
    home: Mapping[str, float]
    driven: tuple[str, ...]
    other: tuple[str, ...]
    by: tuple[float, ...]
    mobility: int
    bad: bool


@st.composite
def _links(draw: st.DrawFn) -> list[tuple[int, int]]:
    """Bodies joined, by number: one loop, or two that share links."""
    n = draw(st.integers(4, 6))
    links = [(k, (k + 1) % n) for k in range(n)]
    if draw(st.integers(0, 2)) == 0:
        more = draw(st.integers(2, 4))
        ends = draw(st.lists(st.integers(0, n - 1), min_size=2, max_size=2, unique=True))
        chain = [ends[0], *range(n, n + more - 1), ends[1]]
        links += list(itertools.pairwise(chain))
    return links


def _kinds(rng: np.random.Generator, count: int, loops: int, surplus: int) -> list[Kind]:
    """As many random kinds, their freedoms adding up to those of the loops and a surplus."""
    usual: list[Kind] = ["revolute", "prismatic", "cylindrical", "universal", "spherical"]
    rare: list[Kind] = ["helical", "planar", "rod"]
    pool = usual * 3 + rare
    wanted = 6 * loops + surplus
    kinds = [pool[rng.integers(len(pool))] for _ in range(count)]
    for _ in range(2000):
        total = sum(FREEDOM[k] for k in kinds)
        if total == wanted and kinds.count("rod") < 2:
            break
        k = int(rng.integers(count))
        kind = pool[rng.integers(len(pool))]
        change = FREEDOM[kind] - FREEDOM[kinds[k]]
        if abs(total + change - wanted) <= abs(total - wanted) or rng.random() < 0.1:
            kinds[k] = kind
    return kinds


def _world_frame(rng: np.random.Generator, style: str) -> Pose:
    p = rng.uniform(-1, 1, 3)
    R = Rotation.random(random_state=rng).as_matrix()
    if style == "round":
        p = np.round(2 * p) / 2
        quarter = rng.integers(0, 4, 3) * (math.pi / 2)
        R = np.round(Rotation.from_euler("XYZ", quarter).as_matrix())
    elif style == "parallel":
        R = Rotation.from_euler("Z", rng.uniform(-3, 3)).as_matrix()
    elif style == "concurrent":
        p = np.zeros(3)
    return Pose(R, p)


@st.composite
def examples(draw: st.DrawFn) -> Example:
    links = draw(_links())
    bodies = 1 + max(b for link in links for b in link)
    style = draw(st.sampled_from(STYLES))
    surplus = draw(st.sampled_from((1, 1, 1, 2, 2, 3, 0)))
    with_platform = draw(st.integers(0, 3)) == 0
    at_zero = draw(st.booleans())
    bad = draw(st.integers(0, 7)) == 0
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    kinds = _kinds(rng, len(links), len(links) - bodies + 1, surplus)
    poses = [Pose(np.eye(3), np.zeros(3))]
    for _ in range(1, bodies):
        lean = rng.uniform(-1, 1, 3) * (2.5, 1.2, 2.5)
        R = np.eye(3) if style == "round" else Rotation.from_euler("XYZ", lean).as_matrix()
        poses.append(Pose(R, np.round(rng.uniform(-1, 1, 3), 1)))
    name = ["base", *(f"b{k}" for k in range(1, bodies))]
    joints: list[Joint] = []
    home: dict[str, float] = {}
    for k, ((a, b), kind) in enumerate(zip(links, kinds, strict=True), start=1):
        parent, child = (a, b) if rng.random() < 0.7 else (b, a)
        F = _world_frame(rng, style)
        pitch = float(rng.choice([-1, 1]) * rng.uniform(0.05, 0.5)) if kind == "helical" else None
        q = np.zeros(FREEDOM[kind]) if at_zero else rng.uniform(-1, 1, FREEDOM[kind])
        length = None
        if kind == "rod":
            q = q[:0]
            far = _world_frame(rng, style)
            length = float(np.linalg.norm(far.p - F.p))
            if length < 0.1:
                far = Pose(far.R, far.p + np.array([0.0, 0.6, 0.8]))
                length = float(np.linalg.norm(far.p - F.p))
            M = far
        else:
            M = F @ moved(kind, q, pitch or 0.0)
        joint = Joint(
            name=f"J{k}",
            kind=kind,
            parent=name[parent],
            child=name[child],
            on_parent=_frame(poses[parent].inverse() @ F),
            on_child=_frame(poses[child].inverse() @ M),
            pitch=pitch,
            length=length,
        )
        joints.append(joint)
        home |= dict(zip(names_of(joint), q.tolist(), strict=True))
    platform = None
    if with_platform:
        carried = int(rng.integers(1, bodies))
        platform = Platform(body=name[carried])
        angles = Rotation.from_matrix(poses[carried].R).as_euler("XYZ")
        labels = ("x", "y", "z", "roll", "pitch", "yaw")
        values = [*poses[carried].p.tolist(), *angles.tolist()]
        home |= {f"platform.{n}": v for n, v in zip(labels, values, strict=True)}
    mechanism = Mechanism(
        name="random",
        notes=f"{style}, {', '.join(kinds)}",
        bodies=tuple(Body(name=n) for n in name[1:]),
        joints=tuple(joints),
        platform=platform,
        guess=home,
    )
    driven, mobility = _drives(mechanism, rng)
    other, _ = _drives(mechanism, rng)
    if bad and home:
        size = max(1, len(driven) + int(rng.integers(-1, 2)))
        driven = tuple(str(n) for n in rng.permutation(list(home))[:size])
    by = tuple(float(s) for s in rng.uniform(0.05, 0.2, len(driven)) * rng.choice([-1, 1]))
    return Example(mechanism, home, driven, other, by, mobility, bad)


def _drives(mechanism: Mechanism, rng: np.random.Generator) -> tuple[tuple[str, ...], int]:
    """Coordinates that determine the motion at home, as many as its mobility; else none.

    Picked one after the other, each among those that move well when those before are held.
    """
    graph = graph_of(mechanism)
    home = assembled(graph)
    motions = free_motions(graph, graph.tree(), home)
    left = motions / coordinate_scales(graph)[:, None]
    picked: list[int] = []
    for _ in range(motions.shape[1]):
        sizes = np.linalg.norm(left, axis=1)
        k = int(rng.choice(np.flatnonzero(sizes > 0.3 * sizes.max())))
        picked.append(k)
        direction = left[k] / sizes[k]
        left = left - np.outer(left @ direction, direction)
    return tuple(graph.coordinates[k].name for k in picked), motions.shape[1]
