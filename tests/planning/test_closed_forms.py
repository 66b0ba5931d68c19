"""Which rows single unknowns get."""

from __future__ import annotations

import numpy as np
import pytest

import parakin
from parakin.errors import DrivenError
from parakin.kinematics.assembly import neighbours
from parakin.kinematics.closure import CentreDistance, FrameAxis, Gap, PairAxis
from parakin.kinematics.configuration import configure
from parakin.planning.closed_forms import steady


def test_rows_of_one_frame_span_the_same_volume_everywhere_and_others_do_not() -> None:
    graph = parakin.compile("flight-simulator", machine_code=False).graph
    tree = graph.posed_tree()
    home = parakin.compile("flight-simulator", machine_code=False).plan.home
    at = configure(graph, tree, home[: len(graph.coordinates)])
    samples = [*neighbours(graph, tree, at, 4), at]
    cut = next(k for k in tree.cuts if graph.joints[k].kind == "spherical")
    own = [Gap(cut, FrameAxis("F", axis)) for axis in range(3)]
    assert steady(graph, own, samples)
    mixed = [own[0], Gap(cut, FrameAxis("M", 0))]
    assert not steady(graph, mixed, samples)


def test_a_leg_is_solved_by_its_length() -> None:
    """Inverse of the hexapod: each slide by the distance between its leg's two centres."""
    plan = parakin.compile("gough-stewart", machine_code=False).plan
    graph = plan.graph
    for i in range(1, 7):
        slide = graph.index(f"P{i}", "test")
        (block,) = [b for b in plan.blocks if slide in b.unknowns]
        (row,) = block.rows
        assert isinstance(row, (CentreDistance, Gap))
        if isinstance(row, Gap):
            assert isinstance(row.along, (FrameAxis, PairAxis))
        others = {graph.joints[graph.coordinates[k].joint].name for k in block.needs}
        assert not {name for name in others if name.startswith("P") and name != f"P{i}"}


def test_a_singular_home_is_refused_by_name() -> None:
    """A four-bar driven at its rocker, where crank and coupler are in line."""
    a, b, c, d = 0.04, 0.12, 0.08, 0.1
    stretched = np.arccos(((a + b) ** 2 + d**2 - c**2) / (2 * (a + b) * d))
    mechanism = parakin.load("four-bar")
    mechanism = mechanism.model_copy(
        update={"home": {"A": float(stretched)}, "guess": {"B": 0.0, "D": 1.8}, "driven": ("D",)}
    )
    with pytest.raises((DrivenError, parakin.AssemblyError), match="four-bar"):
        parakin.compile(mechanism, machine_code=False)
