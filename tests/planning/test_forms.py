"""Closed forms: they put their unknown where the rows vanish, on the root of their sign."""

from __future__ import annotations

import math

import numpy as np
import pytest

import parakin
from parakin.algebra.spatial import ARRAYS, FLOATS, as_array, as_float
from parakin.kinematics import loops
from parakin.kinematics.configuration import circuits_at
from parakin.planning.forms import (
    CosineAngle,
    Form,
    Iterated,
    LinearSlide,
    QuadraticSlide,
    Solution,
    TangentAngle,
    TwoRoots,
    TwoRowAngle,
    signed,
)
from parakin.planning.plan import Block, Plan

CLOSED = (LinearSlide, QuadraticSlide, TangentAngle, CosineAngle, TwoRowAngle)
PLANS = [
    ("flight-simulator", None),
    ("flight-simulator", ("A2", "B3", "C3")),
    ("gough-stewart", None),
    ("slider-crank", None),
    ("slider-crank", ("D",)),
    ("four-bar", None),
    ("bennett", None),
    ("3-prs", None),
    ("6-pus", None),
    ("linear-delta", None),
    ("delta-revolute", None),
]


def plan_of(name: str, driven: tuple[str, ...] | None) -> Plan:
    return parakin.compile(name, driven, machine_code=False).plan


def solved(plan: Plan, block: Block) -> tuple[Solution, float]:
    """Of a block of one unknown at home, all others being there; and how far its rows are off."""
    assert not isinstance(block.form, Iterated)
    (k,) = block.unknowns
    base = circuits_at(plan.graph, plan.tree, plan.home)
    found = block.form.solve(base, k, block.rows, FLOATS)
    there = base.with_coordinates({k: found.turn})
    off = [abs(as_float(row.value(there, loops.ends(there, row.cut)))) for row in block.rows]
    return found, max(off)


@pytest.mark.parametrize(("name", "driven"), PLANS)
def test_the_root_is_that_of_home(name: str, driven: tuple[str, ...] | None) -> None:
    plan = plan_of(name, driven)
    for block in plan.blocks:
        if block.iterated:
            continue
        found, off = solved(plan, block)
        (k,) = block.unknowns
        assert off < 1e-14 * (1 + plan.graph.length) ** 2
        if plan.graph.coordinates[k].angle:
            angle = math.atan2(as_float(found.turn.sine), as_float(found.turn.cosine))
            assert math.cos(angle - plan.home[k]) > 1 - 1e-14
        else:
            assert as_float(found.turn.amount) == pytest.approx(plan.home[k], abs=1e-13)


def test_every_form_has_been_tried() -> None:
    tried = {type(block.form) for plan in PLANS for block in plan_of(*plan).blocks}
    assert tried >= {*CLOSED}, [form for form in CLOSED if form not in tried]


@pytest.mark.parametrize(("name", "driven"), PLANS)
def test_the_other_sign_gives_the_other_root(name: str, driven: tuple[str, ...] | None) -> None:
    plan = plan_of(name, driven)
    for block in plan.blocks:
        if not isinstance(block.form, TwoRoots):
            continue
        other = type(block.form)(**{**vars(block.form), "sign": -block.form.sign})
        found, off = solved(plan, Block(block.unknowns, block.rows, other))
        assert off < 1e-13 * (1 + plan.graph.length) ** 2
        (k,) = block.unknowns
        mine = solved(plan, block)[0].turn
        if plan.graph.coordinates[k].angle:
            apart = as_float(mine.cosine) * as_float(found.turn.cosine)
            apart += as_float(mine.sine) * as_float(found.turn.sine)
            assert apart < 1 - 1e-9
        else:
            assert abs(as_float(mine.amount) - as_float(found.turn.amount)) > 1e-9


def test_what_cannot_be_reached_is_nan() -> None:
    """The rocker of the four-bar where crank and ground are too far apart for the coupler."""
    plan = parakin.compile(parakin.load("four-bar", {"d": 0.22}), machine_code=False).plan
    (block,) = [b for b in plan.blocks if isinstance(b.form, CosineAngle)]
    q = np.array([plan.home, plan.home]).T
    crank = plan.driven[0]
    q[crank] = [plan.home[crank], math.pi]  # stretched: 260 mm to span with 200
    base = circuits_at(plan.graph, plan.tree, q)
    with np.errstate(invalid="ignore"):
        assert not isinstance(block.form, Iterated)
        found = block.form.solve(base, block.unknowns[0], block.rows, ARRAYS)
    assert np.isnan(as_array(found.turn.cosine)).tolist() == [False, True]
    assert as_array(found.signed[0])[1] < 0  # the figure says so too


def test_signs_come_from_the_slope_at_home() -> None:
    for slope in (2.0, -3.0):
        for form in (QuadraticSlide(False), TangentAngle(True, 1.0), CosineAngle(True, 1.0)):
            found = signed(form, np.array([[slope]]))
            assert isinstance(found, type(form))
            assert found.sign == np.sign(slope)
    assert signed(LinearSlide(True), np.array([[-2.0]])) == LinearSlide(True)


def test_home_is_singular_where_the_slopes_are() -> None:
    forms: list[Form] = [CosineAngle(True, 1.0), LinearSlide(True), Iterated()]
    for form in forms:
        assert signed(form, np.array([[0.0]])) is None
    rows = np.array([[1.0, 2.0], [2.0, 4.0 + 1e-12]])
    assert signed(Iterated(), rows) is None
    with np.errstate(invalid="ignore"):
        assert signed(Iterated(), np.array([[np.nan]])) is None


def test_several_unknowns_are_measured_by_their_determinant() -> None:
    rows = np.array([[3.0, 4.0], [0.0, -2.0]])
    found = signed(Iterated(), rows)
    assert found == Iterated(sign=-1.0, reference=0.6, lengths=(5.0, 2.0))
    tall = np.array([[1.0, 0.0], [0.0, 2.0], [0.0, 0.0]])
    assert signed(Iterated(), tall) == Iterated(unsigned=True, reference=2.0)
