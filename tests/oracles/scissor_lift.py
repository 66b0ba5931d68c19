"""Scissor lifts of many stages, and the closed form of their height."""

from __future__ import annotations

import math
import tomllib

import numpy as np

from parakin import Mechanism
from parakin.arrays import FloatArray
from parakin.files.mechanism_toml import mechanism_from_table

LENGTH = 0.4  # of a bar [m]
HOME = math.radians(35.0)  # inclination of the bars


def scissor_lift(stages: int, *, by_slide: bool = True) -> Mechanism:
    """Bars p1, q1, p2, q2, ... crossed in pairs and pinned in the middle (M1, ...) and at their
    ends to the next pair (L1, R1, ...). The foot of p1 is fixed and turns by A, that of q1 slides
    by S; one of them drives all. T, of every bar, is its upper end.
    """
    home = {"S": LENGTH * math.cos(HOME)} if by_slide else {"A": HOME}
    guess = {"B": math.pi - HOME} | ({"A": HOME} if by_slide else {"S": LENGTH * math.cos(HOME)})
    joints = [
        _pin("A", "base", "p1", 0.0, 0.0, actuated=not by_slide),
        '[joints.S]\nkind = "prismatic"\nparent = "base"\nchild = "slider"\n'
        "on_parent = { axis = [1, 0, 0], x = [0, 1, 0] }\n"
        f"on_child = {{ axis = [1, 0, 0], x = [0, 1, 0] }}\nactuated = {str(by_slide).lower()}\n",
        _pin("B", "slider", "q1", 0.0, 0.0),
    ]
    opening = math.pi - 2 * HOME
    for i in range(1, stages + 1):
        joints.append(_pin(f"M{i}", f"p{i}", f"q{i}", LENGTH / 2, LENGTH / 2))
        guess[f"M{i}"] = opening
        if i < stages:
            joints.append(_pin(f"R{i}", f"p{i}", f"q{i + 1}", LENGTH, 0.0))
            joints.append(_pin(f"L{i}", f"q{i}", f"p{i + 1}", LENGTH, 0.0))
            guess |= {f"R{i}": opening, f"L{i}": -opening}
    bars = [f"{name}{i}" for i in range(1, stages + 1) for name in "pq"]
    tables = [
        f'name = "scissor-lift-{stages}"\nup = "y"\ndriven = ["{"S" if by_slide else "A"}"]\n',
        "[home]\n" + _values(home),
        "[guess]\n" + _values(guess),
        "[bodies]\nslider = {}\n",
        *(f"{bar} = {{ points = {{ T = [{LENGTH}, 0, 0] }} }}\n" for bar in bars),
        *joints,
    ]
    return mechanism_from_table(tomllib.loads("".join(tables)), f"scissor-lift-{stages}")


def _pin(
    name: str, parent: str, child: str, there: float, here: float, *, actuated: bool = False
) -> str:
    return (
        f'[joints.{name}]\nkind = "revolute"\nparent = "{parent}"\nchild = "{child}"\n'
        f"on_parent = {{ at = [{there}, 0, 0] }}\non_child = {{ at = [{here}, 0, 0] }}\n"
        f"actuated = {str(actuated).lower()}\n"
    )


def _values(values: dict[str, float]) -> str:
    return "".join(f"{name} = {value!r}\n" for name, value in values.items())


def top(
    stages: int, slide: FloatArray, rate: FloatArray, second: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Height of the lift with its derivatives, from those of the slide: every stage is as high as
    the first, of which bar, slide and height are a right-angled triangle.
    """
    height = np.sqrt(LENGTH**2 - slide**2)
    speed = -slide * rate / height
    change = -(rate**2 + slide * second + speed**2) / height
    return stages * height, stages * speed, stages * change
