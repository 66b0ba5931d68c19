"""What driven coordinates determine, and what they do not."""

from __future__ import annotations

import pytest

import parakin
from parakin.errors import DrivenError


def test_a_parallelogram_turns_its_coupler_back() -> None:
    """Opposite sides alike: the rocker turns with the crank, the coupler does not turn at all."""
    sides = {"a": 0.08, "b": 0.1, "c": 0.08, "d": 0.1}
    mechanism = parakin.load("four-bar", sides)
    mechanism = mechanism.model_copy(update={"guess": {"B": "-40 deg", "D": "40 deg"}})
    plan = parakin.compile(mechanism, coordinates="all", machine_code=False).plan
    crank = plan.graph.index("A", "test")
    rules = {plan.graph.coordinates[k].name: rule for k, rule in plan.affine.items()}
    assert rules["A"].factors == ((crank, 1.0),)
    assert rules["B"].factors == ((crank, -1.0),)  # exactly, and not but for rounding
    assert rules["B"].constant == pytest.approx(0.0, abs=1e-14)


def test_a_crank_rocker_has_no_such_rule() -> None:
    plan = parakin.compile("four-bar", machine_code=False).plan
    assert set(plan.affine) == set(plan.driven)


@pytest.mark.parametrize(
    ("name", "driven", "said"),
    [
        ("four-bar", ["A", "D"], "A, D depend on one another"),
        ("five-bar", ["A1"], "mobility is 2"),
        ("gough-stewart", ["P1", "P2", "P3", "P4", "P5"], "not determined"),
        ("flight-simulator", ["A2", "B3", "C3", "D1"], "only 3 can move"),
    ],
)
def test_what_cannot_be_driven_is_refused(name: str, driven: list[str], said: str) -> None:
    with pytest.raises(DrivenError, match=said):
        parakin.compile(name, driven, machine_code=False)
