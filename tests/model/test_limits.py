"""Limits as a file declares them, and as numbers."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import parakin
from parakin import InputError
from parakin.model.evaluation import graph_of
from parakin.model.limits import UNLIMITED, Limit


def limited(**limits: Any) -> tuple[Limit, ...]:
    legs = parakin.load("gough-stewart").model_copy(update={"limits": limits})
    return graph_of(legs).limited


def test_positions_velocities_and_accelerations_have_their_own_units() -> None:
    found = limited(
        **{
            "P1": ("100 mm", "2*stroke_0"),
            "P1.velocity": ("-600 mm/s", "0.6 m/s"),
            "P1.acceleration": (-4, "4000 mm/s^2"),
            "U2.1.velocity": ("-30 deg/s", "5 rpm"),
            "S3.cone": (0, "20 deg"),
            "U3.cone": (0, 0.5),
        }
    )
    assert [(limit.coordinate, limit.order) for limit in found] == [
        ("P1", 0), ("P1", 1), ("P1", 2), ("U2.1", 1), ("S3.cone", 0), ("U3.cone", 0)
    ]  # fmt: skip
    ends = np.array([limit.ends for limit in found])
    turn, cone = (math.radians(-30), 10 * math.pi / 60), (0.0, math.radians(20))
    expected = [(0.1, 2.0), (-0.6, 0.6), (-4.0, 4.0), turn, cone, (0.0, 0.5)]
    np.testing.assert_allclose(ends, expected, rtol=1e-15)
    assert [limit.name for limit in found[:3]] == ["P1", "P1.velocity", "P1.acceleration"]


def test_position_may_be_named_beside_the_rates() -> None:
    (limit,) = limited(**{"P1.position": (0, 1)})
    assert limit == Limit("P1", 0, 0.0, 1.0)
    assert limit.name == "P1"


def test_one_end_may_be_open() -> None:
    (limit,) = limited(P1=(-math.inf, "0.5 m"))
    assert limit.ends == (-math.inf, 0.5)
    assert limit.excess(0.6) == pytest.approx(0.1)
    assert limit.excess(-1e9) < 0


def test_an_excess_is_how_far_beyond_the_nearer_end() -> None:
    limit = Limit("P1", 0, -1.0, 2.0)
    assert [limit.excess(x) for x in (-1.5, -1.0, 0.0, 2.0, 2.25)] == [0.5, 0.0, -1.0, 0.0, 0.25]
    assert math.isnan(limit.excess(math.nan))


@pytest.mark.parametrize(
    ("name", "pair", "said"),
    [
        ("P7", (0, 1), "limits.P7: found unknown coordinate 'P7'; expected one of: "),
        ("P1.velocty", (0, 1), "did you mean 'P1.velocity'"),
        ("P1.velocity", ("1 m", "2 m"), "'1 m', a length; expected a velocity"),
        ("P1.acceleration", ("0 m/s", "2 m/s"), "a velocity; expected an acceleration"),
        ("U1.2.velocity", ("0 m/s", "2 m/s"), "a velocity; expected an angular velocity"),
        ("U1.2.acceleration", ("0 m", "2 m"), "a length; expected an angular acceleration"),
        ("S1.cone.velocity", (0, 1), "a limit on the velocity of a cone angle; expected one on"),
        ("P1.velocity", (1, 1), "found [1, 1]; expected a lower limit below the upper one"),
        ("P1", (math.inf, -math.inf), "found [inf, -inf]; expected a lower limit below"),
        ("P1", (-math.inf, math.inf), "found [-inf, inf]; expected at least one end that is"),
        ("P1", (math.nan, 1.0), "found nan; expected a finite number"),
    ],
)
def test_what_makes_no_limit_is_refused(name: str, pair: Any, said: str) -> None:
    with pytest.raises(InputError) as error:
        limited(**{name: pair})
    assert said in str(error.value)
    assert f"limits.{name}" in str(error.value)


def test_a_limit_given_twice_is_refused() -> None:
    with pytest.raises(InputError, match=r"limits\.P1\.position: found two limits; expected one"):
        limited(**{"P1": (0, 1), "P1.position": (0, 2)})


def test_a_graph_knows_its_limits_by_name_and_order() -> None:
    legs = parakin.load("gough-stewart").model_copy(
        update={"limits": {"P1": (0, 1), "P1.velocity": (-2, 2)}}
    )
    graph = graph_of(legs)
    assert graph.limits("P1") == (0.0, 1.0)
    assert graph.limits("P1", 1) == (-2.0, 2.0)
    assert graph.limits("P1", 2) == graph.limits("S1.cone") == UNLIMITED
