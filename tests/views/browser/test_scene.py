"""The scene of a page: bodies stand where the solver puts them, and can be seen."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from browser import Page, agree, needs_chromium, until
from scipy.spatial.transform import Rotation

import parakin
from parakin.model.evaluation import graph_of
from parakin.views.browser.scene import Scene, _from_z
from parakin.views.solids.drawing import COLOURS, drawing_of


def _like(pixels: np.ndarray, rgb: tuple[int, int, int]) -> int:
    """How many pixels have a colour's hue, whatever its light."""
    wanted = np.array(rgb) / np.linalg.norm(rgb)
    size = np.linalg.norm(pixels, axis=2)
    near = (pixels @ wanted > 0.985 * size) & (size > 60) & (np.ptp(pixels, axis=2) > 40)
    return int(near.sum())


@needs_chromium
def test_it_loads_without_a_word_and_shows_the_machine(simulator: Page) -> None:
    until(lambda: _like(simulator.pixels(), COLOURS["actuated"]) > 300)
    pixels = simulator.pixels()
    assert _like(pixels, COLOURS["platform"]) > 300
    assert pixels.std() > 10
    assert simulator.said == []
    start = simulator.viewer.url
    assert all(url.startswith((start, f"blob:{start}", "data:")) for url in simulator.asked)


@needs_chromium
def test_bodies_stand_where_the_solver_says(simulator: Page) -> None:
    solver = parakin.compile("flight-simulator")
    simulator.choose("Motion", "general")
    until(
        lambda: (
            simulator.session.playback is not None and simulator.session.playback.name == "general"
        )
    )
    ds = solver.solve("general", bodies=True)
    for k in (0, 700, 1500, 3000):
        simulator.session.seek(float(ds["time"][k]))
        position, wxyz = ds["body_position"].values[k], ds["body_orientation"].values[k]
        agree(simulator, position, wxyz)


class Api:
    """What viser's scene is asked for; nodes keep what they are given."""

    def __init__(self) -> None:
        self.nodes: dict[str, SimpleNamespace] = {}

    def _add(self, name: str, *_: Any, **given: Any) -> SimpleNamespace:
        self.nodes[name] = SimpleNamespace(**given, remove=lambda: self.nodes.pop(name))
        return self.nodes[name]

    add_frame = add_label = add_mesh_simple = add_grid = add_line_segments = _add


@pytest.mark.parametrize("direction", [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0.6, -0.48, 0.64)])
def test_the_shortest_turn_from_z(direction: tuple[float, float, float]) -> None:
    turn = Rotation.from_quat(_from_z(np.array(direction, dtype=float)), scalar_first=True)
    np.testing.assert_allclose(turn.apply([0, 0, 1]), direction, atol=1e-15)
    assert turn.magnitude() == pytest.approx(np.arccos(direction[2]), abs=1e-7)


def test_rods_reach_from_end_to_end() -> None:
    """A rod of an RSSR turns with its bodies, and keeps its length."""
    solver = parakin.compile("rssr")
    api = Api()
    scene = Scene(api, drawing_of(solver.graph))
    result = solver.solve(next(iter(solver.mechanism.motions)), bodies=True)
    (rod,) = scene.drawing.rods
    node = api.nodes[f"/mechanism/.rod {solver.graph.joints[rod.joint].name}"]
    length = solver.graph.joints[rod.joint].length
    names = solver.graph.bodies[1:]
    for k in (0, len(result["time"]) // 3, -1):
        position = result["body_position"].sel(body=list(names)).values[k]
        wxyz = result["body_orientation"].sel(body=list(names)).values[k]
        scene.place(position, wxyz)
        turns = Rotation.from_quat(wxyz, scalar_first=True)
        start = position[rod.parent - 1] + turns[rod.parent - 1].apply(rod.start)
        end = position[rod.child - 1] + turns[rod.child - 1].apply(rod.end)
        np.testing.assert_allclose(node.position, start, atol=1e-12)
        along = Rotation.from_quat(node.wxyz, scalar_first=True).apply([0, 0, length])
        np.testing.assert_allclose(node.position + along, end, atol=1e-9)


def test_joints_are_highlighted_and_no_others() -> None:
    graph = graph_of(parakin.load("four-bar"))
    api = Api()
    scene = Scene(api, drawing_of(graph))
    number = next(k for k, joint in enumerate(graph.joints) if joint.name == "C")

    def red() -> set[str]:
        marked = {
            n for n, node in api.nodes.items() if vars(node).get("color") == COLOURS["offending"]
        }
        return {name.split()[1] for name in marked}

    assert red() == set()
    scene.highlight({number})
    assert red() == {"C"}
    scene.highlight(())
    assert red() == set()


def test_a_trace_replaces_the_one_before() -> None:
    api = Api()
    scene = Scene(api, drawing_of(graph_of(parakin.load("four-bar"))))
    scene.trace(np.random.default_rng(0).normal(size=(10_000, 3)))
    assert "/mechanism/.trace" in api.nodes
    scene.trace(None)
    assert "/mechanism/.trace" not in api.nodes
    scene.trace(np.full((5, 3), np.nan))
    assert "/mechanism/.trace" not in api.nodes
