"""Random URDF models and the files of their loops, which close by construction, and where SciPy's
rotations have their links by URDF's own definition.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
Rng = np.random.Generator
FREEDOMS = {
    **{"revolute": 1, "continuous": 1, "prismatic": 1, "fixed": 0},
    **{"floating": 6, "planar": 3, "spherical": 3},
}
UNUSED = (
    '<material name="red"><color rgba="1 0 0 1"/></material>',
    '<gazebo reference="l1"><mu1>0.2</mu1></gazebo>',
    '<transmission name="t"><joint name="j1"/></transmission>',
    '<ros2_control name="r"/>',
)
VISUAL = '<visual><geometry><mesh filename="package://no/such.stl"/></geometry></visual>'
REFUSED = {  # in the URDF: what stands instead of </robot>, and a part of what is said
    '<joint name="zz" type="revolut"><parent link="l0"/><child link="zz"/></joint>': "'revolute'",
    '<link name="zz"/><joint name="zz" type="fixed"><origin xyz="1_0 0 0"/><parent link="l0"/>'
    '<child link="zz"/></joint>': "xyz: found '1_0 0 0'",
    '<link name="zz"/><joint name="zz" type="fixed"><origin xyz="١ 0 0"/><parent link="l0"/>'
    '<child link="zz"/></joint>': "3 finite numbers",
    '<link name="zz"/><joint name="zz" type="revolute"><limit lower="1" upper="-1"/>'
    '<parent link="l0"/><child link="zz"/></joint>': "lower below upper",
    '<link name="zz"/><joint name="zz" type="revolute"><mimic joint="none"/><parent link="l0"/>'
    '<child link="zz"/></joint>': "unknown joint 'none'",
    '<link name="zz"/><joint name="zz" type="revolute"><origin/><origin/><parent link="l0"/>'
    '<child link="zz"/></joint>': "a second <origin>",
    '<xacro:macro xmlns:xacro="x" name="m"/>': "as written by: xacro",
    '<gazebo><joint name="g" type="revolute"/></gazebo>': "a joint in <gazebo>",
    "<lnk/>": "did you mean 'link'?",
}
REFUSED_BESIDE = {  # in the file of loops
    "closed_lop: [[a, b]]\n": "did you mean 'closed_loop'?",
    "home: {j1: 1_0}\n": "a plain decimal number",
    "dependent: [none]\n": "unknown joint 'none'",
    "name_mot: [none]\n": "unknown joint 'none'",
    "joint_name: [none]\njoint_type: [FIXED]\n": "unknown joint 'none'",
}


def pose(R: Any, p: Any) -> Array:
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = R, p
    return made


@dataclass
class Joint:
    """A joint of the tree. mimics: the joint it follows, by how much, and from where."""

    name: str
    kind: str
    parent: str
    child: str
    origin: Array
    axis: Array
    limits: tuple[float, float] | None = None
    mimics: tuple[str, float, float] | None = None
    driven: bool = False


@dataclass
class Loop:
    """Frames on two links that coincide but for what `kind` leaves free about or along `axis`."""

    kind: str
    a: str
    b: str
    on_a: Array
    on_b: Array
    axis: Array = field(default_factory=lambda: np.array([1.0, 0.0, 0.0]))


def motion(joint: Joint, q: Array) -> Array:
    """The child's frame after the joint moved by q, in the joint's own."""
    kind = joint.kind
    if kind in ("revolute", "continuous"):
        return pose(Rotation.from_rotvec(q[0] * joint.axis).as_matrix(), np.zeros(3))
    if kind == "prismatic":
        return pose(np.eye(3), q[0] * joint.axis)
    if kind == "spherical":
        return pose(Rotation.from_euler("XYZ", q).as_matrix(), np.zeros(3))
    if kind == "floating":
        return pose(Rotation.from_euler("XYZ", q[3:]).as_matrix(), q[:3])
    return np.eye(4)


def numbers(values: Any) -> str:
    return " ".join(repr(float(v)) for v in np.atleast_1d(values))


def frame(rng: Rng) -> tuple[str, Array]:
    """A random origin as URDF writes it, and as a matrix."""
    p = rng.normal(size=3).round(3)
    rpy = rng.normal(size=3).round(3)
    turn = Rotation.from_euler("xyz", rpy)  # about fixed axes, one after another
    text = f'rpy="{numbers(rpy)}"'
    if rng.random() < 0.2:
        text = f'quat_xyzw="{numbers(turn.as_quat())}"'
    if rng.random() < 0.2:
        turn, text = Rotation.identity(), ""
    return f'xyz="{numbers(p)}" {text}', pose(turn.as_matrix(), p)


def gathered(mass: float, com: Array, tensor: Array) -> Array:
    """Of a body, about the origin: mass, first moments, second moments of rotation."""
    about_origin = tensor + mass * (com @ com * np.eye(3) - np.outer(com, com))
    return np.hstack([mass, mass * com, about_origin.ravel()])


def written(at: Array) -> str:
    """A matrix as an origin."""
    rpy = Rotation.from_matrix(at[:3, :3]).as_euler("xyz")
    return f'xyz="{numbers(at[:3, 3])}" rpy="{numbers(rpy)}"'


class Writer:
    """Writes one random URDF and, for most with loops, the file beside it."""

    def __init__(self, seed: int) -> None:
        rng = self.rng = np.random.default_rng(seed)
        self.heavy = np.random.default_rng([seed, 1])  # so that poses are those of the seed
        self.weights: dict[str, tuple[float, Array, Array]] = {}
        self.joints: list[Joint] = []
        self.loops: list[Loop] = []
        self.elements: list[str] = ['<link name="l0"/>']
        self.table: dict[str, Any] = {}
        self.home: dict[str, Array] = {}
        self.way = str(rng.choice(["tree", "inside", "pairs", "closures"]))
        for number in range(1, int(rng.integers(3, 9))):
            self.joint(number, f"l{rng.integers(max(0, number - 3), number)}", f"l{number}")
        if self.way == "pairs":
            self.home = {
                j.name: rng.normal(size=1) * 0.5
                for j in self.joints
                if FREEDOMS[j.kind] == 1 and j.mimics is None
            }
            self.table["home"] = {name: float(q[0]) for name, q in self.home.items()}
        at = self.walk(self.home)
        for number in range(int(rng.integers(1, 3)) if self.way != "tree" else 0):
            self.loop(number, at)
        if not self.loops:
            self.way, self.table, self.home = "tree", {}, {}
        self.table |= {"name_mot": self.motors()} if self.table else {}

    def motors(self) -> list[str]:
        chosen = [j for j in self.joints if FREEDOMS[j.kind] == 1 and j.mimics is None]
        for joint in chosen[:1]:
            joint.driven = True
        return [joint.name for joint in chosen[:1]]

    def joint(self, number: int, parent: str, child: str) -> None:
        rng = self.rng
        kinds = ["revolute", "continuous", "prismatic", "revolute", "fixed", "spherical"]
        if number == 1:
            kinds = ["revolute"]
        elif rng.random() < 0.2:
            kinds = ["floating"]
        if rng.random() < 0.2 and number > 1:
            return self.screw(number, parent, child)
        text, origin = frame(rng)
        axis = rng.normal(size=3)
        told = f'<axis xyz="{numbers(axis)}"/>'
        if rng.random() < 0.2:
            axis, told = np.array([1.0, 0.0, 0.0]), ""
        made = Joint(
            f"j{number}", str(rng.choice(kinds)), parent, child, origin, axis / np.linalg.norm(axis)
        )
        self.add(made, f"<origin {text}/>{told}")
        return None

    def screw(self, number: int, parent: str, child: str) -> None:
        """A hinge and a slide along it, one of which mimics the other."""
        rng = self.rng
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        text, origin = frame(rng)
        sign, ratio, offset = rng.choice([1.0, -1.0]), 0.3 + rng.random(), rng.normal()
        parts = [
            Joint(f"j{number}", "continuous", parent, f"n{number}", origin, axis),
            Joint(f"s{number}", "prismatic", f"n{number}", child, np.eye(4), sign * axis),
        ]
        if rng.random() < 0.5:  # the slide comes first
            one, two = parts
            parts = [
                Joint(two.name, two.kind, parent, f"n{number}", origin, two.axis),
                Joint(one.name, one.kind, f"n{number}", child, np.eye(4), axis),
            ]
        if self.way == "closures":
            offset = 0.0  # they are told with every joint at zero
        follower, leader = (parts[0], parts[1]) if rng.random() < 0.5 else (parts[1], parts[0])
        follower.mimics = leader.name, ratio, offset
        self.elements.append(f'<link name="n{number}"/>')
        for part, at in zip(parts, (f"<origin {text}/>", ""), strict=True):
            mimic = (
                f'<mimic joint="{leader.name}" multiplier="{ratio!r}" offset="{offset!r}"/>'
                if part is follower else ""
            )  # fmt: skip
            self.add(part, f'{at}<axis xyz="{numbers(part.axis)}"/>{mimic}', link=part is parts[1])

    def add(self, made: Joint, inside: str, link: bool = True) -> None:
        rng = self.rng
        if FREEDOMS[made.kind] == 1 and made.mimics is None and rng.random() < 0.4:
            made.limits = (-3.0 - rng.random(), 3.0)
            inside += f'<limit effort="1" velocity="1" lower="{made.limits[0]!r}" upper="3"/>'
            if made.kind == "continuous":
                made.limits = None  # as URDF has it
        inside += '<dynamics damping="1" friction="0.5"/>' if rng.random() < 0.3 else ""
        ends = f'<parent link="{made.parent}"/><child link="{made.child}"/>'
        self.elements.append(f'<joint name="{made.name}" type="{made.kind}">{ends}{inside}</joint>')
        if link:
            seen = VISUAL if rng.random() < 0.3 else ""
            weight = self.inertial(made.child) if self.heavy.random() < 0.7 else ""
            self.elements.append(f'<link name="{made.child}">{seen}{weight}</link>')
        self.joints.append(made)

    def inertial(self, link: str) -> str:
        """What a link weighs: four masses at random points."""
        rng = self.heavy
        text, at = frame(rng)
        points, mass = rng.normal(size=(4, 3)), float(rng.random())
        tensor = np.einsum("ij,ij->", points, points) * np.eye(3) - points.T @ points
        self.weights[link] = mass, at, tensor
        six = [
            f'i{"xyz"[i]}{"xyz"[j]}="{tensor[i, j]:.17g}"' for i in range(3) for j in range(i, 3)
        ]
        moments = f"<inertia {' '.join(six)}/>"
        return f'<inertial><origin {text}/><mass value="{mass!r}"/>{moments}</inertial>'

    def moments(self, told: Mapping[str, Any]) -> Array:
        """Of all links together, about the base's origin: mass, first moments, second moments of
        rotation.
        """
        found, walked = np.zeros(13), self.walk(told)
        for link, (mass, at, tensor) in self.weights.items():
            place = walked[link] @ at
            found += gathered(mass, place[:3, 3], place[:3, :3] @ tensor @ place[:3, :3].T)
        return found

    def values(self, told: Mapping[str, Any]) -> dict[str, Array]:
        """All joints' coordinates from those of the independent ones; zero where none are told."""
        q = {j.name: np.asarray(told.get(j.name, np.zeros(FREEDOMS[j.kind]))) for j in self.joints}
        for j in self.joints:
            if j.mimics is not None:
                leader, ratio, offset = j.mimics
                q[j.name] = ratio * q[leader] + offset
        return q

    def walk(self, told: Mapping[str, Any]) -> dict[str, Array]:
        """Every link's pose."""
        q, at = self.values(told), {"l0": np.eye(4)}
        for j in self.joints:  # parents come first
            at[j.child] = at[j.parent] @ j.origin @ motion(j, q[j.name])
        return at

    def loop(self, number: int, at: dict[str, Array]) -> None:
        """Closes a loop between two links that can move apart."""
        rng = self.rng
        ends = sorted(link for link in at if link.startswith("l"))  # nothing inside a screw
        pairs = [(a, b) for a in ends for b in ends if a < b and self.between(a, b) > 3]
        pairs = [
            pair for pair in pairs if all({loop.a, loop.b} != set(pair) for loop in self.loops)
        ]
        if not pairs:
            return
        a, b = pairs[int(rng.integers(len(pairs)))]
        _, on_a = frame(rng)
        on_b = np.linalg.inv(at[b]) @ at[a] @ on_a
        if self.way == "inside":
            self.inside(number, a, b, on_a, on_b)
        elif self.way == "pairs":
            kind = str(rng.choice(["spherical", "fixed"]))
            for side, link, place in (("a", a, on_a), ("b", b, on_b)):
                name = f"e{number}{side}"
                ends_ = f'<parent link="{link}"/><child link="{name}"/><origin {written(place)}/>'
                self.elements.append(f'<link name="{name}"/>')
                self.elements.append(f'<joint name="{name}" type="fixed">{ends_}</joint>')
            self.table.setdefault("closed_loop", []).append([f"e{number}a", f"e{number}b"])
            self.table.setdefault("type", []).append({"spherical": "3d", "fixed": "6d"}[kind])
            self.loops.append(Loop(kind, a, b, on_a, on_b))
        else:
            point, axis = (at[a] @ on_a)[:3, 3], rng.normal(size=3)
            closure = {"link_a": a, "link_b": b, "point": [float(x) for x in point]}
            hinge = rng.random() < 0.6
            if hinge:
                closure["axis"] = [float(x) for x in axis]
            self.table.setdefault("closures", []).append(closure)
            axis /= np.linalg.norm(axis)
            places = [np.linalg.inv(at[link]) @ pose(np.eye(3), point) for link in (a, b)]
            self.loops.append(
                Loop("revolute" if hinge else "spherical", a, b, places[0], places[1], axis)
            )

    def inside(self, number: int, a: str, b: str, on_a: Array, on_b: Array) -> None:
        """A loop in the URDF itself; what its kind leaves free is not at zero."""
        rng = self.rng
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        kind = str(rng.choice(["revolute", "spherical", "fixed", "prismatic"]))
        free = rng.normal()
        if kind in ("revolute", "prismatic"):
            on_b = on_b @ motion(Joint("", kind, "", "", np.eye(4), axis), np.array([free]))
        elif kind == "spherical":
            on_b = on_b @ pose(Rotation.from_rotvec(axis * free).as_matrix(), np.zeros(3))
        told = f'<axis xyz="{numbers(axis)}"/>'
        if rng.random() < 0.5:
            sides = "".join(
                f'<{role} link="{link}"><origin {written(at)}/></{role}>'
                for role, link, at in (("predecessor", a, on_a), ("successor", b, on_b))
            )
            self.elements.append(f'<loop name="c{number}" type="{kind}">{sides}{told}</loop>')
        else:
            sides = "".join(
                f'<{role} link="{link}" {written(at)}/>'
                for role, link, at in (("link1", a, on_a), ("link2", b, on_b))
            )
            self.elements.append(
                f'<loop_joint name="c{number}" type="{kind}">{sides}{told}</loop_joint>'
            )
        self.loops.append(Loop(kind, a, b, on_a, on_b, axis))

    def between(self, a: str, b: str) -> int:
        """How many freedoms lie between two links."""
        below = {j.child: j for j in self.joints}

        def above(link: str) -> set[str]:
            return {link} | above(below[link].parent) if link in below else set()

        path = above(a) ^ above(b)
        return sum(FREEDOMS[below[k].kind] - (below[k].mimics is not None) for k in path)

    def gaps(self, told: Mapping[str, Any]) -> Array:
        """What keeps the loops from closing; zero where they do [m, rad]."""
        at, found = self.walk(told), [np.zeros(0)]
        for loop in self.loops:
            A, B = at[loop.a] @ loop.on_a, at[loop.b] @ loop.on_b
            apart = B[:3, 3] - A[:3, 3]
            turned = Rotation.from_matrix(A[:3, :3].T @ B[:3, :3]).as_rotvec()
            one, two = A[:3, :3] @ loop.axis, B[:3, :3] @ loop.axis
            if loop.kind == "prismatic":
                found += [np.cross(one, apart), turned]
            else:
                more = {"revolute": one - two, "fixed": turned}.get(loop.kind)
                found += [apart] if more is None else [apart, more]
        return np.hstack(found)

    def text(self) -> str:
        unused = self.rng.permutation(np.array(UNUSED))[: self.rng.integers(3)]
        return '<robot name="random">\n' + "\n".join([*self.elements, *unused]) + "\n</robot>\n"
