"""Motions from samples: what is taken, dropped and refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_array_equal
from waves import uneven, wave

from parakin.arrays import FloatArray
from parakin.errors import InputError
from parakin.motion import laws
from parakin.motion.laws import from_laws
from parakin.motion.sampled import from_arrays

PATIENT = settings(deadline=None)  # the first spline imports scipy


def refusal(error: pytest.ExceptionInfo[InputError]) -> str:
    return str(error.value)


REST_TO_REST = [laws.cosine, laws.polynomial345, laws.polynomial4567]


def test_given_derivatives_are_taken_as_given() -> None:
    t = uneven(200)
    drive = from_arrays("m", ["x", "y"], t, *wave(t))
    assert drive.derivatives == "given"
    assert drive.count == 200
    samples = drive.samples()
    for got, expected in zip(samples.orders, wave(t), strict=True):
        assert_array_equal(got, expected)
        assert got.flags.c_contiguous


@PATIENT
@given(st.integers(0, 50), st.integers(0, 50))
def test_a_window_of_arrays_is_a_slice_and_the_callers_own(start: int, stop: int) -> None:
    t = uneven(50)
    p, v, a, j = wave(t)
    drive = from_arrays("m", ["x", "y"], t, p, v, a, j)
    expected = drive.samples()
    part = drive.window(start, stop)
    p[:] = 0  # what the motion was made from
    for got, whole in zip(part.orders, expected.orders, strict=True):
        assert got.flags.c_contiguous
        assert_array_equal(got, whole[:, start:stop])
        got[:] = np.nan
    assert_array_equal(drive.samples().position, expected.position)


def test_a_repeated_sample_is_dropped_and_said() -> None:
    t = np.linspace(0, 1, 11)
    again = np.insert(t, 5, t[5])
    drive = from_arrays("m", ["x", "y"], again, *wave(again))
    assert drive.count == 11
    assert drive.derivatives == "given; repeated samples dropped: 1"
    assert_array_equal(drive.samples().time, t)


def arrays(**changes: Any) -> dict[str, Any]:
    """Good arguments of from_arrays, some of them replaced."""
    t = np.linspace(0, 1, 50)
    p, v, a, _ = wave(t)
    good = {"time": t, "position": p, "velocity": v, "acceleration": a, "jerk": None}
    return {"name": "m", "coordinates": ["x", "y"], **good, **changes}


POSITIONS_ONLY: dict[str, Any] = {"velocity": None, "acceleration": None}


def with_value(rows: FloatArray, index: Any, value: float) -> FloatArray:
    rows = rows.copy()
    rows[index] = value
    return rows


GOOD = arrays()

REFUSED: list[tuple[str, dict[str, Any], list[str]]] = [
    ("no coordinates", {"coordinates": []}, ["coordinates []", "one or more, each once"]),
    ("repeated", {"coordinates": ["x", "x"]}, ["coordinates ['x', 'x']", "each once"]),
    ("velocity alone", {"acceleration": None}, ["velocity alone", "both velocity and"]),
    ("acceleration alone", {"velocity": None}, ["acceleration alone", "both velocity and"]),
    ("smoothing given", {"smoothing": 1e-3}, ["velocity and smoothing", "positions alone"]),
    (
        "smoothing zero",
        {"smoothing": 0.0, **POSITIONS_ONLY},
        ["smoothing: found 0; expected a positive number"],
    ),
    (
        "smoothing whom",
        {"smoothing": {"z": 1.0}, **POSITIONS_ONLY},
        ["smoothing: found 'z'; expected one of: x, y"],
    ),
    ("text", {"time": ["a"]}, ["motion 'm', time", "'a'", "expected numbers"]),
    ("ragged", {"position": [[1.0], [1.0, 2.0]]}, ["motion 'm', position", "expected numbers"]),
    ("table of times", {"time": np.zeros((2, 2))}, ["an array of shape (2, 2)", "expected (n,)"]),
    (
        "transposed",
        {"position": GOOD["position"].T},
        ["motion 'm', position: found an array of shape (50, 2); expected (2, 50)"],
    ),
    (
        "time nan",
        {"time": with_value(GOOD["time"], 7, np.nan)},
        ["time of sample 7: found nan; expected a finite number"],
    ),
    (
        "velocity inf",
        {"velocity": with_value(GOOD["velocity"], (1, 49), np.inf)},
        ["velocity of 'y': found inf at t = 1 s (sample 49); expected a finite number"],
    ),
    (
        "backwards",
        {"time": with_value(GOOD["time"], 7, 0.1)},
        ["time of sample 7: found 0.1 s after 0.12244898 s; expected a later time"],
    ),
    (
        "stamp twice",
        {"time": with_value(GOOD["time"], 7, GOOD["time"][6])},
        ["time of sample 7: found 0.12244898 s after 0.12244898 s", "all values the same"],
    ),
    (
        "gap",
        {"time": np.append(GOOD["time"][:-1], 2.0)},
        [
            "found a step of 1.02041 s after sample 48 (t = 0.979591837 s)",
            "at most 0.204082 s (10 times the median)",
            "a larger max_gap allows it",
        ],
    ),
    ("gap by max_gap", {"max_gap": 0.01}, ["at most 0.01 s (max_gap)"]),
    ("max_gap", {"max_gap": np.nan}, ["max_gap: found nan; expected a positive number"]),
    (
        "too few for a spline",
        {"time": GOOD["time"][:5], "position": GOOD["position"][:, :5], **POSITIONS_ONLY},
        ["motion 'm': found 5 samples; expected at least 6"],
    ),
    (
        "too few to smooth",
        {
            "time": GOOD["time"][:23],
            "position": GOOD["position"][:, :23],
            "smoothing": 1.0,
            **POSITIONS_ONLY,
        },
        ["motion 'm': found 23 samples; expected at least 24"],
    ),
    (
        "one sample",
        {key: GOOD[key][..., :1] for key in ("time", "position", "velocity", "acceleration")},
        ["motion 'm': found 1 samples; expected at least 2"],
    ),
    (
        "none",
        {key: GOOD[key][..., :0] for key in ("time", "position", "velocity", "acceleration")},
        ["motion 'm': found 0 samples; expected at least 2"],
    ),
    (
        "too uneven",
        {"time": with_value(GOOD["time"], 7, GOOD["time"][6] + 1e-7), **POSITIONS_ONLY},
        ["'x': found steps from 1e-07 s to 0.0408162 s", "within a factor of 10,000"],
    ),
    ("jerk alone", {"jerk": GOOD["position"], **POSITIONS_ONLY}, ["found jerk alone"]),
    (
        "jerk in other units",
        {"jerk": 1e3 * wave(GOOD["time"])[3]},
        ["jerk of 'x': found an integral off by", "the derivative"],
    ),
    (
        "beyond range",
        {"position": 1e307 * GOOD["position"], **POSITIONS_ONLY},
        ["of 'x': found", "expected a finite number"],
    ),
]


@pytest.mark.parametrize(
    ("changes", "parts"), [case[1:] for case in REFUSED], ids=[case[0] for case in REFUSED]
)
def test_from_arrays_refuses(changes: dict[str, Any], parts: list[str]) -> None:
    with pytest.raises(InputError) as error:
        from_arrays(**arrays(**changes))
    assert "motion 'm'" in refusal(error)
    for part in parts:
        assert part in refusal(error)


def test_a_gap_may_be_allowed() -> None:
    t = np.append(np.linspace(0, 1, 50), 1.5)
    assert from_arrays("m", ["x", "y"], t, *wave(t), max_gap=0.6).count == 51


@pytest.mark.parametrize(
    ("velocity", "acceleration", "blamed"),
    [
        (180 / np.pi, 180 / np.pi, "velocity"),  # degrees beside radians
        (np.pi / 180, np.pi / 180, "velocity"),
        (1e3, 1e6, "velocity"),  # per ms
        (-1, -1, "velocity"),
        (0, 0, "velocity"),  # columns never filled
        (1, 60, "acceleration"),
        (1, 0, "acceleration"),
        (3, 3, "velocity"),
    ],
)
@pytest.mark.parametrize("n", [30, 200, 20_000])
@pytest.mark.parametrize("noise", [0.0, 1e-4])
def test_contradictions_are_refused(
    velocity: float, acceleration: float, blamed: str, n: int, noise: float
) -> None:
    t = uneven(n) if n > 100 else np.linspace(0, 2, n)
    p, v, a = (row[:1] for row in wave(t)[:3])
    p = p + noise * np.random.default_rng(7).standard_normal(p.shape)
    with pytest.raises(InputError) as error:
        from_arrays("m", ["x"], t, p, velocity * v, acceleration * a)
    assert f"motion 'm', {blamed} of 'x': found an integral off by" in refusal(error)
    assert "the derivative, in SI or the unit stated; or only positions" in refusal(error)


AMPLITUDES = st.sampled_from([0.0, 1e-9, 1e-3, 1.0, 1e3])

CYCLES = st.floats(0, 0.15)  # per sample: seven samples a cycle or more


@PATIENT
@given(n=st.integers(4, 1000), cycles=CYCLES, amplitude=AMPLITUDES, phase=st.floats(0, 6))
def test_true_derivatives_are_no_contradiction(
    n: int, cycles: float, amplitude: float, phase: float
) -> None:
    t = np.linspace(0, 1, n)
    p, v, a, j = laws.sine(0.3, amplitude, cycles * n, phase)(t)
    from_arrays("m", ["x"], t, [p], [v], [a], [j])


@given(
    n=st.integers(40, 3000),
    cycles=CYCLES,
    amplitude=AMPLITUDES,
    noise=st.tuples(*[st.sampled_from([0.0, 1e-5, 1e-2])] * 3),
    seed=st.integers(0, 2**32 - 1),
)
@settings(deadline=None, max_examples=300)
def test_noisy_derivatives_are_no_contradiction(
    n: int, cycles: float, amplitude: float, noise: tuple[float, ...], seed: int
) -> None:
    """Also where nothing moves, given samples enough to judge the noise by."""
    t = np.linspace(0, 1, n)
    rng = np.random.default_rng(seed)
    exact = laws.sine(0.3, amplitude, cycles * n, float(rng.uniform(0, 6)))(t)
    p, v, a = (x + s * rng.standard_normal(n) for x, s in zip(exact[:3], noise, strict=True))
    from_arrays("m", ["x"], t, [p], [v], [a])


def test_derivatives_of_short_laws_are_no_contradiction() -> None:
    for make in REST_TO_REST:
        for n in range(4, 20):
            samples = from_laws("m", {"x": make(0, 1, 1)}, 1, n - 1).samples()
            assert from_arrays("again", ["x"], *samples).count == n
