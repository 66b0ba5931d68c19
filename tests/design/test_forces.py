"""Efforts as limits, and how hard a rig may move, against the balance of forces and moments on its
platform: all else has no mass.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

import parakin
from parakin.solving.solver import Solver

RIG = Path(__file__).parents[2] / "examples" / "rig.toml"
MASS, MOST, G = 400.0, 2200.0, 9.80665
INERTIA = np.array([50.0, 60.0, 90.0])


@cache
def rig(*, unlimited: bool = False) -> Solver:
    data = parakin.load(RIG).model_dump(exclude_unset=True)
    for body in data["bodies"]:
        if body["name"] == "platform":
            body |= {"mass": MASS, "com": (0.0, 0.0, 0.0), "inertia": tuple(INERTIA)}
    for joint in data["joints"]:
        if joint["name"].startswith("P"):
            joint["drive"] = {"max_effort": MOST}
    if unlimited:
        data["limits"] = {}
    return parakin.compile(parakin.Mechanism(**data))


def circle(radius: float, degrees: list[float]) -> np.ndarray:
    angle = np.radians(degrees)
    return radius * np.array([np.cos(angle), np.sin(angle), 0.0 * angle])


BASE = circle(0.82, [-7, 7, 113, 127, 233, 247])
TOP = circle(0.61, [-51, 51, 69, 171, 189, -69])


def wrenches(pose: np.ndarray) -> np.ndarray:
    """Of legs that push with 1 N each, on the platform's point, (6, 6)."""
    arms = Rotation.from_euler("XYZ", pose[3:]).as_matrix() @ TOP
    legs = pose[:3, None] + arms - BASE
    along = legs / np.linalg.norm(legs, axis=0)
    return np.concatenate([along, np.cross(arms, along, axis=0)])


def pushes(pose: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Of the legs (6,), so that with its weight the platform gets this force and moment."""
    weight = np.array([0, 0, -MASS * G, 0, 0, 0])
    return np.linalg.solve(wrenches(pose), wanted - weight)


def home() -> np.ndarray:
    return np.array([0, 0, rig().home["platform.z"], 0, 0, 0])


def most(unit: np.ndarray) -> tuple[float, float]:
    """How often a wrench may be wanted, down and up, for pushes within their bounds."""
    resting, slope = pushes(home(), 0.0 * unit), np.linalg.solve(wrenches(home()), unit)
    up = np.min((np.where(slope > 0, MOST, -MOST) - resting) / slope)
    down = np.max((np.where(slope > 0, -MOST, MOST) - resting) / slope)
    return float(down), float(up)


def test_accelerations_at_home_are_those_of_the_balance() -> None:
    found = parakin.range(rig())["max_acceleration"].values
    for row, inertia in enumerate([MASS, MASS, MASS, *INERTIA]):
        assert found[row] == pytest.approx(most(inertia * np.eye(6)[row]), rel=1e-9)


def test_loads_at_home_are_those_of_the_balance() -> None:
    found = parakin.range(rig())["max_load"].values
    for row in np.arange(6):
        down, up = most(-np.eye(6)[row])  # the legs give the opposite
        assert found[row] == pytest.approx([down, up], rel=1e-9)


def beyond(pose: np.ndarray) -> float:
    return float(np.abs(pushes(pose, np.zeros(6))).max() / MOST - 1.0)


@pytest.mark.parametrize("row", [0, 1, 2, 4])
def test_ways_end_where_efforts_at_rest_do(row: int) -> None:
    found = parakin.range(rig(unlimited=True), forces=True)
    way = np.eye(6)[row]
    samples = np.linspace(0.0, 1.5, 3001)
    for side, sign in enumerate((-1.0, 1.0)):
        over = (k for k, s in enumerate(samples) if beyond(home() + sign * s * way) > 0.0)
        first = next(over, None)
        away = sign * float(found["travel"].values[row, side])
        if first is None:
            assert away > 1.5
            continue
        pair = samples[first - 1], samples[first]
        where = brentq(lambda s, g=sign: beyond(home() + g * s * way), *pair, xtol=1e-15)
        assert away == pytest.approx(where, abs=1e-9)
        words = str(found["stopped_by"].values[row, side])
        leg = int(words[1]) - 1
        push = pushes(home() + sign * where * way, np.zeros(6))[leg]
        assert push == pytest.approx(MOST if ">" in words else -MOST, rel=1e-7)


@pytest.mark.parametrize("row", [0, 2])
def test_a_sine_is_as_large_as_efforts_allow(row: int) -> None:
    pytest.importorskip("heyoka")  # on arrays it takes a minute
    pulsation = 2 * np.pi * 1.2
    found = parakin.range(rig(unlimited=True), frequency=1.2, forces=True)
    amplitude = float(found["amplitude"].values[row])
    way = np.eye(6)[row]
    shares = [
        np.abs(pushes(home() + s * way, -MASS * pulsation**2 * s * way)).max() / MOST
        for s in amplitude * np.sin(np.linspace(0, 2 * np.pi, 4001))
    ]
    assert max(shares) == pytest.approx(1.0, rel=1e-6)
    assert "effort" in str(found["amplitude_limited_by"].values[row])


def test_offsets_end_where_efforts_do() -> None:
    alone = parakin.range(rig(unlimited=True), forces=True)["travel"].values[0, 1]
    found = parakin.range(rig(unlimited=True), offsets={"platform.x": 2 * alone}, forces=True)
    assert found.attrs["reached"] == pytest.approx(0.5, abs=1e-9)
    assert "effort" in found.attrs["stopped"]


def test_a_heavier_payload_leaves_less() -> None:
    light = parakin.compile(rig().mechanism.with_payload("1 kg at platform"))
    found = (
        parakin.range(light, loads={"payload": 0.0}),
        parakin.range(light, loads={"payload": 300}),
    )
    for key in ("max_load", "max_acceleration"):
        none, much = (each[key].sel(driven="platform.z").values for each in found)
        assert none == pytest.approx(parakin.range(rig())[key].values[2], rel=1e-9)
        assert much[0 if key == "max_load" else 1] ** 2 < none[0 if key == "max_load" else 1] ** 2


def test_what_is_not_known_says_why() -> None:
    bare = parakin.range(parakin.compile(RIG))
    assert "nothing that makes forces" in bare["max_acceleration"].attrs["not_known"]
    legs = parakin.compile("gough-stewart", [f"P{k}" for k in range(1, 7)])
    found = parakin.range(legs)
    assert "platform" in found["max_load"].attrs["not_known"]
    assert np.isnan(found["max_load"].values).all()


def least_singular_value(pose: np.ndarray) -> float:
    """Of the rates of the legs, in lengths of the mechanism, at home angles about x, y, z."""
    length = rig().graph.length
    turns = np.eye(3)
    roll, pitch = pose[3], pose[4]
    turns[:, 1] = Rotation.from_euler("x", roll).apply([0, 1, 0])
    turns[:, 2] = Rotation.from_euler("XY", [roll, pitch]).apply([0, 0, 1])
    by = wrenches(pose).T
    by = np.concatenate([by[:, :3], by[:, 3:] @ turns / length], axis=1)
    return float(np.linalg.svd(by, compute_uv=False)[-1])


@pytest.mark.parametrize("row", [0, 4])
def test_ways_end_where_the_legs_hold_less_firmly(row: int) -> None:
    found = parakin.range(rig(unlimited=True), least_conditioning=0.7)
    for side in (0, 1):
        assert str(found["stopped_by"].values[row, side]) == "conditioning < 0.7"
        there = home() + np.eye(6)[row] * found["travel"].values[row, side]
        ratio = least_singular_value(there) / least_singular_value(home())
        assert ratio == pytest.approx(0.7, abs=1e-9)
