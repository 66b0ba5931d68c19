"""MuJoCo models (MJCF) as mechanisms: bodies, joints, and the loops closed by connect and weld.

MuJoCo's own compiler resolves frames, defaults, units and anchors, in the skeleton of the model.
"""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from parakin.algebra.spatial import IDENTITY, IDENTITY_POSE, Matrix, Pose, matrix
from parakin.errors import InputError, nearest, not_installed
from parakin.files.from_links import WORLD, mechanism_of
from parakin.files.links import TINY, Link, moved
from parakin.files.mjcf_dynamics import Gears, Weights, is_ours
from parakin.files.mjcf_skeleton import check_mjcf, skeleton, used
from parakin.files.mjcf_springs import Tendons
from parakin.files.parsing import number, numbers
from parakin.files.vocabulary import line_number, line_of, listed, not_used, unused
from parakin.model.mechanism import MAX_JOINTS, Mechanism
from parakin.model.placement import about, vector

if TYPE_CHECKING:
    from lxml.etree import _Element

_LOCKED = 1e-12  # the cosine of the second of three angles at gimbal lock
_SLIDE = 2  # MuJoCo's kinds of joints: free, ball, slide, hinge
_LINE = re.compile(r",? ?\bline (\d+)")


def mechanism_from_mjcf(root: _Element, origin: str) -> Mechanism:
    """The mechanism in a MuJoCo model.

    root: the XML. origin: the file, for messages. Raises InputError.
    """
    try:
        import mujoco
    except ImportError:
        raise not_installed(origin, "mujoco") from None
    check_mjcf(root, mujoco.mj_printSchema(False, False), origin)
    count = sum(1 for _ in root.iter("body", "joint", "freejoint", "connect", "weld"))
    if count > 4 * MAX_JOINTS:
        found = f"{count} bodies, joints and loops"
        raise InputError(origin, found, f"at most {4 * MAX_JOINTS}")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about bounds of inertias
            weights = Weights(mujoco, root, skeleton(root, origin))
    except (ValueError, RuntimeError) as error:
        raise _refused(str(error), mujoco.__version__, origin) from None
    model = weights.model
    home = _home(root, model, origin)
    motors = _Motors(root, model, origin)
    read = _Model(mujoco, root, weights, home, motors.gears, origin)
    loops = read.loops()
    links = [link for body in range(1, model.nbody) for link in read.links(body)]
    masses = weights.masses(read.bodies)
    tendons = Tendons(mujoco, root, model, read.bodies, origin)
    passed = not_used(root, lambda element: tendons.read(element) or _read(element))
    notes = f"Read from MJCF.{passed}{motors.notes()}"
    notes += weights.left_out(root, read.bodies)
    if read.no_loops and model.neq:
        notes += " Its equalities are disabled by <flag>."
    return mechanism_of(
        root.get("model") or "model",
        WORLD,
        read.bodies,
        links,
        loops,
        origin,
        notes,
        masses,
        weights.gravity(root, bool(masses)),
        tendons.springs,
    )


def _read(element: _Element) -> bool:
    ours = element.tag in ("custom", "text") and is_ours(element)
    return ours or used(element)


def _refused(said: str, version: str, origin: str) -> InputError:
    """MuJoCo's own message, its line as part of the place."""
    line = _LINE.search(said)
    place = f"{origin}, line {line[1]}" if line else origin
    reason = " ".join(_LINE.sub("", said).split())
    return InputError(place, f"a model that MuJoCo refuses: {reason}", f"MJCF of MuJoCo {version}")


def _home(root: _Element, model: Any, origin: str) -> list[float]:
    """The pose of the key frame "home", or the model's first pose if there is none."""
    home = [float(q) for q in model.qpos0]
    names: set[str] = set()
    for key in root.iterfind("keyframe/key"):
        place, name = line_of(key, origin), key.get("name")
        if name and name in names:
            raise InputError(place, f"a second key {name!r:.80}", "distinct names")
        names |= {name} if name else set()
        qpos = numbers(key.get("qpos"), model.nq, list(model.qpos0), f"{place}: qpos")
        if name == "home":
            home = qpos
    return home


class _Motors:
    """The hinges and slides that actuators move directly; `gears` are their ratios by name.

    idle: the lines of actuators that move none. geared: those whose gear is not taken over.
    """

    def __init__(self, root: _Element, model: Any, origin: str) -> None:
        """Raises InputError on unknown joints."""
        self.gears: dict[str, float] = {}
        self.idle: list[str] = []
        self.geared: list[str] = []
        known = {model.joint(k).name: k for k in range(model.njnt) if model.joint(k).name}
        gears = Gears(root)
        for element in root.iterfind("actuator/*"):
            keys = [key for key in ("joint", "jointinparent") if element.get(key) is not None]
            names = {key: str(element.get(key)) for key in keys}
            for key, name in names.items():
                if name not in known:
                    place = f"{line_of(element, origin)}: {key}"
                    raise InputError(place, f"unknown joint {name!r:.80}", nearest(name, known))
            single = {name for name in names.values() if model.jnt_type[known[name]] >= _SLIDE}
            line = f"line {line_number(element)}"
            self.idle += [] if single else [line]
            ratio, *others = (number(word) for word in gears.of(element).split() or "1")
            for name in single:
                odd = any(others) or (name in self.gears and self.gears[name] != ratio)
                odd = odd or (model.jnt_type[known[name]] == _SLIDE and ratio != 1.0)
                if odd or not 0.0 < abs(ratio) < math.inf:
                    self.geared.append(line)
                    ratio = 1.0
                self.gears.setdefault(name, ratio)

    def notes(self) -> str:
        """Sentences on what is not taken over."""
        said = listed("Actuators that drive no hinge or slide: on", self.idle).replace("on:", "on")
        return said + listed("Not used: gears of actuators on", self.geared).replace("on:", "on")


class _Model:
    """A compiled MuJoCo model, read as links."""

    def __init__(
        self,
        mujoco: Any,
        root: _Element,
        weights: Weights,
        home: list[float],
        gears: Mapping[str, float],
        origin: str,
    ) -> None:
        model = weights.model
        self.mujoco, self.model, self.home, self.weights = mujoco, model, home, weights
        self.gears, self.origin = gears, origin
        self.lines = {"joint": _joint_lines(root), "equality": _equality_lines(root)}
        bodies = [model.body(k).name for k in range(model.nbody)]
        joints = [model.joint(k).name for k in range(model.njnt)]
        self.bodies, self.joints = _all_named(bodies, "body"), _all_named(joints, "joint")
        equalities = [model.equality(i).name for i in range(model.neq)]
        self.loop_names = _all_named(equalities, "loop")
        self.taken = set(self.bodies)
        self.held: dict[int, float] = {}  # joints that an equality holds still, and where
        disabled, bits = int(model.opt.disableflags), mujoco.mjtDisableBit
        self.no_loops = bool(disabled & (bits.mjDSBL_EQUALITY | bits.mjDSBL_CONSTRAINT))
        self.no_limits = bool(disabled & (bits.mjDSBL_LIMIT | bits.mjDSBL_CONSTRAINT))

    def place(self, what: str, k: int) -> str:
        """Where joint or equality number `k` stands in the file."""
        name = self.joints[k] if what == "joint" else self.loop_names[k]
        return f"{self.origin}, line {self.lines[what][k]}: {what} {name!r:.80}"

    def links(self, body: int) -> list[Link]:
        """A body's joints in order, with nameless bodies between them. Raises InputError."""
        model = self.model
        at = self._placement(model.body_pos[body], model.body_quat[body])
        near, name = self.bodies[int(model.body_parentid[body])], self.bodies[body]
        first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
        if count == 0:
            return [Link(f"{name} on {near}", "fixed", near, name, at)]
        made = []
        for j in range(first, first + count):
            last = j == first + count - 1
            far = name if last else _taken(f"{name} after {self.joints[j]}", self.taken)
            made.append(self._link(j, near, far, at))
            near, at = far, IDENTITY_POSE
        return made

    def _link(self, j: int, near: str, far: str, at: Pose[float]) -> Link:
        model, kinds, pose = self.model, self.mujoco.mjtJoint, self.home
        name, kind, k = self.joints[j], int(model.jnt_type[j]), int(model.jnt_qposadr[j])
        point, place = vector(model.jnt_pos[j]), self.place("joint", j)
        if kind == kinds.mjJNT_FREE:
            values = (*pose[k : k + 3], *_angles_of(self._matrix(pose[k + 3 : k + 7])))
            passive, at_home = self.weights.passive(j, place), tuple(map(float, values))
            return Link(name, "free", near, far, values=at_home, place=place, passive=passive)
        limited = bool(model.jnt_limited[j]) and not self.no_limits
        if kind == kinds.mjJNT_BALL:
            if limited:
                expected = "none: no coordinate here counts a ball's whole turn"
                raise InputError(f"{place}: range", "a range of a ball joint", expected)
            here = Pose(IDENTITY, point)
            values = _angles_of(self._matrix(pose[k : k + 4]))
            passive = self.weights.passive(j, place)
            return Link(
                name, "spherical", near, far, at @ here, here, values, place=place, passive=passive
            )
        slides = kind == kinds.mjJNT_SLIDE
        here = Pose(about(vector(model.jnt_axis[j])), point)
        # In the file's pose the joint stands at `ref`; here it stands at zero.
        F = at @ here @ moved(slides, -float(model.qpos0[k]))
        if j in self.held:
            return Link(name, "fixed", near, far, F @ moved(slides, self.held[j]), here)
        low, high = (float(a) for a in model.jnt_range[j])
        return Link(
            name,
            "prismatic" if slides else "revolute",
            near,
            far,
            F,
            here,
            (float(pose[k]),),
            ((low, high),) if limited and low < high else (),
            actuated=name in self.gears,
            place=place,
            passive=self.weights.passive(j, place),
            gear=self.gears.get(name, 1.0),
        )

    def loops(self) -> list[Link]:
        """Loops closed by equality constraints. Two points shared by two bodies are a hinge.

        Raises InputError.
        """
        model, kinds = self.model, self.mujoco.mjtEq
        made: list[Link] = []
        for i, name in enumerate(self.loop_names):
            if not model.eq_active0[i] or self.no_loops:
                continue
            kind = int(model.eq_type[i])
            if kind == kinds.mjEQ_JOINT:
                made += self._coupling(i, name)
                continue
            if kind not in (kinds.mjEQ_CONNECT, kinds.mjEQ_WELD):
                expected = "connect, weld, or joint"
                raise InputError(self.place("equality", i), "another kind of equality", expected)
            a, b, F, M = self._ends(i)
            turning = kind == kinds.mjEQ_WELD and model.eq_data[i][10] != 0
            if kind == kinds.mjEQ_WELD and not turning:
                F, M = Pose(IDENTITY, F.p), Pose(IDENTITY, M.p)
            closing, place = "fixed" if turning else "spherical", self.place("equality", i)
            made.append(Link(name, closing, a, b, F, M, place=place))
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
        return self.bodies[bodies[0]], self.bodies[bodies[1]], F, M

    def _coupling(self, i: int, name: str) -> list[Link]:
        """The coupling of a hinge and a slide as a screw; none for a joint that is held still.

        MuJoCo's equation: q1 - ref1 = c0 + c1 (q2 - ref2) + ... Raises InputError on others.
        """
        model, kinds = self.model, self.mujoco.mjtJoint
        place = self.place("equality", i)
        first, second = int(model.eq_obj1id[i]), int(model.eq_obj2id[i])
        offset, ratio, *curved = (float(a) for a in model.eq_data[i][:5])
        zero = self._zero(first)
        if second < 0 or (ratio == 0 and not any(curved)):
            if first in self.held:
                raise InputError(place, "a joint held twice", "one equality for each joint")
            self.held[first] = zero + offset
            return []
        slides = [int(model.jnt_type[k]) == kinds.mjJNT_SLIDE for k in (first, second)]
        if any(curved) or slides[0] == slides[1]:
            expected = "a slide that advances with a hinge in proportion: gears are not supported"
            raise InputError(place, "coupled joints", expected)
        advance = zero + offset - ratio * self._zero(second)
        if abs(ratio) < TINY:
            raise InputError(place, f"a ratio of {ratio:g}", f"0, or at least {TINY:g}")
        if slides[1]:  # the hinge is told by the slide
            first, second, advance, ratio = second, first, -advance / ratio, 1 / ratio
        ends = self.joints[second], self.joints[first]
        return [Link(name, "screw", *ends, pitch=ratio, advance=advance, place=place)]

    def _zero(self, joint: int) -> float:
        """A joint's `ref`."""
        return float(self.model.qpos0[self.model.jnt_qposadr[joint]])

    def _placement(self, p: Any, quaternion: Any) -> Pose[float]:
        return Pose(self._matrix(quaternion), vector(p))

    def _matrix(self, quaternion: Any) -> Matrix[float]:
        R = np.empty(9)
        unit = np.array(quaternion, dtype=float)
        self.mujoco.mju_normalize4(unit)  # as MuJoCo does before it uses a pose
        self.mujoco.mju_quat2Mat(R, unit)
        return matrix(R.reshape(3, 3).tolist())


def _joint_lines(root: _Element) -> list[int]:
    """The lines of joints in MuJoCo's order: body by body, each in the file's order."""
    lines: dict[_Element | None, list[int]] = {body: [] for body in root.iter("body")}
    for joint in root.iter("joint", "freejoint"):
        body = next(joint.iterancestors("body"), None)
        if body is not None:
            lines[body].append(line_number(joint))
    return [line for own in lines.values() for line in own]


def _equality_lines(root: _Element) -> list[int]:
    return [
        line_number(element)
        for section in root.iterfind("equality")
        for element in section.iterchildren("connect", "weld", "joint")
    ]


def _all_named(names: list[str], what: str) -> list[str]:
    """Names by number, those that are missing made up: `what` and the number."""
    taken = set(names)
    return [name or _taken(f"{what}{k}", taken) for k, name in enumerate(names)]


def _taken(name: str, taken: set[str]) -> str:
    """An unused name, added to those `taken`."""
    name = unused(name, taken)
    taken.add(name)
    return name


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
    """The hinge through two points shared by two bodies; None if the points coincide, or lie
    further apart on one body than on the other.
    """
    frames, lengths = [], []
    for p, q in ((a.F.p, b.F.p), (a.M.p, b.M.p)):
        along = q - p
        length = math.hypot(*along)
        if length < 1e-9:
            return None
        lengths.append(length)
        frames.append(Pose(about((1 / length) * along), p))
    if abs(lengths[0] - lengths[1]) > 1e-12 * max(1.0, *lengths):
        return None
    return Link(a.name, "revolute", a.parent, a.child, frames[0], frames[1], place=a.place)
