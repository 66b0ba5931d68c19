"""When a motion first goes beyond a limit, against roots of its law."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import parakin
from parakin import Body, Joint, Mechanism

SPAN, BY = 2.0, 0.6


def law(time: float, order: int) -> float:
    """The law poly345, and its first two derivatives."""
    s = time / SPAN
    shapes = (
        10 * s**3 - 15 * s**4 + 6 * s**5,
        30 * s**2 - 60 * s**3 + 30 * s**4,
        60 * s - 180 * s**2 + 120 * s**3,
    )
    return BY * shapes[order] / SPAN**order


def slide(limits: dict[str, Any], rate: float) -> tuple[parakin.Solver, parakin.Motion]:
    """A slide driven by 0.6 m in 2 s."""
    mechanism = Mechanism(
        name="slide",
        driven=("P",),
        bodies=(Body(name="a"),),
        joints=(Joint(name="P", kind="prismatic", parent="base", child="a"),),
        limits=limits,
        motions={
            "go": {"duration": SPAN, "rate": rate, "laws": {"P": {"law": "poly345", "by": BY}}}
        },
    )
    solver = parakin.compile(mechanism, machine_code=False)
    return solver, solver.motion("go")


@pytest.mark.parametrize("rate", [3, 10, 1000])
@pytest.mark.parametrize(
    ("name", "order", "limit", "until"),
    [
        ("P", 0, 0.25, SPAN),
        ("P", 0, 0.599, SPAN),
        ("P.velocity", 1, 0.4, 1.0),
        ("P.acceleration", 2, 0.5, 0.3),
    ],
)
def test_the_crossing_is_the_laws_own(
    name: str, order: int, limit: float, until: float, rate: float
) -> None:
    solver, motion = slide({name: (-math.inf, limit)}, rate)
    ds = solver.solve(motion)
    time = ds["time"].values
    beyond = np.array([law(t, order) > limit for t in time])
    np.testing.assert_array_equal(ds["status"].values == 5, beyond)
    if not beyond.any():
        assert ds.attrs["stops_met"] == ""
        return
    expected = brentq(lambda t: law(t, order) - limit, 0.0, until, xtol=1e-14)
    first = ds["first_at"].values[beyond]
    assert (first == first[0]).all()
    if expected > time[int(np.argmax(beyond)) - 1]:  # it may have been back before a coarse sample
        assert first[0] == pytest.approx(expected, abs=2e-9)
    np.testing.assert_allclose(
        ds["excess"].values[beyond], [law(t, order) - limit for t in time[beyond]], atol=1e-12
    )
    assert np.isnan(ds["excess"].values[~beyond]).all()
    assert np.isnan(ds["first_at"].values[~beyond]).all()


def test_the_first_sample_of_all_is_its_own_moment() -> None:
    solver, motion = slide({"P": (0.1, 1.0)}, 100)
    ds = solver.solve(motion)
    assert ds["first_at"].values[0] == 0.0
    assert ds["excess"].values[0] == pytest.approx(-0.1)


@pytest.mark.parametrize("size", [1, 2, 7, 50])
def test_windows_cut_no_crossing(size: int) -> None:
    solver, motion = slide({"P": (-1, 0.25), "P.velocity": (-0.5, 0.5)}, 50)
    whole = solver.solve(motion)
    parts = list(solver.stream(motion, size))
    joined = np.concatenate([part["first_at"].values for part in parts])
    np.testing.assert_array_equal(joined, whole["first_at"].values)
    assert parts[-1].attrs["stops_met"] == whole.attrs["stops_met"]
    met = [part.split()[0] for part in str(whole.attrs["stops_met"]).split(", ")]
    assert met == ["P.velocity", "P"]


def test_iterated_coordinates_cross_where_finer_samples_do() -> None:
    limits = {"platform.roll": (-0.05, 0.05)}
    legs = parakin.load("gough-stewart").model_copy(update={"limits": limits})
    inverse = parakin.compile(legs)
    free = parakin.compile("gough-stewart")
    names = [f"P{k}" for k in range(1, 7)]
    tour = free.solve(free.motion("tour", rate=500))
    motion = parakin.from_arrays(
        "legs",
        names,
        tour["time"].values,
        *(tour[q].sel(coordinate=names).values.T for q in ("position", "velocity", "acceleration")),
    )
    forward = parakin.compile(legs, names)
    ours, theirs = forward.solve(motion), inverse.solve(inverse.motion("tour", rate=500))
    np.testing.assert_array_equal(ours["status"], theirs["status"])
    beyond = theirs["status"].values == 5
    assert beyond.any()
    np.testing.assert_allclose(
        ours["first_at"].values[beyond], theirs["first_at"].values[beyond], atol=1e-7
    )


def test_each_end_of_a_limit_has_its_own_crossing() -> None:
    """There and back again, beyond both ends: a sine of 0.3 m, once in 2 s."""
    mechanism = slide({"P": (-0.2, 0.1)}, 100)[0].mechanism
    laws = {"P": {"law": "sine", "amplitude": 0.3, "frequency": 0.5}}
    mechanism = mechanism.model_copy(update={"motions": {"go": {"duration": 2.0, "laws": laws}}})
    ds = parakin.compile(mechanism, machine_code=False).solve("go")
    excess, first = ds["excess"].values, ds["first_at"].values
    up, down = math.asin(1 / 3) / math.pi, 1.0 + math.asin(2 / 3) / math.pi
    np.testing.assert_allclose(first[excess > 0], up, atol=2e-9)
    np.testing.assert_allclose(first[excess < 0], down, atol=2e-9)
    assert ds.attrs["stops_met"] == f"P > 0.1 m at t = {up:.4g} s, P < -0.2 m at t = {down:.4g} s"
