"""Which assemblies could be built, against distances and lines worked out from the joints."""

from __future__ import annotations

import math

import numpy as np
import pytest

import parakin
from parakin import Body, Joint, Mechanism
from parakin.solving.usability import limits_exceeded, turned_through


def at(solver: parakin.Solver, **changed: float) -> np.ndarray:
    """Coordinates, as they are counted, at home but for some."""
    names = [c.name for c in solver.graph.coordinates]
    return np.array([changed.get(name, solver.home[name]) for name in names])


def test_a_leg_is_turned_through_where_its_length_is_negative() -> None:
    # The hexapod's legs count from 1 m, so that their lengths change sign at -1 m.
    solver = parakin.compile("gough-stewart", machine_code=False, coordinates="all")
    assert turned_through(solver.plan, at(solver)) == ()
    assert turned_through(solver.plan, at(solver, P2=-0.99)) == ()
    assert turned_through(solver.plan, at(solver, P2=-1.01, P5=-3.0)) == ("P2", "P5")


def test_slides_on_the_base_and_passive_ones_are_no_legs() -> None:
    for name in ("linear-delta", "6-pus", "slider-crank"):
        solver = parakin.compile(name, machine_code=False, coordinates="all")
        slides = [j.name for j in solver.graph.joints if j.kind == "prismatic"]
        assert slides
        assert turned_through(solver.plan, at(solver, **dict.fromkeys(slides, -9.0))) == ()


def test_a_leg_counts_from_where_its_joints_are() -> None:
    """The far joint sits 0.4 m behind the rod's origin, the near one 0.1 m ahead of the tube's."""
    mechanism = Mechanism(
        name="leg",
        driven=("A", "P", "B"),
        bodies=(Body(name="tube"), Body(name="rod"), Body(name="end")),
        joints=(
            Joint(
                name="A",
                kind="revolute",
                parent="base",
                child="tube",
                on_child=parakin.Frame(at=(0, 0, 0.1), axis=(0, 1, 0)),
            ),
            Joint(name="P", kind="prismatic", parent="tube", child="rod", actuated=True),
            Joint(
                name="B",
                kind="revolute",
                parent="rod",
                child="end",
                on_parent=parakin.Frame(at=(0, 0, -0.4), axis=(0, 1, 0)),
            ),
        ),
        home={"P": 0.8},
    )
    solver = parakin.compile(mechanism, machine_code=False)
    names = {P: turned_through(solver.plan, at(solver, P=P)) for P in (0.8, 0.51, 0.49, -2.0)}
    assert names == {0.8: (), 0.51: (), 0.49: ("P",), -2.0: ("P",)}


def test_limits_on_cones_and_positions_are_told() -> None:
    limits = {"P1": (0, "0.5 m"), "S1.cone": (0, "5 deg"), "P2.velocity": (-1, 1)}
    legs = parakin.load("gough-stewart").model_copy(update={"limits": limits})
    solver = parakin.compile(legs, machine_code=False, coordinates="all")
    assert limits_exceeded(solver.plan, at(solver)) == ()
    assert limits_exceeded(solver.plan, at(solver, P1=0.6)) == ("P1",)
    tilted = {"platform.pitch": math.radians(20)}
    assert limits_exceeded(solver.plan, at(solver, **tilted)) in (("S1.cone",), ())


@pytest.mark.parametrize(("name", "usable"), [("gough-stewart", 1), ("octahedral-hexapod", 1)])
def test_hexapods_have_one_usable_working_mode(name: str, usable: int) -> None:
    """2^6 combinations of signs of the lengths, of which one has all legs as they are built."""
    found = parakin.modes(parakin.compile(name, machine_code=False))
    assert len(found.modes) == 64
    assert len(found.usable) == usable
    assert found.modes[0].name == "home"
    assert found.modes[0].usable
    assert f"64 distinct, {usable} of them usable" in found.summary
    by_legs = {mode.turned_through for mode in found.modes}
    assert len(by_legs) == 64


def test_usable_ones_come_first_and_keep_their_order() -> None:
    limits = {"P1": (0, "2 m"), "platform.z": (0, "3 m")}
    legs = parakin.load("gough-stewart").model_copy(update={"limits": limits})
    forward = parakin.compile(legs, [f"P{k}" for k in range(1, 7)], machine_code=False)
    found = parakin.modes(forward)
    usable = [mode.usable for mode in found.modes]
    assert usable == sorted(usable, reverse=True)
    assert any(mode.coordinates["platform.z"] < 0 for mode in found.modes)
    for mode in found.modes:
        assert ("platform.z" in mode.limits_exceeded) == (mode.coordinates["platform.z"] < 0)


@pytest.mark.parametrize(
    ("name", "driven"),
    [
        ("gough-stewart", [f"P{k}" for k in range(1, 7)]),
        ("3-rps", None),
        ("flight-simulator", ["A2", "B3", "C3"]),
        ("bricard", None),
        ("delta", None),
    ],
)
def test_coordinates_are_to_round_off(name: str, driven: list[str] | None) -> None:
    solver = parakin.compile(name, driven, machine_code=False, coordinates="all")
    for mode in parakin.modes(solver).modes[:12]:
        there = parakin.compile(
            name,
            solver.driven,
            machine_code=False,
            coordinates="all",
            near=mode.coordinates,
        )
        y = [mode.coordinates[n] for n in solver.driven]
        tick = there.at(y)
        assert tick.residual < 1e-14 * max(1.0, 10 * solver.graph.length)
        off = max(abs(there.home[n] - value) for n, value in mode.coordinates.items())
        assert off < 1e-13 / max(mode.conditioning, 1e-3)


def test_an_angle_beyond_a_limit_is_turned_to_where_it_keeps_it() -> None:
    """The crossed four-bar: its rocker stands at -98 or, which is the same, at 262 degrees."""
    linkage = parakin.load("four-bar").model_copy(update={"limits": {"D": (0.0, 6.2)}})
    solver = parakin.compile(linkage, machine_code=False)
    open_, crossed = parakin.modes(solver).modes
    assert (open_.usable, crossed.usable) == (True, True)
    assert math.degrees(crossed.coordinates["D"]) == pytest.approx(262.0, abs=0.1)
    there = parakin.compile(linkage, machine_code=False, near=crossed.coordinates)
    assert there.home["D"] == pytest.approx(crossed.coordinates["D"], abs=1e-12)
    assert there.at([there.home["A"]]).status == 0
    narrow = linkage.model_copy(update={"limits": {"D": (0.0, 4.5)}})
    assert not parakin.modes(parakin.compile(narrow, machine_code=False)).modes[1].usable


@pytest.mark.parametrize(
    ("name", "driven"),
    [
        ("wrist-on-delta", ["W1", "W2", "W3", "A1", "A2", "A3"]),
        ("hexapod-on-3rps", [f"{k}{i}" for k in "LP" for i in (1, 2, 3)]),
    ],
)
def test_a_platforms_angles_are_named_as_its_solver_names_them(
    name: str, driven: list[str]
) -> None:
    solver = parakin.compile(name, machine_code=False)
    try:
        solver = parakin.compile(name, driven, machine_code=False, coordinates="all")
    except parakin.ParakinError:
        pytest.skip("not driven so")
    for mode in parakin.modes(solver).modes[:6]:
        there = parakin.compile(
            name, driven, machine_code=False, coordinates="all", near=mode.coordinates
        )
        for label in ("roll", "pitch", "yaw"):
            ours, theirs = mode.coordinates[f"platform.{label}"], there.home[f"platform.{label}"]
            assert math.cos(ours - theirs) == pytest.approx(1.0, abs=1e-12)
