"""Actuation: the efforts by which actuators balance what the driven coordinates need."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from parakin.algebra.linear import inner, solve
from parakin.algebra.spatial import FLOATS, Scalar, add, as_float, mul, sub
from parakin.kernel.connectivity import System
from parakin.kernel.force_rows import ForceRows
from parakin.kernel.statics import Statics, is_zero
from parakin.kinematics.configuration import circuits_at
from parakin.planning.plan import Plan

_POOR = 0.05  # a home where actuators hold less firmly than this is not what others compare with


class Actuation:
    """How actuators balance what the driven coordinates need."""

    def __init__(self, statics: Statics, wanted: ForceRows) -> None:
        self.statics, self.wanted = statics, wanted
        driven = statics.plan.driven
        self.direct = {k: driven.index(k) for k in wanted.actuated if k in driven}
        if len(wanted.actuated) > len(driven):
            self.direct = {}  # all share
        self.others = [k for k in wanted.actuated if k not in self.direct]
        places = set(self.direct.values())
        self.places = [place for place in range(len(driven)) if place not in places]
        self.columns = {k: statics.given_by(k) for k in self.others}

    def efforts(
        self, needed: Sequence[Scalar], bands: Mapping[int, Scalar]
    ) -> tuple[list[Scalar], list[Scalar], Scalar]:
        """Efforts, what friction at rest may change them by, and the conditioning."""
        actuated = self.wanted.actuated
        sides = [list(needed)]
        resting = {k: band for k, band in bands.items() if not is_zero(band)}
        apart = [k for k in resting if k not in actuated]
        sides += [self.statics.given_by(k) for k in apart]
        solutions, figure = self.solved(sides)
        totals = [resting.get(k, 0.0) for k in actuated]
        if len(actuated) > len(needed):  # the band of an actuator's friction is shared, too
            totals = [0.0 for _ in actuated]
            apart += [k for k in resting if k in actuated]
            shared = [self.statics.given_by(k) for k in resting if k in actuated]
            solutions = solutions[: len(sides)] + self.solved(shared, preloaded=False)[0]
        for k, solution in zip(apart, solutions[1:], strict=True):
            for place, part in enumerate(solution):
                size = self.statics.functions.sqrt(mul(part, part))
                totals[place] = add(totals[place], mul(size, resting[k]))
        return solutions[0], totals, figure

    def solved(
        self, sides: Sequence[Sequence[Scalar]], *, preloaded: bool = True
    ) -> tuple[list[list[Scalar]], Scalar]:
        """Efforts that give the driven coordinates each of `sides`."""
        if len(self.wanted.actuated) > len(self.statics.plan.driven):
            return self._shared(sides, preloaded=preloaded)
        functions, found = self.statics.functions, []
        figure: Scalar = 1.0
        others: list[list[Scalar]] = [[] for _ in sides]
        if self.others:
            matrix = [[self.columns[k][place] for k in self.others] for place in self.places]
            chosen = [[side[place] for place in self.places] for side in sides]
            solved = solve(matrix, chosen, functions)
            others, figure = solved.solutions, mul(1.0 / self.wanted.reference, solved.conditioning)
        for side, solution in zip(sides, others, strict=True):
            efforts = dict(zip(self.others, solution, strict=True))
            for k, place in self.direct.items():
                effort = side[place]
                for other in self.others:
                    effort = sub(effort, mul(self.columns[other][place], efforts[other]))
                efforts[k] = effort
            found.append([efforts[k] for k in self.wanted.actuated])
        return found, figure

    def _shared(
        self, sides: Sequence[Sequence[Scalar]], *, preloaded: bool
    ) -> tuple[list[list[Scalar]], Scalar]:
        """More actuators than freedoms: of all efforts that serve those nearest to the preload."""
        if not sides:
            return [], 1.0
        matrix = list(zip(*(self.columns[k] for k in self.wanted.actuated), strict=True))
        squares = [[inner(a, b) for b in matrix] for a in matrix]
        wanted: list[Scalar] = [*(self.wanted.preload or [0.0] * len(self.wanted.actuated))]
        starts = [
            wanted if n == 0 and preloaded else [0.0] * len(wanted) for n in range(len(sides))
        ]
        rests = [
            [sub(x, inner(row, start)) for x, row in zip(side, matrix, strict=True)]
            for side, start in zip(sides, starts, strict=True)
        ]
        solved = solve(squares, rests, self.statics.functions)
        columns = [self.columns[k] for k in self.wanted.actuated]
        found = [
            [add(x, inner(column, y)) for x, column in zip(start, columns, strict=True)]
            for start, y in zip(starts, solved.solutions, strict=True)
        ]
        return found, mul(1.0 / self.wanted.reference, solved.conditioning)


def conditioning_at_home(plan: Plan, actuated: tuple[int, ...]) -> float:
    """What the conditioning of the actuators is compared with."""
    circuits = circuits_at(plan.graph, plan.tree, plan.home)
    systems = [System.of(circuits, block) for block in plan.blocks]
    home = Actuation(Statics(plan, circuits, systems, FLOATS), ForceRows(actuated))
    figure = as_float(home.efforts([0.0] * len(plan.driven), {})[2])
    least = _POOR ** len(home.others)
    return figure if abs(figure) > least else least if figure >= 0.0 else -least
