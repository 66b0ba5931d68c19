"""Forks: none while machine code is compiled, or runs on all cores; one core in the child.

Both take locks, and leave a pool of threads that take some whenever they fall asleep. A forked
child has no such threads, and would find their locks taken for ever.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class _Gate:
    """How many are at work, how many wait to fork, and whether any has ever worked."""

    def __init__(self) -> None:
        self.changed = threading.Condition()
        self.at_work = self.forks = 0
        self.used = False


_gate = _Gate()


@contextmanager
def no_fork() -> Iterator[None]:
    """Forks wait for what is done within, and it for those that wait already. Not to be nested."""
    with _gate.changed:
        while _gate.forks:
            _gate.changed.wait()
        _gate.at_work += 1
        _gate.used = True
    try:
        yield
    finally:
        with _gate.changed:
            _gate.at_work -= 1
            _gate.changed.notify_all()


def _before() -> None:
    _gate.changed.acquire()
    _gate.forks += 1
    while _gate.at_work:
        _gate.changed.wait()


def _in_parent() -> None:
    _gate.forks -= 1
    _gate.changed.notify_all()
    _gate.changed.release()


def _in_child() -> None:
    used = _gate.used
    _gate.__init__()  # type: ignore[misc]
    if used:
        for act in _in_children:
            act()


def in_children(act: Callable[[], None]) -> None:
    """Have something done in forked children of a process that has worked."""
    _in_children.add(act)


_in_children: set[Callable[[], None]] = set()
if hasattr(os, "register_at_fork"):  # elsewhere there are no forks
    os.register_at_fork(before=_before, after_in_parent=_in_parent, after_in_child=_in_child)
