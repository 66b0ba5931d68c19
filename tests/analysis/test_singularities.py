"""Singular configurations where plane geometry says they are."""

from __future__ import annotations

import numpy as np
import pytest
from replays import replayed
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

import parakin
from parakin.cli.main import main
from parakin.motion.laws import Law, constant, from_laws, polynomial345
from parakin.motion.motion import Motion
from parakin.motion.sampled import from_arrays


def time_of(law: Law, value: float, low: float, high: float) -> float:
    return float(brentq(lambda t: float(law(np.array([t]))[0][0]) - value, low, high, xtol=1e-15))


def moving(solver: parakin.Solver, name: str, law: Law, rate: float) -> Motion:
    """A second in which one driven coordinate moves and the others rest at home."""
    laws = {n: constant(solver.home[n]) for n in solver.driven} | {name: law}
    return from_laws("moving", laws, 1.0, rate)


@pytest.mark.parametrize("rate", [60.0, 1000.0])
def test_a_five_bar_crosses_type_2_where_its_distal_links_align(rate: float) -> None:
    # Elbows at (+-220, 90) mm: 120-90-150 triangles from the motors; both distal links are 220 mm.
    solver = parakin.compile("five-bar", machine_code=False)
    down = polynomial345(0.26, -0.21, 1.0)
    motion = from_laws("down", {"platform.x": constant(0.0), "platform.y": down}, 1.0, rate)
    result = parakin.require_solved(solver.solve(motion))
    near = parakin.singularities(solver, result)
    (crossing,) = near.crossings
    assert crossing.kind == "type 2"
    # Between samples the motion is a quintic; at 60 Hz that is what limits the time found.
    exact = time_of(down, 0.09, 0.0, 1.0)
    assert abs(crossing.time - exact) < 1e-9
    assert crossing.words == "the platform moves along y with the actuators locked (A1 and A2)"
    assert not crossing.ends
    assert float(near.type2.min()) < 0.05
    assert float(near.type1.min()) > 0.2


def test_a_five_bar_stops_where_an_arm_is_stretched() -> None:
    solver = parakin.compile("five-bar", machine_code=False)
    up = polynomial345(0.26, 0.2, 1.0)
    motion = from_laws("up", {"platform.x": constant(0.0), "platform.y": up}, 1.0, 1000.0)
    result = solver.solve(motion)
    reach = np.sqrt(0.37**2 - 0.1**2)  # both arms straight, motors 100 mm from the middle
    first = int(np.argmax(result.status.values != 0))
    y = motion.samples().position[1]
    assert y[first - 1] <= reach <= y[first]
    near = parakin.singularities(solver, result, motion)
    assert float(np.nanmin(near.type1)) < 0.1
    assert np.isnan(near.type1[first:]).all()
    (ending,) = near.crossings
    assert ending.kind == "type 1"
    assert ending.ends
    assert ending.words == "A1 and A2 move while the platform rests"
    assert abs(ending.time - time_of(up, reach, 0.0, 1.0)) < 1e-9


def test_a_rocker_has_two_dead_centres_in_a_turn() -> None:
    solver = parakin.compile("four-bar", machine_code=False)
    a, b, c, d = (solver.graph.parameters[n] for n in "abcd")
    turning = polynomial345(solver.home["A"], 2 * np.pi, 1.0)
    near = parakin.singularities(
        solver, solver.solve(from_laws("turn", {"A": turning}, 1.0, 500.0))
    )
    stretched = np.arccos(((a + b) ** 2 + d**2 - c**2) / (2 * (a + b) * d))
    folded = np.pi + np.arccos(((b - a) ** 2 + d**2 - c**2) / (2 * (b - a) * d))
    angles = sorted(
        start + 2 * np.pi * k
        for start in (stretched, folded)
        for k in (-1, 0, 1, 2)
        if solver.home["A"] < start + 2 * np.pi * k < solver.home["A"] + 2 * np.pi
    )
    times = [time_of(turning, angle, 0.0, 1.0) for angle in angles]
    assert [crossing.kind for crossing in near.crossings] == ["type 1", "type 1"]
    assert [c.time for c in near.crossings] == pytest.approx(times, abs=1e-9)
    assert {c.words for c in near.crossings} == {"A moves while D rests"}


def test_the_flight_simulator_meets_none_in_its_examples() -> None:
    solver = parakin.compile("flight-simulator")
    for motion in ("vertical", "rectilinear", "general"):
        near = parakin.singularities(solver, solver.solve(motion))
        assert near.crossings == ()
        assert near.type1.min() > 0.1
        assert near.type2.min() > 0.1


def test_without_actuators_there_is_no_saying() -> None:
    mechanism = parakin.load("four-bar")
    passive = mechanism.model_copy(
        update={"joints": tuple(j.model_copy(update={"actuated": False}) for j in mechanism.joints)}
    )
    solver = parakin.compile(passive, machine_code=False)
    with pytest.raises(parakin.InputError, match="0 actuated coordinates and 1 driven"):
        parakin.singularities(
            solver, solver.solve(from_laws("rest", {"A": constant(1.0)}, 0.1, 50.0))
        )


def test_the_command_says_how_near(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["solve", "flight-simulator", "general", "--singularities"]) == 0
    said = capsys.readouterr().err
    assert "type 1 (actuators move, outputs rest): least" in said
    assert "type 2 (outputs move, actuators are locked): least" in said
    assert "all closure rows: least" in said


def test_an_octahedral_hexapod_turned_a_quarter_meets_fichters_singularity() -> None:
    """Fichter (1986): turned by 90 degrees about its normal, whatever its height, the platform of
    a symmetric hexapod moves on a screw along that normal with all legs locked.
    """
    solver = parakin.compile("gough-stewart", machine_code=False)
    turning = polynomial345(0.0, 2.0, 1.0)
    motion = moving(solver, "platform.yaw", turning, 200.0)
    near = parakin.singularities(solver, solver.solve(motion), motion)
    (crossing,) = near.crossings
    assert crossing.kind == "type 2"
    assert abs(crossing.time - time_of(turning, np.pi / 2, 0.0, 1.0)) < 1e-9
    assert crossing.words.startswith("the platform turns about its own z, advancing -")
    # With base radius 1.2, platform 0.7: all legs have one moment over one height, from the
    # lines through A and B = A + leg: pitch = -(A x B).z / (B - A).z, the same for all six.
    a, b = leg_ends(np.pi / 2)
    pitches = -np.cross(a, b - a)[:, 2] / (b - a)[:, 2]
    assert np.ptp(pitches) < 1e-12
    assert f"advancing {2e3 * np.pi * pitches[0]:.3f} mm a turn" in crossing.words


def leg_ends(yaw: float) -> tuple[np.ndarray, np.ndarray]:
    half = np.radians(10)
    base = np.radians([0, 0, 120, 120, 240, 240]) + half * np.array([-1, 1, -1, 1, -1, 1])
    top = np.radians([-60, 60, 60, 180, 180, -60]) + half * np.array([1, -1, 1, -1, 1, -1]) + yaw
    height = parakin.compile("gough-stewart", machine_code=False).home["platform.z"]
    a = 1.2 * np.stack([np.cos(base), np.sin(base), 0 * base], axis=1)
    b = 0.7 * np.stack([np.cos(top), np.sin(top), 0 * top], axis=1) + [0, 0, height]
    return a, b


def test_a_3_upu_loses_a_constraint_where_its_three_moments_are_in_a_plane() -> None:
    """Each leg of a translating 3-UPU forbids one turn, about the normal of its two axes on
    either body. (Zlatanov, Bonev and Gosselin 2002: a constraint singularity.) Lowered onto the
    base, the three normals come to lie in its plane: the platform can turn, whatever is driven.
    """
    solver = parakin.compile("3-upu", machine_code=False)
    height = solver.home["platform.z"]
    down = polynomial345(height, -1.5 * height, 1.0)
    motion = moving(solver, "platform.z", down, 500.0)
    near = parakin.singularities(solver, solver.solve(motion), motion)
    assert float(np.nanmin(near.whole)) < 0.02 * float(np.nanmax(near.whole))
    assert {c.kind for c in near.crossings} == {"constraint"}
    (crossing,) = near.crossings
    assert abs(crossing.time - time_of(down, 0.0, 0.0, 1.0)) < 1e-9


def test_outputs_are_found_where_the_actuators_are_driven_by_the_file() -> None:
    mechanism = parakin.load("delta")
    forward = mechanism.model_copy(
        update={"driven": tuple(j.name for j in mechanism.joints if j.actuated)}
    )
    both = []
    for given in (mechanism, forward):
        solver = parakin.compile(given, machine_code=False)
        rest = from_laws("rest", {n: constant(solver.home[n]) for n in solver.driven}, 0.1, 50.0)
        near = parakin.singularities(solver, solver.solve(rest))
        both.append((near.type1[0], near.type2[0]))
    np.testing.assert_allclose(both[0], both[1], atol=1e-12)


def test_undefined_angles_of_the_platform_are_no_singularity_of_the_mechanism() -> None:
    """At a pitch of 90 degrees roll and yaw are one; the hexapod's six leg lines, though, are
    independent there (their Plücker coordinates by NumPy).
    """
    solver = parakin.compile("gough-stewart", machine_code=False)
    pitching = polynomial345(0.0, 1.75, 1.0)
    motion = moving(solver, "platform.pitch", pitching, 201.0)
    result = parakin.require_solved(solver.solve(motion))
    near = parakin.singularities(solver, result, motion)
    assert near.crossings == ()
    i = int(np.argmin(np.abs(motion.samples().position[4] - np.pi / 2)))
    a, b = leg_ends(0.0)
    middle = np.array([0.0, 0.0, b[0, 2]])
    b = (b - middle) @ np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]) + middle
    lines = (b - a) / np.linalg.norm(b - a, axis=1, keepdims=True)
    assert abs(np.linalg.det(np.hstack([lines, np.cross(b - middle, lines)]))) > 0.01
    assert near.type2[i] > 0.1
    # Driven by its legs it passes that place too, and tells the same orientation.
    legs = [f"P{k}" for k in range(1, 7)]
    forward = parakin.compile("gough-stewart", legs, machine_code=False)
    passed = parakin.require_solved(forward.solve(replayed(result, legs)))
    angles = ["platform.roll", "platform.pitch", "platform.yaw"]
    there, here = (
        Rotation.from_euler("XYZ", told.position.sel(coordinate=angles).values).as_matrix()
        for told in (passed, result)
    )
    np.testing.assert_allclose(there, here, atol=1e-10)
    places = ["platform.x", "platform.y", "platform.z"]
    off = passed.position.sel(coordinate=places) - result.position.sel(coordinate=places)
    assert float(np.abs(off).max()) < 1e-10


def test_several_freedoms_are_counted() -> None:
    """A 3-RPS lowered into the plane of its three hinges: heave, roll and pitch are all free."""
    solver = parakin.compile("3-rps", machine_code=False)
    height = solver.home["platform.z"]
    down = polynomial345(height, -1.3 * height, 1.0)
    motion = moving(solver, "platform.z", down, 400.0)
    near = parakin.singularities(solver, solver.solve(motion), motion)
    (crossing,) = near.crossings
    assert crossing.kind == "type 2"
    assert crossing.words.endswith("; 3 freedoms in all")
    assert abs(crossing.time - time_of(down, 0.0, 0.0, 1.0)) < 1e-8


def test_times_counted_from_long_ago_are_located_as_well_as_they_can_be() -> None:
    solver = parakin.compile("five-bar", machine_code=False)
    down = polynomial345(0.26, -0.21, 1.0)
    t = np.linspace(0.0, 1.0, 201)
    rows = [np.stack([constant(0.0)(t)[k], down(t)[k]]) for k in range(3)]
    motion = from_arrays("down", ["platform.x", "platform.y"], 1.7e9 + t, *rows)
    near = parakin.singularities(solver, solver.solve(motion), motion)
    (crossing,) = near.crossings
    assert abs(crossing.time - 1.7e9 - time_of(down, 0.09, 0.0, 1.0)) < 2e-6


def test_singularities_of_another_motion_are_refused() -> None:
    solver = parakin.compile("five-bar", coordinates=["A1", "A2"], machine_code=False)
    motion = solver.motion("circle")
    result = solver.solve(motion)
    assert parakin.singularities(solver, result, motion).crossings == ()
    with pytest.raises(parakin.InputError, match="the motion that was solved"):
        parakin.singularities(solver, result, solver.motion("circle", rate=50))
    with pytest.raises(parakin.InputError, match="them, or the motion too"):
        parakin.singularities(solver, result)
