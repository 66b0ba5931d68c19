"""Sensitivities against closed forms: a slider-crank and a leg between two points."""

from __future__ import annotations

import math

import numpy as np
import pytest

import parakin
from parakin.kernel.designs import SensitivityRows
from parakin.kernel.outputs import Outputs


def test_rows_say_how_many_there_are() -> None:
    solver = parakin.compile("gough-stewart", free=["r_base", "height"], machine_code=False)
    rows = SensitivityRows(solver.opened.plan, Outputs((0, 1), 0, checks=False), 0)
    assert (rows.parameters, rows.seeds, rows.changes) == (2, 8, 0)
    fixed = SensitivityRows(solver.plan, Outputs((0,), 0, checks=False), 0)
    assert (fixed.parameters, fixed.seeds, fixed.changes) == (0, 6, 0)


@pytest.mark.parametrize("angle", [-2.0, 0.3, 1.4, 3.0])
def test_a_slider_crank_by_its_closed_form(angle: float, reading: bool) -> None:
    a, b, h = 0.04, 0.12, -0.02
    solver = parakin.compile(
        "slider-crank", free=["a", "b", "offset"], coordinates="all", machine_code=reading
    )
    found = parakin.sensitivities(solver, [angle])
    slide = slide_of(solver)
    s, c = math.sin(angle), math.cos(angle)
    # x = a c + r, r² = b² - (h - a s)²
    r = math.sqrt(b**2 - (h - a * s) ** 2)
    assert found.of(slide, "a") == pytest.approx(c + (h - a * s) * s / r, abs=1e-13)
    assert found.of(slide, "b") == pytest.approx(b / r, abs=1e-13)
    assert found.of(slide, "offset") == pytest.approx(-(h - a * s) / r, abs=1e-13)
    assert found.of(slide, "A") == pytest.approx(-a * s + (h - a * s) * a * c / r, abs=1e-13)


def slide_of(solver: parakin.Solver) -> str:
    """The slide's coordinate, which is x itself, whatever it is called."""
    (joint,) = [j for j in solver.graph.joints if j.kind == "prismatic"]
    assert solver.at([0.0]).value(joint.name) == pytest.approx(
        0.04 + math.sqrt(0.12**2 - 0.02**2), abs=1e-12
    )
    return joint.name


def test_a_leg_by_plain_vectors() -> None:
    names = ["r_base", "r_platform", "stroke_0"]
    solver = parakin.compile("gough-stewart", free=names)
    rng = np.random.default_rng(4)
    y = np.array([solver.home[k] for k in solver.driven])[:, None] + rng.uniform(-0.1, 0.1, (6, 9))
    y[3:] = 0.0
    found = parakin.sensitivities(solver, y)
    foot, top = np.radians(-10.0), np.radians(-50.0)
    outward = np.array([[np.cos(foot)], [np.sin(foot)], [0.0]])
    inward = np.array([[np.cos(top)], [np.sin(top)], [0.0]])
    leg = y[:3] + 0.7 * inward - 1.2 * outward
    along = leg / np.linalg.norm(leg, axis=0)
    np.testing.assert_allclose(found.of("P1", "r_base"), -(along * outward).sum(0), atol=1e-13)
    np.testing.assert_allclose(found.of("P1", "r_platform"), (along * inward).sum(0), atol=1e-13)
    np.testing.assert_allclose(found.of("P1", "stroke_0"), -1.0, atol=1e-13)
    np.testing.assert_allclose(found.of("P1", "platform.z"), along[2], atol=1e-13)
