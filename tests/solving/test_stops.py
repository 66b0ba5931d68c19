"""What stops a mechanism: rows of limits, loops, and what is said of them."""

from __future__ import annotations

import copy
import math
import pickle

import numpy as np
import pytest

import parakin
from parakin import Status
from parakin.model.evaluation import graph_of
from parakin.solving.stops import Stops, beyond_limits, stops_of

LIMITS = {
    "P4": ("0.1 m", "0.55 m"),
    "P1.velocity": ("-0.5 m/s", "0.5 m/s"),
    "P2.acceleration": (-math.inf, "2 m/s^2"),
    "S2.cone": (0, "9 deg"),
}


@pytest.fixture(scope="module")
def rig() -> parakin.Solver:
    legs = parakin.load("gough-stewart").model_copy(update={"limits": LIMITS})
    return parakin.compile(legs, coordinates="all")


def test_stops_are_nothing_then_limits_then_limbs(rig: parakin.Solver) -> None:
    stops = rig.stops
    assert stops.names[:5] == ("", "P4", "P1.velocity", "P2.acceleration", "S2.cone")
    assert stops.names[5:] == tuple(f"limb U{k}, P{k}, S{k}" for k in range(1, 7))
    assert stops.units[:5] == ("", "m", "m/s", "m/s²", "rad")
    assert stops.joints[4:6] == (("S2",), ("U1", "P1", "S1"))
    for twin in (pickle.loads(pickle.dumps(stops)), copy.deepcopy(stops)):
        assert repr(twin) == repr(stops)  # NaN is not equal to itself


def test_joints_of_several_legs_that_are_solved_together_are_named_together() -> None:
    forward = parakin.compile("gough-stewart", [f"P{k}" for k in range(1, 7)])
    assert forward.stops.names[1].startswith("limbs U1, P1, S1, U2, ")


def test_a_loop_without_the_platform_is_no_limb() -> None:
    stops = parakin.compile("four-bar").stops
    assert stops.names == ("", "loop A, B, C, D")
    assert stops.words(1, math.nan) == "loop A, B, C, D cannot close"


def test_loops_of_another_plan_are_named_by_the_joints_they_share(rig: parakin.Solver) -> None:
    stops = stops_of(rig.plan)
    assert stops.names[stops.most_like(("U3", "P3"))] == "limb U3, P3, S3"
    assert stops.most_like(("elsewhere",)) == 0


@pytest.mark.parametrize(
    ("number", "excess", "words"),
    [
        (0, math.nan, ""),
        (1, 0.002, "P6 at 1.262 m, limit 1.260 m"),
        (1, -0.1, "P6 at 0.400 m, limit 0.500 m"),
        (1, 3e-9, "P6 at 1.260000003 m, limit 1.260000000 m"),
        (2, math.radians(1), "A.velocity at 31.000°/s, limit 30.000°/s"),
        (3, math.radians(-2), "B.cone at -2.000°, limit 0.000°"),
        (4, math.nan, "limb A, B cannot reach"),
    ],
)
def test_words_name_the_stop_with_as_many_digits_as_it_takes(
    number: int, excess: float, words: str
) -> None:
    stops = Stops(
        ("", "P6", "A.velocity", "B.cone", "limb A, B"),
        ("", "m", "rad/s", "rad", ""),
        (math.nan, 0.5, math.radians(-30), 0.0, math.nan),
        (math.nan, 1.26, math.radians(30), math.radians(45), math.nan),
        ((), ("P6",), ("A",), ("B",), ("A", "B")),
    )
    assert stops.words(number, excess) == words


def test_rows_say_which_limit_is_exceeded_by_the_greatest_part_of_its_range(
    rig: parakin.Solver,
) -> None:
    rows = rig.chart.limits
    place = dict(zip(rows.numbers.tolist(), rows.rows.tolist(), strict=True))
    out = np.zeros((rig.chart.outputs.count, 6))
    out[place[1]] = 0.3
    out[place[1], 1:4] = [0.59, 0.05, 0.55 + 1e-14]  # the last within rounding
    out[place[2], 1] = 0.6  # 10 % of its range beyond, and P4 a little less
    out[place[3], 4] = 3.0
    out[place[4], 5] = np.nan  # undefined, and so beyond nothing
    found = rows.stopped(out)
    assert found.number.tolist() == [0, 2, 1, 0, 3, 0]
    np.testing.assert_allclose(found.excess, [np.nan, 0.1, -0.05, np.nan, 1.0, np.nan])
    kept = [rows.kept(column) for column in out.T]
    assert kept == [True, False, False, True, False, False]  # where NaN is not kept


@pytest.mark.filterwarnings("error")
def test_infinity_is_beyond_every_end_that_is_not_open(rig: parakin.Solver) -> None:
    rows = rig.chart.limits
    place = dict(zip(rows.numbers.tolist(), rows.rows.tolist(), strict=True))
    out = np.zeros((rig.chart.outputs.count, 2))
    out[place[1]] = 0.3
    out[place[1], 0] = 0.6
    out[place[3], 0], out[place[3], 1] = -np.inf, np.inf  # open below
    found = rows.stopped(out)
    assert found.number.tolist() == [1, 3]
    np.testing.assert_allclose(found.excess, [0.05, np.inf])


def test_a_configuration_is_held_to_positions_and_cones_alone() -> None:
    graph = graph_of(parakin.load("gough-stewart").model_copy(update={"limits": LIMITS}))
    assert beyond_limits(graph, {"P4": 0.3, "S2.cone": 0.1}) == ()
    assert beyond_limits(graph, {"P4": 0.6, "S2.cone": 0.2}) == ("P4", "S2.cone")
    assert beyond_limits(graph, {"P4": math.nan, "S2.cone": 0.1}) == ("P4",)


def test_a_limb_that_follows_from_loops_left_open_is_not_to_blame() -> None:
    """A passive limb of two links beside a hexapod that its legs drive."""
    legs = parakin.load("gough-stewart")
    along_x, along_y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    passive = (
        parakin.Joint(
            name="E",
            kind="universal",
            parent="base",
            child="upper",
            on_parent=parakin.Frame(at=(0.05, 0.02, 0), axis=along_x, x=along_y),
            on_child=parakin.Frame(axis=along_y, x=(-1.0, 0.0, 0.0)),
        ),
        parakin.Joint(
            name="F",
            kind="revolute",
            parent="upper",
            child="lower",
            on_parent=parakin.Frame(at=(0, 0, 0.7), axis=along_x),
            on_child=parakin.Frame(axis=along_x),
        ),
        parakin.Joint(
            name="G",
            kind="spherical",
            parent="lower",
            child="platform",
            on_parent=parakin.Frame(at=(0, 0, 0.7)),
        ),
    )
    both = legs.model_copy(
        update={
            "bodies": (*legs.bodies, parakin.Body(name="upper"), parakin.Body(name="lower")),
            "joints": (*legs.joints, *passive),
            "guess": {**legs.guess, "E.1": -0.667, "F": 1.333},
        }
    )
    sliders = [f"P{k}" for k in range(1, 7)]
    alone, rig = (
        parakin.compile(m, sliders, coordinates="all", machine_code=False) for m in (legs, both)
    )
    rng = np.random.default_rng(0)
    home = np.array([rig.home[name] for name in sliders])
    y = home[:, None] + 0.4 * rng.normal(size=(6, 100))
    at_home = alone.at(y, guess=np.array([alone.home[c] for c in alone.coordinates]))
    reached = np.isfinite(at_home.position).all(axis=0)
    tick = rig.at(y, guess=np.array([rig.home[c] for c in rig.coordinates]))
    named = np.array(rig.stops.names)[np.asarray(tick.stopped_by)]
    unreached = (Status.OUT_OF_REACH, Status.ITERATION_LIMIT)
    open_ = np.isin(tick.status, unreached)
    assert {*named[open_ & np.isin(at_home.status, unreached)]} == {rig.stops.names[1]}
    assert {*named[open_ & reached]} == {"limb E, F, G"}
