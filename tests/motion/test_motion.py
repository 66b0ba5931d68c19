"""Motions: laws with exact derivatives, samples with those of splines, tables, and refusals."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import mp
from numpy.testing import assert_allclose, assert_array_equal
from pydantic import BaseModel, ConfigDict, ValidationError, field_validator

from parakin.arrays import FloatArray
from parakin.errors import InputError
from parakin.files.motion_toml import laws_by_coordinate, motion_from_table
from parakin.model.expressions import ANGLE, LENGTH, Parameters
from parakin.model.validation import input_error, validated
from parakin.motion import laws
from parakin.motion.laws import Law, from_laws
from parakin.motion.motion import Motion
from parakin.motion.sampled import from_arrays

PATIENT = settings(deadline=None)  # the first spline imports scipy
EPS = float(np.finfo(float).eps)


def refusal(error: pytest.ExceptionInfo[InputError]) -> str:
    return str(error.value)


def assert_says(error: pytest.ExceptionInfo[InputError], message: str) -> None:
    """Each of the parts of `message`, which three dots separate."""
    for part in message.split(" ... "):
        assert part in refusal(error)


# ---- laws


def same_in_mpmath(law: str) -> Callable[[Any], Any]:
    """Position as a function of t, written down a second time with 40 digits."""
    pi: Any = mp.pi
    sin: Callable[[Any], Any] = mp.sin
    cos: Callable[[Any], Any] = mp.cos

    def u(t: Any) -> Any:
        return (t - mp.mpf("0.25")) / 2

    laws: dict[str, Callable[[Any], Any]] = {
        "constant": lambda t: mp.mpf("0.7"),
        "cosine": lambda t: mp.mpf("0.1") + mp.mpf("-0.3") / 2 * (1 - cos(pi * u(t))),
        "polynomial345": lambda t: (
            mp.mpf("0.1") - mp.mpf("0.3") * (10 * u(t) ** 3 - 15 * u(t) ** 4 + 6 * u(t) ** 5)
        ),
        "polynomial4567": lambda t: (
            mp.mpf("0.1")
            - mp.mpf("0.3") * (35 * u(t) ** 4 - 84 * u(t) ** 5 + 70 * u(t) ** 6 - 20 * u(t) ** 7)
        ),
        "sine": lambda t: mp.mpf("0.5") + mp.mpf("0.2") * sin(2 * pi * mp.mpf("1.5") * t + 1),
        "sines": lambda t: mp.mpf("0.5") + mp.mpf("0.2") * sin(2 * pi * t) + sin(6 * pi * t + 2),
        "chirp": lambda t: (
            mp.mpf("0.5")
            + mp.mpf("0.2") * sin(2 * pi * (t / 2 + (mp.mpf(4) - mp.mpf("0.5")) * t**2 / 6) + 1)
        ),
    }
    return laws[law]


LAWS: dict[str, Law] = {
    "constant": laws.constant(0.7),
    "cosine": laws.cosine(0.1, -0.3, 2.0, 0.25),
    "polynomial345": laws.polynomial345(0.1, -0.3, 2.0, 0.25),
    "polynomial4567": laws.polynomial4567(0.1, -0.3, 2.0, 0.25),
    "sine": laws.sine(0.5, 0.2, 1.5, 1.0),
    "sines": laws.sines(0.5, [(0.2, 1.0, 0.0), (1.0, 3.0, 2.0)]),
    "chirp": laws.chirp(0.5, 0.2, 0.5, 4.0, 3.0, 1.0),
}


@pytest.mark.parametrize("name", LAWS)
def test_laws_and_their_derivatives_agree_with_forty_digits(name: str) -> None:
    t = np.linspace(0.3, 2.2, 41)  # where the rest-to-rest laws move
    with mp.workdps(40):
        reference = [
            [float(mp.diff(same_in_mpmath(name), mp.mpf(float(x)), order)) for x in t]
            for order in range(4)
        ]
    for got, expected in zip(LAWS[name](t), reference, strict=True):
        # Angles reach 2π·3 Hz·2.2 s, about 40 rad; the polynomials cancel about 100-fold at u = 1.
        assert_allclose(got, expected, rtol=0, atol=200 * EPS * max(1, np.abs(expected).max()))


def test_a_law_may_leave_out_the_jerk_and_no_more() -> None:
    drive = from_laws("m", {"x": lambda t: LAWS["sine"](t)[:3], "y": LAWS["cosine"]}, 1.0, 10.0)
    samples = drive.samples()
    assert samples.jerk is None
    assert_array_equal(samples.acceleration[1], LAWS["cosine"](samples.time)[2])
    with pytest.raises(InputError, match="2 arrays from the law of 'x'; expected position, vel"):
        from_laws("m", {"x": lambda t: LAWS["sine"](t)[:2]}, 1.0, 10.0).samples()


def test_cosine_is_equation_6_of_the_paper() -> None:
    home, x_star = 1.8, 0.05
    samples = from_laws("paper", {"x": laws.cosine(home, 2 * x_star, 3.0)}, 3.0, 1000.0).samples()
    assert_allclose(
        samples.position[0],
        home + x_star * (1 - np.cos(np.pi / 3 * samples.time)),
        rtol=0,
        atol=4 * EPS,
    )
    assert len(samples.time) == 3001
    assert samples.time[-1] == 3.0
    # The end's samples have the accelerations of the moving side, also after rounded times.
    assert_allclose(
        samples.acceleration[0, [0, -1]], [x_star * np.pi**2 / 9, -x_star * np.pi**2 / 9]
    )


REST_TO_REST = [laws.cosine, laws.polynomial345, laws.polynomial4567]
finite = st.floats(-10, 10)
positive = st.floats(0.01, 100)


@pytest.mark.parametrize("make", REST_TO_REST)
@PATIENT
@given(start=finite, by=finite, duration=positive, begin=st.floats(0, 10))
def test_rest_to_rest_laws_rest_at_and_beyond_both_ends(
    make: Any, start: float, by: float, duration: float, begin: float
) -> None:
    law = make(start, by, duration, begin)
    ends = np.array([begin - 1, begin, begin + duration, begin + duration + 1])
    position, velocity, acceleration, _ = law(ends)
    scale = abs(start) + abs(by)
    # The coefficients of the polynomials amount to 209: so many roundings at most.
    assert_allclose(
        position, [start, start, start + by, start + by], atol=209 * EPS * scale, rtol=0
    )
    # The cosine's end rests but for the rounding of the time, as its velocity grows linearly.
    late = 1e-14 * (1 + begin / duration)
    assert_allclose(velocity, 0, atol=10 * late * abs(by) / duration, rtol=0)
    assert_array_equal(velocity[[0, 3]], 0)
    assert_array_equal(acceleration[[0, 3]], 0)
    if make is not laws.cosine:
        atol = 1000 * late * abs(by) / duration**2
        assert_allclose(acceleration, 0, atol=atol, rtol=0)


@PATIENT
@given(
    steps=st.lists(st.floats(0.2, 2), min_size=1, max_size=6),
    values=st.lists(finite, min_size=7, max_size=7),
)
def test_waypoints_are_met_and_begin_and_end_at_rest(
    steps: list[float], values: list[float]
) -> None:
    times = np.cumsum([0.5, *steps])
    x = np.array(values[: len(times)])
    law = laws.waypoints(times, x)
    position, velocity, acceleration, _ = law(times)
    # Ten times as fine steps reach ten thousandfold the fourth derivative: hence 1e-9.
    assert_allclose(position, x, atol=1e-9, rtol=0)
    assert_array_equal(velocity[[0, -1]], 0)
    assert_array_equal(acceleration[[0, -1]], 0)
    beyond = law(np.array([0.0, times[-1] + 1]))
    assert_allclose(beyond[0], x[[0, -1]], atol=1e-9)
    assert_array_equal(beyond[1:], np.zeros((3, 2)))


def test_two_waypoints_are_the_polynomial345() -> None:
    """The one quintic that rests at both ends."""
    t = np.linspace(0, 3, 301)
    through = laws.waypoints([0.5, 2.5], [1.0, 4.0])(t)
    for got, expected in zip(through, laws.polynomial345(1.0, 3.0, 2.0, 0.5)(t), strict=True):
        assert_allclose(got, expected, atol=1e-13)


def test_waypoints_are_smooth_between() -> None:
    times = np.array([0.0, 0.4, 1.0, 1.3, 2.0])
    law = laws.waypoints(times, [0.0, 1.0, -0.5, 0.2, 0.0])
    for end in times[1:-1]:
        before, after = np.array([end - 1e-9]), np.array([end + 1e-9])
        for a, b in zip(law(before), law(after), strict=True):
            assert_allclose(a, b, atol=1e-5)  # the jerk, below 1e3, over 2e-9 s
    t = np.linspace(0.01, 1.99, 100)
    h = 1e-4  # central differences: h² x'''/6 with x''' and x'''' below 1e4, and rounding ε/h
    _, velocity, acceleration, jerk = law(t)
    ahead, behind = law(t + h), law(t - h)
    assert_allclose((ahead[0] - behind[0]) / (2 * h), velocity, atol=1e-4)
    assert_allclose((ahead[1] - behind[1]) / (2 * h), acceleration, atol=1e-3)
    assert_allclose((ahead[2] - behind[2]) / (2 * h), jerk, atol=0.1)  # of some hundreds


@pytest.mark.parametrize(
    ("times", "values", "parts"),
    [
        ([0.0], [1.0], ["times: found [0.0]", "two or more, increasing"]),
        ([0, 1, 1], [1, 2, 3], ["times: found [0.0, 1.0, 1.0]", "increasing"]),
        ([0, np.inf], [1, 2], ["times", "increasing"]),
        ([0, 1], [1, np.nan], ["values: found [1.0, nan]", "finite"]),
        ([0, 1, 2], [1, 2], ["values: found an array of shape (2,)", "expected (3,)"]),
        (["a"], [1], ["times", "'a'", "expected numbers"]),
        ([0, 1e-9, 1], [1, 2, 3], ["steps from 1e-09 s to 1 s", "within a factor of 10,000"]),
    ],
)
def test_waypoints_refuse(times: Any, values: Any, parts: list[str]) -> None:
    with pytest.raises(InputError) as error:
        laws.waypoints(times, values)
    for part in parts:
        assert part in refusal(error)


@pytest.mark.parametrize("duration", [0.0, -1.0, np.nan, np.inf])
def test_laws_refuse_durations(duration: float) -> None:
    for make in REST_TO_REST:
        with pytest.raises(InputError, match=f"duration: found {duration:g}; expected a positive"):
            make(0.0, 1.0, duration)
    with pytest.raises(InputError, match=f"duration: found {duration:g}; expected a positive"):
        laws.chirp(0.0, 1.0, 1.0, 2.0, duration)


# ---- motions from laws


def test_a_window_is_a_slice_of_the_samples() -> None:
    drive = from_laws("all", LAWS, 2.5, 97.3)
    assert drive.count == 244
    assert drive.derivatives == "exact"
    assert drive.coordinates == tuple(LAWS)
    everything = drive.samples()

    @PATIENT
    @given(st.integers(0, drive.count), st.integers(0, drive.count))
    def check(start: int, stop: int) -> None:
        part = drive.window(start, stop)
        assert_array_equal(part.time, everything.time[start:stop])
        for got, expected in zip(part.orders, everything.orders, strict=True):
            assert got.flags.c_contiguous
            assert got.shape == (len(LAWS), max(0, stop - start))
            # To rounding: vector and scalar sines may differ in the last digit.
            assert_allclose(got, expected[:, start:stop], rtol=0, atol=4 * EPS * 400)

    check()


def test_ten_million_samples_take_no_memory_until_asked_for() -> None:
    drive = from_laws("long", {"x": laws.sine(0, 1, 1)}, 10_000, 1000)
    assert drive.count == 10_000_001
    last = drive.window(drive.count - 1, drive.count)
    assert_array_equal(last.time, [10_000.0])
    assert last.position.shape == (1, 1)


def test_times_do_not_accumulate_rounding() -> None:
    drive = from_laws("long", {"x": laws.constant(0)}, 1000.0, 1000.0)
    time = drive.window(700_001, 700_002).time
    assert_array_equal(time, [700.001])


@pytest.mark.parametrize(
    ("duration", "rate", "parts"),
    [
        (0.0, 1000.0, ["motion 'm', duration", "found 0", "a positive number"]),
        (np.inf, 1000.0, ["motion 'm', duration", "found inf"]),
        (1.0, -1.0, ["motion 'm', rate", "found -1"]),
        (1.0, np.nan, ["motion 'm', rate", "found nan"]),
        (1e-4, 1000.0, ["found 0.1 steps (0.0001 s at 1000 samples per second)", "at least 1"]),
        (1e7, 1000.0, ["found 1e+10 steps", "fewer than 1e+09"]),
        (1e300, 1e300, ["found inf steps"]),
    ],
)
def test_from_laws_refuses_extents(duration: float, rate: float, parts: list[str]) -> None:
    with pytest.raises(InputError) as error:
        from_laws("m", {"x": laws.constant(0)}, duration, rate)
    for part in parts:
        assert part in refusal(error)


def test_from_laws_refuses_no_laws_and_values_that_are_not_finite() -> None:
    with pytest.raises(InputError, match="motion 'm': found no laws; expected one for every"):
        from_laws("m", {}, 1.0, 10.0)
    drive = from_laws("m", {"x": laws.cosine(0, 1e308, 0.1)}, 1.0, 10.0)
    with pytest.raises(InputError, match=r"velocity of 'x': found nan at t = 0 s \(sample 0\)"):
        drive.samples()


def test_reordered() -> None:
    given = {"a": laws.constant(1), "b": laws.constant(2), "c": laws.constant(3)}
    turned = from_laws("m", given, 1.0, 10.0).reordered(["c", "a", "b"])
    assert turned.coordinates == ("c", "a", "b")
    part = turned.window(2, 5)
    assert_array_equal(part.position, [[3] * 3, [1] * 3, [2] * 3])
    assert all(rows.flags.c_contiguous for rows in part.orders)


@pytest.mark.parametrize(
    ("wanted", "message"),
    [
        (["slide", "turm"], "motion 'm': found no 'turm' ... did you mean 'turn'"),
        (["slide"], "motion 'm': found 'turn', not driven; expected one of: slide"),
        (["slide", "turn", "turn"], "expected one or more, each once"),
    ],
)
def test_reordered_refuses(wanted: list[str], message: str) -> None:
    drive = from_laws("m", {"slide": laws.constant(1), "turn": laws.constant(2)}, 1.0, 10.0)
    with pytest.raises(InputError) as error:
        drive.reordered(wanted)
    assert_says(error, message)


# ---- samples


def wave(t: FloatArray) -> tuple[FloatArray, ...]:
    """Two coordinates: amplitude 1 m at 1 Hz, and 0.5 rad at 0.3 Hz; (2, n) each."""
    one, other = laws.sine(0.2, 1.0, 1.0, 0.3)(t), laws.sine(-0.1, 0.5, 0.3)(t)
    return tuple(np.stack(pair) for pair in zip(one, other, strict=True))


def uneven(n: int, seed: int = 1) -> FloatArray:
    """Steps that vary sevenfold about the mean, over 3 s."""
    steps = np.random.default_rng(seed).uniform(0.25, 1.75, n - 1)
    return np.append(0.0, np.cumsum(steps)) * 3 / float(steps.sum())


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


@pytest.mark.parametrize("origin", [0.0, 1.7e9])
def test_the_splines_derivatives_of_uneven_samples(origin: float) -> None:
    """Errors of h⁵x⁽⁶⁾ and h⁴x⁽⁶⁾ times constants below 1, here with h = 10 ms and 2π rad/s."""
    t = uneven(600)
    stamps = origin + t  # seconds since 1970 are rounded to 0.24 µs
    seen = stamps - origin
    drive = from_arrays("m", ["x", "y"], stamps, wave(seen)[0])
    assert drive.derivatives == "quintic spline"
    time, position, velocity, acceleration, jerk = drive.samples()
    _, v, a, j = wave(seen)
    assert_array_equal(time, stamps)
    assert_array_equal(position, wave(seen)[0])
    h, sixth = np.diff(seen).max(), (2 * np.pi) ** 6
    assert_allclose(velocity, v, rtol=0, atol=h**5 * sixth)
    assert_allclose(acceleration, a, rtol=0, atol=h**4 * sixth)
    assert jerk is not None
    assert_allclose(jerk, j, rtol=0, atol=h**3 * sixth)


@PATIENT
@given(
    st.lists(st.floats(-3, 3), min_size=6, max_size=6),
    st.lists(st.floats(0.2, 1), min_size=8, max_size=20),
)
def test_the_spline_reproduces_quintics(coefficients: list[float], steps: list[float]) -> None:
    t = np.cumsum(steps) / len(steps)
    p = np.polynomial.Polynomial(coefficients)
    _, position, velocity, acceleration, _ = from_arrays("m", ["x"], t, [p(t)]).samples()
    assert_array_equal(position[0], p(t))
    # Rounding, amplified by 1/h and 1/h² with h down to 0.01 s and by the splines' uneven knots.
    assert_allclose(velocity[0], p.deriv()(t), atol=1e-9, rtol=0)
    assert_allclose(acceleration[0], p.deriv(2)(t), atol=1e-7, rtol=0)


@pytest.mark.parametrize("n", [301, 3001, 30_001])
def test_smoothing_recovers_the_derivatives(n: int) -> None:
    """The spline is taken once its residual is the noise's but for 3√(2/n), one more of which may
    be luck; so it misses by b = σ√(6√(2/n) + c/n), c = 13 coefficients at least. What it misses
    swings within intervals of h = 3/8 s: a derivative brings a factor of order 10/h.
    """
    sigma, h = 1e-3, 3 / 8
    t = uneven(n, seed=2)
    p, v, a, _ = wave(t)
    noisy = p + sigma * np.random.default_rng(3).standard_normal(p.shape)
    drive = from_arrays("m", ["x", "y"], t, noisy, smoothing={"x": sigma, "y": sigma})
    assert drive.derivatives == "smoothed quintic spline (noise x 0.001, y 0.001)"
    _, position, velocity, acceleration, _ = drive.samples()
    b = sigma * np.sqrt(6 * np.sqrt(2 / n) + 13 / n)
    assert np.sqrt(np.mean((position - p) ** 2)) < b
    assert np.sqrt(np.mean((velocity - v) ** 2)) < 10 * b / h
    assert np.sqrt(np.mean((acceleration - a) ** 2)) < 100 * b / h**2
    # The spline through all samples is useless: its accelerations are wrong by about σ (n/3)².
    raw = from_arrays("m", ["x", "y"], t, noisy).samples()
    assert np.sqrt(np.mean((raw.acceleration - a) ** 2)) > sigma * (n / 3) ** 2
    assert 100 * b / h**2 < 0.03 * np.abs(a).max()


def test_smoothing_of_one_coordinate_leaves_the_other() -> None:
    t = uneven(300)
    p = wave(t)[0]
    noisy = p + 1e-3 * np.random.default_rng(5).standard_normal(p.shape)
    samples = from_arrays("m", ["x", "y"], t, noisy, smoothing={"y": 1e-3}).samples()
    assert_array_equal(samples.position[0], noisy[0])
    assert np.abs(samples.position[1] - noisy[1]).max() > 1e-3


def test_smoothing_says_when_the_noise_is_larger_than_said() -> None:
    t = uneven(3000)
    noisy = wave(t)[0] + 1e-3 * np.random.default_rng(6).standard_normal((2, 3000))
    with pytest.raises(InputError) as error:
        from_arrays("m", ["x", "y"], t, noisy, smoothing=5e-4)
    assert "motion 'm', 'x': found smoothing 0.0005 where the noise is about 0.00" in refusal(error)
    assert "the noise's standard deviation, or more samples" in refusal(error)


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


# ---- velocities and accelerations that contradict


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


# ---- tables

PLATFORM = {"platform.x": LENGTH, "platform.y": LENGTH, "platform.phi": ANGLE}
HOME = {"platform.x": 1.8, "platform.y": 1.1, "platform.phi": 0.1}


def read(
    text: str, rate: float | None = None, parameters: Mapping[str, Any] | None = None
) -> Motion:
    table = tomllib.loads(text)["motions"]["general"]
    known = Parameters({"x_star": "50 mm", "phi_star": "20 deg", **(parameters or {})})
    return motion_from_table(table, "general", known, HOME, PLATFORM, "motions.general", rate)


def one(law: str, coordinate: str = "platform.x") -> FloatArray:
    """(3, n) of a motion of 2 s with one law."""
    drive = read(
        f'[motions.general]\nduration = "2 s"\nrate = 100\n'
        f"[motions.general.laws]\n{coordinate} = {law}\n"
    )
    row = drive.coordinates.index(coordinate)
    return np.stack([rows[row] for rows in drive.samples().orders])


def test_a_whole_table() -> None:
    drive = read(
        """
        [motions.general]
        title = "General evolution"
        duration = "3 s"
        [motions.general.laws]
        platform.x = { law = "cosine", by = "2*x_star" }
        "platform.phi" = { law = "sines", terms = [
            { amplitude = "2 deg", frequency = "0.5 Hz", phase = "90 deg" },
            { amplitude = 0.01, frequency = 3 } ] }
        """
    )
    assert drive.name == "general"
    assert drive.coordinates == ("platform.x", "platform.y", "platform.phi")
    assert drive.count == 3001
    assert drive.derivatives == "exact"
    samples = drive.samples()
    t = samples.time
    terms = [(np.radians(2), 0.5, np.pi / 2), (0.01, 3.0, 0.0)]
    given = [laws.cosine(1.8, 0.1, 3.0), laws.constant(1.1), laws.sines(0.1, terms)]
    for row, law in enumerate(given):
        for got, expected in zip(samples.orders, law(t), strict=True):
            assert_allclose(got[row], expected, atol=1e-13)


def test_rate_may_be_said_and_replaced() -> None:
    text = '[motions.general]\nduration = 3\nrate = "2 kHz"\n'
    assert read(text).count == 6001
    assert read(text, rate=10.0).count == 31
    assert read("[motions.general]\nduration = 3\n").count == 3001


T = np.arange(201) / 100


@pytest.mark.parametrize(
    ("law", "expected"),
    [
        ('{ law = "constant", value = "2 m" }', laws.constant(2.0)),
        ('{ law = "cosine", to = "2 m" }', laws.cosine(1.8, 0.2, 2.0)),
        ('{ law = "cosine", from = 1, to = 2, begin = 0.5 }', laws.cosine(1, 1, 1.5, 0.5)),
        (
            '{ law = "poly345", by = "x_star", begin = "500 ms", duration = "1 s" }',
            laws.polynomial345(1.8, 0.05, 1.0, 0.5),
        ),
        ('{ law = "poly4567", by = -0.1 }', laws.polynomial4567(1.8, -0.1, 2.0)),
        (
            '{ law = "sine", amplitude = "10 mm", frequency = "2 Hz" }',
            laws.sine(1.8, 0.01, 2.0),
        ),
        (
            '{ law = "sine", center = 0, amplitude = 1, frequency = 1, phase = "90 deg" }',
            laws.sine(0.0, 1.0, 1.0, np.pi / 2),
        ),
        (
            '{ law = "chirp", amplitude = 0.1, from_frequency = 0, to_frequency = "5 Hz" }',
            laws.chirp(1.8, 0.1, 0.0, 5.0, 2.0),
        ),
        (
            '{ law = "waypoints", times = [0, "500 ms", 2], values = ["1800 mm", 2, "x_star"] }',
            laws.waypoints([0, 0.5, 2], [1.8, 2.0, 0.05]),
        ),
    ],
)
def test_each_law_of_a_table(law: str, expected: Law) -> None:
    assert_allclose(one(law), np.stack(expected(T)), atol=1e-12)


HEAD = '[motions.general]\nduration = "2 s"\n'
LAW = HEAD + "[motions.general.laws]\nplatform.x = "
BAD_TABLES = [
    ("[motions.general]\n", "motions.general: found no key 'duration'"),
    (HEAD + "law = 1", "motions.general: found unknown key 'law' ... did you mean 'laws'?"),
    (HEAD + "laws = 3", "motions.general.laws: found 3; expected a table"),
    (HEAD + "title = 3", "motions.general.title: found 3; expected text"),
    (
        "[motions.general]\nduration = true",
        "motions.general.duration: found True; expected a number",
    ),
    (
        '[motions.general]\nduration = "3 m"',
        "motions.general.duration: found '3 m', a length; expected a time",
    ),
    (
        '[motions.general]\nduration = "-3 s"',
        "motions.general.duration: found -3; expected a positive number",
    ),
    (
        "[motions.general]\nduration = inf",
        "motions.general.duration: found inf ... a finite number",
    ),
    (HEAD + "rate = 0", "motions.general.rate: found 0; expected a positive number"),
    (HEAD + 'rate = "1 rpm"', "motions.general.rate: found '1 rpm'"),
    (HEAD + "rate = 1e9", "motion 'general': found 2e+09 steps"),
    (
        HEAD + "laws.platform.z = { law = 'constant', value = 1 }",
        "motions.general.laws: found 'platform.z', not driven ... did you mean 'platform.",
    ),
    (LAW + "3", "motions.general.laws.platform: found no key 'law'; expected the key law"),
    (LAW + "{ by = 3 }", "motions.general.laws.platform.x: found no key 'law'; expected the key"),
    (LAW + "{}", "motions.general.laws.platform.x: found no key 'law'"),
    (
        LAW + '{ law = "cosin", by = 3 }',
        "general.laws.platform.x.law: found 'cosin' ... poly4567 ... did you mean 'cosine'?",
    ),
    (LAW + "{ law = 3 }", "motions.general.laws.platform.x.law: found 3; expected one of: "),
    (
        LAW + '{ law = "cosine", bye = 3 }',
        "laws.platform.x: found unknown key 'bye' ... duration, from, law, to ... mean 'by'",
    ),
    (
        LAW + '{ law = "sine", amplitud = 1, frequency = 1 }',
        "laws.platform.x: found unknown key 'amplitud' ... did you mean 'amplitude'",
    ),
    (
        LAW + '{ law = "sine", amplitude = 1 }',
        "motions.general.laws.platform.x: found no key 'frequency'",
    ),
    (
        LAW + '{ law = "cosine", by = [3] }',
        "motions.general.laws.platform.x.by: found [3]; expected a number",
    ),
    (
        LAW + '{ law = "cosine", by = "2*y_star" }',
        "motions.general.laws.platform.x.by: found '2*y_star': unknown parameter 'y_star'",
    ),
    (
        LAW + '{ law = "cosine", by = "phi_star" }',
        "motions.general.laws.platform.x.by: found 'phi_star', an angle; expected a length",
    ),
    (LAW + '{ law = "cosine" }', "platform.x.by and to: found neither; expected one of them"),
    (LAW + '{ law = "cosine", by = 1, to = 1 }', "platform.x.by and to: found both; expected one"),
    (
        LAW + '{ law = "cosine", by = 1, begin = 1, duration = 1.5 }',
        "platform.x.begin: found a law from 1 s to 2.5 s; expected one within the motion, 0 s to 2",
    ),
    (LAW + '{ law = "cosine", by = 1, begin = -1 }', "found a law from -1 s to 2 s"),
    (LAW + '{ law = "cosine", by = 1, begin = 5 }', "found a law from 5 s to 2 s"),
    (
        LAW + '{ law = "cosine", by = 1, duration = 0 }',
        "motions.general.laws.platform.x.duration: found 0; expected a positive number",
    ),
    (
        LAW + '{ law = "sines", terms = [] }',
        "motions.general.laws.platform.x.terms: found []; expected List should have at least 1",
    ),
    (
        LAW + '{ law = "sines", terms = [{ amplitude = 1, frequency = 1 }, { frequency = 1 }] }',
        "motions.general.laws.platform.x.terms[1]: found no key 'amplitude'",
    ),
    (
        LAW + '{ law = "sines", terms = [{ amplitude = 1, frequency = "1 s" }] }',
        "motions.general.laws.platform.x.terms[0].frequency: found '1 s', a time; expected a freq",
    ),
    (
        LAW + '{ law = "waypoints", times = [0, "1 m"], values = [0, 1] }',
        "motions.general.laws.platform.x.times[1]: found '1 m', a length; expected a time",
    ),
    (
        LAW + '{ law = "waypoints", times = [0, 3], values = [0, 1] }',
        "motions.general.laws.platform.x.times: found a law from 0 s to 3 s; expected one within",
    ),
    (
        LAW + '{ law = "waypoints", times = [], values = [] }',
        "motions.general.laws.platform.x.times: found []; expected two or more, increasing",
    ),
    (
        LAW + '{ law = "waypoints", times = [0, 1], values = [0, 1, 2] }',
        "motions.general.laws.platform.x.values: found an array of shape (3,); expected (2,)",
    ),
    (
        LAW + '{ law = "constant", value = 1 }\n"platform.x" = { law = "constant", value = 2 }',
        "motions.general.laws.platform.x: found two laws; expected one",
    ),
]


@pytest.mark.parametrize(("text", "message"), BAD_TABLES)
def test_tables_are_refused(text: str, message: str) -> None:
    with pytest.raises(InputError) as error:
        read(text)
    assert_says(error, message)


@PATIENT
@given(
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
        lambda inner: (
            st.lists(inner, max_size=3)
            | st.dictionaries(
                st.sampled_from(
                    ["law", "by", "to", "from", "terms", "amplitude", "times", "values", "duration"]
                ),
                inner,
                max_size=4,
            )
        ),
        max_leaves=10,
    ),
    st.sampled_from(["constant", "cosine", "sine", "sines", "chirp", "waypoints", "x"]),
)
def test_any_table_is_a_motion_or_an_input_error(law: Any, kind: str) -> None:
    table: dict[str, Any] = {"duration": 1, "rate": 10, "laws": {"platform": {"x": law}}}
    if isinstance(law, dict):
        law["law"] = kind
    try:
        drive = motion_from_table(table, "m", Parameters({}), HOME, PLATFORM, "motions.m")
        assert np.isfinite(drive.samples().acceleration).all()
    except InputError as error:
        assert error.place.startswith("motion")


def test_flatten_keeps_law_tables_whole() -> None:
    table = {"platform": {"x": {"law": "a"}, "y": {"z": {"law": "b"}}}, "A2": {"law": "c"}, "B": 3}
    flat = {"platform.x": {"law": "a"}, "platform.y.z": {"law": "b"}, "A2": {"law": "c"}, "B": 3}
    assert laws_by_coordinate(table, "laws") == flat


# ---- the converter of pydantic's findings


class Plain(BaseModel):
    """A model that is no Table."""

    model_config = ConfigDict(extra="forbid", strict=True)
    size: int | str = 1
    items: list[int] = []

    @field_validator("size")
    @classmethod
    def _even(cls, size: int | str) -> int | str:
        if isinstance(size, int) and size % 2:
            raise ValueError("an even number")
        return size


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({"size": 3}, "here.size: found 3; expected an even number"),
        ({"size": 0.5}, "here.size: found 0.5; expected a whole number"),
        ({"items": [1, "b"]}, "here.items[1]: found 'b'; expected a whole number"),
        ({"items": 3}, "here.items: found 3; expected a list"),
        ({"items": ["x" * 200]}, "..."),
        (7, "here: found 7; expected a table"),
    ],
)
def test_findings_of_any_model(data: Any, message: str) -> None:
    with pytest.raises(InputError) as error:
        validated(Plain, data, "here")
    assert message in refusal(error)
    assert len(refusal(error)) < 150


def test_findings_without_the_data() -> None:
    with pytest.raises(ValidationError) as error:
        Plain.model_validate({"size": 0.5})
    assert str(input_error(error.value, "here")).startswith("here.size: found 0.5; expected a ")
