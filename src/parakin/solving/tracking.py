"""A motion followed from home on its branch, as far as one that went slowly would get.

It is followed in its own steps (`parakin.motion.course`), by the rule of
`parakin.solving.continuity`, from chart to chart where a plan no longer serves. The samples asked
for lie on that walk and are held to the same rule. So neither the number of samples nor windows nor
threads change the answer.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from parakin.arrays import FloatArray, StatusArray
from parakin.kinematics.configuration import Configuration
from parakin.motion.course import Course
from parakin.motion.motion import Samples
from parakin.solving.charts import Chart
from parakin.solving.continuity import shortest_interval
from parakin.solving.status import Status, classify
from parakin.solving.stretch import LOOKBACK, Ending, Nodes, Stretch, joined
from parakin.solving.walking import REGULAR, State, carried_over, iterate, walk

_AT_ONCE = 512  # steps of the motion's own that are looked at together
POORER = 30.0  # times: where a plan's figure has fallen by more than that, it is the plan's fault
_GOOD = 0.05  # figure of a plan where another takes over

OtherCharts = Callable[[Chart, Configuration, Configuration], Iterable[Chart]]


class Piece(NamedTuple):
    """Consecutive samples on one chart: from `start` to before `stop`, and all outputs of them."""

    start: int
    stop: int
    chart: Chart
    out: FloatArray


class Track:
    """A walk along a motion from home, made as far as it is asked for.

    home: where the walk to the motion's start begins; units (k,): of the driven coordinates, 1 for
    angles, else the characteristic length. charts: others that may serve at a configuration
    instead of one, which does no more at another.
    """

    def __init__(
        self, chart: Chart, course: Course, home: State, units: FloatArray, charts: OtherCharts
    ) -> None:
        self._course, self._home, self._units, self._charts = course, home, units, charts
        self._walks: list[tuple[Stretch, Nodes]] = []  # the last goes on
        self._first = Stretch(chart, course, units)
        self._switched = -np.inf  # when the last chart took over
        self._ending: Ending | None = None
        self._end_reported = False
        self._since: float | None = None  # the last sample of the window before

    @property
    def ending(self) -> Ending | None:
        """The last moment that can be reached, as far as is known."""
        return self._ending

    def solve(self, samples: Samples, *, parallel: bool) -> tuple[list[Piece], StatusArray]:
        """Samples that can be reached, and the status of all; windows come one after the other."""
        time, n = samples.time, len(samples.time)
        status = np.full(n, Status.NOT_REACHED, dtype=np.int8)
        pieces: list[Piece] = []
        if not self._end_reported:
            since = float(time[0]) if self._since is None else self._since
            self._reach(since, float(time[-1]))
            self._since = float(time[-1])
            while not self._placed(samples, pieces, parallel):
                pieces = []
        reached = pieces[-1].stop if pieces else 0
        status[:reached] = Status.CONVERGED
        if reached < n and not self._end_reported and self._ending is not None:
            self._end_reported = True
            status[reached] = self._ending.status
        return pieces, status

    def at(self, time: FloatArray) -> list[Piece]:
        """Outputs at moments (n,) since the last sample of the window before, as far as the walk
        has come.
        """
        orders = len(self._first.chart.layout.iterated)
        samples = Samples(time, *self._course.at(time, orders))
        pieces, start = [], 0
        for stretch, nodes in self._walks:
            stop = int(np.searchsorted(time, float(nodes.time[-1]), side="right"))
            if stop > start:
                out, _ = stretch.placed(nodes, samples.cropped(start, stop), parallel=False)
                pieces.append(Piece(start, stop, stretch.chart, out))
                start = stop
        return pieces

    def after_end(self, sample: float) -> tuple[Chart, FloatArray, FloatArray]:
        """What becomes of the pose just after the ending, and at the time of the first sample after
        it: the chart, driven values (k, 2) and outputs (rows, 2), not all of which are closed.
        """
        assert self._ending is not None
        stretch, nodes = self._walks[-1]
        chart, orders = stretch.chart, len(stretch.chart.layout.iterated)
        last = max(self._ending.time, float(nodes.time[0]))
        driven = self._course.at(np.array([last + 2 * shortest_interval(last), sample]), orders)
        guess = nodes.out[chart.layout.iterated[0], -1:].repeat(2, axis=1)
        return chart, driven[0], iterate(chart, driven.reshape(-1, 2), guess)

    def _placed(self, samples: Samples, pieces: list[Piece], parallel: bool) -> bool:
        """Put samples on the walk. False if one did not fit, and the walk was looked into."""
        start = 0
        for number, (stretch, nodes) in enumerate(self._walks):
            last = number == len(self._walks) - 1
            until = float(nodes.time[-1])
            if last:
                until = np.inf if self._ending is None else self._ending.time
            stop = int(np.searchsorted(samples.time, until, side="right"))
            if stop > start:
                inside = samples.cropped(start, stop)
                out, doubtful = stretch.placed(nodes, inside, parallel=parallel)
                if doubtful is not None:
                    self._look_closer(number, doubtful)
                    return False
                pieces.append(Piece(start, stop, stretch.chart, out))
                start = stop
        return True

    def _look_closer(self, number: int, time: float) -> None:
        stretch, nodes = self._walks[number]
        nodes, ending = stretch.closer(nodes, time)
        self._walks[number] = (stretch, nodes)
        if ending:
            self._walks, self._ending = self._walks[: number + 1], ending

    def _reach(self, first: float, until: float) -> None:
        """Walk on until `until` is covered; what lies before `first` is needed no more."""
        if not self._walks:
            self._enter(until)
        while self._ending is None and self._walks[-1][1].time[-1] < until:
            stretch, nodes = self._walks[-1]
            ends = self._course.steps(float(nodes.time[-1]), until, _AT_ONCE)
            last = float(nodes.time[-1])
            head = nodes.part(slice(_place_before(nodes, last), None))
            found, ending = stretch.walked(head, ends)
            nodes = joined(nodes, found.part(slice(len(head.time), None)))
            self._walks[-1] = (stretch, nodes)
            if ending and not self._changed_chart(ending):
                self._ending = ending
        while len(self._walks) > 1 and self._walks[0][1].time[-1] < first:
            self._walks.pop(0)
        stretch, nodes = self._walks[0]
        self._walks[0] = (stretch, nodes.part(slice(_place_before(nodes, first), None)))

    def _enter(self, until: float) -> None:
        """From home to where the motion begins; where no guess is needed, on at once."""
        stretch, chart = self._first, self._first.chart
        layout = chart.layout
        ends = self._course.steps(-np.inf, until, _AT_ONCE)
        guess = np.empty((0, len(ends)))
        status, ending = Status.CONVERGED, None
        if len(layout.iterated[0]):
            ends = ends[:1]
            driven = self._course.at(ends, len(layout.iterated))
            out, walked, _ = walk(chart.walker, self._home, driven[0], self._units)
            guess, status = out[chart.walker.layout.iterated[0]], Status(int(walked[0]))
        steps = np.zeros(len(ends))
        steps[1:] = ends[1:] - ends[:-1]
        nodes = stretch.evaluated(ends, steps, guess)
        status = status or Status(int(classify(nodes.out[:, :1].copy(), layout)[0]))
        if status == Status.CONVERGED:
            nodes, ending = stretch.certified(nodes)
        else:
            nodes, ending = nodes.part(slice(0, 1)), Ending(-np.inf, status)
        self._walks = [(stretch, nodes)]
        if ending and (status != Status.CONVERGED or not self._changed_chart(ending)):
            self._ending = ending

    def _changed_chart(self, ending: Ending) -> bool:
        """Go on with another chart, if it is only the plan that ends here and not the mechanism."""
        stretch, nodes = self._walks[-1]
        chart, row = stretch.chart, stretch.chart.layout.outputs.conditioning
        figure = np.where(nodes.time > self._switched, nodes.out[row], 0.0)
        if ending.status == Status.NOT_SMOOTH or not figure.any():
            return False
        good = np.flatnonzero(figure > _GOOD)
        place = int(good[-1]) if len(good) else int(np.argmax(figure))
        at, end = (chart.configuration(nodes.driven[0, :, k], nodes.out[:, k]) for k in (place, -1))
        regularity, fallen = chart.regularity(at), float(figure[-1] / figure[place])
        if not chart.regularity(end) > max(REGULAR, POORER * fallen * regularity):
            return False
        for other in self._charts(chart, at, end):
            begun = self._begun(other, nodes.part(slice(place, place + 1)), at)
            if begun is not None:
                self._walks[-1] = (stretch, nodes.part(slice(0, place + 1)))
                self._walks.append(begun)
                self._switched = float(nodes.time[place])
                return True
        return False

    def _begun(
        self, chart: Chart, head: Nodes, before: Configuration
    ) -> tuple[Stretch, Nodes] | None:
        """The same moment on another chart, if it serves there and the pose is the same."""
        out = carried_over(chart, head.driven, before)
        if out is None:
            return None
        return Stretch(chart, self._course, self._units), head._replace(out=out)


def _place_before(nodes: Nodes, time: float) -> int:
    """The first of the moments by which an ending at this time would be judged."""
    since = time - LOOKBACK * shortest_interval(time)
    return max(int(np.searchsorted(nodes.time, since, side="right")) - 1, 0)
