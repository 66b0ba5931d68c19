"""A mechanism as a MuJoCo model, built and compiled by MuJoCo's own MjSpec.

Bodies form a spanning tree from the base that contains the platform's pose. Each coordinate is a
separate hinge or slide with the same name, counted from the joint's zero. Loops close between two
named sites: by `connect` at spherical joints and rods, by `weld` at all others, with their
coordinates on a small extra body. The model's first pose is home. (Base and platform are bodies
like others, since Pinocchio accepts only one body in the world.)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from parakin.algebra.spatial import IDENTITY, ZERO, Matrix, Pose, Vector, as_array
from parakin.arrays import FloatArray
from parakin.errors import not_installed
from parakin.exports.mjcf_dynamics import Weighing
from parakin.files.parsing import parse_xml
from parakin.files.vocabulary import unused
from parakin.kinematics.assembly import assembled
from parakin.kinematics.configuration import Configuration, configure
from parakin.model.graph import Graph
from parakin.model.joints import GraphJoint
from parakin.model.placement import about, vector

_STEP = 0.0005  # of time [s]: heavy platforms on light legs need it short
_CLOSED = (2 * _STEP, 1.0)  # time constant [s] and damping ratio of loops: as stiff as can be
_MET = ("armature", "damping", "stiffness", "frictionloss", "springref")  # by a joint
_UNBOUNDED = 1000.0  # [m or rad]: an open end of a range, as MuJoCo's have two
_GREY, _BLUE, _ORANGE = (0.5, 0.5, 0.5, 1.0), (0.3, 0.5, 0.8, 1.0), (0.9, 0.5, 0.1, 1.0)


def mjcf(graph: Graph) -> str:
    """The model as XML. Raises InputError if MuJoCo is not installed, AssemblyError."""
    try:
        import mujoco
    except ImportError:
        raise not_installed("MJCF", "mujoco") from None
    tree = graph.posed_tree()
    model = _Model(mujoco, graph, configure(graph, tree, assembled(graph).q))
    for number, backwards in tree.steps:
        joint = graph.joints[number]
        near, far = (joint.child, joint.parent) if backwards else (joint.parent, joint.child)
        pose = model.at.pose(far)
        model.carry(joint, graph.bodies[near], graph.bodies[far], pose, backwards)
    for number in tree.cuts:
        model.close(graph.joints[number])
    for body, name in enumerate(graph.bodies):
        model.draw(body, name)
    return model.text()


class _Pair(NamedTuple):
    """A hinge or slide; its axis and a point on it are given in the world, at home."""

    name: str
    slides: bool
    axis: Vector
    point: Vector
    home: float
    limits: tuple[float, float] = (-np.inf, np.inf)


@dataclass
class _Model:
    """An MjSpec as it is built; `placed` are its bodies so far, with their poses at home."""

    mujoco: Any
    graph: Graph
    at: Configuration
    spec: Any = field(init=False)
    placed: dict[str, tuple[Any, Pose[float]]] = field(init=False)
    radius: float = field(init=False)
    taken: set[str] = field(init=False)  # names of bodies
    weighing: Weighing = field(init=False)

    def __post_init__(self) -> None:
        spec = self.spec = self.mujoco.MjSpec()
        spec.modelname = self.graph.mechanism.name
        spec.compiler.degree = False
        spec.option.timestep = _STEP
        spec.option.integrator = self.mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        self.weighing = Weighing(self.mujoco, self.graph, spec)
        base = self.graph.bodies[0]
        self.taken = set(self.graph.bodies)
        body = spec.worldbody.add_body(name=self._named(base))
        self.placed = {base: (body, Pose(IDENTITY, ZERO))}
        spec.visual.headlight.ambient = [0.4, 0.4, 0.4]
        spec.visual.headlight.diffuse = [0.6, 0.6, 0.6]
        places = [p for joint in self.graph.joints for p in (joint.F.p, joint.M.p)]
        places += [p for _, p in self.graph.points.values()]
        self.radius = 0.02 * (max(float(np.linalg.norm(p)) for p in places) or 1.0)

    def hang(self, name: str, near: str, pose: Pose[float]) -> None:
        """Adds a body as the child of another, at `pose` at home."""
        body, at = self.placed[near]
        here = at.inverse @ pose
        child = body.add_body(
            name=self._named(name), pos=here.p, quat=_quaternion(self.mujoco, here.R)
        )
        self.placed[name] = (child, pose)

    def carry(
        self, joint: GraphJoint, near: str, far: str, pose: Pose[float], backwards: bool
    ) -> None:
        """Adds a body, at `pose` at home, on a joint's coordinates one after another.

        There are small bodies between them: MuJoCo does not need these, but Pinocchio (4.1)
        ignores the positions of all but the last joint of a body.
        """
        order = list(zip(joint.coordinates, joint.pairs, strict=True))
        sign = -1.0 if backwards else 1.0
        pairs: list[_Pair] = []
        for k, pair in reversed(order) if backwards else order:
            screw = self.at.screws[:, k]
            axis = vector(sign * (screw[3:] if pair.slides else screw[:3]))
            coordinate, home = self.graph.coordinates[k], float(self.at.q[k])
            point = vector(as_array(self.at.axes[k].point))
            low, high = self.graph.limits(coordinate.name)
            if k in self.graph.from_home:  # MuJoCo counts from the joint's zero
                low, high = low + home, high + home
            pairs.append(_Pair(coordinate.name, pair.slides, axis, point, home, (low, high)))
            if pair.pitch:
                advance = f"{coordinate.name}.advance"
                pairs.append(_Pair(advance, True, axis, point, pair.pitch * home))
                coupling = self.spec.add_equality(
                    name=advance,
                    type=self.mujoco.mjtEq.mjEQ_JOINT,
                    name1=advance,
                    name2=coordinate.name,
                )
                coupling.data[:5] = [0.0, pair.pitch, 0.0, 0.0, 0.0]
        self._chain(joint.name, near, far, pose, pairs)

    def _chain(
        self, joint: str, near: str, far: str, pose: Pose[float], pairs: Sequence[_Pair]
    ) -> None:
        for pair in pairs[:-1]:
            between = self._inside(joint)
            self.hang(between, near, pose)
            self._move(between, pair)
            self._ball(between, pose.R.T @ (pair.point - pose.p), _GREY)
            near = between
        self.hang(far, near, pose)
        for pair in pairs[-1:]:
            self._move(far, pair)

    def _move(self, body: str, pair: _Pair) -> None:
        child, pose = self.placed[body]
        inward = pose.R.T
        kinds = self.mujoco.mjtJoint
        joint = child.add_joint(
            name=pair.name,
            type=kinds.mjJNT_SLIDE if pair.slides else kinds.mjJNT_HINGE,
            pos=inward @ (pair.point - pose.p),
            axis=inward @ pair.axis,
            ref=pair.home,
        )
        if np.isfinite(pair.limits).any():
            joint.range = np.clip(pair.limits, -_UNBOUNDED, _UNBOUNDED)

    def close(self, joint: GraphJoint) -> None:
        """Adds a joint outside the tree, as two sites that stay together."""
        names = self.graph.bodies
        parent, child = names[joint.parent], names[joint.child]
        kinds = self.mujoco.mjtEq
        kind, far, place = kinds.mjEQ_WELD, parent, joint.F
        there = self.placed[child][1] @ joint.M
        if joint.kind == "spherical":
            kind = kinds.mjEQ_CONNECT
        elif joint.kind == "rod":
            kind, far = kinds.mjEQ_CONNECT, self._inside(joint.name, "rod")
            start = (self.placed[parent][1] @ joint.F).p
            along = (1 / joint.length) * (there.p - start)
            x, y = (vector(column) for column in np.array(about(along)).T[:2])
            hinges = [_Pair(f"{joint.name}.{k + 1}", False, (x, y)[k], start, 0.0) for k in (0, 1)]
            self._chain(joint.name, parent, far, Pose(about(along), start), hinges)
            place = Pose(IDENTITY, Vector((0.0, 0.0, joint.length)))
            self._capsule(far, ZERO, place.p, _GREY)
        elif joint.kind != "fixed":
            far, place = self._inside(joint.name), Pose(IDENTITY, ZERO)
            self.carry(joint, parent, far, there, False)
            self._ball(far, ZERO, _GREY)
        near = self._site(f"{joint.name}.{child}", child, joint.M)
        other = self._site(f"{joint.name}.{parent}", far, place)
        self.spec.add_equality(
            name=joint.name,
            type=kind,
            objtype=self.mujoco.mjtObj.mjOBJ_SITE,
            name1=other
            if kind == kinds.mjEQ_CONNECT
            else near,  # a reader keeps the first one's name
            name2=near if kind == kinds.mjEQ_CONNECT else other,
            solref=_CLOSED,
            solimp=[0.99, 0.999, 0.001, 0.5, 2.0],
        )

    def _named(self, body: str) -> str:
        """A body's name in the file: MuJoCo has a body "world" of its own."""
        return self._inside(body, "body") if body == "world" else body

    def _inside(self, joint: str, what: str = "link") -> str:
        """An unused name for a body, as a small one within a joint."""
        name = unused(f"{joint} {what}", self.taken)
        self.taken.add(name)
        return name

    def _site(self, name: str, body: str, place: Pose[float]) -> str:
        while self.spec.site(name) is not None:
            name += "'"
        quat = _quaternion(self.mujoco, place.R)
        size = [0.5 * self.radius] * 3
        self.placed[body][0].add_site(name=name, pos=place.p, quat=quat, size=size)
        return name

    def draw(self, body: int, name: str) -> None:
        """Adds a body's points as sites, and a simple shape from joint to joint."""
        ends = self._ends(body)
        for label, (of, p) in self.graph.points.items():
            if of == body:
                self._site(label, name, Pose(IDENTITY, p))
                ends.setdefault(p, False)
        middle = vector(np.mean(list(ends), axis=0)) if ends else ZERO
        colour = _GREY if body == 0 else _BLUE
        for p, actuated in ends.items():
            self._ball(name, p, _ORANGE if actuated else colour, 2.0 if actuated else 1.3)
        for p in list(ends)[len(ends) == 2 :]:
            self._capsule(name, next(iter(ends)) if len(ends) == 2 else middle, p, colour)
        if not ends:
            self._ball(name, ZERO, colour)
        for joint in self.graph.joints:
            if joint.child == body and joint.kind in ("prismatic", "cylindrical"):
                self._capsule(name, joint.M.p, self._behind(joint), _GREY, 0.6)

    def _ends(self, body: int) -> dict[Vector[float], bool]:
        """Positions of a body's joints, and whether there is a motor."""
        ends: dict[Vector[float], bool] = {}
        for joint in self.graph.joints:
            for of, place in ((joint.parent, joint.F), (joint.child, joint.M)):
                if of == body and joint.name != "platform":
                    ends[place.p] = ends.get(place.p, False) or joint.actuated
        return ends

    def _behind(self, joint: GraphJoint) -> Vector[float]:
        """Where a piston's rod begins: the middle of its cylinder, at home."""
        middle = vector(np.mean(list(self._ends(joint.parent)), axis=0))
        pose = self.placed[self.graph.bodies[joint.parent]][1]
        here = self.placed[self.graph.bodies[joint.child]][1].inverse
        return (here @ pose @ Pose(IDENTITY, middle)).p

    def _ball(self, body: str, p: Vector[float], rgba: Sequence[float], size: float = 1.0) -> None:
        self.placed[body][0].add_geom(
            type=self.mujoco.mjtGeom.mjGEOM_SPHERE,
            pos=p,
            size=[size * self.radius, 0, 0],
            rgba=rgba,
            contype=0,
            conaffinity=0,
        )

    def _capsule(
        self,
        body: str,
        a: Vector[float],
        b: Vector[float],
        rgba: Sequence[float],
        size: float = 1.0,
    ) -> None:
        if np.linalg.norm(a - b) < self.radius:
            return
        self.placed[body][0].add_geom(
            type=self.mujoco.mjtGeom.mjGEOM_CAPSULE,
            fromto=[*a, *b],
            size=[size * self.radius, 0, 0],
            rgba=rgba,
            contype=0,
            conaffinity=0,
        )

    def text(self) -> str:
        """The model as XML, with servos on the actuated coordinates and home as its key frame."""
        from lxml import etree

        for spring in self.graph.dynamics.springs:
            first, second = (
                self._site(f"{spring.name} {k}", self.graph.bodies[body], Pose(IDENTITY, p))
                for k, (body, p) in enumerate(spring.ends, start=1)
            )
            self.weighing.stretch(spring.name, (first, second))
        self.weighing.weigh({name: body for name, (body, _) in self.placed.items()})
        self.weighing.resist()
        moved = [c for c in self.graph.coordinates if c.actuated]
        qpos = self.spec.compile().qpos0
        self.spec.add_key(name="home", qpos=qpos, ctrl=[self.spec.joint(c.name).ref for c in moved])
        self.spec.compile()
        root = _in_full(self.spec)
        self.weighing.write(root)
        etree.indent(root)
        return etree.tostring(root, encoding="unicode") + "\n"


def _in_full(spec: Any) -> Any:
    """The spec's XML with all digits of what matters; MuJoCo writes six."""
    root = parse_xml(spec.to_xml(), "MJCF")
    found = {"body": spec.body, "joint": spec.joint, "site": spec.site}
    keys = {
        "body": ("pos", "quat"),
        "joint": ("pos", "axis", "ref", "range", *_MET),
        "site": ("pos", "quat"),
    }
    for element in root.iter("body", "joint", "site"):
        if element.get("joint1") or element.get("site"):  # a coupling of two, a tendon's end
            continue
        item = found[str(element.tag)](element.get("name"))
        for key in keys[str(element.tag)]:
            if element.get(key) is not None or key not in ("range", *_MET):
                values = getattr(item, key)
                element.set(key, _numbers(np.atleast_1d(values)[:1] if key in _MET else values))
    for element, item in zip(root.iterfind("equality/*"), spec.equalities, strict=True):
        if element.get("polycoef") is not None:
            element.set("polycoef", _numbers(item.data[:5]))
    (home,) = root.iterfind("keyframe/key")
    for name in ("qpos", "ctrl"):
        values = getattr(spec.keys[0], name)
        if len(values):
            home.set(name, _numbers(values))
    return root


def _numbers(values: Any) -> str:
    return " ".join(f"{float(value):.17g}" for value in np.atleast_1d(values))


def _quaternion(mujoco: Any, R: Matrix[float]) -> FloatArray:
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, np.array(R, dtype=float).ravel())
    return quaternion
