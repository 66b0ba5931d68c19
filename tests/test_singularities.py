"""Singular configurations where plane geometry says they are."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

import parakin
from parakin.cli import main
from parakin.motion import Law, constant, from_laws, polynomial345


def time_of(law: Law, value: float, low: float, high: float) -> float:
    return float(brentq(lambda t: float(law(np.array([t]))[0][0]) - value, low, high, xtol=1e-15))


@pytest.mark.parametrize("rate", [60.0, 1000.0])
def test_a_five_bar_crosses_type_2_where_its_distal_links_align(rate: float) -> None:
    # Elbows at (+-220, 90) mm: 120-90-150 triangles from the motors; both distal links are 220 mm.
    solver = parakin.compile("five-bar", machine_code=False)
    down = polynomial345(0.26, -0.21, 1.0)
    motion = from_laws("down", {"platform.x": constant(0.0), "platform.y": down}, 1.0, rate)
    result = parakin.require_solved(solver.solve(motion))
    near = solver.singularities(result)
    (crossing,) = near.crossings
    assert crossing.type == 2
    # Between samples the motion is a quintic; at 60 Hz that is what limits the time found.
    exact = time_of(down, 0.09, 0.0, 1.0)
    assert abs(crossing.time - exact) < 1e-9
    assert crossing.words == "platform.y can move while A1, A2 are locked"
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
    near = solver.singularities(result)
    assert float(np.nanmin(near.type1)) < 0.1
    assert np.isnan(near.type1[first:]).all()


def test_a_rocker_has_two_dead_centres_in_a_turn() -> None:
    solver = parakin.compile("four-bar", machine_code=False)
    a, b, c, d = (solver.graph.parameters[n] for n in "abcd")
    turning = polynomial345(solver.home["A"], 2 * np.pi, 1.0)
    near = solver.singularities(solver.solve(from_laws("turn", {"A": turning}, 1.0, 500.0)))
    stretched = np.arccos(((a + b) ** 2 + d**2 - c**2) / (2 * (a + b) * d))
    folded = np.pi + np.arccos(((b - a) ** 2 + d**2 - c**2) / (2 * (b - a) * d))
    angles = sorted(
        start + 2 * np.pi * k
        for start in (stretched, folded)
        for k in (-1, 0, 1, 2)
        if solver.home["A"] < start + 2 * np.pi * k < solver.home["A"] + 2 * np.pi
    )
    times = [time_of(turning, angle, 0.0, 1.0) for angle in angles]
    assert [crossing.type for crossing in near.crossings] == [1, 1]
    assert [c.time for c in near.crossings] == pytest.approx(times, abs=1e-9)
    assert {c.words for c in near.crossings} == {"A can move while D are locked"}


def test_the_flight_simulator_meets_none_in_its_examples() -> None:
    solver = parakin.compile("flight-simulator")
    for motion in ("vertical", "rectilinear", "general"):
        near = solver.singularities(solver.solve(motion))
        assert near.crossings == ()
        assert near.type1.min() > 0.1
        assert near.type2.min() > 0.1


def test_without_actuators_there_is_no_saying() -> None:
    mechanism = parakin.load("four-bar")
    passive = mechanism.model_copy(
        update={"joints": tuple(j.model_copy(update={"actuated": False}) for j in mechanism.joints)}
    )
    solver = parakin.compile(passive, machine_code=False)
    with pytest.raises(parakin.InputError, match="0 actuated coordinates"):
        solver.singularities(solver.solve(from_laws("rest", {"A": constant(1.0)}, 0.1, 50.0)))


def test_the_command_says_how_near(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["solve", "flight-simulator", "general", "--singularities"]) == 0
    said = capsys.readouterr().err
    assert "type 1 (actuators move, outputs rest): nearest" in said
    assert "type 2 (outputs move, actuators are locked): nearest" in said
