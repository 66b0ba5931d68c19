"""Tables of bodies: one solid or several, and keys that do not exist."""

from __future__ import annotations

from typing import Any

import pytest

from parakin import Body, InputError
from parakin.model.bodies import Cylinder, Sphere


def test_one_solid_stands_for_a_list_of_one() -> None:
    ball: Any = {"kind": "sphere", "diameter": 1, "mass": 1}
    bar: Any = {"kind": "cylinder", "from": [0, 0, 1], "to": [0, 0, 2], "diameter": 1, "mass": 1}
    assert [type(solid) for solid in Body(name="b", solid=ball).solid] == [Sphere]
    several: Any = [ball, bar]
    both = Body(name="b", solid=several).solid
    assert [type(solid) for solid in both] == [Sphere, Cylinder]
    assert isinstance(both[1], Cylinder)
    assert both[1].from_ == (0, 0, 1)
    again = Cylinder(kind="cylinder", from_=(0, 0, 1), to=(0, 0, 2), diameter=1, mass=1)
    assert both[1] == again == Cylinder(**both[1].model_dump())


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ({"solid": {"kind": "ball"}}, "Body b: solid.kind: found 'ball'; expected one of: box"),
        ({"solid": [{"kind": "ball"}]}, "Body b: solid[0].kind: found 'ball'"),
        ({"solid": {"kind": "sphere", "radius": 1}}, "unknown key 'radius'"),
        ({"solid": {"diameter": 1}}, "no key 'kind'"),
        ({"mass": True}, "expected a number"),
        ({"inertia": [1, 2]}, "inertia"),
        ({"inertia": {"xx": 1, "yy": 1}}, "a value for zz"),
    ],
)
def test_what_is_no_table_of_a_body(told: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError) as refusal:
        Body(name="b", **told)
    assert said in str(refusal.value)
