"""Ctrl-C: it ends whatever runs, wherever it comes, and lets what cleans up finish."""

from __future__ import annotations

import signal
import sys
import threading
from types import FrameType

_AGAIN = 0.2  # [s] until it is tried again, if a library swallowed it
# On the stack while a file is made, put in place or removed, or HDF5 calls back, which crashes if
# that fails.
_WHOLE = ("replacing", "_DeferredFailure.")


class Interrupts:
    """While entered, Ctrl-C raises KeyboardInterrupt until it is handled. `came`: whether it did.

    Libraries turn it into errors of their own while they are imported, or print it and go on.
    last: the process ends afterwards, and Ctrl-C has nothing more to stop.
    """

    came = False

    def __init__(self, *, last: bool = False) -> None:
        self._last = last

    def __enter__(self) -> Interrupts:
        # Where a shell has it ignored, or a program handles it, it stays so.
        self._ours = (
            threading.current_thread() is threading.main_thread()
            and signal.getsignal(signal.SIGINT) is signal.default_int_handler
        )
        self._timed = self._ours and hasattr(signal, "setitimer")
        if self._ours:
            self._unraisable, sys.unraisablehook = sys.unraisablehook, self._swallowed
            signal.signal(signal.SIGINT, self._heard)
        if self._timed:
            self._alarm = signal.signal(signal.SIGALRM, self._heard)
        return self

    def __exit__(self, *_: object) -> None:
        self._ours, ours = False, self._ours
        if self._timed:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            signal.signal(signal.SIGALRM, self._alarm)
        if ours:
            after = signal.SIG_IGN if self._last else signal.default_int_handler
            signal.signal(signal.SIGINT, after)
            sys.unraisablehook = self._unraisable

    def _swallowed(self, what: sys.UnraisableHookArgs) -> None:
        """Where nothing can be raised, as when an object is deleted: it is tried again."""
        if not issubclass(what.exc_type, KeyboardInterrupt):
            self._unraisable(what)

    def _heard(self, _: int, frame: FrameType | None) -> None:
        if not self._ours:
            return
        self.came = True
        if self._timed:
            signal.setitimer(signal.ITIMER_REAL, _AGAIN)
            if _is_whole(frame) or isinstance(sys.exc_info()[1], KeyboardInterrupt):
                return  # later
        raise KeyboardInterrupt


def _is_whole(frame: FrameType | None) -> bool:
    """Whether what runs must not end half done."""
    while frame is not None:
        if frame.f_code.co_qualname.startswith(_WHOLE):
            return True
        frame = frame.f_back
    return False
