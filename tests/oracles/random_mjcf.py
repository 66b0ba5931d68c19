"""Random MJCF models over the language of kinematics, which close by construction.

MuJoCo itself says where bodies are; sites that close loops are put where it says that they meet in
the key frame `home`. Some models have what parakin refuses, and some a misspelt word.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray
from random_weights import GEOM, Weights, numbers, place

Array = NDArray[np.float64]
Rng = np.random.Generator
UNUSED = (
    '<option timestep="0.001" gravity="0 0 -1"/><visual><map znear="0.1"/></visual>',
    '<asset><material name="m" rgba="1 0 0 1"/><mesh name="none" file="no such file.stl"/></asset>',
    '<statistic extent="2"/><size memory="1M"/><custom><numeric name="n" data="1 2"/></custom>',
    '<contact><exclude body1="b1" body2="b2"/></contact>',
    '<sensor><framepos name="p" objtype="body" objname="b1"/></sensor>',
)
# What is refused, with a part of what is said.
REFUSED = {
    "ball range": "a range of a ball joint",
    "tendon equality": "an equality of <tendon>",
    "gear": "gears are not supported",
    "mocap": "mocap is not supported",
    "aligned": "align='true'",
    "unknown joint": "unknown joint",
    "two homes": "a second key 'home'",
    "long key": "qpos: found",
    "include": "<include>",
    "replicate": "<replicate>",
}


@dataclass
class Part:
    """A body: where it hangs, its attributes, and what is in it."""

    name: str
    parent: int
    attributes: str
    frame: str = ""
    inside: list[str] = field(default_factory=list)
    moves: int = 0  # joints that move it


@dataclass
class Model:
    """A model's text; `refused` is a part of the message where it is refused."""

    text: str
    refused: str | None = None


class Writer:
    """Writes one random model."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.weights = Weights(seed)
        self.parts: list[Part] = [Part("world", -1, "")]
        self.equalities: list[str] = []
        self.actuators: list[str] = []
        self.classes = ["main", "near", "far"]
        self.count = 0
        self.refused: str | None = None
        # Otherwise closed in the model's first pose, where couplings without offset hold too.
        self.at_home = self.chance(0.7)
        self.joined: set[tuple[int, int]] = set()

    def offset(self) -> str:
        return f"{self.rng.normal() * self.at_home:.3f}"

    def chance(self, p: float) -> bool:
        return bool(self.rng.random() < p)

    def header(self) -> str:
        rng = self.rng
        compiler = ""
        if self.chance(0.8):
            compiler += f' angle="{rng.choice(["radian", "degree"])}"'
        if self.chance(0.5):
            compiler += f' eulerseq="{rng.choice(["xyz", "ZYX", "zxZ", "XyX"])}"'
        limits = ' range="-1.5 1.5" limited="true"' if self.chance(0.5) else ""
        site = f'<site pos="{numbers(rng.normal(size=3))}" quat="{numbers(rng.normal(size=4))}"/>'
        far = f'<joint type="slide" ref="{rng.normal():.3f}" limited="auto"/><site {place(rng)}/>'
        active = '<equality active="false"/>'
        return (
            f"<compiler{compiler}/>\n<default>\n<joint axis='{numbers(rng.normal(size=3))}'"
            f'{limits} damping="0.1" armature="0.1"/>{site}<geom rgba="1 0 0 1"/>\n'
            f'<default class="near"><joint ref="{rng.normal():.3f}"/>{active}\n'
            f'<default class="far">{far}<equality active="true"/></default></default></default>\n'
        )

    def joint(self, part: Part, kind: str, name: str) -> str:
        """A hinge, slide or ball, some of it left to its class."""
        rng = self.rng
        said = f'type="{kind}"'
        said += f' name="{name}"' if name else ""
        if kind != "ball" and self.chance(0.7):
            said += f' axis="{numbers(rng.normal(size=3))}"'
        if self.chance(0.6):
            said += f' pos="{numbers(rng.normal(size=3).round(2))}"'
        if kind == "ball":
            said += ' limited="false"'
        else:
            if self.chance(0.4):
                said += f' ref="{rng.normal():.3f}"'
            if self.chance(0.4):
                said += f' range="{-rng.random() - 2:.3f} {rng.random() + 2:.3f}"'
        if self.chance(0.3):
            said += f' class="{rng.choice(self.classes)}"'
        part.moves += 1
        return f"<joint {said} {self.weights.resistance(kind)}/>"

    def screw(self, part: Part, name: str) -> None:
        """A hinge and a slide along it, on one body or on two, coupled with offsets and refs."""
        rng = self.rng
        axis = rng.normal(size=3)
        sign = rng.choice([1.0, -2.0])
        hinge = f'name="{name}" type="hinge" axis="{numbers(axis)}" ref="{rng.normal():.3f}"'
        slide = f'name="{name}s" type="slide" axis="{numbers(sign * axis)}"'
        slide += f' pos="{numbers(rng.normal(size=3))}"'
        if self.chance(0.5):
            hinge, slide = f'{hinge} limited="false"', f'{slide} range="-1 {rng.random():.3f}"'
        else:
            slide += ' limited="false"'
        hinge += f" {self.weights.resistance('hinge')}"
        slide += f" {self.weights.resistance('slide')}"
        joints = [f"<joint {hinge}/>", f'<joint {slide} ref="{rng.normal():.3f}"/>']
        part.inside += joints if self.chance(0.5) else joints[::-1]
        part.moves += 1
        one, two = (f"{name}s", name) if self.chance(0.6) else (name, f"{name}s")
        ratio = rng.choice([-1, 1]) * (0.3 + rng.random())
        self.equalities.append(
            f'<joint joint1="{one}" joint2="{two}" polycoef="{self.offset()} {ratio:.3f} 0 0 0"/>'
        )

    def body(self, number: int) -> None:
        rng = self.rng
        parent = int(rng.integers(max(0, number - 3), number))
        attributes = place(rng) + (
            f' childclass="{rng.choice(self.classes)}"' if self.chance(0.2) else ""
        )
        name = f"b{number}" if self.chance(0.9) or number < 3 else ""
        frame = f"<frame {place(rng)}>" if self.chance(0.3) else ""
        part = Part(name, parent, attributes, frame)
        self.parts.append(part)
        kind = str(
            rng.choice(
                [
                    "hinge",
                    "hinge",
                    "slide",
                    "ball",
                    "two",
                    "chain",
                    "screw",
                    "fixed",
                    "free",
                    "held",
                ]
            )
        )
        if kind == "free" and parent == 0:
            part.frame = ""
            part.inside.append(
                str(rng.choice([f'<freejoint name="f{number}"/>', '<joint type="free"/>']))
            )
            part.moves += 6
        elif kind == "two":
            part.inside += [self.joint(part, "slide", f"t{number}"), self.joint(part, "ball", "")]
        elif kind == "chain":
            self.chain(part, number)
        elif kind == "screw":
            self.screw(part, f"h{number}")
        elif kind == "held":
            part.inside.append(self.joint(part, "hinge", f"k{number}"))
            part.moves = 0
            self.equalities.append(f'<joint joint1="k{number}" polycoef="{self.offset()}"/>')
        elif kind not in ("fixed", "free"):
            named = self.chance(0.85)
            part.inside.append(self.joint(part, kind, f"j{number}" if named else ""))
            if named and kind != "ball" and self.chance(0.3):
                self.actuators.append(f'<motor joint="j{number}"{self.weights.gear()}/>')
        part.inside += self.weights.body()

    def chain(self, part: Part, number: int) -> None:
        """Hinges and slides that make one joint of parakin's, some with limits and motors."""
        kinds = ["ry", "rx"], ["rz", "rx"], ["rz", "pz"], ["rx", "ry", "rz"], ["px", "py", "rz"]
        six = ["px", "py", "pz", *self.rng.permutation(["rx", "ry", "rz"])]
        chosen = [*kinds, six][int(self.rng.integers(6))]
        for k, move in enumerate(chosen, start=1):
            name = f"c{number}.{k}"
            limits = ' range="-3 3.5"' if self.chance(0.3) else ' limited="false"'
            axis = numbers(np.eye(3)["xyz".index(move[1])])
            kind = "slide" if move[0] == "p" else "hinge"
            part.inside.append(
                f'<joint name="{name}" type="{kind}" axis="{axis}" ref="0"{limits} '
                f"{self.weights.resistance(kind)}/>"
            )
            if self.chance(0.2):
                self.actuators.append(f'<position joint="{name}"/>')
        part.moves += len(chosen)

    def below(self, number: int) -> set[int]:
        """A body and all that hang from it."""
        found = {number}
        for k in range(number + 1, len(self.parts)):
            if self.parts[k].parent in found:
                found.add(k)
        return found

    def moving_between(self, a: int, b: int) -> int:
        """How many joints move between two bodies."""

        def above(k: int) -> list[int]:
            return [] if k <= 0 else [k, *above(self.parts[k].parent)]

        return sum(self.parts[k].moves for k in set(above(a)) ^ set(above(b)))

    def text(self, key: str = "") -> str:
        inside = {k: list(part.inside) for k, part in enumerate(self.parts)}
        for k in range(len(self.parts) - 1, 0, -1):
            part = self.parts[k]
            name = f'name="{part.name}" ' if part.name else ""
            text = f"<body {name}{part.attributes}>\n" + "\n".join(inside[k]) + "\n</body>"
            inside[part.parent].append(f"{part.frame}{text}</frame>" if part.frame else text)
        actuators = "\n".join(self.actuators)
        return (
            f'<mujoco model="random">\n{self.head}<worldbody>\n<light pos="0 0 3"/>\n'
            + "\n".join(inside[0])
            + "\n</worldbody>\n<equality>\n"
            + "\n".join(self.equalities)
            + f"\n</equality>\n<actuator>{actuators}</actuator>\n{key}{self.unused}</mujoco>\n"
        )

    def write(self) -> Model:
        rng = self.rng
        self.head = self.header()
        self.head += self.weights.option()
        self.unused = "\n".join(rng.permutation(np.array(UNUSED))[: rng.integers(4)])
        for number in range(1, int(rng.integers(3, 9))):
            self.body(number)
        at = self.home()
        for number in range(int(rng.integers(0, 3))):
            self.loop(number, at)
        key = f'<key name="other"/><key name="home" qpos="{numbers(at.qpos)}"/>'
        key = f"<keyframe>{key}</keyframe>\n"
        text = self.text(key if self.at_home and at.model.nq else "")
        if self.chance(0.1):
            self.refused, text = spoil(text, rng)
        return Model(text, self.refused)

    def home(self) -> Any:
        """A pose in which held joints and screws are where they have to be."""
        model = compiled(self.text())
        data = mujoco.MjData(model)
        for j in range(model.njnt):
            k = model.jnt_qposadr[j]
            size = {0: 7, 1: 4}.get(int(model.jnt_type[j]), 1)
            data.qpos[k : k + size] = model.qpos0[k : k + size] + self.rng.normal(size=size) * 0.4
        mujoco.mj_normalizeQuat(model, data.qpos)
        follow(model, data.qpos)
        mujoco.mj_kinematics(model, data)
        return data

    def loop(self, number: int, data: Any) -> None:
        """Closes a loop between two bodies in one of MJCF's ways."""
        rng, model = self.rng, data.model
        pairs = [
            (a, b)
            for b in range(1, len(self.parts))
            for a in range(len(self.parts))
            if a != b and not {(a, b), (b, a)} & self.joined
            and self.parts[b].name and self.parts[a].name
            and self.moving_between(a, b) > (1 if self.parts[b].moves else 2)
        ]  # fmt: skip
        if not pairs:
            return
        a, b = pairs[int(rng.integers(len(pairs)))]
        self.joined.add((a, b))
        names = self.parts[a].name, self.parts[b].name
        ids = [model.body(name).id for name in names]
        kind = str(rng.choice(["connect", "connect", "weld", "weak"]))
        tag = "weld" if kind == "weak" else kind
        extra = ' torquescale="0"' if kind == "weak" else ""
        extra += str(rng.choice(["", "", ' active="false"', ' class="near"', ' class="far"']))
        if not self.at_home:
            where = f'body1="{names[0]}"' + ("" if b == 0 else f' body2="{names[1]}"')
            anchor = f' anchor="{numbers(rng.normal(size=3))}"'
            self.equalities.append(
                f"<{tag} {where}{anchor if tag == 'connect' or self.chance(0.5) else ''}{extra}/>"
            )
            return
        R = [data.xmat[k].reshape(3, 3) for k in ids]
        if tag == "weld" and self.chance(0.3):
            relative = R[0].T @ (data.xpos[ids[1]] - data.xpos[ids[0]]), quaternion(R[0].T @ R[1])
            relpose = f'relpose="{numbers(np.hstack(relative))}"'
            self.equalities.append(
                f'<weld body1="{names[0]}" body2="{names[1]}" {relpose}{extra}/>'
            )
            return
        # The first site may leave its place to its class; the second is put where that one is.
        near, far = f"s{number}a", f"s{number}b"
        own = place(rng) if self.chance(0.5) else f'class="{rng.choice(self.classes)}"'
        self.parts[a].inside.append(f'<site name="{near}" {own}/>')
        with_site = compiled(self.text())
        moved = mujoco.MjData(with_site)
        moved.qpos[:] = data.qpos
        mujoco.mj_kinematics(with_site, moved)
        at, turned = moved.site(near).xpos, moved.site(near).xmat.reshape(3, 3)
        p, q = R[1].T @ (at - data.xpos[ids[1]]), quaternion(R[1].T @ turned)
        said = f'class="main" pos="{numbers(p)}" quat="{numbers(q)}"'
        self.parts[b].inside.append(f'<site name="{far}" {said}/>')
        ends = f'site1="{near}" site2="{far}"'
        self.equalities.append(f'<{tag} name="loop {number}" {ends}{extra}/>')


def compiled(text: str) -> Any:
    """The model in MuJoCo, without the mesh that does not exist."""
    return mujoco.MjModel.from_xml_string(
        text.replace('<mesh name="none" file="no such file.stl"/>', "")
    )


def quaternion(R: Array) -> Array:
    q = np.empty(4)
    mujoco.mju_mat2Quat(q, np.ascontiguousarray(R).ravel())
    return q


def follow(model: Any, qpos: Array) -> None:
    """Puts held joints and screws where MuJoCo's equations have them (of degree one)."""
    for i in range(model.neq):
        if model.eq_type[i] != mujoco.mjtEq.mjEQ_JOINT or not model.eq_active0[i]:
            continue
        one, two = int(model.eq_obj1id[i]), int(model.eq_obj2id[i])
        a, b = model.jnt_qposadr[one], model.jnt_qposadr[two]
        offset, ratio = model.eq_data[i][:2]
        if two < 0:
            qpos[a] = model.qpos0[a] + offset
        elif model.jnt_type[one] == mujoco.mjtJoint.mjJNT_SLIDE:
            qpos[a] = model.qpos0[a] + offset + ratio * (qpos[b] - model.qpos0[b])
        else:
            qpos[b] = model.qpos0[b] + (qpos[a] - model.qpos0[a] - offset) / ratio


def spoil(text: str, rng: Rng) -> tuple[str, str]:
    """The model with something that is refused; what is said of it, and the text."""
    what = str(rng.choice(list(REFUSED)))
    body = '<body name="zz">{}' + GEOM + "{}</body></worldbody>"
    joint = '<joint name="zy" type="hinge"/><joint name="zx" type="hinge"/>'
    inside = {
        "ball range": '<joint type="ball" range="0 1" limited="true"/>',
        "aligned": '<freejoint align="true"/>',
    }.get(what, joint)
    more = {"replicate": f'<replicate count="2"><body>{GEOM}</body></replicate>'}.get(what, "")
    text = re.sub("<keyframe>.*</keyframe>", "", text)  # of another number of coordinates
    text = text.replace("</worldbody>", body.format(inside, more))
    if what == "mocap":
        text = text.replace("<worldbody>", '<worldbody><body mocap="true"><geom size="1"/></body>')
    tendon = '<tendon><fixed name="zt"><joint joint="zy" coef="1"/></fixed></tendon>'
    end = {
        "tendon equality": f'{tendon}\n<equality><tendon tendon1="zt"/></equality>',
        "gear": '<equality><joint joint1="zy" joint2="zx"/></equality>',
        "unknown joint": '<actuator><motor joint="zz"/></actuator>',
        "two homes": '<keyframe><key name="home"/><key name="home"/></keyframe>',
        "long key": f'<keyframe><key name="z" qpos="{"0 " * 99}"/></keyframe>',
        "include": '<include file="other.xml"/>',
    }.get(what, "")
    return REFUSED[what], text.replace("</mujoco>", end + "</mujoco>")
