"""What a plan says of itself."""

from __future__ import annotations

import pytest

import parakin


def test_unknowns_are_in_order_of_solution_and_each_once() -> None:
    plan = parakin.compile("flight-simulator", machine_code=False).plan
    assert sorted(plan.unknowns) == sorted(set(plan.unknowns))
    known = {*plan.driven, *plan.affine}
    for block in plan.blocks:
        assert set(block.needs) <= {*plan.unknowns[: plan.unknowns.index(block.unknowns[0])]}
        assert not known & set(block.unknowns)
    assert {*known, *plan.unknowns} == set(plan.graph.tree_coordinates(plan.tree))


@pytest.mark.parametrize(
    ("name", "driven", "iterated"),
    [
        ("flight-simulator", None, 0),  # leg by leg in closed form, as the paper solves it
        ("gough-stewart", None, 0),
        ("gough-stewart", tuple(f"P{i}" for i in range(1, 7)), 6),  # forty roots: no closed form
    ],
)
def test_what_is_iterated(name: str, driven: tuple[str, ...] | None, iterated: int) -> None:
    plan = parakin.compile(name, driven, machine_code=False).plan
    assert len(plan.iterated) == iterated
    assert set(plan.iterated) <= set(plan.unknowns)


def test_coordinates_counted_from_home_are_offset_by_it() -> None:
    plan = parakin.compile("flight-simulator", machine_code=False).plan
    psi = plan.graph.index("platform.psi", "test")
    assert psi in plan.graph.from_home
    assert plan.offset(psi) == plan.own_home[psi] != 0.0
    assert plan.offset(plan.graph.index("A1", "test")) == 0.0
