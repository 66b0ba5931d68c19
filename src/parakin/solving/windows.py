"""Windows: a motion solved piece by piece, each with labelled arrays."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from parakin.arrays import FloatArray, StatusArray
from parakin.errors import InputError
from parakin.kernel.outputs import POINT
from parakin.labelled import Labelled
from parakin.motion.course import Course
from parakin.motion.motion import Motion
from parakin.solving.atlas import Atlas
from parakin.solving.bodies import Points, points_of
from parakin.solving.crossings import Crossings
from parakin.solving.force_variables import force_variables
from parakin.solving.forces import Asked, Window
from parakin.solving.from_home import home_state
from parakin.solving.results import Labels, Verdict, labelled
from parakin.solving.status import UNREACHED, Status, are, blank_undefined, classify
from parakin.solving.stops import Stopped
from parakin.solving.tracking import Track


@dataclass(frozen=True)
class Windows:
    """What is to be known of a motion: places of `points`; forces, if they are `asked` for, with
    what payloads and wrenches take, if `loads` are given.
    """

    atlas: Atlas
    labels: Labels
    points: Points
    asked: Asked | None = None
    loads: Mapping[str, ArrayLike] | None = None

    def solve(
        self, motion: Motion, size: int, *, derivatives: int, parallel: bool
    ) -> Iterator[Labelled]:
        """From home along home's branch, in windows of at most `size` samples. Raises InputError
        before the first where forces are not known over the whole motion.
        """
        if self.asked is not None and motion.count:
            ends = [motion.window(k, k + 1).time for k in (0, motion.count - 1)]
            self.atlas.home.mechanics.check_histories(np.concatenate(ends), self.loads)
        return self._solved(motion, size, derivatives=derivatives, parallel=parallel)

    def _solved(
        self, motion: Motion, size: int, *, derivatives: int, parallel: bool
    ) -> Iterator[Labelled]:
        atlas, points = self.atlas, self.points
        home = atlas.home
        track = Track(home, Course(motion), home_state(home), atlas.units, atlas.others)
        last: Labelled | None = None
        crossings = Crossings(atlas.stops, track)
        for start in range(0, motion.count, size):
            samples = motion.window(start, min(start + size, motion.count))
            if samples.jerk is None and derivatives > 2:
                known = "position, velocity and acceleration"
                raise InputError(f"motion {motion.name}", known, "jerk too, or position alone")
            pieces, status = track.solve(samples, parallel=parallel)
            for start_, stop, chart, found in pieces:
                undefined = blank_undefined(found, chart.layout)
                status[start_:stop][undefined] = Status.ANGLES_UNDEFINED
            out = atlas.reported(pieces, len(status))
            stopped = atlas.stopped(pieces, len(status))
            status[stopped.number > 0] = Status.LIMIT_EXCEEDED
            crossings.note(samples.time, pieces)
            self._blame(track, samples.time, status, stopped, crossings)
            figures = atlas.figures(points, pieces, samples, parallel) if points else None
            forces = None
            if self.asked is not None:
                window = Window(start, motion.count)
                loads = home.mechanics.loads(samples.time, len(status), self.loads, window)
                behind = atlas.forces(self.asked, pieces, samples, loads, parallel)
                forces = force_variables(behind, self.asked)
            verdict = Verdict(status, stopped, crossings.of(stopped), crossings.words)
            last = labelled(
                self.labels, motion, samples.time, out, verdict, list(points), figures, forces, last
            )
            yield last

    def schema(self, motion: Motion, rows: int) -> Labelled:
        """A result of NaN for a motion; rows: of what is reported."""
        n = motion.count
        out = np.broadcast_to(np.nan, (rows, n))
        status = np.broadcast_to(np.int8(Status.NOT_REACHED), n)
        nothing = np.broadcast_to(np.nan, n)
        verdict = Verdict(status, Stopped(np.broadcast_to(np.intp(0), n), nothing), nothing)
        figures = np.broadcast_to(np.nan, (POINT * len(self.points), n)) if self.points else None
        time: FloatArray = motion.window(0, n).time
        forces = None
        if self.asked is not None:
            mechanics = self.atlas.home.mechanics
            rows_of = mechanics.rows(self.asked, mechanics.reference)
            unknown = np.broadcast_to(np.nan, (rows_of.count, n))
            forces = force_variables(mechanics.forces(self.asked, rows_of, unknown), self.asked)
        return labelled(self.labels, motion, time, out, verdict, list(self.points), figures, forces)

    def _blame(
        self,
        track: Track,
        time: FloatArray,
        status: StatusArray,
        stopped: Stopped,
        crossings: Crossings,
    ) -> None:
        """Name the loop that cannot be closed, where a motion ends out of reach."""
        ended = np.flatnonzero(are(UNREACHED, status))
        if not len(ended) or track.ending is None:
            return
        chart, driven, out = track.after_end(float(time[ended[0]]))
        open_ = np.flatnonzero(are(UNREACHED, classify(out.copy(), chart.layout)))
        if not len(open_):
            return
        number = self.atlas.loop_stops(chart, driven, out)[open_[0]]
        stopped.number[ended[0]] = number
        if number and np.isfinite(track.ending.time):
            crossings.first_at[1, number] = track.ending.time


def windows_of(
    atlas: Atlas,
    labels: Labels,
    bodies: bool | Sequence[str] = False,
    forces: bool = False,
    reactions: bool | Sequence[str] = False,
    energies: bool = False,
    preload: Mapping[str, float] | None = None,
    indeterminate: str = "nan",
    loads: Mapping[str, ArrayLike] | None = None,
) -> Windows:
    """What is asked for as of `Solver.solve`. Raises InputError."""
    asked = None
    if forces or reactions or energies:
        asked = atlas.home.mechanics.asked(
            reactions=reactions, energies=energies, preload=preload, indeterminate=indeterminate
        )
    return Windows(atlas, labels, points_of(atlas.home.plan.graph.plain, bodies), asked, loads)
