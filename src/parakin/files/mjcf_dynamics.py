"""What weighs and resists in a MuJoCo model, as MuJoCo's own compiler has it.

A model of kinematics need not say what bodies weigh, yet MuJoCo compiles none that weighs nothing:
the skeleton has bounds, which are no masses.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from parakin.algebra.spatial import Matrix, Vector, matrix
from parakin.errors import InputError
from parakin.files.link_masses import of_principal
from parakin.files.mjcf_skeleton import BOUND, UNSHAPED
from parakin.files.resistances import acting
from parakin.files.vocabulary import line_number, listed
from parakin.model.dynamics import Passive
from parakin.model.masses import Mass
from parakin.model.placement import vector

if TYPE_CHECKING:
    from lxml.etree import _Element

INVENTED_MASS = "parakin: invented masses"
"""The text of an exported model that lists bodies which weigh nothing in the mechanism."""
INVENTED_INERTIA = "parakin: invented inertias"
INVENTED_ARMATURE = "parakin: invented armatures"
INVENTED_DAMPING = "parakin: invented dampings"
_INVENTED = (INVENTED_MASS, INVENTED_INERTIA, INVENTED_ARMATURE, INVENTED_DAMPING)
_NO_MASS = 100 * BOUND
_SLIDE, _BALL = 2, 1  # MuJoCo's kinds of joints: free, ball, slide, hinge
_STEADY = 1.0  # MuJoCo tries a step, which needs inertia in all directions


class Weights:
    """A model's masses and what its joints meet. `model` is the compiled skeleton."""

    def __init__(self, mujoco: Any, root: _Element, text: str) -> None:
        """text: the skeleton. Raises ValueError or RuntimeError where MuJoCo does."""
        spec = mujoco.MjSpec.from_string(text)
        joints, geoms, bodies = list(spec.joints), list(spec.geoms), list(spec.bodies)
        armature = [float(joint.armature) for joint in joints]
        for joint in joints:
            joint.armature += _STEADY
        heavy = [_weighs(geom, spec) for geom in geoms]
        for geom in geoms:
            if geom.name.startswith(UNSHAPED):
                geom.mass = 0.0
        self.model = spec.compile()
        self._armature = {int(j.id): a for j, a in zip(joints, armature, strict=True)}
        from_geoms = (
            spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
        )
        told = {int(b.id) for b in bodies if b.explicitinertial and not from_geoms}
        self._unknown = {
            int(geom.parent.id) for geom, counts in zip(geoms, heavy, strict=True) if counts
        } - told
        self._invented = invented(root)
        flags, bits = int(self.model.opt.disableflags), mujoco.mjtDisableBit
        self.off = {
            "gravity": bool(flags & bits.mjDSBL_GRAVITY),
            "stiffness": bool(flags & bits.mjDSBL_SPRING),
            "viscous": bool(flags & bits.mjDSBL_DAMPER),
            "coulomb": bool(flags & (bits.mjDSBL_FRICTIONLOSS | bits.mjDSBL_CONSTRAINT)),
        }
        self._mujoco = mujoco
        self._odd: list[str] = []

    def masses(self, names: Sequence[str]) -> dict[str, Mass]:
        """Masses by body, those of which they are known. names: of all bodies, by number."""
        model, found = self.model, {}
        for k in range(1, model.nbody):
            name, mass = model.body(k).name, float(model.body_mass[k])
            if k in self._unknown or mass <= _NO_MASS or name in self._invented[INVENTED_MASS]:
                continue
            if _within_a_joint(model, k):
                continue
            moments = vector(model.body_inertia[k])
            if max(moments) <= BOUND or name in self._invented[INVENTED_INERTIA]:
                moments = Vector((0.0, 0.0, 0.0))
            R = self._matrix(model.body_iquat[k])
            found[names[k]] = of_principal(mass, vector(model.body_ipos[k]), R, moments)
        return found

    def gravity(self, root: _Element, masses: bool) -> tuple[float, float, float] | None:
        """The vector; none where nothing weighs anything and the file does not tell it."""
        told = any(option.get("gravity") is not None for option in root.iterfind("option"))
        if not masses and not told:
            return None
        x, y, z = (0.0 if self.off["gravity"] else float(g) for g in self.model.opt.gravity)
        return x, y, z

    def passive(self, j: int, place: str) -> tuple[Passive, ...]:
        """What joint number `j` meets. Raises InputError on less than nothing."""
        model, name = self.model, self.model.joint(j).name
        kind, dof = int(model.jnt_type[j]), int(model.jnt_dofadr[j])
        polynomials = ("jnt_stiffnesspoly", j), ("dof_dampingpoly", dof)
        if any(np.any(getattr(model, key, np.zeros((dof + 1, 1)))[k]) for key, k in polynomials):
            self._odd.append(f"nonlinear springs and dampers of {name!r}")
        values = {
            "stiffness": float(model.jnt_stiffness[j]),
            "viscous": float(model.dof_damping[dof]),
            "coulomb": float(model.dof_frictionloss[dof]),
            "armature": self._armature[j],
        }
        for key, value in values.items():
            if value < 0.0:
                raise InputError(f"{place}: {_WORDS[key]}", f"{value:g}", "zero or more")
            if self.off.get(key):
                values[key] = 0.0
        if name in self._invented[INVENTED_ARMATURE]:
            values["armature"] = 0.0
        if name in self._invented[INVENTED_DAMPING]:
            values["viscous"] = 0.0
        if kind < _SLIDE:
            kept = ("viscous",) if kind == _BALL else ()
            lost = [_WORDS[key] for key, value in values.items() if value and key not in kept]
            if lost:
                self._odd.append(f"{' and '.join(lost)} of {name or place!r}")
            return acting([Passive(viscous=values["viscous"])]) if kept else ()
        zero = float(model.qpos_spring[model.jnt_qposadr[j]]) if values["stiffness"] else 0.0
        return acting([Passive(zero=zero, **values)])

    def left_out(self, root: _Element, names: Sequence[str]) -> str:
        """Sentences on what has no counterpart in a mechanism, for notes."""
        unknown = [names[k] for k in sorted(self._unknown) if k]
        said = listed("Masses left out of bodies shaped by meshes, which are not read", unknown)
        odd = [*self._odd]
        for element in root.iter("joint", "body", "motor", "general", "position", "velocity"):
            for key in _UNCOUNTED.get(str(element.tag), _OF_ACTUATORS):
                if element.get(key) is not None:
                    odd.append(f"{key} on line {line_number(element)}")
        return said + listed("Not used", odd)

    def _matrix(self, quaternion: Any) -> Matrix[float]:
        R = np.empty(9)
        self._mujoco.mju_quat2Mat(R, np.array(quaternion, dtype=float))
        return matrix(R.reshape(3, 3).tolist())


_WORDS = {
    "stiffness": "stiffness",
    "viscous": "damping",
    "coulomb": "frictionloss",
    "armature": "armature",
}
_OF_ACTUATORS = ("armature", "damping")
_UNCOUNTED = {"joint": ("springdamper", "springyield"), "body": ("gravcomp",)}


def invented(root: _Element) -> dict[str, set[str]]:
    """What an exported model lists as no part of the mechanism: names by text."""
    found: dict[str, set[str]] = {name: set() for name in _INVENTED}
    for each in root.iterfind("custom/text"):
        name = str(each.get("name"))
        if name in found:
            found[name] |= {word.strip() for word in str(each.get("data")).split(",")}
    return found


def is_ours(element: _Element) -> bool:
    """Whether an element is such a list, or holds nothing else."""
    texts = element.findall("text") if element.tag == "custom" else [element]
    return len(texts) == max(len(element), 1) and all(t.get("name") in _INVENTED for t in texts)


def _weighs(geom: Any, spec: Any) -> bool:
    """Whether a geom whose shape is not read would count for its body's mass."""
    low, high = spec.compiler.inertiagrouprange
    if not geom.name.startswith(UNSHAPED) or not low <= geom.group <= high:
        return False
    return bool(geom.density != 0.0 if np.isnan(geom.mass) else geom.mass != 0.0)


def _within_a_joint(model: Any, body: int) -> bool:
    """Whether earlier exports made the body, within a joint of several coordinates: it is called
    "X link", and its joint X.1, X.2, ....
    """
    stem, link, primes = model.body(body).name.rpartition(" link")
    if not link or primes.strip("'") or not model.body_jntnum[body]:
        return False
    return bool(model.joint(int(model.body_jntadr[body])).name.rpartition(".")[0] == stem)


class Gears:
    """Ratios of the actuators of joints, with those that their classes tell."""

    def __init__(self, root: _Element) -> None:
        self._by_class: dict[str, str] = {}
        for top in root.iterfind("default"):
            self._gather(top, "1")
            self._by_class.setdefault("main", self._by_class[top.get("class") or "main"])

    def _gather(self, default: _Element, gear: str) -> None:
        for element in default.iterchildren():
            gear = str(element.get("gear", gear)) if element.tag not in _SECTIONS else gear
        self._by_class[default.get("class") or "main"] = gear
        for inner in default.iterchildren("default"):
            self._gather(inner, gear)

    def of(self, actuator: _Element) -> str:
        """The text of an actuator's `gear`."""
        known = self._by_class.get(actuator.get("class") or "main", "1")
        return str(actuator.get("gear", known))


_SECTIONS = ("default", "joint", "geom", "site", "camera", "light", "pair", "equality", "tendon")
