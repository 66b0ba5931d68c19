"""A motion with its coordinates in another order, and sent elsewhere."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import parakin
from parakin.errors import InputError
from parakin.motion import laws
from parakin.motion.laws import from_laws
from parakin.motion.motion import Motion
from parakin.motion.sampled import from_arrays


def refusal(error: pytest.ExceptionInfo[InputError]) -> str:
    return str(error.value)


def assert_says(error: pytest.ExceptionInfo[InputError], message: str) -> None:
    """Each of the parts of `message`, which three dots separate."""
    for part in message.split(" ... "):
        assert part in refusal(error)


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


TIME = np.linspace(0.0, 2.0, 50)
EVERY_LAW = {
    "a": laws.constant(0.3),
    "b": laws.cosine(0.1, 0.2, 1.5, 0.25),
    "c": laws.polynomial345(0.1, 0.2, 1.5, 0.25),
    "d": laws.polynomial4567(0.1, 0.2, 1.5, 0.25),
    "e": laws.sine(0.0, 0.1, 2.0, 0.3),
    "f": laws.sines(0.1, [(0.1, 2.0, 0.3), (0.2, 1.0, 0.0)]),
    "g": laws.chirp(0.1, 0.2, 1.0, 3.0, 2.0, 0.1),
    "h": laws.waypoints([0.0, 0.5, 2.0], [0.1, 0.3, 0.2]),
}
MOTIONS = [
    from_laws("laws", EVERY_LAW, 2.0, 100.0),
    from_laws("laws", EVERY_LAW, 2.0, 100.0).reordered("hgfedcba"),
    from_arrays("plain", "ab", TIME, [np.sin(TIME), np.cos(TIME)]),
    from_arrays("smooth", ["a"], TIME, [np.sin(TIME)], smoothing=1e-3).reordered(["a"]),
]


@pytest.mark.parametrize("way", [copy.copy, copy.deepcopy, lambda m: pickle.loads(pickle.dumps(m))])
@pytest.mark.parametrize("motion", MOTIONS, ids=lambda motion: motion.name)
def test_a_motion_is_the_same_once_pickled_or_copied(
    motion: Motion, way: Callable[[Motion], Motion]
) -> None:
    other = way(motion)
    for name in ("name", "coordinates", "count", "derivatives", "knots", "period"):
        assert getattr(other, name) == getattr(motion, name)
    for here, there in zip(motion.samples(), other.samples(), strict=True):
        assert_array_equal(here, there)
    assert (motion.between is None) == (other.between is None)
    if motion.between is not None and other.between is not None:
        at = np.array([0.01, 0.77, 1.99])
        for here, there in zip(motion.between(at), other.between(at), strict=True):
            assert_array_equal(here, there)


@pytest.mark.parametrize("name", ["vertical", "rectilinear", "general"])
def test_the_motion_of_a_file_can_be_pickled(name: str, solver: parakin.Solver) -> None:
    motion = solver.motion(name)
    other = pickle.loads(pickle.dumps(motion))
    assert_array_equal(motion.samples().position, other.samples().position)
