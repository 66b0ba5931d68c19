"""A mechanism as URDF and a YAML file of its loops.

URDF has trees of single hinges and slides: a joint of several coordinates becomes a chain of
them, X.1, X.2, ..., with links without a body between. The loops go into a separate file as pairs
of links that coincide (Gepetto's convention): in a point (3d) at spherical joints and rods, as
frames (6d) at all others. `home` in it is parakin's, with coordinates counted from their joints'
zeros. Masses, damping and friction go into the URDF; what it cannot hold, into a comment in it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from parakin.algebra.spatial import IDENTITY, IDENTITY_POSE, ZERO, Matrix, Pose, Vector, matrix
from parakin.errors import not_installed
from parakin.exports.left_out import comment, left_out, masses_of
from parakin.files.vocabulary import unused
from parakin.kinematics.assembly import assembled
from parakin.kinematics.configuration import Configuration, configure
from parakin.model.dynamics import Passive
from parakin.model.graph import Graph
from parakin.model.joints import GraphJoint
from parakin.model.limits import UNLIMITED
from parakin.model.masses import Mass
from parakin.model.placement import about

_UNBOUNDED = 1000.0  # [m or rad]: an open end, as limits in URDF have two
_LOCKED = 1e-12


def urdf(graph: Graph) -> tuple[str, str]:
    """The tree as URDF and its loops as YAML.

    Raises InputError if lxml or PyYAML is not installed, AssemblyError.
    """
    try:
        import yaml
        from lxml import etree
    except ImportError:
        raise not_installed("URDF", "lxml or PyYAML") from None
    tree = graph.posed_tree()
    robot = _Robot(graph, configure(graph, tree, assembled(graph).q))
    robot.link(graph.bodies[0])
    for number, backwards in tree.steps:
        joint = graph.joints[number]
        near, far = (joint.child, joint.parent) if backwards else (joint.parent, joint.child)
        end = joint.F if backwards else joint.M
        robot.chain(joint, graph.bodies[near], graph.bodies[far], end, backwards)
    for number in tree.cuts:
        robot.close(graph.joints[number])
    for name, (body, p) in graph.points.items():
        robot.frame(name, graph.bodies[body], Pose(IDENTITY, p))
    comment(robot.root, left_out(graph, ()), [load.name for load in graph.dynamics.loads])
    etree.indent(robot.root)
    text = etree.tostring(robot.root, encoding="unicode") + "\n"
    loops = {
        "closed_loop": [list(pair) for pair in robot.pairs],
        "type": robot.types,
        "name_mot": [c.name for c in graph.coordinates if c.actuated],
        "home": robot.home,
    }
    header = (
        f"# Loops of {graph.mechanism.name}: pairs of links that coincide, and home [m, rad].\n"
    )
    return text, header + yaml.safe_dump(loops, sort_keys=False, default_flow_style=None)


class _Robot:
    """A URDF as it is built, with the pairs of links that close its loops."""

    def __init__(self, graph: Graph, at: Configuration) -> None:
        from lxml import etree

        self._sub = etree.SubElement
        self.graph, self.at = graph, at
        self.root = etree.Element("robot", name=graph.mechanism.name)
        self.links: set[str] = set()
        self.pairs: list[tuple[str, str]] = []
        self.types: list[str] = []
        self.home: dict[str, float] = {}
        self.masses = masses_of(graph)

    def link(self, name: str) -> None:
        self.links.add(name)
        link = self._sub(self.root, "link", name=name)
        if name in self.graph.bodies:
            geometry = self._sub(self._sub(link, "visual"), "geometry")
            self._sub(geometry, "sphere", radius=f"{0.03 * self.graph.length:.6g}")
            mass = self.masses.get(self.graph.bodies.index(name))
            if mass is not None:
                self._weigh(link, mass)

    def _weigh(self, link: Any, mass: Mass) -> None:
        inertial = self._sub(link, "inertial")
        self._sub(inertial, "origin", xyz=_numbers(mass.com), rpy="0 0 0")
        self._sub(inertial, "mass", value=_numbers([mass.mass]))
        axes = [(i, j) for i in range(3) for j in range(i, 3)]
        moments = self._sub(inertial, "inertia")
        for i, j in axes:
            moments.set(f"i{'xyz'[i]}{'xyz'[j]}", _numbers([mass.inertia[i][j]]))

    def chain(
        self, joint: GraphJoint, near: str, far: str, end: Pose[float], backwards: bool
    ) -> None:
        """Adds a joint's coordinates one after another, from one link to another."""
        here = joint.M if backwards else joint.F
        if backwards:
            here = here @ Pose(joint.tail.T, ZERO)
        after = end.inverse
        if not backwards:
            after = Pose(joint.tail, ZERO) @ after
        order = list(zip(joint.coordinates, joint.pairs, strict=True))
        for i, (k, pair) in enumerate(reversed(order) if backwards else order):
            last = i == len(order) - 1 and after == IDENTITY_POSE and not pair.pitch
            axis: list[float] = [0.0, 0.0, 0.0]
            axis[pair.axis] = -1.0 if backwards else 1.0
            name = self.graph.coordinates[k].name
            child = far if last else self._fresh(f"{joint.name} link {i + 1}")
            self._moving(name, k, pair.slides, near, child, here, axis)
            near, here = child, IDENTITY_POSE
            if pair.pitch:
                child = far if after == IDENTITY_POSE else self._fresh(f"{joint.name} nut")
                self._moving(f"{name}.advance", k, True, near, child, here, axis, pair.pitch)
                near = child
        if near != far:
            self.fixed(f"{joint.name} end", near, far, here @ after)

    def _moving(
        self,
        name: str,
        k: int,
        slides: bool,
        near: str,
        far: str,
        here: Pose[float],
        axis: Sequence[float],
        pitch: float = 0.0,
    ) -> None:
        low, high = self.graph.limits(self.graph.coordinates[k].name)
        home = float(self.at.q[k])
        if k in self.graph.from_home:  # URDF counts from the joint's zero
            low, high = low + home, high + home
        bounded = (math.isfinite(low) or math.isfinite(high)) and not pitch
        kind = "prismatic" if slides else "revolute" if bounded else "continuous"
        joint = self._joint(name, kind, near, far, here)
        self._sub(joint, "axis", xyz=_numbers(axis))
        if slides or bounded:
            low, high = (low, high) if bounded else UNLIMITED
            rates = self.graph.limits(self.graph.coordinates[k].name, 1)
            speed = min(*map(abs, rates), _UNBOUNDED)
            limit = self._sub(joint, "limit", effort="1000", velocity=_numbers([speed]))
            limit.set("lower", _numbers([max(low, -_UNBOUNDED)]))
            limit.set("upper", _numbers([min(high, _UNBOUNDED)]))
        if pitch:
            self._sub(
                joint,
                "mimic",
                joint=self.graph.coordinates[k].name,
                multiplier=_numbers([pitch]),
            )
            return
        self.home[name] = home
        met = self.graph.dynamics.passive.get(k, Passive())
        if met.viscous or met.damping or met.coulomb:
            damping, friction = (_numbers([x]) for x in (met.viscous + met.damping, met.coulomb))
            self._sub(joint, "dynamics", damping=damping, friction=friction)

    def _joint(self, name: str, kind: str, near: str, far: str, here: Pose[float]):  # type: ignore[no-untyped-def]  # lxml's element
        self.link(far)
        joint = self._sub(self.root, "joint", name=name, type=kind)
        self._sub(joint, "parent", link=near)
        self._sub(joint, "child", link=far)
        self._sub(joint, "origin", xyz=_numbers(here.p), rpy=_numbers(_rpy(here.R)))
        return joint

    def fixed(self, name: str, near: str, far: str, here: Pose[float]) -> None:
        self._joint(name, "fixed", near, far, here)

    def frame(self, name: str, body: str, at: Pose[float]) -> str:
        """Adds a link without a body, placed on one with a body. Returns its name."""
        name = self._fresh(name)
        self.fixed(f"{name} on {body}", body, name, at)
        return name

    def close(self, joint: GraphJoint) -> None:
        """Adds a joint outside the tree, as two links that coincide."""
        parent, child = self.graph.bodies[joint.parent], self.graph.bodies[joint.child]
        kind = "3d" if joint.kind in ("spherical", "rod") else "6d"
        if joint.kind == "rod":
            near = self._rod(joint, parent)
        elif joint.kind in ("spherical", "fixed"):
            near = self.frame(f"{joint.name}_A", parent, joint.F)
        else:
            near = self._fresh(f"{joint.name}_A")
            self.chain(joint, parent, near, IDENTITY_POSE, False)
        far = self.frame(f"{joint.name}_B", child, joint.M)
        # If links become one body, a reader keeps the name of the first.
        self.pairs.append((near, far) if kind == "3d" else (far, near))
        self.types.append(kind)

    def _rod(self, joint: GraphJoint, parent: str) -> str:
        """Adds a rod on two hinges, zero at home. Returns the name of the link at its tip."""
        poses = [self.at.pose(body) for body in (joint.parent, joint.child)]
        start, tip = (
            (pose @ place).p for pose, place in zip(poses, (joint.F, joint.M), strict=True)
        )
        along = (1 / joint.length) * (tip - start)
        turn = np.array(poses[0].R, dtype=float).T @ np.array(about(along), dtype=float)
        here = Pose(matrix(turn.tolist()), joint.F.p)
        near = parent
        for number, axis in enumerate(np.eye(3)[:2], start=1):
            name = f"{joint.name}.{number}"
            far = self._fresh(f"{joint.name} rod" if number == 2 else f"{joint.name} link")
            hinge = self._joint(name, "continuous", near, far, here)
            self._sub(hinge, "axis", xyz=_numbers(axis))
            self.home[name] = 0.0
            near, here = far, IDENTITY_POSE
        return self.frame(f"{joint.name}_A", near, Pose(IDENTITY, Vector((0.0, 0.0, joint.length))))

    def _fresh(self, name: str) -> str:
        return unused(name, {*self.links, *self.graph.bodies})


def _rpy(R: Matrix[float]) -> Vector[float]:
    """Roll, pitch and yaw: angles about the fixed x, y and z axes, in this order."""
    size = math.hypot(R[2][1], R[2][2])
    pitch = math.atan2(-R[2][0], size)
    if size < _LOCKED:
        return Vector((math.atan2(-R[1][2], R[1][1]), pitch, 0.0))
    return Vector((math.atan2(R[2][1], R[2][2]), pitch, math.atan2(R[1][0], R[0][0])))


def _numbers(values: Sequence[float]) -> str:
    return " ".join(f"{float(value) + 0.0:.17g}" for value in values)
