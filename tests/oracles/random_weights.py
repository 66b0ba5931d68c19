"""What weighs and resists in random MJCF models, and how they write numbers and places."""

from __future__ import annotations

from typing import Any

import numpy as np

Rng = np.random.Generator
GEOM = '<geom type="box" size="0.1 0.2 0.3" pos="0.1 0 0.2" mass="1"/>'


def numbers(values: Any) -> str:
    return " ".join(repr(float(v)) for v in np.atleast_1d(values))


def turn(rng: Rng) -> str:
    """A random orientation in one of MJCF's five ways, or none."""
    v = rng.normal(size=6)
    sizes = {"quat": 4, "axisangle": 4, "euler": 3, "xyaxes": 6, "zaxis": 3, "": 0}
    way = str(rng.choice(list(sizes)))
    return f'{way}="{numbers(v[: sizes[way]])}"' if way else ""


def place(rng: Rng) -> str:
    return f'pos="{numbers(rng.normal(size=3).round(3))}" {turn(rng)}'


class Weights:
    """What weighs and resists; random in a row of its own, so that poses are those of the seed."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng([seed, 1])

    def chance(self, p: float) -> bool:
        return bool(self.rng.random() < p)

    def option(self) -> str:
        told = f' gravity="{numbers(self.rng.normal(size=3) * 9)}"' if self.chance(0.5) else ""
        flags = [f for f in ("gravity", "spring", "damper", "frictionloss") if self.chance(0.05)]
        inside = " ".join(f'{flag}="disable"' for flag in flags)
        return f"<option{told}>" + (f"<flag {inside}/>" if flags else "") + "</option>\n"

    def resistance(self, kind: str) -> str:
        """Of a hinge or slide, some of it left to its class."""
        said = {key: self.rng.random() for key in ("armature", "damping") if self.chance(0.4)}
        if kind != "ball":
            said |= {key: self.rng.random() for key in ("frictionloss", "stiffness")
                     if self.chance(0.3)}  # fmt: skip
            said |= {"springref": self.rng.normal()} if self.chance(0.3) else {}
        return " ".join(f'{key}="{value!r}"' for key, value in said.items())

    def gear(self) -> str:
        return f' gear="{self.rng.integers(2, 9)}"' if self.chance(0.3) else ""

    def body(self) -> list[str]:
        """Shapes, an inertial, or both."""
        rng = self.rng
        shapes = [
            GEOM,
            f'<geom type="sphere" size="0.2" density="300" {place(rng)}/>',
            f'<geom type="capsule" fromto="0 0 0 {numbers(rng.normal(size=3))}" size="0.05"/>',
            f'<geom type="cylinder" size="0.1 0.3" {place(rng)} group="{rng.integers(6)}"/>',
        ]
        made = [GEOM, *rng.permutation(np.array(shapes))[: rng.integers(3)]]
        if self.chance(0.4):
            made.append(self.inertial())
        return made

    def inertial(self) -> str:
        rng = self.rng
        points = rng.normal(size=(6, 3)) * 0.3
        tensor = np.einsum("ij,ij->", points, points) * np.eye(3) - points.T @ points
        where = f'pos="{numbers(rng.normal(size=3))}" mass="{rng.random() + 0.5!r}"'
        if self.chance(0.5):
            six = [tensor[k] for k in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
            return f'<inertial {where} fullinertia="{numbers(six)}"/>'
        moments = rng.permutation(np.linalg.eigvalsh(tensor))
        return f'<inertial {where} {turn(rng)} diaginertia="{numbers(moments)}"/>'
