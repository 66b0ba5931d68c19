"""A mechanism in numbers: what its expressions come to, worked out by hand."""

from __future__ import annotations

import math

import pytest

from parakin import Body, Frame, InputError, Joint, Mechanism, Platform
from parakin.model.evaluation import graph_of


def arm(**changes: object) -> Mechanism:
    """A telescopic arm: a cylindrical joint, a screw, and a rod from the base to its hand."""
    parts: dict[str, object] = {
        "name": "arm",
        "parameters": {"l": "400 mm", "h": "l/4"},
        "bodies": (Body(name="slider"), Body(name="hand", points={"tip": ("l", 0, "2*h")})),
        "joints": (
            Joint(name="C", kind="cylindrical", parent="base", child="slider", actuated=(2,)),
            Joint(
                name="S",
                kind="helical",
                parent="slider",
                child="hand",
                pitch="10 mm",
                on_parent=Frame(at=("3*h", 0, 0)),
            ),
            Joint(name="R", kind="rod", parent="base", child="hand", length="l + h"),
        ),
        "platform": Platform(body="hand", point="tip"),
        "limits": {"C.2": (0, "l"), "S": ("-1 deg", "1 deg")},
        "stated": {"S": "90 deg"},
        "from_home": ("C.2",),
        "driven": ("C.2",),
    }
    return Mechanism(**parts | changes)


def test_coordinates_are_numbered_joint_by_joint_and_the_platforms_come_last() -> None:
    graph = graph_of(arm())
    assert [c.name for c in graph.coordinates] == [
        *("C.1", "C.2", "S"),
        *("platform.x", "platform.y", "platform.z"),
        *("platform.roll", "platform.pitch", "platform.yaw"),
    ]
    assert [c.unit for c in graph.coordinates] == ["rad", "m", "rad", *"mmm", *["rad"] * 3]
    assert [c.actuated for c in graph.coordinates] == [False, True, *[False] * 7]
    assert [joint.first for joint in graph.joints] == [0, 2, 3, 3]
    assert graph.platform == 3


def test_expressions_become_metres_and_radians() -> None:
    graph = graph_of(arm())
    assert graph.parameters == {"l": 0.4, "h": 0.1}
    assert graph.points == {"hand.tip": (2, (0.4, 0.0, 0.2))}
    assert graph.joints[1].F.p == pytest.approx((0.3, 0.0, 0.0), abs=1e-16)
    assert graph.joints[1].pairs[0].pitch == pytest.approx(0.01 / (2 * math.pi), rel=1e-15)
    assert graph.joints[2].length == 0.5
    assert graph.joints[3].M.p == (0.4, 0.0, 0.2)
    assert graph.limits("C.2") == (0.0, 0.4)
    assert graph.limits("S") == pytest.approx((-math.pi / 180, math.pi / 180))
    assert graph.limits("C.1") == (-math.inf, math.inf)
    assert graph.stated == {2: math.pi / 2}
    assert graph.from_home == {1}
    assert graph.length == pytest.approx(math.hypot(0.4, 0.2))  # the furthest frame


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"driven": ("C",)}, "arm: driven: found unknown coordinate 'C'; expected one of: C.1"),
        ({"from_home": ("Q",)}, "arm: from_home: found unknown coordinate 'Q'"),
        ({"limits": {"S": (1, "1 rad")}}, "arm: limits.S: found [1, 1]; expected a lower limit"),
        ({"guess": {"C.2": "1 deg"}}, "arm: guess.C.2: found '1 deg', an angle; expected a length"),
        ({"home": {"Q": 1}}, "arm: home.Q: found unknown coordinate 'Q'"),
        ({"parameters": {"l": 1, "h": "x"}}, "arm: parameters.h: found 'x': unknown parameter"),
        ({"parameters": {"l": 1, "h": -2}}, "arm: joints.R.length: found -1 m; expected a length"),
    ],
)
def test_what_cannot_be_evaluated_is_named(changes: dict[str, object], message: str) -> None:
    with pytest.raises(InputError) as error:
        graph_of(arm(**changes))
    assert message in str(error.value)


def test_a_motor_on_a_coordinate_that_a_joint_has_not_is_refused() -> None:
    joints = (Joint(name="C", kind="cylindrical", parent="base", child="a", actuated=(3,)),)
    with pytest.raises(InputError, match=r"joints\.C\.actuated: found 3; expected numbers of its"):
        graph_of(Mechanism(name="m", bodies=(Body(name="a"),), joints=joints))


def test_a_spherical_joints_cone_angle_may_have_limits() -> None:
    joints = (Joint(name="B", kind="spherical", parent="base", child="a"),)
    ball = Mechanism(
        name="m", bodies=(Body(name="a"),), joints=joints, limits={"B.cone": (0, "30 deg")}
    )
    graph = graph_of(ball)
    assert graph.limits("B.cone") == pytest.approx((0.0, math.pi / 6))
    assert graph.holder("B.cone") == 0


def test_lengths_whose_squares_would_overflow_are_refused() -> None:
    far = Frame(at=("1e150", 0, 0))
    joints = (Joint(name="B", kind="revolute", parent="base", child="a", on_parent=far),)
    with pytest.raises(InputError, match=r"joints\.B: found a frame 1e\+150 m away; expected less"):
        graph_of(Mechanism(name="m", bodies=(Body(name="a"),), joints=joints))
