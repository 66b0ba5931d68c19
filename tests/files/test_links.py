"""Links of other programs' files, made into joints: compared with matrices and by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from parakin.algebra.spatial import IDENTITY_POSE, Matrix, Pose, Vector
from parakin.errors import InputError
from parakin.files.links import Link, merge_chains, merge_rigid, split_off_platform
from parakin.files.screws import merge_screws
from parakin.model.placement import vector


def at(
    x: float = 0.0, y: float = 0.0, z: float = 0.0, turn: str = "z", by: float = 0.0
) -> Pose[float]:
    a, b, c = (vector(row) for row in Rotation.from_euler(turn, by).as_matrix())
    return Pose(Matrix((a, b, c)), Vector((x, y, z)))


def matrix(place: Pose[float]) -> np.ndarray:
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = place.R, place.p
    return made


# ---- links fixed to one another


def test_fixed_links_are_one_body_and_know_their_place_on_it() -> None:
    first, second = at(1.0, 0.0, 0.0, "z", 0.5), at(0.0, 2.0, 0.0, "x", -0.3)
    links = [
        Link("hinge", "revolute", "base", "a", at(z=1.0)),
        Link("weld", "fixed", "a", "b", first),
        Link("weld 2", "fixed", "b", "c", second),
        Link("tip", "revolute", "c", "d", at(y=0.1)),
    ]
    moving, owner = merge_rigid("base", links, "file")
    assert [link.name for link in moving] == ["hinge", "tip"]
    assert {name: body for name, (body, _) in owner.items()} == {
        **{"base": "base", "a": "a", "b": "a", "c": "a", "d": "d"}
    }
    on_a = matrix(first) @ matrix(second)
    assert_allclose(matrix(owner["c"][1]), on_a, atol=1e-15)
    assert_allclose(matrix(moving[1].F), on_a @ matrix(at(y=0.1)), atol=1e-15)
    assert moving[1].parent == "a"


def test_what_is_fixed_to_the_base_is_the_base() -> None:
    links = [Link("w", "fixed", "a", "base", at(x=1.0)), Link("h", "revolute", "a", "b")]
    moving, owner = merge_rigid("base", links, "file")
    assert owner["a"][0] == "base"
    assert_allclose(matrix(owner["a"][1]), np.linalg.inv(matrix(at(x=1.0))))
    assert moving[0].parent == "base"


def test_links_welded_twice_have_to_be_where_they_are() -> None:
    twice = [Link("one", "fixed", "base", "a", at(x=1.0)), Link("two", "fixed", "base", "a")]
    same = [twice[0], replace(twice[1], F=at(x=1.0))]
    assert merge_rigid("base", same, "file")[0] == []
    with pytest.raises(InputError, match="file: two: found links that are already rigid"):
        merge_rigid("base", twice, "file")
    inside = [twice[0], Link("three", "revolute", "base", "a")]
    with pytest.raises(InputError, match="which are one rigid body; expected a joint between"):
        merge_rigid("base", inside, "file")


# ---- hinges and slides in chains


def chain(*kinds_and_turns: tuple[str, str, float]) -> list[Link]:
    """J.1, J.2, ... from base to hand, each turned against the one before."""
    count = len(kinds_and_turns)
    bodies = ["base", *(f"b{k}" for k in range(1, count)), "hand"]
    return [
        Link(f"J.{k + 1}", kind, bodies[k], bodies[k + 1], at(turn=turn, by=by), values=(0.1 * k,))
        for k, (kind, turn, by) in enumerate(kinds_and_turns)
    ]


QUARTER = math.pi / 2


@pytest.mark.parametrize(
    ("links", "kind"),
    [
        (chain(("revolute", "z", 0.0), ("prismatic", "z", 0.0)), "cylindrical"),
        (chain(("revolute", "z", 0.3), ("revolute", "x", -QUARTER)), "universal"),
        (
            chain(
                ("revolute", "y", QUARTER), ("revolute", "x", -QUARTER), ("revolute", "y", -QUARTER)
            ),
            "spherical",
        ),
        (chain(("revolute", "z", 0.0), ("revolute", "x", 0.5)), None),  # not square
        (chain(("prismatic", "z", 0.0), ("revolute", "z", 0.0)), None),  # no kind of ours
    ],
)
def test_chains_become_the_joint_they_make_or_stay(links: list[Link], kind: str | None) -> None:
    found = merge_chains(links, {"base"})
    if kind is None:
        assert found == links
    else:
        (whole,) = found
        assert (whole.name, whole.kind) == ("J", kind)
        assert (whole.parent, whole.child) == ("base", "hand")
        assert whole.values == tuple(value for link in links for value in link.values)


def test_a_chain_keeps_the_limits_and_motors_of_its_coordinates() -> None:
    first, second = chain(("revolute", "z", 0.0), ("prismatic", "z", 0.0))
    (whole,) = merge_chains([first, replace(second, limits=((0.0, 1.0),), actuated=True)], {"base"})
    assert whole.limits == (None, (0.0, 1.0))
    assert whole.actuated == (2,)
    (whole,) = merge_chains([replace(first, actuated=True), replace(second, actuated=True)], set())
    assert whole.actuated is True
    assert whole.limits == ()


def test_a_chain_is_made_whole_or_not_at_all() -> None:
    """Its last two hinges alone would be a universal joint, whose coordinates have other names."""
    links = chain(
        ("prismatic", "z", 0.0),
        ("revolute", "x", 0.5),
        ("revolute", "z", 0.3),
        ("revolute", "x", -QUARTER),
    )
    assert merge_chains(links, {"base"}) == links
    ring = chain(("revolute", "z", 0.3), ("revolute", "x", -QUARTER))
    ring[1] = replace(ring[1], child="base")
    assert merge_chains(ring, {"base"}) == ring  # a joint of a body with itself


def test_a_chain_stays_where_something_else_hangs_from_its_inside() -> None:
    links = chain(("revolute", "z", 0.0), ("prismatic", "z", 0.0))
    more = [*links, Link("other", "revolute", "b1", "c")]
    assert merge_chains(more, {"base"}) == more
    assert merge_chains(links, {"base", "b1"}) == links


# ---- screws


def test_a_coupled_hinge_and_slide_are_a_screw() -> None:
    hinge = Link("h", "revolute", "base", "nut", at(x=1.0), values=(0.2,))
    slide = Link("s", "prismatic", "nut", "rod", values=(0.1,))
    coupling = Link("c", "screw", "h", "s", pitch=0.5)
    (screw,) = merge_screws([hinge, slide], [coupling], [], "file")
    assert (screw.name, screw.parent, screw.child) == ("h", "base", "rod")
    assert screw.pitch == pytest.approx(
        2 * math.pi * 0.5
    )  # per turn, where the coupling's is per rad
    assert screw.F == hinge.F
    wrong = replace(slide, F=at(turn="x", by=0.1))
    with pytest.raises(InputError, match="a slide along the axis of the hinge it is coupled to"):
        merge_screws([hinge, wrong], [coupling], [], "file")
    loop = Link("l", "spherical", "nut", "base")
    with pytest.raises(InputError, match="file: c: found 'nut', inside the screw of 'h', joined"):
        merge_screws([hinge, slide], [coupling], [loop], "file")
    with pytest.raises(InputError, match="expected one coupling for each joint"):
        merge_screws([hinge, slide], [coupling, coupling], [], "file")


def test_a_screws_slide_may_lead_point_back_and_stand_anywhere() -> None:
    """A turn of 0.4 rad, and a slide of 0.1 - 0.5 * 0.4 against the hinge's axis, 1 m off."""
    back = at(x=1.0, turn="x", by=math.pi)
    slide = Link("s", "prismatic", "base", "nut", back, limits=((-1.0, 0.6),))
    hinge = Link(
        "h", "revolute", "nut", "rod", at(z=2.0, turn="x", by=math.pi), limits=((-9.0, 1.0),)
    )
    coupling = Link("c", "screw", "h", "s", pitch=-0.5, advance=0.1)
    (screw,) = merge_screws([slide, hinge], [coupling], [], "file")
    assert (screw.parent, screw.child) == ("base", "rod")
    assert screw.limits[0] == pytest.approx((-1.0, 1.0))  # where the slide may be, and the hinge
    moved = matrix(at(z=screw.pitch / (2 * math.pi) * 0.4, by=0.4))
    found = matrix(screw.F) @ moved @ np.linalg.inv(matrix(screw.M))
    slid = matrix(back) @ matrix(at(z=0.1 - 0.5 * 0.4))
    expected = slid @ matrix(hinge.F) @ matrix(at(by=0.4))
    assert_allclose(found, expected, atol=1e-12)
    narrow = replace(hinge, limits=((2.5, 3.0),))
    with pytest.raises(InputError, match="file: c: found limits of 'h' and 's' that exclude"):
        merge_screws([slide, narrow], [coupling], [], "file")


# ---- the platform


def test_a_free_joint_in_a_loop_is_the_platforms_pose() -> None:
    leg = [Link("a", "revolute", "base", "leg"), Link("b", "spherical", "leg", "top")]
    pose = Link("pose", "free", "base", "top", IDENTITY_POSE, at(x=0.1))
    assert split_off_platform("base", [*leg, pose]) == (leg, pose)
    assert split_off_platform("base", [leg[0], pose]) == (
        [leg[0], pose],
        None,
    )  # what carries it, then
    assert split_off_platform("base", [*leg, replace(pose, actuated=True)])[1] is None
    assert split_off_platform("base", [*leg, replace(pose, F=at(x=1.0))])[1] is None
