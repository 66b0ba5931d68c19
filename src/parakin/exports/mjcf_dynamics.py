"""What weighs, resists and acts in an exported MuJoCo model.

MuJoCo compiles no body that weighs nothing and moves: where the mechanism tells no masses, these
are invented, and texts in the model list which. Where it does, bodies without a mass weigh
next to nothing. MuJoCo cannot simulate these in loops: there their joints have an inertia, which
the lists tell too.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from parakin.exports.left_out import (
    ARMATURES,
    GRAVITY,
    POINT_SPRINGS,
    SPRINGS,
    comment,
    left_out,
    masses_of,
)
from parakin.files.mjcf_dynamics import (
    INVENTED_ARMATURE,
    INVENTED_DAMPING,
    INVENTED_INERTIA,
    INVENTED_MASS,
)
from parakin.model.dynamics import Passive
from parakin.model.graph import Graph
from parakin.model.masses import Mass

_SERVO = 30.0  # natural frequency of an actuator that carries the whole mechanism [rad/s]
# Of that inertia, on coordinates that move nothing of a mass: MuJoCo holds loops together with a
# force in proportion to it.
_ROTOR = 0.05
_SLIGHT = 1e-9  # of the whole mass, what a body without one has
_LEAST = 1e-13  # [kg m²] MuJoCo refuses less than a tenth of it
_SLIGHT_ROTOR = 1e-6  # in a model without loops
_NARROW = 1e-11  # of the largest moment, what the triangle inequality has to be kept by


class Weighing:
    """Gives a spec masses, and its joints what they meet. `bodies` are specs by our names."""

    def __init__(self, mujoco: Any, graph: Graph, spec: Any) -> None:
        self.mujoco, self.graph, self.spec = mujoco, graph, spec
        self.masses = {graph.bodies[k]: mass for k, mass in masses_of(graph).items()}
        self.total = sum(mass.mass for mass in self.masses.values())
        self.invented: dict[str, list[str]] = {}
        self.rotors: list[str] = []
        if self.total:
            spec.option.gravity = list(graph.dynamics.gravity)
        else:
            spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_GRAVITY

    def weigh(self, bodies: Mapping[str, Any]) -> None:
        """Gives bodies their masses; without any, MuJoCo takes those of the shapes drawn."""
        self.told: dict[str, Mass] = {}
        for name, body in bodies.items():
            if name == self.graph.bodies[0] and self.total:
                continue  # what it weighs is the ground's to carry
            mass = self.masses.get(name)
            if mass is None or not mass.mass:
                self._invent(INVENTED_MASS, body.name)
                mass = Mass(_SLIGHT * self.total)
            if not self.total:
                continue
            tensor = np.array(mass.inertia, dtype=float)
            if not tensor.any():
                if mass.mass > _SLIGHT * self.total:
                    self._invent(INVENTED_INERTIA, body.name)
                least = _SLIGHT * max(mass.mass, self.total) * self.graph.length**2
                tensor = np.eye(3) * max(least, _LEAST)
            self.told[body.name] = mass._replace(inertia=_sound(tensor))
        for body in bodies.values():
            if body.name in self.told:
                mass = self.told[body.name]
                body.explicitinertial, body.mass = True, mass.mass
                body.ipos, body.fullinertia = mass.com, _six(mass)
        if self.total:
            for geom in self.spec.geoms:
                geom.mass = 0.0

    def _invent(self, what: str, name: str) -> None:
        self.invented.setdefault(what, []).append(name)

    def resist(self) -> None:
        """Gives joints what they meet, and servos to the actuated ones."""
        graph, model = self.graph, self.spec.compile()
        mass = float(model.body_subtreemass[0])
        hinge = self.mujoco.mjtJoint.mjJNT_HINGE
        numbers = {c.name: k for k, c in enumerate(graph.coordinates)}
        inertias = {}
        for joint in self.spec.joints:
            k = numbers.get(joint.name, -1)
            met = graph.dynamics.passive.get(k, Passive())
            inertia = mass * (graph.length**2 if joint.type == hinge else 1.0)
            inertias[joint.name] = inertia
            light = model.body_subtreemass[joint.parent.id] < 1e-6 * mass
            rotor = light * (_ROTOR if model.neq else _SLIGHT_ROTOR) if self.total else _ROTOR
            joint.armature, damping = met.armature, met.viscous + met.damping
            motor = graph.dynamics.motors.get(k)
            if not joint.armature and motor is not None and motor.rotor:
                joint.armature = motor.rotor * motor.ratio**2
                self.rotors.append(joint.name)
                self._invent(INVENTED_ARMATURE, joint.name)  # no part of efforts, when read back
            elif not joint.armature and rotor:
                joint.armature = rotor * inertia
                self._invent(INVENTED_ARMATURE, joint.name)
            if not damping and rotor:
                damping = _SERVO * rotor * inertia
                self._invent(INVENTED_DAMPING, joint.name)
            joint.damping, joint.stiffness = [damping, 0.0, 0.0], [met.stiffness, 0.0, 0.0]
            joint.frictionloss = met.coulomb
            if met.stiffness:  # MuJoCo counts from the joint's zero
                home = self.spec.joint(joint.name).ref if k in graph.from_home else 0.0
                joint.springref = met.zero + home
        for coordinate in (c for c in graph.coordinates if c.actuated):
            inertia = inertias[coordinate.name]
            servo = self.spec.add_actuator(
                name=coordinate.name,
                target=coordinate.name,
                trntype=self.mujoco.mjtTrn.mjTRN_JOINT,
            )
            servo.set_to_position(kp=_SERVO**2 * inertia, kv=2 * _SERVO * inertia)

    def stretch(self, name: str, sites: tuple[str, str]) -> None:
        """Adds a spring between points as a tendon between two sites."""
        spring = next(each for each in self.graph.dynamics.springs if each.name == name)
        tendon = self.spec.add_tendon(
            name=name,
            stiffness=[spring.stiffness, 0.0, 0.0],
            damping=[spring.damping, 0.0, 0.0],
            springlength=[spring.length, spring.length],
        )
        for site in sites:
            tendon.wrap_site(site)

    def write(self, root: Any) -> None:
        """Puts masses with all digits, lists of what is invented, and a comment into the XML."""
        from lxml import etree

        for element in root.iter("body"):
            mass, written = self.told.get(element.get("name")), element.find("inertial")
            if mass is not None and written is not None:
                written.attrib.clear()
                for key, values in (
                    ("pos", mass.com),
                    ("mass", [mass.mass]),
                    ("fullinertia", _six(mass)),
                ):
                    written.set(key, " ".join(f"{float(value):.17g}" for value in values))
        for spring, element in zip(
            self.graph.dynamics.springs, root.iterfind("tendon/spatial"), strict=True
        ):
            for key in ("stiffness", "damping"):
                element.set(key, f"{getattr(spring, key):.17g}")
            element.set("springlength", f"{spring.length:.17g}")
        if self.invented:
            custom = etree.SubElement(root, "custom")
            for what, names in self.invented.items():
                etree.SubElement(custom, "text", name=what, data=", ".join(names))
        lines = left_out(self.graph, {ARMATURES, SPRINGS, POINT_SPRINGS, GRAVITY})
        light = self.invented.get(INVENTED_ARMATURE, []) if self.total else []
        light = [name for name in light if name not in self.rotors]
        if self.rotors:
            lines.append(
                f"screws and gears, but the rotors behind them of {', '.join(self.rotors)}"
            )
        if light:
            lines.append(f"bodies without a mass, but with invented inertias of {', '.join(light)}")
        comment(root, lines, [load.name for load in self.graph.dynamics.loads])


def _six(mass: Mass) -> list[float]:
    """MuJoCo's order: xx, yy, zz, xy, xz, yz."""
    tensor = mass.inertia
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    return [float(tensor[i][j]) for i, j in pairs]


def _sound(tensor: Any) -> Any:
    """A tensor as MuJoCo takes it: rounding must not break the triangle inequality."""
    a, b, c = np.linalg.eigvalsh(tensor)
    short = _NARROW * c - min(a, a + b - c)
    return tensor + max(short, 0.0) * np.eye(3)
