"""A motion with its coordinates in another order."""

from __future__ import annotations

import pytest
from numpy.testing import assert_array_equal

from parakin.errors import InputError
from parakin.motion import laws
from parakin.motion.laws import from_laws


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
