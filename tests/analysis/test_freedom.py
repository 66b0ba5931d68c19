"""What goes free at a pose, at singularities known in closed form."""

from __future__ import annotations

import numpy as np
import pytest

import parakin
from parakin.analysis.freedom import outputs_of, sets_of, whole_values
from parakin.errors import InputError


@pytest.mark.parametrize(
    ("name", "outputs"),
    [
        ("flight-simulator", ["platform.x", "platform.y", "platform.phi"]),
        ("gough-stewart", ["platform.x", "platform.y", "platform.z"]),
        ("four-bar", ["D"]),
    ],
)
def test_outputs_are_what_the_actuated_coordinates_move(name: str, outputs: list[str]) -> None:
    found = outputs_of(parakin.compile(name, coordinates="all", machine_code=False))
    assert found[: len(outputs)] == outputs


def test_as_many_motors_as_freedoms_are_needed() -> None:
    mechanism = parakin.load("four-bar")
    joints = tuple(j.model_copy(update={"actuated": False}) for j in mechanism.joints)
    solver = parakin.compile(mechanism.model_copy(update={"joints": joints}), machine_code=False)
    with pytest.raises(InputError, match="0 actuated coordinates and 1 driven"):
        sets_of(solver)


def test_the_platforms_angles_stand_together_or_not_at_all() -> None:
    hexapod = sets_of(parakin.compile("gough-stewart", coordinates="all", machine_code=False))
    assert hexapod.turned == [9, 10, 11]  # after six motors and three places
    delta = sets_of(parakin.compile("delta", coordinates="all", machine_code=False))
    assert delta.turned == []


def test_singular_values_are_those_of_all_rows() -> None:
    """A parallelogram flattened may fold either way: one more value vanishes there."""
    sides = {"a": 0.08, "b": 0.1, "c": 0.08, "d": 0.1}
    mechanism = parakin.load("four-bar", sides)
    mechanism = mechanism.model_copy(update={"guess": {"B": "-40 deg", "D": "40 deg"}})
    plan = parakin.compile(mechanism, coordinates="all", machine_code=False).plan
    names = [c.name for c in plan.graph.coordinates]
    poses = []
    for crank in (0.7, 0.0):
        angles = {"A": crank, "B": -crank, "C": crank, "D": crank}
        poses.append([angles[name] for name in names])
    values = np.sort(whole_values(plan, np.array(poses).T), axis=1)
    assert (values[0] < 1e-12).sum() == 1  # its one freedom
    assert (values[1] < 1e-12).sum() == 2
