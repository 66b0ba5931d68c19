"""Mechanisms made from links: names, points, limits, and what is driven."""

from __future__ import annotations

import numpy as np
import pytest

from parakin.algebra.spatial import IDENTITY, Pose, Vector
from parakin.errors import InputError
from parakin.files.from_links import WORLD, mechanism_of
from parakin.files.links import Link
from parakin.model.mechanism import MAX_JOINTS, Mechanism
from parakin.model.placement import about, vector


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


def test_the_world_is_called_after_what_has_its_frame() -> None:
    """What stands elsewhere is a point on it: the frame with its name would be another."""
    arm = Link("A", "revolute", "frame", "arm", values=(0.0,))
    assert made([Link("w", "fixed", WORLD, "frame"), arm], base=WORLD).base == "frame"
    above = Link("w", "fixed", WORLD, "frame", Pose(IDENTITY, Vector((0.0, 0.0, 1.0))))
    mechanism = made([above, arm], base=WORLD)
    assert mechanism.base == WORLD
    (base,) = (body for body in mechanism.bodies if body.name == WORLD)
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


def test_a_screw_alone_and_a_loop_of_screws() -> None:
    links = [
        Link("h", "revolute", WORLD, "nut", values=(0.0,)),
        Link("s", "prismatic", "nut", "rod", values=(0.0,)),
    ]
    coupling = Link("c", "screw", "h", "s", pitch=0.1)
    bodies = [WORLD, "nut", "rod"]
    mechanism = mechanism_of("m", WORLD, bodies, links, [coupling], "file", "")
    assert [joint.kind for joint in mechanism.joints] == ["helical"]
    assert mechanism.base == WORLD
    more = [
        Link("h2", "revolute", WORLD, "b", values=(0.0,)),
        Link("s2", "prismatic", "b", "rod", values=(0.0,)),
    ]
    second = Link("c2", "screw", "h2", "s2", pitch=0.2)
    with pytest.raises(InputError, match=r"file: joints\.h2: found a loop of helical joints alone"):
        mechanism_of("m", WORLD, [*bodies, "b"], [*links, *more], [coupling, second], "file", "")


def test_a_joint_called_platform_gives_way_to_the_platforms_pose() -> None:
    links = [
        Link("platform", "revolute", "base", "leg", values=(0.0,)),
        Link("b", "spherical", "leg", "top", values=(0.0,) * 3),
        Link("pose", "free", "base", "top", values=(0.0,) * 6),
    ]
    mechanism = made(links)
    assert mechanism.platform is not None
    assert mechanism.joints[0].name == "platform_2"


def test_free_joints_that_are_not_the_platforms_pose_turn_about_x_y_and_z() -> None:
    """A chain of three slides and turns about z, y, x stays, unless it is the platform's pose."""
    axes = [*np.eye(3), *np.eye(3)[::-1]]
    kinds = ["prismatic"] * 3 + ["revolute"] * 3
    links = [Link("A", "revolute", "base", "b0", values=(0.0,))]
    for k, (kind, axis) in enumerate(zip(kinds, axes, strict=True)):
        frame = Pose(about(vector(axis)), Vector((0.0, 0.0, 0.0)))
        name = f"F.{k + 1}"
        links.append(Link(name, kind, f"b{k}", f"b{k + 1}", frame, frame, values=(0.0,)))
    names = [joint.name for joint in made(links).joints]
    assert names == ["A", *(f"F_{k}" for k in range(1, 7))]
