"""Forks wait for what must not be forked, and it for them. See system/test_processes."""

from __future__ import annotations

import threading

from parakin.kernel import forking
from parakin.kernel.forking import in_children, no_fork


def test_a_fork_waits_for_what_is_at_work() -> None:
    forked, begun = threading.Event(), threading.Event()

    def fork() -> None:
        begun.set()
        forking._before()
        forked.set()
        forking._in_parent()

    other = threading.Thread(target=fork)
    with no_fork():
        other.start()
        begun.wait()
        while not forking._gate.forks:  # until it waits
            pass
        assert not forked.is_set()
    other.join()
    assert forked.is_set()
    assert (forking._gate.at_work, forking._gate.forks) == (0, 0)


def test_what_begins_during_a_fork_waits_for_it() -> None:
    order = []

    def work() -> None:
        with no_fork():
            order.append("work")

    other = threading.Thread(target=work)
    forking._before()
    other.start()
    order.append("fork")
    forking._in_parent()
    other.join()
    assert order == ["fork", "work"]


def test_a_child_begins_anew_and_does_what_it_was_asked_to() -> None:
    gate, done = forking._gate, []
    before = set(forking._in_children)
    forking._gate = forking._Gate()
    forking._in_children.clear()
    try:
        in_children(lambda: done.append("asked"))
        forking._before()
        forking._in_child()  # nobody has worked: nothing to do
        assert not done
        with no_fork():
            pass
        forking._before()
        forking._in_child()
        assert done == ["asked"]
        with no_fork():
            pass
    finally:
        forking._gate = gate
        forking._in_children |= before
