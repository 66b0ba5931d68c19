"""Results of any length on their way to a file: summed up, timed and thinned as they pass."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import ExitStack

from rich.console import Console
from rich.progress import Progress

from parakin.errors import InputError
from parakin.labelled import Labelled, joined
from parakin.motion.motion import Motion
from parakin.views.extremes import Extremes, extremes
from parakin.views.thinning import every

_PATIENCE = 1.0  # seconds before there is a progress bar
_PICTURED = 20_000  # samples, about, that figures and films are made from


class Run:
    """One pass over the windows of a result; `seconds` of it are spent on solving."""

    def __init__(self, motion: Motion, *, pictured: bool) -> None:
        self.seconds = 0.0
        self._last: Labelled | None = None
        self._extremes: Extremes | None = None
        self._motion = motion
        self._stride = max(1, motion.count // _PICTURED)
        self._thinned: list[Labelled] | None = [] if pictured else None

    def watched(self, windows: Iterator[Labelled], console: Console) -> Iterator[Labelled]:
        """The windows, with a progress bar in a terminal if they take long."""
        begun = time.perf_counter()
        with ExitStack() as stack:
            bar, task = None, None
            while True:
                start = time.perf_counter()
                window = next(windows, None)
                self.seconds += time.perf_counter() - start
                if window is None:
                    return
                begin = 0 if self._extremes is None else self._extremes.samples
                self._extremes = extremes(window, self._extremes)
                self._last = window
                if self._thinned is not None:
                    self._thinned.append(every(self._stride, window, begin))
                yield window
                if bar is None and console.is_terminal and time.perf_counter() - begun > _PATIENCE:
                    bar = stack.enter_context(Progress(console=console, transient=True))
                    task = bar.add_task("solving", total=self._motion.count)
                if bar is not None and task is not None:
                    bar.update(task, completed=self._extremes.samples)

    def totals(self) -> tuple[Labelled, Extremes]:
        """The last window, and the extremes of all. Raises InputError where there were none."""
        if self._last is None or self._extremes is None:
            raise InputError(f"motion {self._motion.name}", "no samples", "at least one")
        return self._last, self._extremes

    def picture(self) -> Labelled:
        """The result, thinned if it is long, for figures and films."""
        assert self._thinned is not None
        return joined(self._thinned)
