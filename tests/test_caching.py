"""Properties worked out once, and without a lock."""

from __future__ import annotations

import threading

from parakin.caching import cached_property


class Thing:
    def __init__(self) -> None:
        self.worked_out = 0
        self.reached, self.go_on = threading.Event(), threading.Event()

    @cached_property
    def plain(self) -> int:
        """What it is."""
        self.worked_out += 1
        return self.worked_out

    @cached_property
    def slow(self) -> str:
        self.reached.set()
        self.go_on.wait()
        return "worked out"


def test_it_is_worked_out_once_for_each_object() -> None:
    one, other = Thing(), Thing()
    assert [one.plain, one.plain, other.plain] == [1, 1, 1]
    assert Thing.plain.__doc__ == "What it is."


def test_no_lock_is_held_meanwhile() -> None:
    one, other = Thing(), Thing()
    other.go_on.set()
    thread = threading.Thread(target=lambda: one.slow)
    thread.start()
    one.reached.wait()
    assert other.slow == "worked out"  # with the lock of functools it would wait for `one`
    one.go_on.set()
    thread.join()
