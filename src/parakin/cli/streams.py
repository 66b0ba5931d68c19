"""Standard output and standard error."""

from __future__ import annotations

import io
import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING

from parakin.errors import InputError, reason

if TYPE_CHECKING:
    from rich.console import Console, RenderableType

_LONG = 2.0  # [s]: a wait to be told of
WIDE = 1000  # columns; rows of numbers are never folded


@contextmanager
def flushed_stdout() -> Iterator[None]:
    """Flush stdout at the end. Raises InputError if it cannot be written to."""
    try:
        try:
            yield
        finally:
            if sys.stdout is not None:
                sys.stdout.flush()
    except OSError as error:
        with open(os.devnull, "w") as nothing:  # for Python's own flush at exit
            os.dup2(nothing.fileno(), sys.stdout.fileno())
        if isinstance(error, BrokenPipeError):
            raise
        raise InputError(
            "standard output", reason(error), "a stream that accepts all output"
        ) from None


def hold_closed() -> None:
    """Open what is closed of the three standard streams to nothing: files opened later would take
    their numbers, and get what libraries print.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free


def console(*, stderr: bool = False, width: int | None = None) -> Console:
    """A console that obeys NO_COLOR, `width` columns wide, by default as the terminal."""
    from rich.console import Console

    if not stderr and isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # as stderr does, if ü cannot be encoded
    colours = None if os.environ.get("NO_COLOR") else "auto"
    return Console(
        stderr=stderr,
        width=width,
        color_system=colours,  # type: ignore[arg-type]
        soft_wrap=True,
        highlight=False,
    )


@contextmanager
def waiting(what: str) -> Iterator[None]:
    """Tell on stderr what is waited for, if that takes long; only on a terminal."""
    shown = console(stderr=True)
    if not shown.is_terminal:
        yield
        return
    status = shown.status(what)
    timer = threading.Timer(_LONG, status.start)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
        timer.join()  # or it might still start after the next line
        status.stop()


def say(what: RenderableType) -> None:
    """Print on stdout, strings without markup. Raises InputError if it cannot be written to."""
    from rich.text import Text

    with flushed_stdout():
        console(width=WIDE).print(Text(what) if isinstance(what, str) else what)


def tell(*what: RenderableType, style: str = "") -> None:
    """Print on stderr, strings without markup. If it takes no more, that changes no exit code."""
    from rich.text import Text

    try:
        for each in what:
            shown = Text(each, style) if isinstance(each, str) else each
            console(stderr=True, width=WIDE).print(shown)
        if sys.stderr is not None:
            sys.stderr.flush()
    except OSError:
        with suppress(OSError, ValueError), open(os.devnull, "w") as nothing:
            os.dup2(nothing.fileno(), sys.stderr.fileno())  # for Python's own flush at exit
