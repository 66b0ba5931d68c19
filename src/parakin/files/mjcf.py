"""MuJoCo models (MJCF) as mechanisms: bodies, joints, and the loops closed by connect and weld.

MuJoCo's own compiler resolves frames, defaults, units and anchors. It sees only the skeleton of
the model: shapes, contacts, masses and references to other files are left out, so that no file
is opened but the one that the user named.
"""

from __future__ import annotations

import math
import warnings
from typing import TYPE_CHECKING, Any

import numpy as np

from parakin.algebra.spatial import IDENTITY, IDENTITY_POSE, ZERO, Matrix, Pose, Vector, matrix
from parakin.errors import InputError, not_installed
from parakin.files.from_links import WORLD, mechanism_of
from parakin.files.links import Link
from parakin.files.parsing import numbers
from parakin.model.mechanism import MAX_JOINTS, Mechanism
from parakin.model.placement import about, vector

if TYPE_CHECKING:
    from lxml.etree import _Element

_TURN = {"quat", "axisangle", "xyaxes", "zaxis", "euler"}
_KEPT: dict[str, set[str]] = {
    "mujoco": {"model"},
    "compiler": {"angle", "autolimits", "eulerseq"},
    "default": {"class"},
    "worldbody": set(),
    "body": {"name", "pos", "childclass", *_TURN},
    "frame": {"name", "pos", "childclass", *_TURN},
    "joint": {"name", "class", "type", "pos", "axis", "range", "limited", "ref"},
    "freejoint": {"name"},
    "site": {"name", "class", "pos", "fromto", *_TURN},
    "equality": {"class"},
    "connect": {"name", "class", "active", "body1", "body2", "anchor", "site1", "site2"},
    "weld": {
        *("name", "class", "active", "body1", "body2", "anchor", "relpose", "site1", "site2"),
        "torquescale",
    },
}
_KEPT_COUPLING = {"name", "class", "active", "joint1", "joint2", "polycoef"}
_NUMBERS = {
    *("pos", "axis", "range", "ref", "fromto", "anchor", "relpose", "torquescale", "polycoef"),
    *_TURN,
}
_LOCKED = 1e-12  # the cosine of the second of three angles at gimbal lock
_HUGE = 1e10  # out of bounds for MuJoCo too
_ELSEWHERE = {
    "include": "one file, with what it includes written out",
    "attach": "one file, with what it attaches written out",
    "replicate": "bodies written out one by one",
    "composite": "bodies written out one by one",
    "flexcomp": "rigid bodies",
}


def mechanism_from_mjcf(root: _Element, origin: str) -> Mechanism:
    """The mechanism in a MuJoCo model.

    root: the XML. origin: the file, for messages. Raises InputError.
    """
    try:
        import mujoco
    except ImportError:
        raise not_installed(origin, "mujoco") from None
    from lxml import etree

    skeleton = _skeleton(root, origin)
    parts = list(skeleton.iter("body", "joint", "freejoint", "connect", "weld"))
    if len(parts) > 4 * MAX_JOINTS:
        found = f"{len(parts)} bodies, joints and loops"
        raise InputError(origin, found, f"at most {4 * MAX_JOINTS}")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about inertias, which do not matter here
            spec = mujoco.MjSpec.from_string(etree.tostring(skeleton, encoding="unicode"))
            model = spec.compile()
    except (ValueError, RuntimeError) as error:
        reason = " ".join(str(error).split())
        raise InputError(origin, f"a model that MuJoCo refuses: {reason}", "a valid one") from None
    read = _Model(mujoco, model, origin)
    pose = _home(root, model)
    actuated = _actuated(root)
    links = [link for body in range(1, model.nbody) for link in read.links(body, pose, actuated)]
    loops = read.loops()
    names = [read.body(k) for k in range(model.nbody)]
    return mechanism_of(
        root.get("model") or "model", WORLD, names, links, loops, origin, "Read from MJCF."
    )


def _skeleton(root: _Element, origin: str) -> _Element:
    """A copy with only the elements and attributes that kinematics needs. Raises InputError."""
    from lxml import etree

    def kept(element: _Element) -> _Element:
        within = element.getparent()
        inside_default = within is not None and within.tag == "default"
        coupling = within is not None and within.tag == "equality"
        keys = _KEPT_COUPLING if element.tag == "joint" and coupling else _KEPT[element.tag]
        made = etree.Element(element.tag)
        for key, value in _attributes(element, keys).items():
            if key in _NUMBERS:
                _check_numbers(value, f"{origin}, line {element.sourceline}: {key}")
            made.set(key, value)
        if element.tag == "site" and not inside_default:
            made.set("type", "capsule" if "fromto" in made.attrib else "sphere")
            made.set("size", "0.01")
        for child in element:
            if child.tag in _ELSEWHERE:
                place = f"{origin}, line {child.sourceline}"
                raise InputError(place, f"<{child.tag}>", _ELSEWHERE[child.tag])
            wanted = child.tag in _KEPT and (child.tag != "site" or not inside_default)
            if wanted and child.tag != "compiler":
                made.append(kept(child))
        return made

    skeleton = kept(root)
    compiler = etree.Element("compiler")
    for element in root.iterfind("compiler"):  # the last word counts, as in MuJoCo
        for key, value in _attributes(element, _KEPT["compiler"]).items():
            compiler.set(key, value)
    compiler.attrib.update({"boundmass": "1", "boundinertia": "1", "fusestatic": "false"})
    skeleton.insert(0, compiler)
    return skeleton


def _attributes(element: _Element, keys: set[str]) -> dict[str, str]:
    """An element's attributes of these names, looked up one by one: listing all of them takes
    lxml quadratic time.
    """
    found = {key: element.get(key) for key in sorted(keys)}
    return {key: value for key, value in found.items() if value is not None}


def _check_numbers(text: str, place: str) -> None:
    """Raises InputError on numbers that MuJoCo would only log a warning about, or accept."""
    try:
        if "_" in text or not all(abs(float(word)) < _HUGE for word in text.split()):
            raise ValueError
    except ValueError:
        raise InputError(place, f"{text!r:.80}", f"finite numbers below {_HUGE:g}") from None


def _home(root: _Element, model: Any) -> list[float]:
    """The pose of the key frame "home", or the model's first pose if there is none."""
    for key in root.iterfind("keyframe/key"):
        if key.get("name") == "home" and key.get("qpos") is not None:
            place = f"line {key.sourceline}: qpos"
            return numbers(key.get("qpos"), model.nq, (), place)
    return [float(q) for q in model.qpos0]


def _actuated(root: _Element) -> set[str]:
    """Names of the joints that an actuator moves directly."""
    return {
        name
        for element in root.iterfind("actuator/*")
        for name in (element.get("joint"), element.get("jointinparent"))
        if name is not None
    }


class _Model:
    """A compiled MuJoCo model, read as links."""

    def __init__(self, mujoco: Any, model: Any, origin: str) -> None:
        self.mujoco, self.model, self.origin = mujoco, model, origin

    def body(self, k: int) -> str:
        return self.model.body(k).name or f"body{k}"

    def joint(self, k: int) -> str:
        return self.model.joint(k).name or f"joint{k}"

    def links(self, body: int, pose: list[float], actuated: set[str]) -> list[Link]:
        """A body's joints in order, with nameless bodies between them."""
        model = self.model
        at = self._placement(model.body_pos[body], model.body_quat[body])
        near, name = self.body(int(model.body_parentid[body])), self.body(body)
        first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
        if count == 0:
            return [Link(f"{name} on {near}", "fixed", near, name, at)]
        made = []
        for j in range(first, first + count):
            last = j == first + count - 1
            far = name if last else f"{name} after {self.joint(j)}"
            made.append(self._link(j, near, far, at, pose, actuated))
            near, at = far, IDENTITY_POSE
        return made

    def _link(
        self, j: int, near: str, far: str, at: Pose[float], pose: list[float], actuated: set[str]
    ) -> Link:
        model, kinds = self.model, self.mujoco.mjtJoint
        name, kind, k = self.joint(j), int(model.jnt_type[j]), int(model.jnt_qposadr[j])
        point = vector(model.jnt_pos[j])
        if kind == kinds.mjJNT_FREE:
            R = self._matrix(pose[k + 3 : k + 7])
            values = (*pose[k : k + 3], *_angles_of(R))
            return Link(name, "free", near, far, values=tuple(map(float, values)))
        if kind == kinds.mjJNT_BALL:
            here = Pose(IDENTITY, point)
            values = _angles_of(self._matrix(pose[k : k + 4]))
            return Link(name, "spherical", near, far, at @ here, here, values)
        slides = kind == kinds.mjJNT_SLIDE
        R, ref = about(vector(model.jnt_axis[j])), float(model.qpos0[k])
        here = Pose(R, point)
        # In the file's pose the joint stands at `ref`; here it stands at zero.
        back = Pose(IDENTITY, Vector((0.0, 0.0, -ref)))
        if not slides:
            c, s = math.cos(ref), math.sin(ref)
            back = Pose(matrix(((c, s, 0.0), (-s, c, 0.0), (0.0, 0.0, 1.0))), ZERO)
        limited = bool(model.jnt_limited[j])
        low, high = (float(a) for a in model.jnt_range[j])
        return Link(
            name,
            "prismatic" if slides else "revolute",
            near,
            far,
            at @ here @ back,
            here,
            (float(pose[k]),),
            (low, high) if limited and low < high else None,
            name in actuated,
        )

    def loops(self) -> list[Link]:
        """Loops closed by equality constraints. Two points shared by two bodies are a hinge."""
        model, kinds = self.model, self.mujoco.mjtEq
        made: list[Link] = []
        for i in range(model.neq):
            name = model.equality(i).name or f"loop{i}"
            if not model.eq_active0[i]:
                continue
            kind = int(model.eq_type[i])
            if kind == kinds.mjEQ_JOINT:
                made.append(self._screw(i, name))
                continue
            a, b, F, M = self._ends(i)
            turning = kind == kinds.mjEQ_WELD and model.eq_data[i][10] != 0
            if kind == kinds.mjEQ_WELD and not turning:
                F, M = Pose(IDENTITY, F.p), Pose(IDENTITY, M.p)
            made.append(Link(name, "fixed" if turning else "spherical", a, b, F, M))
        return _hinges(made)

    def _ends(self, i: int) -> tuple[str, str, Pose[float], Pose[float]]:
        model = self.model
        ends, data = (int(model.eq_obj1id[i]), int(model.eq_obj2id[i])), model.eq_data[i]
        if model.eq_objtype[i] == self.mujoco.mjtObj.mjOBJ_SITE:
            bodies = [int(model.site_bodyid[k]) for k in ends]
            F, M = (self._placement(model.site_pos[k], model.site_quat[k]) for k in ends)
        else:
            bodies = list(ends)
            F, M = (Pose(IDENTITY, vector(data[k : k + 3])) for k in (0, 3))
            if model.eq_type[i] == self.mujoco.mjtEq.mjEQ_WELD:
                F, M = self._placement(data[3:6], data[6:10]), Pose(IDENTITY, F.p)
        return self.body(bodies[0]), self.body(bodies[1]), F, M

    def _screw(self, i: int, name: str) -> Link:
        """The coupling of a hinge and a slide as a screw. Raises InputError on any other."""
        model = self.model
        first, second = int(model.eq_obj1id[i]), int(model.eq_obj2id[i])
        ratio = float(model.eq_data[i][1])
        straight = second >= 0 and ratio != 0 and not any(model.eq_data[i][k] for k in (2, 3, 4))
        if straight and model.jnt_type[first] == self.mujoco.mjtJoint.mjJNT_HINGE:
            first, second, ratio = second, first, 1 / ratio
        kinds = [int(model.jnt_type[k]) for k in (first, second)] if straight else []
        if kinds != [self.mujoco.mjtJoint.mjJNT_SLIDE, self.mujoco.mjtJoint.mjJNT_HINGE]:
            raise InputError(
                f"{self.origin}: equality {name!r}",
                "coupled joints",
                "connect, weld, or a slide that advances with a hinge: gears are not supported",
            )
        return Link(name, "screw", self.joint(second), self.joint(first), pitch=ratio)

    def _placement(self, p: Any, quaternion: Any) -> Pose[float]:
        return Pose(self._matrix(quaternion), vector(p))

    def _matrix(self, quaternion: Any) -> Matrix[float]:
        R = np.empty(9)
        self.mujoco.mju_quat2Mat(R, np.asarray(quaternion, dtype=float))
        return matrix(R.reshape(3, 3).tolist())


def _angles_of(R: Matrix[float]) -> tuple[float, float, float]:
    """Angles about the moving x, y and z axes, in this order; the last is 0 at gimbal lock."""
    (a, b, c), (_, e, f), (_, h, g) = R
    size = math.hypot(a, b)
    if size < _LOCKED:
        return math.atan2(h, e), math.atan2(c, size), 0.0
    return math.atan2(-f, g), math.atan2(c, size), math.atan2(-b, a)


def _hinges(loops: list[Link]) -> list[Link]:
    """Replaces pairs of points shared by the same two bodies by the hinge they make."""
    made: list[Link] = []
    waiting: dict[tuple[str, str], Link] = {}
    for link in loops:
        pair = (link.parent, link.child)
        first = waiting.pop(pair, None) if link.kind == "spherical" else None
        if first is None:
            made.append(link)
            if link.kind == "spherical":
                waiting[pair] = link
            continue
        hinge = _hinge(first, link)
        if hinge is None:
            made.append(link)
        else:
            made[made.index(first)] = hinge
    return made


def _hinge(a: Link, b: Link) -> Link | None:
    """The hinge through two points shared by two bodies; None if the points coincide."""
    frames = []
    for p, q in ((a.F.p, b.F.p), (a.M.p, b.M.p)):
        along = q - p
        length = math.hypot(*along)
        if length < 1e-9:
            return None
        frames.append(Pose(about((1 / length) * along), p))
    return Link(a.name, "revolute", a.parent, a.child, frames[0], frames[1])
