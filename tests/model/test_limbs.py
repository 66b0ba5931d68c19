"""Limbs expanded, compared with the same written out by hand."""

from __future__ import annotations

import tomllib

import pytest

from parakin import InputError
from parakin.model.limbs import expand_limbs

SHORT = """
[parameters]
r = "1 m"

[limbs.leg]
count = 2
each = { angle = ["0 deg", "i*60 deg"], x = [1, 2] }
bodies = { "rod{i}" = { points = { tip = ["r*cos(angle)", "i*x", 0] } } }
guess = { "A{i}" = "angle + i" }
symbols = { "A{i}" = "α{i}" }

[limbs.leg.joints."A{i}"]
kind = "revolute"
parent = "base"
child = "rod{i}"
on_parent = { at = ["x", 0, 0], turns = [["x", "angle"]] }
"""
LONG = """
[parameters]
r = "1 m"
leg1_angle = "0 deg"
leg1_x = 1
leg2_angle = "(2)*60 deg"
leg2_x = 2

[bodies]
rod1 = { points = { tip = ["r*cos(leg1_angle)", "(1)*leg1_x", 0] } }
rod2 = { points = { tip = ["r*cos(leg2_angle)", "(2)*leg2_x", 0] } }

[joints.A1]
kind = "revolute"
parent = "base"
child = "rod1"
on_parent = { at = ["leg1_x", 0, 0], turns = [["x", "leg1_angle"]] }

[joints.A2]
kind = "revolute"
parent = "base"
child = "rod2"
on_parent = { at = ["leg2_x", 0, 0], turns = [["x", "leg2_angle"]] }

[guess]
A1 = "leg1_angle + (1)"
A2 = "leg2_angle + (2)"

[symbols]
A1 = "α1"
A2 = "α2"
"""


def test_limbs_are_what_one_would_write_by_hand() -> None:
    assert expand_limbs(tomllib.loads(SHORT), "file") == tomllib.loads(LONG)


def test_a_table_without_limbs_is_left_as_it_is() -> None:
    table = tomllib.loads(LONG)
    assert expand_limbs(table, "file") == table


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("count = 2", "count = 3", "limbs.leg.each.angle: found 2 values; expected a list of 3"),
        ("count = 2", "count = 1001", "limbs.leg.count: found 1001; expected 1 to 1000"),
        (
            '"A{i}" = "angle + i"',
            'A = "angle"',
            "limbs.leg: guess: found 'A' twice; expected names",
        ),
        (
            "x = [1, 2]",
            '"1x" = [1, 2]',
            "limbs.leg.each: found the name '1x'; expected a name that",
        ),
        ("count = 2", "counts = 2", "limbs.leg: found unknown key 'counts'"),
    ],
)
def test_limbs_that_mean_nothing_are_refused(old: str, new: str, message: str) -> None:
    with pytest.raises(InputError) as error:
        expand_limbs(tomllib.loads(SHORT.replace(old, new, 1)), "file")
    assert str(error.value).startswith("file: limbs.leg")
    assert message in str(error.value)
