"""How far, how fast and how hard a mechanism moves from a pose, and what stops it."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from parakin.arrays import FloatArray
from parakin.design.answer import Alone, Pair, answer, blocked
from parakin.design.asked import check_conditioning, of_design, positions
from parakin.design.envelopes import envelopes
from parakin.design.march import Node
from parakin.design.rays import Ray, follow, other_chart, reported
from parakin.design.stopping import Demands, cut_short, words_of
from parakin.design.strength import Firmness, limited_efforts
from parakin.design.swing import amplitudes
from parakin.errors import InputError
from parakin.model.expressions import Value
from parakin.solving.forces import is_finite
from parakin.solving.inputs import refuse_lean
from parakin.solving.locks import begun_at, locks_of
from parakin.solving.solver import Solver
from parakin.solving.status import SOLVED, Status, converged

if TYPE_CHECKING:
    import xarray as xr

FULL_TURN = 2.0 * np.pi  # an angle that comes so far is told as unlimited
FAR = 20.0  # characteristic lengths: and a slide that comes so far
_BEYOND = 1.01  # times the way to a declared limit of its own: farther is not looked
_RAYS = (8, 3600)  # of a pair
_STRAIGHT = 1e-12  # of a range: a part of a ray along the other coordinate that is rounding


class _Start(NamedTuple):
    """Where ranges are counted from: driven values (k,) and the pose there."""

    y: FloatArray
    node: Node


def range(
    solver: Solver,
    pose: Mapping[str, Value] | None = None,
    *,
    offsets: Mapping[str, Value] | None = None,
    pairs: bool = False,
    rays: int = 72,
    frequency: float | None = None,
    forces: bool = False,
    loads: Mapping[str, ArrayLike] | None = None,
    least_conditioning: float | None = None,
    parameters: Mapping[str, Value] | None = None,
) -> xr.Dataset:
    """How far each driven coordinate goes alone from a pose, down and up, and what stops it there;
    how fast it may go at the pose, and how hard.

    pose: positions of driven coordinates, by name [m or rad, or text with a unit, "10 deg"], home's
    where not given. offsets: what they are moved by first, all at once and straight; all else is
    counted from there. pairs: the boundary around the pose for every pair of driven coordinates
    too, along so many `rays`. frequency [Hz]: the largest sine of each coordinate alone too.
    forces: limits of efforts end the ways too: at rest, and of sines in motion; loads: as of
    `Solver.solve`. least_conditioning: how near to a singularity the ways may come, 1 being as firm
    as home. parameters: of another design, for which `solver.with_design` compiles; without them it
    is the file's own, whatever was left `free`.

    Every declared limit of positions and cone angles counts, reported or not, loops that cannot be
    closed, and singularities. The way is followed from the pose; what lies beyond a gap does not
    count. Ends are located by root finding.

    Result, over `driven` and `end` ("down", "up"): `travel`, what may be added [m or rad], infinite
    where a full turn or `FAR` characteristic lengths meet nothing; `stopped_by`, in words;
    `position` of all reported `coordinate`s there; `max_velocity`, `max_acceleration` and
    `max_load` (a force or moment on the platform) with what limits them, NaN where the mechanism
    does not say; over `driven`: `pose`, `amplitude`. Over `pair`, `ray` and `side`: `boundary`,
    what may be added to the `first` and the `second` of the pair. Attributes: `reached`, the part
    of the offsets that was gone, less than 1 where something stopped it, and `stopped`, what did,
    or what is wrong with the pose; all else is NaN then.
    Raises InputError on unknown names, values that are not finite, a lean solver, and `forces`
    where efforts are not known or have no bounds.
    """
    solver = of_design(solver, parameters)
    refuse_lean(solver.reported)
    _check_numbers(rays, frequency, least_conditioning)
    home = np.array([solver.home[name] for name in solver.driven])
    y = positions(solver, pose, "pose", home)
    away = positions(solver, offsets, "offsets", np.zeros(len(home)))
    demands = Demands(
        limited_efforts(solver, loads) if forces else None,
        None if least_conditioning is None else Firmness(solver).check(solver),
        least_conditioning or 0.0,
    )
    start, wrong = _start(solver, y)
    if start is None:
        return blocked(solver, y, 0.0, wrong)
    if away.any():
        moved, reached, wrong = _moved(solver, start, away, demands)
        if moved is None:
            return blocked(solver, y + away, reached, wrong)
        start = moved
    alone, ways = _alone(solver, start, demands)
    return answer(
        solver,
        start.y,
        alone,
        _pairs(solver, start, alone, demands, rays) if pairs else None,
        envelopes(solver, start.y, start.node, loads),
        None if frequency is None else amplitudes(solver, alone, ways, frequency, demands.efforts),
    )


def _check_numbers(rays: int, frequency: float | None, least: float | None) -> None:
    if not isinstance(rays, (int, np.integer)) or not _RAYS[0] <= rays <= _RAYS[1]:
        raise InputError("rays", repr(rays), f"a whole number from {_RAYS[0]} to {_RAYS[1]}")
    if frequency is not None and not (is_finite(frequency) and frequency > 0.0):
        raise InputError("frequency", repr(frequency), "a number of hertz above zero")
    check_conditioning(least)


def _start(solver: Solver, y: FloatArray) -> tuple[_Start | None, str]:
    """The pose at driven values, or why there is none to start from."""
    tick = solver.at(y)
    if tick.status not in SOLVED or tick.status == Status.LIMIT_EXCEEDED:
        return None, tick.why()
    chart = solver.atlas.followed
    guess = begun_at(locks_of(solver.plan), solver.layout, tick)
    out = chart.at_rest(y, guess)
    node = Node(0.0, chart, out)
    if not converged(out[:, None], chart.layout)[0]:  # solved where this chart is singular
        node = other_chart(solver.atlas, node, y, y) or node
    return _Start(y, node), ""


def _moved(
    solver: Solver, start: _Start, away: FloatArray, demands: Demands
) -> tuple[_Start | None, float, str]:
    """The pose after offsets, or how far it went, as a part of them, and what stopped it."""
    traces: list[list[Node]] = [[]]
    goal = start.y + away
    met = follow(solver.atlas, start.node, start.y, goal[:, None], traces)
    ray = Ray(start.y, goal, traces[0])
    part, words = float(met.part[0]), words_of(solver, met, 0)
    if demands.any:
        part, words = cut_short(solver, ray, part, words, demands)
    if part < 1.0:
        return None, part, words
    last = traces[0][-1]
    return _Start(goal, last._replace(part=0.0)), 1.0, ""


def _alone(solver: Solver, start: _Start, demands: Demands) -> tuple[Alone, list[tuple[Ray, Ray]]]:
    """Each driven coordinate down and up, and the rays that were followed."""
    k = len(start.y)
    far = _far(solver, start.y)
    ways = np.concatenate([-np.diag(far[:, 0]), np.diag(far[:, 1])], axis=1)
    goal = start.y[:, None] + ways
    traces: list[list[Node]] = [[] for _ in goal.T]
    met = follow(solver.atlas, start.node, start.y, goal, traces)
    rays = [Ray(start.y, goal[:, i], traces[i]) for i in np.arange(2 * k)]
    words = [words_of(solver, met, i) for i, _ in enumerate(rays)]
    part, position = met.part.copy(), met.position
    if demands.any:
        for i, ray in enumerate(rays):
            part[i], words[i] = cut_short(solver, ray, part[i], words[i], demands)
            if part[i] < met.part[i]:
                position[:, i] = reported(solver.atlas, ray, part[i])
    free = (part >= 1.0) & np.array([not each for each in words])
    position[:, free] = np.nan
    travel = np.where(free, np.inf, part) * ways[np.tile(np.arange(k), 2), np.arange(2 * k)]
    sides = (slice(0, k), slice(k, 2 * k))
    return (
        Alone(
            np.array([travel[side] for side in sides]).T,
            np.array([words[side] for side in sides], dtype=object).T,
            np.array([position[:, side].T for side in sides]).swapaxes(0, 1),
        ),
        list(zip(rays[:k], rays[k:], strict=True)),
    )


def _far(solver: Solver, y: FloatArray) -> FloatArray:
    """How far it is looked, down and up, (k, 2): beyond limits of the coordinate itself."""
    graph = solver.graph
    found = []
    for name, value in zip(solver.driven, y.tolist(), strict=True):
        most = FULL_TURN if graph.is_angle(name) else FAR * graph.length
        own = [abs(end - value) for end in graph.limits(name)]
        found.append([max(most, _BEYOND * each) if np.isfinite(each) else most for each in own])
    return np.array(found)


def _pairs(solver: Solver, start: _Start, alone: Alone, demands: Demands, count: int) -> list[Pair]:
    """The boundary around the pose for each pair, in rays that are evenly spread where both ranges
    are drawn as long.
    """
    atlas, k = solver.atlas, len(start.y)
    known = np.where(np.isfinite(alone.travel), np.abs(alone.travel), 0.0)
    size = known.sum(axis=1) / np.maximum((known > 0.0).sum(axis=1), 1)
    size = np.where(size > 0.0, size, atlas.units)
    turn = 2.0 * np.pi * np.arange(count) / count
    numbers = list(itertools.combinations(np.arange(k).tolist(), 2))
    ways = np.zeros((k, len(numbers), count))
    far = _far(solver, start.y)
    for number, (i, j) in enumerate(numbers):
        ways[i, number], ways[j, number] = size[i] * np.cos(turn), size[j] * np.sin(turn)
        ways[np.abs(ways) < _STRAIGHT * size[:, None, None]] = 0.0
        # Until one of the two is as far as it is looked at alone.
        both = ways[[i, j], number]
        with np.errstate(divide="ignore"):
            times = np.where(both < 0.0, far[[i, j], 0, None], far[[i, j], 1, None]) / np.abs(both)
        ways[:, number] *= times.min(axis=0)
    away = ways.reshape(k, -1)
    goal = start.y[:, None] + away
    traces: list[list[Node]] | None = [[] for _ in goal.T] if demands.any else None
    met = follow(atlas, start.node, start.y, goal, traces)
    ends = [(float(part), words_of(solver, met, ray)) for ray, part in enumerate(met.part)]
    if traces is not None:
        rays = [Ray(start.y, goal[:, ray], nodes) for ray, nodes in enumerate(traces)]
        ends = [cut_short(solver, ray, *end, demands) for ray, end in zip(rays, ends, strict=True)]
    found = []
    for number, (i, j) in enumerate(numbers):
        mine = slice(number * count, (number + 1) * count)
        part = np.array([np.inf if p >= 1.0 and not words else p for p, words in ends[mine]])
        with np.errstate(invalid="ignore"):
            boundary = part * away[[i, j], mine]
        boundary[away[[i, j], mine] == 0.0] = 0.0
        found.append(
            Pair(solver.driven[i], solver.driven[j], boundary.T, [w for _, w in ends[mine]])
        )
    return found
