"""Where the platform's point can go, put into the scene."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import parakin
from parakin.arrays import FloatArray
from parakin.solving.solver import Solver
from parakin.views.browser.surface import Surface, add_surface, slides_of, surface_of

RIG = Path(__file__).parents[3] / "examples" / "rig.toml"


class _Scene:
    """Takes note of what is added."""

    def __init__(self) -> None:
        self.added: dict[str, tuple[str, tuple[Any, ...], dict[str, Any]]] = {}

    def add_mesh_simple(self, name: str, *given: Any, **look: Any) -> str:
        self.added[name] = "mesh", given, look
        return name

    def add_line_segments(self, name: str, *given: Any, **look: Any) -> str:
        self.added[name] = "lines", given, look
        return name


def _solver(mechanism: str | Path) -> Solver:
    return parakin.compile(mechanism, coordinates="all")


def _home(solver: Solver) -> FloatArray:
    return np.array([solver.home[name] for name in solver.driven])


def _found(mechanism: str | Path, **pose: float) -> tuple[Solver, Surface]:
    solver = _solver(mechanism)
    y = _home(solver)
    for name, value in pose.items():
        y[solver.driven.index(f"platform.{name}")] = value
    found = surface_of(solver, y)
    assert isinstance(found, Surface)
    return solver, found


def test_only_a_platform_with_slides_has_one() -> None:
    assert slides_of(("platform.z", "platform.roll")) == ()
    assert slides_of(("A",)) == ()
    assert slides_of(("platform.yaw", "platform.y", "platform.x")) == ("platform.x", "platform.y")


def test_the_rigs_legs_are_as_long_as_said_where_the_surface_says_so() -> None:
    tilt = np.radians(8.0)
    _, found = _found(RIG, pitch=tilt)
    half = np.radians([7.0, 9.0])  # of the angles between joints of a pair
    thirds = np.radians([0.0, 120.0, 240.0])
    at = np.concatenate([[turn - half[0], turn + half[0]] for turn in thirds])
    sides = np.radians([-60.0, 60.0, 60.0, 180.0, 180.0, -60.0])
    top = sides + half[1] * np.array([1, -1, 1, -1, 1, -1])
    base = 0.82 * np.array([np.cos(at), np.sin(at), 0.0 * at]).T
    own = 0.61 * np.array([np.cos(top), np.sin(top), 0.0 * top]).T
    c, s = np.cos(tilt), np.sin(tilt)
    turned = own @ np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]).T
    checked = 0
    for number, word in enumerate(found.words):
        if not word.startswith("P"):
            continue
        leg, end = int(word[1]) - 1, float(word.split()[2])
        corners = found.facets[found.numbers == number].reshape(-1, 3)
        length = np.linalg.norm(corners + turned[leg] - base[leg], axis=1)
        # Of a facet across an edge of the surface a corner may belong to another leg.
        assert np.median(np.abs(length - end)) < 1e-8
        assert length.max() < 1.26 + 1e-8
        checked += len(corners)
    assert checked > 0.9 * found.facets.size / 3
    assert "platform.pitch = 8.0 deg" in found.told
    assert "platform.x" not in found.told


def test_it_stands_where_the_scene_shows_the_platforms_point() -> None:
    """Also where slides are counted from home, and one of them follows from the others."""
    for mechanism in ("five-bar", "flight-simulator", "3-upu"):
        solver, found = _found(mechanism)
        joint = solver.graph.joints[solver.graph.platform or 0]
        far = found.facets.reshape(-1, 3)
        far = far[np.isfinite(far).all(axis=1)][::501]
        own = [k for k, name in enumerate(("x", "y", "z")) if f"platform.{name}" in solver.driven]
        y = _home(solver)
        for point in far:
            for axis in own:
                name = f"platform.{'xyz'[axis]}"
                offset = solver.plan.offset(solver.graph.index(name, "test"))
                y[solver.driven.index(name)] = point[axis] - offset
            position, wxyz = solver.poses(y, solver.at(y))
            w, *v = wxyz[joint.child - 1]
            at = np.array(joint.M.p)
            turned = at + 2.0 * np.cross(v, np.cross(v, at) + w * at)
            assert position[joint.child - 1] + turned == pytest.approx(point, abs=1e-9)


def test_the_five_bars_outline_is_arcs_of_circles() -> None:
    solver, found = _found("five-bar")
    values = solver.graph.parameters
    lines = found.facets
    assert lines.shape[1:] == (2, 3)
    assert np.abs(lines[..., 2]).max() == 0.0
    joints = {joint.name: joint for joint in solver.graph.joints}
    pivots = np.array([joints[name].F.p for name in ("A1", "A2")])[:, :2]
    away = np.linalg.norm(lines.reshape(-1, 1, 3)[..., :2] - pivots, axis=-1)
    ends = np.array([values["distal"] - values["proximal"], values["distal"] + values["proximal"]])
    assert np.abs(away[..., None] - np.abs(ends)).min(axis=(1, 2)).max() < 1e-8


def test_each_colour_is_one_translucent_mesh_without_gaps() -> None:
    _, found = _found(RIG)
    scene = _Scene()
    nodes = add_surface(scene, found, "/workspace")
    assert nodes == list(scene.added)
    assert 1 < len(nodes) <= 12
    count, volume = 0, 0.0
    for kind, (vertices, faces), look in scene.added.values():
        assert kind == "mesh"
        assert 0.0 < look["opacity"] < 1.0
        a, b, c = vertices[faces].swapaxes(0, 1)
        volume += float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0
        count += len(faces)
    assert count == len(found.facets)
    assert volume == pytest.approx(0.0799, abs=4e-4)  # as random points tell, see docs/design.md
    assert len({look["color"] for _, _, look in scene.added.values()}) == len(nodes)


def test_nothing_is_drawn_at_the_edge_of_what_was_looked_at() -> None:
    _, found = _found("gough-stewart")
    scene = _Scene()
    assert add_surface(scene, found, "/workspace") == []
    assert "goes on beyond what was looked at" in found.told


def test_a_pose_beyond_limits_has_none() -> None:
    solver = _solver(RIG)
    y = _home(solver)
    y[2] = 1.3
    assert str(surface_of(solver, y)).startswith("no workspace from there: P")
