"""Which reactions cannot be known, and what would have to give way."""

from __future__ import annotations

import pytest

import parakin
from parakin.analysis.indeterminacy import indeterminacy
from parakin.kinematics.assembly import assembled
from parakin.model.evaluation import graph_of


def test_of_a_planar_loop_one_hinge_has_to_give_way() -> None:
    graph = graph_of(parakin.load("four-bar"))
    found = indeterminacy(graph, assembled(graph))
    assert (found.count, found.components) == (12, 20)
    assert list(found.unknown) == ["A", "B", "C", "D"]
    across = ("force z", "moment x", "moment y")
    assert found.unknown["C"] == across
    assert found.releases == {"A": across}


def test_as_a_ball_and_a_cylinder_the_hinges_of_a_four_bar_can_be_known() -> None:
    """What the diagnosis says is true: with those components released nothing is indeterminate."""
    four_bar = parakin.load("four-bar")
    joints = [
        j.model_copy(update={"kind": "spherical"}) if j.name == "D" else j for j in four_bar.joints
    ]
    joints = [j.model_copy(update={"kind": "cylindrical"}) if j.name == "C" else j for j in joints]
    graph = graph_of(four_bar.model_copy(update={"joints": tuple(joints), "guess": {}}))
    assert indeterminacy(graph, assembled(graph)).count == 0


@pytest.mark.parametrize("name", ["gough-stewart", "delta", "3-prs", "seat-3dof"])
def test_where_all_is_determinate_nothing_is_said(name: str) -> None:
    graph = graph_of(parakin.load(name))
    found = indeterminacy(graph, assembled(graph))
    assert found.count == 0
    assert found.releases == {}


def test_the_flight_simulators_cranks_and_leg_a() -> None:
    graph = graph_of(parakin.load("flight-simulator"))
    found = indeterminacy(graph, assembled(graph))
    assert (found.count, found.components) == (24, 69)
    assert set(found.unknown) == {"A1", "A2", "A3", "D1", "D2", "E1", "E2P", "E2"}
    assert sum(map(len, found.releases.values())) == 6
