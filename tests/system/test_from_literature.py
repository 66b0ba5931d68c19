"""Mechanisms as a reader of the documentation types them, with what textbooks know of them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from literature import GOLDBERG, JACK
from scipy.spatial.transform import Rotation

import parakin
from parakin import Status
from parakin.analysis.mobility import mobility
from parakin.files import reading as files
from parakin.kinematics.assembly import assembled
from parakin.model.evaluation import graph_of
from parakin.motion.laws import constant, from_laws, polynomial345

SCHATZ = """
name = "schatz"
title = "Schatz's linkage, the Turbula mixer"
driven = ["A"]
[parameters]
a = "100 mm"
R = "60 mm"
[guess]
A = "40 deg"
[bodies]
l1 = {}
l2 = {}
l3 = {}
l4 = {}
l5 = {}
[joints]
A = { kind = "revolute", parent = "base", child = "l1", actuated = true, on_child = { at = [0, 0, "-R"] } }
B = { kind = "revolute", parent = "l1", child = "l2", on_parent = { turns = [["x", "90 deg"]] } }
C = { kind = "revolute", parent = "l2", child = "l3", on_parent = { at = ["a", 0, 0], turns = [["x", "90 deg"]] } }
D = { kind = "revolute", parent = "l3", child = "l4", on_parent = { at = ["a", 0, 0], turns = [["x", "90 deg"]] } }
E = { kind = "revolute", parent = "l4", child = "l5", on_parent = { at = ["a", 0, 0], turns = [["x", "90 deg"]] } }
F = { kind = "revolute", parent = "l5", child = "base", on_parent = { turns = [["x", "90 deg"]] }, on_child = { at = ["-sqrt(3)*a", 0, "R"] } }
"""

PARALLELOGRAM = """
name = "parallelogram"
driven = ["A"]
[parameters]
l = "40 mm"
[home]
A = "60 deg"
[guess]
B = "-60 deg"
D = "60 deg"
[bodies]
crank = {}
coupler = {}
rocker = {}
[joints]
A = { kind = "revolute", parent = "base", child = "crank", actuated = true }
B = { kind = "revolute", parent = "crank", child = "coupler", on_parent = { at = ["l", 0, 0] } }
C = { kind = "revolute", parent = "coupler", child = "rocker", on_parent = { at = ["100 mm", 0, 0] }, on_child = { at = ["40 mm", 0, 0] } }
D = { kind = "revolute", parent = "base", child = "rocker", on_parent = { at = ["100 mm", 0, 0] } }
[platform]
body = "coupler"
"""


CRU = """
name = "3-cru"
title = "3-CRU: three translations, motors on the slides of cylindrical joints"
driven = ["C1.2", "C2.2", "C3.2"]
[parameters]
l = "300 mm"
[platform]
body = "platform"
[home]
platform = { x = "200 mm", y = "210 mm", z = "220 mm" }
[bodies]
platform = {}
[limbs.leg]
count = 3
[limbs.leg.each]
ax = [1, 0, 0]
ay = [0, 1, 0]
az = [0, 0, 1]
[limbs.leg.bodies]
"upper{i}" = {}
"lower{i}" = {}
[limbs.leg.joints]
"C{i}" = { kind = "cylindrical", parent = "base", child = "upper{i}", actuated = [2], on_parent = { axis = ["ax", "ay", "az"], x = ["ay", "az", "ax"] } }
"B{i}" = { kind = "revolute", parent = "upper{i}", child = "lower{i}", on_parent = { at = ["l", 0, 0] } }
"U{i}" = { kind = "universal", parent = "lower{i}", child = "platform", on_parent = { at = ["l", 0, 0] }, on_child = { axis = ["ay", "az", "ax"], x = ["-ax", "-ay", "-az"] } }
[limbs.leg.guess]
"C{i}.2" = "200 mm"
"B{i}" = "100 deg"
"""


@pytest.fixture(name="typed")
def _typed(tmp_path: Path) -> Path:
    for name, text in (
        ("goldberg", GOLDBERG),
        ("schatz", SCHATZ),
        ("parallelogram", PARALLELOGRAM),
        ("jack", JACK),
        ("3-cru", CRU),
    ):
        (tmp_path / f"{name}.toml").write_text(text)
    return tmp_path


def turned(path: Path, driven: str, by: float, samples: int = 1000) -> dict[str, np.ndarray]:
    """All coordinates over a motion of one, solved at every sample."""
    solver = parakin.compile(path, driven, coordinates="all", machine_code=False)
    law = polynomial345(solver.home[driven], by, 1.0)
    result = parakin.require_solved(solver.solve(from_laws("turn", {driven: law}, 1.0, samples)))
    return {n: result.position.sel(coordinate=n).values for n in result.coordinate.values.tolist()}


def chain_gap(joints: list[tuple[np.ndarray, float, float, float]]) -> float:
    """How far a chain of (angle about z, offset along z, length along x, twist about x) is from
    closing, by SciPy's rotations: radians and metres.
    """
    turned, at = Rotation.identity(), np.zeros(3)
    for angle, offset, length, twist in joints:
        turned = turned * Rotation.from_euler("z", angle[:, None])
        at = at + turned.apply([length, 0.0, offset])
        turned = turned * Rotation.from_euler("x", twist)
    return max(float(turned.magnitude().max()), float(np.abs(at).max()))


@pytest.mark.parametrize("driven", ["A", "B", "C", "D"])
def test_goldbergs_linkage_turns_by_bennetts_relations(typed: Path, driven: str) -> None:
    q = turned(typed / "goldberg.toml", driven, 2 * np.pi)
    alpha, beta, gamma = np.radians([40, 75, 55])
    # tan(A/2) tan(B/2) and tan(A/2) / tan(C/2), free of poles
    for other, twist, sign in (("B", beta, 1), ("C", gamma, -1)):
        high, low = np.sin((twist + alpha) / 2), np.sin((twist - alpha) / 2)
        s, c = np.sin(q["A"] / 2), np.cos(q["A"] / 2)
        u, v = np.sin(q[other] / 2), np.cos(q[other] / 2)
        relation = low * s * u - high * c * v if sign > 0 else high * s * v - low * c * u
        np.testing.assert_allclose(relation, 0.0, atol=1e-13)


@pytest.mark.parametrize(("driven", "other"), [("A", "F"), ("F", "A")])
def test_schatzs_linkage_turns_both_its_base_cranks_fully(
    typed: Path, driven: str, other: str
) -> None:
    q = turned(typed / "schatz.toml", driven, 2 * np.pi)
    assert abs(q[other][-1] - q[other][0]) == pytest.approx(2 * np.pi, abs=1e-12)
    quarter, a = np.pi / 2, 0.1
    lengths = {"A": 0.0, "B": a, "C": a, "D": a, "E": 0.0, "F": np.sqrt(3) * a}
    offsets = {"A": 0.06, "F": -0.06}
    twists = dict.fromkeys("ABCDE", quarter) | {"F": 0.0}
    chain = [(q[n], offsets.get(n, 0.0), lengths[n], twists[n]) for n in "ABCDEF"]
    assert chain_gap(chain) < 1e-12


def test_a_parallelogram_is_flagged_where_it_folds_flat(typed: Path) -> None:
    solver = parakin.compile(typed / "parallelogram.toml", machine_code=False)
    law = polynomial345(solver.home["A"], 2 * np.pi, 1.0)
    motion = from_laws("turn", {"A": law}, 1.0, 1000.0)
    result = solver.solve(motion)
    flat = law(result.time.values)[0] >= np.pi
    first = int(np.argmax(flat))
    assert not result.status.values[:first].any()
    assert result.status.values[first] > 0
    (ending,) = parakin.singularities(solver, result, motion).crossings
    assert ending.kind == "constraint"
    assert solver.at([np.pi]).status == Status.SINGULAR


def test_a_parallelogram_has_its_crossed_twin(typed: Path) -> None:
    for near in (None, {"D": -1.8645}):
        solver = parakin.compile(typed / "parallelogram.toml", near=near, machine_code=False)
        found = parakin.modes(solver).modes
        rocker = sorted(branch.coordinates["D"] for branch in found)
        # Crossed, crank and rocker mirror each other about the bisector of their pivots.
        x, y = 40 * np.cos(np.pi / 3) - 100, 40 * np.sin(np.pi / 3)
        crossed = 2 * np.arctan2(y, x) - np.pi / 3
        crossed -= 2 * np.pi * np.round((crossed + np.pi / 2) / (2 * np.pi))
        mirrored = np.arctan2(np.sin(rocker), np.cos(rocker))
        assert len(rocker) == 2
        assert np.cos(mirrored - np.pi / 3).max() == pytest.approx(1.0)
        other = float(mirrored[np.argmin(np.cos(mirrored - np.pi / 3))])
        tip = np.array([100 + 40 * np.cos(other), 40 * np.sin(other)])
        crank = np.array([40 * np.cos(np.pi / 3), 40 * np.sin(np.pi / 3)])
        assert np.linalg.norm(tip - crank) == pytest.approx(100.0)


@pytest.mark.parametrize("off", [1e-10, 1e-8, 1e-6])
def test_a_parallelogram_a_little_off_is_none(typed: Path, off: float) -> None:
    """Its rocker no longer follows the crank exactly; by how much, two circles tell."""
    solver = parakin.compile(
        typed / "parallelogram.toml", parameters={"l": 0.04 + off}, machine_code=False
    )
    a = np.radians(np.linspace(60, 150, 200))
    d = solver.at(a[None, :]).position[solver.coordinates.index("D")]
    crank = (0.04 + off) * np.stack([np.cos(a), np.sin(a)])
    rocker = np.stack([0.1 + 0.04 * np.cos(d), 0.04 * np.sin(d)])
    np.testing.assert_allclose(np.linalg.norm(rocker - crank, axis=0), 0.1, rtol=1e-14)


@pytest.mark.parametrize("driven", ["H", "S", "G", "A", "E"])
def test_a_jack_rises_as_its_screw_turns(typed: Path, driven: str) -> None:
    by = {"H": -40.0, "S": 40.0, "G": 0.06, "A": 0.3, "E": 0.3}[driven]
    q = turned(typed / "jack.toml", driven, by, 400)
    across = 4e-3 * q["H"] / (2 * np.pi)
    np.testing.assert_allclose(q["G"], 2 * np.sqrt(0.15**2 - across**2 / 4), rtol=1e-12)


def test_motors_on_the_slides_of_cylindrical_joints(typed: Path) -> None:
    solver = parakin.compile(typed / "3-cru.toml", machine_code=False)
    laws = {n: polynomial345(solver.home[n], 0.02 * k, 1.0) for k, n in enumerate(solver.driven)}
    result = parakin.require_solved(solver.solve(from_laws("m", laws, 1.0, 50.0)))
    assert result.coordinate.values[result.actuated.values].tolist() == ["C1.2", "C2.2", "C3.2"]
    for slide, axis in zip(solver.driven, "xyz", strict=True):
        rises = result.position.sel(coordinate=[slide, f"platform.{axis}"]).values
        np.testing.assert_allclose(np.diff(rises, axis=1), np.diff(rises, axis=1)[0, 0], atol=1e-13)
    near = parakin.singularities(solver, result)
    np.testing.assert_allclose(near.type1, np.sqrt(0.5), rtol=1e-12)  # slides are coordinates
    np.testing.assert_allclose(near.type2, np.sqrt(0.5), rtol=1e-12)


@pytest.mark.parametrize("digits", [6, 8, 9, 10, 12])
def test_a_delta_typed_with_decimals(tmp_path: Path, digits: int) -> None:
    """Rounded directions tilt the platform by as much: less than shows, more than round-off."""
    written = files.expanded("delta", {})
    for k, angle in enumerate(np.radians([0, 120, 240]), start=1):
        for name, value in (("sin", np.sin(angle)), ("cos", np.cos(angle))):
            written = written.replace(f"{name}(arm{k}_angle)", f"({value:.{digits}f})")
    assert "arm2_angle)" not in written
    path = tmp_path / "delta.toml"
    path.write_text(written)
    solver = parakin.compile(path, machine_code=False)
    result = parakin.require_solved(solver.solve("spiral"))
    assert float(result.residual.max()) < 1e-12


def test_a_delta_has_sixteen_assemblies_among_them_its_mirror_image() -> None:
    """Sixteen: as many as Newton's iteration from random poses of six rods finds."""
    solver = parakin.compile("delta", driven=["A1", "A2", "A3"], machine_code=False)
    found = parakin.modes(solver).modes
    heights = [b.coordinates["platform.z"] for b in found if level(b.coordinates)]
    assert len(found) == 16
    # The elbows, a sine of the arms below the motors, are half way between it and its image.
    p = solver.graph.parameters
    elbow = -p["arm"] * np.sin(solver.home["A1"])
    for height in heights:
        assert any(2 * elbow - height == pytest.approx(other, abs=1e-9) for other in heights)
    assert solver.home["platform.z"] == pytest.approx(min(heights), abs=1e-9)


def test_the_textbook_delta_has_twelve_idle_freedoms() -> None:
    """Balls at all corners of the parallelograms: six rods and six crossbars spin (Lynch and Park,
    Modern Robotics, example 2.7: 15 freedoms). It moves as with hinges there.
    """
    hinged = parakin.load("delta-revolute")
    joints = tuple(
        joint.model_copy(update={"kind": "spherical"}) if joint.name[0] in "CDEF" else joint
        for joint in hinged.joints
    )
    balls = hinged.model_copy(update={"joints": joints})
    driven = ["platform.x", "platform.y", "platform.z"]
    solvers = [parakin.compile(m, driven, machine_code=False) for m in (hinged, balls)]
    graph = graph_of(balls)
    found = mobility(graph, assembled(graph))
    assert (found.generic, len(found.idle)) == (15, 12)
    move = 0.05 * np.random.default_rng(0).uniform(-1, 1, (3, 50))
    motors = []
    for solver in solvers:
        tick = solver.at(np.array([[solver.home[n]] for n in driven]) + move)
        assert not np.any(tick.status)
        motors.append(tick.position[[solver.coordinates.index(n) for n in ("A1", "A2", "A3")]])
    np.testing.assert_allclose(motors[0], motors[1], rtol=0, atol=1e-12)


def test_a_link_that_dangles_is_not_idle() -> None:
    """A crank beside a four-bar, on a hinge and nothing else: it is for the user to hold."""
    mechanism = parakin.load("four-bar")
    beside = mechanism.model_copy(
        update={
            "bodies": (*mechanism.bodies, parakin.Body(name="beside")),
            "joints": (
                *mechanism.joints,
                parakin.Joint(name="E", kind="revolute", parent="base", child="beside"),
            ),
        }
    )
    with pytest.raises(parakin.DrivenError, match="not determined: E"):
        parakin.compile(beside, machine_code=False)


def level(at: Mapping[str, float]) -> bool:
    return all(abs(at[f"platform.{n}"]) < 1e-6 for n in ("roll", "pitch", "yaw"))


def test_rest_far_from_home_is_reached(typed: Path) -> None:
    """A motion may begin anywhere that can be reached straight from home."""
    legs = [f"P{i}" for i in range(1, 7)]
    inverse = parakin.compile("gough-stewart", machine_code=False)
    pose = [inverse.home[n] for n in inverse.driven]
    pose[2:4] = [pose[2] + 0.2, 0.3]
    at = inverse.at(pose).position
    lengths = [float(at[inverse.coordinates.index(leg)]) for leg in legs]
    forward = parakin.compile("gough-stewart", legs, machine_code=False)
    rest = from_laws("rest", dict(zip(legs, map(constant, lengths), strict=True)), 0.01, 1000.0)
    result = parakin.require_solved(forward.solve(rest))
    found = result.position.sel(coordinate=list(inverse.driven)).values
    np.testing.assert_allclose(found, np.array(pose)[None, :] + np.zeros_like(found), atol=1e-12)
