"""A motion on one chart, moment by moment."""

from __future__ import annotations

import numpy as np
import pytest

import parakin
from parakin import Status
from parakin.motion.course import Course
from parakin.motion.laws import from_laws, polynomial345
from parakin.solving.stretch import Nodes, Stretch, joined


def stretch_of(name: str, driven: str, to: float) -> tuple[Stretch, Nodes, parakin.Solver]:
    solver = parakin.compile(name, [driven], coordinates="all", machine_code=False)
    law = polynomial345(solver.home[driven], to - solver.home[driven], 1.0)
    course = Course(from_laws("m", {driven: law}, 1.0, 100.0))
    stretch = Stretch(solver.chart, course, solver.atlas.units)
    begin = np.zeros(1)
    head = stretch.evaluated(begin, begin, np.empty((0, 1)))
    return stretch, head, solver


def test_a_whole_turn_is_followed_to_its_end() -> None:
    stretch, head, solver = stretch_of("four-bar", "A", 7.0)
    walked, ending = stretch.walked(head, np.linspace(0.05, 1.0, 20))
    assert ending is None
    assert walked.time[0] == 0.0
    assert walked.time[-1] == 1.0
    assert (np.diff(walked.time) > 0).all()
    row = solver.coordinates.index("B")
    jumps = np.abs(np.diff(walked.out[row]))
    assert jumps.max() < 1.0  # no turn is lost on the way


def test_it_ends_where_the_mechanism_does() -> None:
    """The rocker of a crank-rocker swings between the crank's two dead points and no further."""
    a, b, c, d = 0.04, 0.12, 0.08, 0.1
    reach = np.arccos(((b - a) ** 2 - c * c - d * d) / (2 * c * d))  # crank folded on the coupler
    stretch, head, solver = stretch_of("four-bar", "D", np.pi)
    walked, ending = stretch.walked(head, np.linspace(0.02, 1.0, 50))
    assert ending is not None
    assert ending.status in (Status.OUT_OF_REACH, Status.BRANCH_CHANGE)
    last = walked.driven[0, 0, -1]
    assert last == pytest.approx(reach, abs=1e-6)
    assert solver.home["D"] < last


def test_middles_lie_between_and_on_the_motion() -> None:
    stretch, head, _ = stretch_of("four-bar", "A", 2.0)
    walked, _ = stretch.walked(head, np.array([0.5, 1.0]))
    halved = stretch.with_middles(walked, np.arange(len(walked.time) - 1))
    assert len(halved.time) == 2 * len(walked.time) - 1
    exact = stretch.evaluated(halved.time, halved.step, np.empty((0, len(halved.time))))
    np.testing.assert_allclose(halved.driven, exact.driven)
    np.testing.assert_allclose(halved.out[:3], exact.out[:3], atol=1e-12)


def test_parts_are_joined_as_they_were_cut() -> None:
    stretch, head, _ = stretch_of("four-bar", "A", 2.0)
    walked, _ = stretch.walked(head, np.linspace(0.1, 1.0, 10))
    again = joined(walked.part(slice(0, 4)), walked.part(slice(4, None)))
    for one, other in zip(walked, again, strict=True):
        np.testing.assert_array_equal(one, other)
