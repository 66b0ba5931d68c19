"""Messages: their form, the nearest name, what the system says, and bounded length."""

from __future__ import annotations

import copy
import errno
import pickle
from collections.abc import Callable

import pytest

import parakin
from parakin.errors import InputError, ParakinError, nearest, not_installed, reason


def test_a_message_has_place_found_and_expected() -> None:
    error = InputError("file.toml: name", "3", "text")
    assert str(error) == "file.toml: name: found 3; expected text"
    assert (error.place, error.found, error.expected) == ("file.toml: name", "3", "text")
    assert isinstance(error, ParakinError)


def test_an_error_within_a_file_names_it() -> None:
    assert InputError("name", "3", "text").within("a.csv").place == "a.csv: name"


def test_whatever_a_message_quotes_it_stays_one_line_of_bounded_length() -> None:
    error = InputError("a\nb", "\x1b[31m" + "x" * 5000, "é")
    assert error.place == r"a\nb"
    assert error.found.startswith(r"\x1b[31mxxx")
    assert error.found.endswith("...")
    assert len(error.found) == 1000
    assert error.expected == "é"


@pytest.mark.parametrize(
    ("name", "known", "text"),
    [
        ("lenght", ["width", "length"], "one of: length, width; did you mean 'length'?"),
        ("LENGTH", ["width", "length"], "one of: length, width; did you mean 'length'?"),
        ("q", ["width", "length"], "one of: length, width"),
        ("q", [], "no name, as none are defined"),
    ],
)
def test_the_nearest_name(name: str, known: list[str], text: str) -> None:
    assert nearest(name, known) == text


def test_no_more_than_forty_names_are_listed() -> None:
    text = nearest("q", (f"name{k:02d}" for k in range(50)))
    assert text.startswith("one of: name00, name01, ")
    assert text.endswith("name39, ...")


def test_the_reason_is_the_systems_without_its_number() -> None:
    missing = OSError(errno.ENOENT, "No such file or directory", "x.toml")
    assert reason(missing) == "no such file or directory"
    assert reason(OSError(errno.ENOSPC, "[Errno 28] by a library")) == "no space left on device"
    assert reason(OSError("Unable to Open")) == "unable to open"
    assert reason(ValueError("Embedded")) == "Embedded"


def test_a_missing_library_comes_with_how_to_install_it() -> None:
    error = not_installed("x.xml", "mujoco")
    assert str(error) == (
        "x.xml: found mujoco is not installed; expected pip install 'parakin[exchange]'"
    )


class _StrangeError(InputError):
    """A subclass whose arguments are its own."""

    def __init__(self, number: int, *, unit: str) -> None:
        self.number = number
        super().__init__("number", f"{number} {unit}", "another")


def _each() -> list[ParakinError]:
    known = [kind("what happened") for kind in _kinds(ParakinError) if kind.__init__ is _plain]
    return [*known, InputError("a", "b\n" * 999, "c").within("d"), _StrangeError(3, unit="mm")]


_plain = ParakinError.__init__


def _kinds(kind: type[ParakinError]) -> list[type[ParakinError]]:
    return [kind, *(k for below in kind.__subclasses__() for k in _kinds(below))]


WAYS = [copy.copy, copy.deepcopy] + [
    (lambda error, n=n: pickle.loads(pickle.dumps(error, n)))
    for n in range(pickle.HIGHEST_PROTOCOL + 1)
]


@pytest.mark.parametrize("way", WAYS)
def test_every_error_survives_pickling_and_copying(way: Callable[[Exception], Exception]) -> None:
    errors = _each()
    assert {type(error) for error in errors} == set(_kinds(ParakinError))
    for error in errors:
        error.add_note("a note")
        error.__dict__["more"] = [1, 2]
        other = way(error)
        assert type(other) is type(error)
        assert (str(other), other.args, other.__dict__) == (str(error), error.args, error.__dict__)
        again = way(other)
        assert (str(again), again.__dict__) == (str(error), error.__dict__)


def test_what_an_error_follows_from_goes_along_unless_it_could_hang_the_receiver() -> None:
    class UnsendableError(Exception):
        def __reduce__(self) -> str:
            raise TypeError("cannot be pickled")

    for cause in (parakin.AssemblyError("open"), UnsendableError(), None):
        try:
            raise InputError("a", "b", "c") from cause
        except InputError as error:
            other = pickle.loads(pickle.dumps(error))
        assert other.__suppress_context__
        kept = cause if isinstance(cause, ParakinError) else None
        assert repr(other.__cause__) == repr(kept)
