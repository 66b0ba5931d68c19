"""Trees, rows and their order, for mechanisms whose order is known."""

from __future__ import annotations

import pytest

import parakin
from parakin.errors import DrivenError
from parakin.kinematics.configuration import configure
from parakin.planning.ordering import with_twins


def sizes(name: str, driven: tuple[str, ...] | None = None, **options: object) -> list[int]:
    solver = parakin.compile(name, driven, machine_code=False, **options)  # type: ignore[arg-type]
    return [len(block.unknowns) for block in solver.plan.blocks]


@pytest.mark.parametrize(
    "name", ["four-bar", "slider-crank", "six-bar-watt", "3-rrr", "gough-stewart", "delta", "6-pus"]
)
def test_dyads_and_legs_are_solved_one_unknown_at_a_time(name: str) -> None:
    assert set(sizes(name)) == {1}


def test_the_stephenson_six_bar_is_no_chain_of_dyads_from_its_far_crank() -> None:
    """Driven at F it closes as a triad: an Assur group of class three (Assur, 1914)."""
    assert max(sizes("six-bar-stephenson", ("F",))) > 1


def test_cutting_other_joints_changes_the_tree() -> None:
    usual = parakin.compile("slider-crank", machine_code=False).plan
    other = parakin.compile("slider-crank", cut=["B"], machine_code=False).plan
    names = [[p.graph.joints[k].name for k in p.tree.cuts] for p in (usual, other)]
    assert names[1] == ["B"] != names[0]


def test_a_joint_that_must_stay_cannot_be_cut() -> None:
    with pytest.raises(DrivenError, match="cannot be left out of the tree"):
        parakin.compile("four-bar", cut=["A"], machine_code=False)


def test_three_angles_that_are_nearly_undefined_get_a_twin_beside_them() -> None:
    solver = parakin.compile("gough-stewart", machine_code=False)
    graph = solver.graph
    q = solver.plan.home[: len(graph.coordinates)].copy()
    at = configure(graph, graph.posed_tree(), q)
    assert with_twins(graph, at, held=())[0] is graph
    pitch = graph.index("platform.pitch", "test")
    q[pitch] = 1.5  # rad: where roll and yaw are all but the same
    at = configure(graph, graph.posed_tree(), q)
    twinned, there = with_twins(graph, at, held=())
    assert list(twinned.twins) == [graph.platform]
    assert len(there.q) == len(q) + 6
    assert with_twins(graph, at, held=[pitch])[0] is graph
