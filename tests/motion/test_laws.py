"""Laws of time, their exact derivatives, and motions made from them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import mp
from numpy.testing import assert_allclose, assert_array_equal

from parakin.errors import InputError
from parakin.motion import laws
from parakin.motion.laws import Law, from_laws

PATIENT = settings(deadline=None)  # the first spline imports scipy

EPS = float(np.finfo(float).eps)


def refusal(error: pytest.ExceptionInfo[InputError]) -> str:
    return str(error.value)


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
