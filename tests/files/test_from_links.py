"""Mechanisms made from links: names, points, limits, and what is driven."""

from __future__ import annotations

import pytest

from parakin.algebra.spatial import IDENTITY, Pose, Vector
from parakin.errors import InputError
from parakin.files.from_links import WORLD, mechanism_of
from parakin.files.links import Link
from parakin.model.mechanism import MAX_JOINTS, Mechanism


def made(links: list[Link], base: str = "base", name: str = "m") -> Mechanism:
    bodies = list(dict.fromkeys([base, *(n for link in links for n in (link.parent, link.child))]))
    return mechanism_of(name, base, bodies, links, [], "file", "Read for a test.")


def test_names_of_other_programs_are_made_fit_and_kept_apart() -> None:
    links = [
        Link("left/knee", "revolute", "base", "left/leg", values=(0.5,)),
        Link("left:knee", "revolute", "left/leg", "left:leg", values=(0.0,)),
        Link("1", "revolute", "left:leg", "é", values=(0.0,)),
    ]
    mechanism = made(links, name="my/robot")
    assert mechanism.name == "my_robot"
    assert mechanism.title == "my/robot"
    assert [joint.name for joint in mechanism.joints] == ["left_knee", "left_knee_2", "n1"]
    assert [body.name for body in mechanism.bodies] == ["base", "left_leg", "left_leg_2", "n_"]
    assert mechanism.guess == {"left_knee": 0.5, "left_knee_2": 0.0, "n1": 0.0}


def test_the_world_is_called_after_what_stands_on_it() -> None:
    frame = Link("w", "fixed", WORLD, "frame", Pose(IDENTITY, Vector((0.0, 0.0, 1.0))))
    mechanism = made([frame, Link("A", "revolute", "frame", "arm", values=(0.0,))], base=WORLD)
    assert mechanism.base == "frame"
    (base,) = (body for body in mechanism.bodies if body.name == "frame")
    assert base.points == {"frame": (0.0, 0.0, 1.0)}


def test_motors_and_limits_are_those_of_the_file() -> None:
    links = [
        Link("A", "revolute", "base", "a", values=(0.0,), limits=((-1.0, 1.0),), actuated=True),
        Link(
            "B", "universal", "a", "b", values=(0.1, 0.2), limits=(None, (0.0, 2.0)), actuated=(2,)
        ),
        Link("C", "prismatic", "b", "c", values=(0.3,)),
    ]
    mechanism = made(links)
    assert mechanism.driven == ("A", "B.2")
    assert mechanism.limits == {"A": (-1.0, 1.0), "B.2": (0.0, 2.0)}
    assert mechanism.guess == {"A": 0.0, "B.1": 0.1, "B.2": 0.2, "C": 0.3}


def test_nothing_that_moves_and_too_much_are_refused() -> None:
    with pytest.raises(InputError, match="file: found no joints that move; expected at least one"):
        made([Link("w", "fixed", "base", "a")])
    many = [Link(f"J{k}", "revolute", f"b{k}", f"b{k + 1}") for k in range(MAX_JOINTS + 1)]
    with pytest.raises(InputError, match=f"found {MAX_JOINTS + 1} joints; expected at most"):
        made(many, base="b0")
