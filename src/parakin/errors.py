"""Errors. The message of bad input names the place, what was found and what was expected."""

from __future__ import annotations

import copyreg
import errno
import os
from collections.abc import Iterable
from typing import Any

_NAMES = 40  # listed in a message
_LENGTH = 1000  # of each part of a message


class ParakinError(Exception):
    """Anything that parakin refuses or cannot do; the command line prints it and exits with 2.

    It survives pickling and copying: an error that cannot be unpickled hangs a pool of processes.
    """

    def __reduce__(self) -> tuple[Any, ...]:
        # Built without __init__, whatever arguments that of a subclass takes. A cause goes along
        # if it is one of ours: others may be impossible to unpickle.
        kept = {**self.__dict__, "__suppress_context__": self.__suppress_context__}
        if isinstance(self.__cause__, ParakinError):
            kept["__cause__"] = self.__cause__
        return copyreg.__newobj__, (type(self), *self.args), kept  # type: ignore[attr-defined]


class InputError(ParakinError):
    """Invalid input: a file, a name, a value, an expression."""

    def __init__(self, place: str, found: str, expected: str) -> None:
        self.place = _line(place)
        self.found = _line(found)
        self.expected = _line(expected)
        super().__init__(f"{self.place}: found {self.found}; expected {self.expected}")

    def within(self, outer: str) -> InputError:
        """The error with its place prefixed by what encloses it (a file, a table)."""
        return InputError(f"{outer}: {self.place}", self.found, self.expected)


class AssemblyError(ParakinError):
    """The loops of the mechanism cannot be closed from its guess."""


class DrivenError(ParakinError):
    """The chosen driven coordinates do not determine the motion."""


class NotSolvedError(ParakinError):
    """Some samples of a motion were flagged, and the caller asked for all or nothing."""


def nearest(name: str, known: Iterable[str]) -> str:
    """The names that exist, and the one that `name` may have meant, to end a message."""
    import difflib  # here, as it takes long to import

    names = sorted(known)
    if not names:
        return "no name, as none are defined"
    folded = {other.casefold(): other for other in names}
    close = difflib.get_close_matches(name[:100].casefold(), folded, n=1, cutoff=0.5)
    hint = f"; did you mean {folded[close[0]]!r}?" if close else ""
    return f"one of: {', '.join(names[:_NAMES])}{', ...' if len(names) > _NAMES else ''}{hint}"


def not_installed(place: str, library: str, extra: str = "exchange") -> InputError:
    """A library is missing; `extra` is the extra of parakin that installs it."""
    return InputError(place, f"{library} is not installed", f"pip install 'parakin[{extra}]'")


def reason(error: Exception) -> str:
    """The system's message in lower case, without its number; the message of other errors."""
    if not isinstance(error, OSError):
        return str(error)
    if error.errno is not None and error.errno in errno.errorcode:
        # Libraries add to `strerror`.
        return os.strerror(error.errno).lower()
    return (error.strerror or str(error)).lower()


def printable(text: str) -> str:
    """`text` on one line that can be encoded, whatever it quotes: names of files are not always
    UTF-8.
    """
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)


def _line(text: str) -> str:
    """`text` on one line of bounded length."""
    text = printable(text[:_LENGTH])
    return text if len(text) < _LENGTH else f"{text[: _LENGTH - 3]}..."
