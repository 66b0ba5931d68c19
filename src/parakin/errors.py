"""One error tree. Every message names the place, what was found and what was expected."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class ParakinError(Exception):
    """Anything parakin refuses or cannot do; the command line prints it and exits with 2."""


class InputError(ParakinError):
    """Input that does not mean anything: a file, a name, a value, an expression."""

    def __init__(self, place: str, found: str, expected: str) -> None:
        self.place = place
        self.found = found
        self.expected = expected
        super().__init__(f"{place}: found {found}; expected {expected}")

    def within(self, outer: str) -> InputError:
        """The same error, its place prefixed by what encloses it (a file, a table)."""
        return InputError(f"{outer}: {self.place}", self.found, self.expected)


class AssemblyError(ParakinError):
    """The mechanism cannot be closed from its guess."""


class DrivenError(ParakinError):
    """The chosen driven coordinates do not determine the motion."""


class NotSolvedError(ParakinError):
    """Some samples of a motion were flagged and the caller asked for all or nothing."""


def nearest(name: str, known: Iterable[str]) -> str:
    """What exists, the nearest to `name` first, as the tail of a message."""
    names = sorted(known)
    close = difflib.get_close_matches(name, names, n=1, cutoff=0.5)
    hint = f"did you mean {close[0]!r}? " if close else ""
    shown = ", ".join(names[:30]) + (", ..." if len(names) > 30 else "")
    return f"{hint}one of: {shown}" if names else "none: there are none"
