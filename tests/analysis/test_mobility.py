"""Mobility and redundancy, as a text on mechanisms counts them."""

from __future__ import annotations

import pytest

import parakin
from parakin import Body, Frame, Joint, Mechanism
from parakin.analysis.mobility import Mobility, mobility
from parakin.kinematics.assembly import assembled
from parakin.model.evaluation import graph_of


def found(mechanism: Mechanism) -> Mobility:
    graph = graph_of(mechanism)
    return mobility(graph, assembled(graph), len(mechanism.driven))


@pytest.mark.parametrize(
    ("name", "grubler", "true", "ranks"),
    [
        ("four-bar", -2, 1, [3]),  # planar loops in space: three equations of six each
        ("slider-crank", -2, 1, [3]),
        ("bennett", -2, 1, [3]),
        ("bricard", 0, 1, [5]),
        ("agile-eye", -3, 3, [3, 3]),  # spherical loops
        ("gough-stewart", 6, 6, [6, 6, 6, 6, 6]),
        ("rssr", 1, 1, [1]),
    ],
)
def test_what_joints_promise_and_what_loops_allow(
    name: str, grubler: int, true: int, ranks: list[int]
) -> None:
    here = found(parakin.load(name))
    assert here.grubler == grubler
    assert {here.home, *here.nearby} == {true}
    assert [loop.rank for loop in here.loops] == ranks
    assert here.redundant == true - grubler


def hexapod_with_spinning_legs() -> Mechanism:
    hexapod = parakin.load("gough-stewart")
    return hexapod.model_copy(
        update={
            "joints": tuple(
                j.model_copy(update={"kind": "spherical"}) if j.name.startswith("U") else j
                for j in hexapod.joints
            ),
            "guess": {},
        }
    )


def test_the_spin_of_a_leg_is_idle_and_the_rest_is_solved() -> None:
    here = found(hexapod_with_spinning_legs())
    assert (here.home, len(here.idle)) == (12, 6)
    assert all(name[:2] in {f"{k}{i}" for k in "US" for i in range(1, 7)} for name in here.idle)
    solver = parakin.compile(hexapod_with_spinning_legs(), machine_code=False)
    result = solver.solve(solver.motion("tour", rate=20))
    theirs = parakin.compile("gough-stewart", machine_code=False)
    expected = theirs.solve(theirs.motion("tour", rate=20))
    legs = [f"P{i}" for i in range(1, 7)]
    ours = abs(1.0 + result.position.sel(coordinate=legs))  # a leg may stand head over heels
    assert float(abs(ours - 1.0 - expected.position.sel(coordinate=legs)).max()) < 1e-12


def test_a_motor_that_is_forgotten_is_not_idle() -> None:
    five_bar = parakin.load("five-bar").model_copy(update={"platform": None, "home": {}})
    joints = tuple(j.model_copy(update={"actuated": j.name == "A1"}) for j in five_bar.joints)
    half = five_bar.model_copy(update={"joints": joints, "driven": ("A1",)})
    assert found(half).idle == ()
    with pytest.raises(parakin.DrivenError, match="mobility is 2 near home, but 1"):
        parakin.compile(half)


def test_a_structure_is_called_one() -> None:
    triangle = Mechanism(
        name="triangle",
        bodies=(Body(name="left"), Body(name="right")),
        joints=(
            Joint(name="A", kind="revolute", parent="base", child="left"),
            Joint(
                name="B",
                kind="revolute",
                parent="left",
                child="right",
                on_parent=Frame(at=(1.0, 0, 0)),
                on_child=Frame(at=(1.0, 0, 0)),
            ),
            Joint(
                name="C",
                kind="revolute",
                parent="base",
                child="right",
                on_parent=Frame(at=(1.2, 0, 0)),
            ),
        ),
        driven=("A",),
        guess={"A": 0.9, "C": 2.2},
    )
    here = found(triangle)
    assert here.generic == 0
    with pytest.raises(parakin.DrivenError, match=r"A cannot move|mobility is 0"):
        parakin.compile(triangle)
