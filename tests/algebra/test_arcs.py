"""The angle of a point against the library's in extended precision, over its whole domain."""

from __future__ import annotations

import math

import numpy as np
import pytest

from parakin.algebra.arcs import atan2
from parakin.algebra.spatial import ARRAYS, FLOATS

ULPS = 2.5
DRAW = np.random.default_rng(11)
N = 100_000
EIGHTHS = DRAW.integers(-8, 9, N) * math.pi / 8.0 + DRAW.normal(size=N) * 10.0 ** DRAW.uniform(
    -17.0, -1.0, N
)
POINTS = {
    "near one": DRAW.normal(size=(2, N)),
    "of all sizes": DRAW.normal(size=(2, N)) * 10.0 ** DRAW.uniform(-300.0, 306.0, (2, N)),
    "where pieces meet": np.array([np.sin(EIGHTHS), np.cos(EIGHTHS)]),
    "whole numbers, zeros too": DRAW.integers(-40, 41, (2, N)).astype(float),
    "far apart": np.array([DRAW.normal(size=N), DRAW.normal(size=N) * 1e-200]),
}


def plain(y: np.ndarray, x: np.ndarray) -> np.ndarray:
    """With NumPy's own selection."""
    with np.errstate(all="ignore"):
        return np.asarray(atan2(y, x, np.where, np.less))


def compiled(y: np.ndarray, x: np.ndarray) -> np.ndarray:
    """As the kernel's machine code has it."""
    pytest.importorskip("heyoka")
    from parakin.kernel.backends import compiled as made

    kernel = made(lambda taken, functions: [functions.atan2(*taken)], 2, machine_code=True)
    out = np.empty((1, len(y)))
    kernel(np.array([y, x]), out, False)
    return np.asarray(out[0])


@pytest.mark.parametrize("way", [plain, compiled])
@pytest.mark.parametrize("name", POINTS)
def test_angles_are_exact_to_two_and_a_half_units_in_the_last_place(way, name: str) -> None:  # type: ignore[no-untyped-def]
    y, x = POINTS[name]
    exact = np.arctan2(y.astype(np.longdouble) + 0, x.astype(np.longdouble) + 0)
    unit = np.spacing(np.abs(exact.astype(float)))
    assert (np.abs(way(y, x) - exact) <= ULPS * unit).all()


@pytest.mark.parametrize("way", [plain, compiled])
def test_zeros_have_no_sign(way) -> None:  # type: ignore[no-untyped-def]
    zeros = np.array([0.0, -0.0])
    assert way(zeros, np.array([-1.0, -1.0])).tolist() == [math.pi, math.pi]
    for other in (1.0, 0.0, -0.0):
        found = way(zeros, np.array([other, other]))
        assert found.tolist() == [0.0, 0.0]
    assert way(np.array([2.0, -2.0]), zeros).tolist() == [math.pi / 2.0, -math.pi / 2.0]
    assert ARRAYS.atan2(zeros, -np.ones(2)).tolist() == [math.pi, math.pi]
    assert FLOATS.atan2(-0.0, -1.0) == FLOATS.atan2(0.0, -1.0) == math.pi
    assert FLOATS.atan2(-0.0, -0.0) == 0.0


@pytest.mark.parametrize("way", [plain, compiled])
def test_infinities_and_nan(way) -> None:  # type: ignore[no-untyped-def]
    inf, nan = math.inf, math.nan
    y = np.array([inf, -inf, 1.0, 1.0, -1.0])
    x = np.array([1.0, 1.0, inf, -inf, -inf])
    expected = [math.pi / 2.0, -math.pi / 2.0, 0.0, math.pi, -math.pi]
    assert way(y, x).tolist() == expected
    unknown = way(np.array([nan, 1.0, nan, inf, -inf]), np.array([1.0, nan, nan, inf, -inf]))
    assert np.isnan(unknown).all()


@pytest.mark.parametrize("way", [plain, compiled])
def test_the_smallest_numbers_are_told_apart(way) -> None:  # type: ignore[no-untyped-def]
    least = 5e-324
    y = np.array([least, least, 3.0 * least, 1e-308])
    x = np.array([least, 0.0, -least, 2e-308])
    found = way(y, x)
    assert found == pytest.approx(np.arctan2(y, x), abs=0.4)
    assert found[3] == pytest.approx(math.atan2(1.0, 2.0), rel=1e-15)
