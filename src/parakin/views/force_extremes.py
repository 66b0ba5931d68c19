"""What sums up the forces of a result, accumulated over its windows."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from parakin.arrays import BoolArray, FloatArray
from parakin.solving.status import SOLVED, are
from parakin.views.ranges import Range

if TYPE_CHECKING:
    from parakin.labelled import Result
    from parakin.model.graph import Graph
    from parakin.model.motors import Motor

_RANGED = ("effort", "power", "motor_torque", "motor_speed", "motor_power", "motor_current")
RPM = 30.0 / math.pi  # per rad/s
_SQUARED = ("effort", "motor_torque")


class Use(NamedTuple):
    """How much of a drive's limit is used: the largest magnitude, when, and the limit, in `unit`.
    what: "effort", "speed" or "power" of the joint, or "torque" of the motor.
    """

    actuator: str
    what: str
    peak: float
    time: float
    limit: float
    unit: str

    @property
    def part(self) -> float:
        """The peak as a part of the limit."""
        return self.peak / self.limit


@dataclass
class Reactions:
    """Of joints, the largest force [N] and moment [N m], and when. force_known, moment_known:
    which of their components (joints, 3) rigid bodies determine.
    """

    joints: tuple[str, ...]
    force: Range
    moment: Range
    force_known: BoolArray
    moment_known: BoolArray


@dataclass
class ForceExtremes:
    """The extremes of forces. `units`: "N" or "N m" of each actuator's effort; `ranges`: by name of
    the result's variable, with a curve for each actuator; `conditioning`: how firmly actuators
    hold; `reactions`, if the result has them. solved: samples that are; unknown: those of them
    without finite efforts, the first at `unknown_from` [s].
    """

    actuators: tuple[str, ...]
    units: tuple[str, ...]
    ranges: dict[str, Range]
    conditioning: Range
    reactions: Reactions | None = None
    solved: int = 0
    unknown: int = 0
    unknown_from: float = math.nan
    _time: FloatArray = field(default_factory=lambda: np.zeros(0))  # the last sample so far
    _last: dict[str, FloatArray] = field(default_factory=dict)
    _sums: dict[str, FloatArray] = field(default_factory=dict)

    def peak(self, quantity: str, k: int) -> tuple[float, float]:
        """The value of largest magnitude, with its sign, and its time."""
        return self.ranges[quantity].peak(k)

    def rms(self, quantity: str, k: int) -> float:
        """The root mean square over time, of effort or motor torque."""
        square, seconds = self._sums[quantity][:, k]
        return float(np.sqrt(square / seconds)) if seconds else abs(self.peak(quantity, k)[0])

    @property
    def work(self) -> tuple[float, float]:
        """What all actuators give, and what they take back [J]."""
        given, taken = self._sums["power"].sum(axis=1)
        return float(given), float(taken)

    def least_conditioning(self) -> tuple[float, float]:
        """The least magnitude, zero where it changes sign, and the time of the least value."""
        low, high = float(self.conditioning.low[0]), float(self.conditioning.high[0])
        least = 0.0 if low <= 0.0 <= high else min(abs(low), abs(high))
        at = self.conditioning.low_time if low > -high else self.conditioning.high_time
        return least, float(at[0])

    @property
    def changes_sign(self) -> bool:
        """Whether the actuators' hold on what is driven does: a type 2 singularity is crossed."""
        return bool(self.conditioning.low[0] < 0.0 < self.conditioning.high[0])

    def add(self, ds: Result) -> None:
        """Take in one more window."""
        time = ds["time"].values
        efforts = np.isfinite(ds["effort"].values).all(axis=1)
        solved = are(SOLVED, ds["status"].values)
        lost = np.flatnonzero(solved & ~efforts)
        if len(lost) and not self.unknown:
            self.unknown_from = float(time[lost[0]])
        self.solved, self.unknown = self.solved + int(solved.sum()), self.unknown + len(lost)
        values = {name: np.where(efforts[:, None], ds[name].values, np.nan) for name in self.ranges}
        for name, rows in values.items():
            self.ranges[name].widen(time, rows)
        self.conditioning.widen(time, ds["effort_conditioning"].values[:, None])
        if self.reactions is not None:
            self._add_reactions(self.reactions, ds.isel(time=efforts) if len(lost) else ds)
        squares = {name: values[name] ** 2 for name in _SQUARED if name in values}
        self._integrate(time, {**squares, "power": values["power"]})

    def _integrate(self, time: FloatArray, rows: dict[str, FloatArray]) -> None:
        """By the trapezoidal rule, where both ends of a step are known."""
        steps = np.diff(np.concatenate([self._time, time]))[:, None]
        for name, values in rows.items():
            joined = np.concatenate([self._last.get(name, values[:0]), values])
            if name == "power":
                parts = (np.maximum(joined, 0.0), np.maximum(-joined, 0.0))
            else:
                parts = (joined, np.where(np.isfinite(joined), 1.0, np.nan))
            found = [np.nansum(0.5 * steps * (part[1:] + part[:-1]), axis=0) for part in parts]
            self._sums[name] = self._sums.get(name, 0.0) + np.array(found)
            self._last[name] = values[-1:]
        self._time = time[-1:]

    @staticmethod
    def _add_reactions(found: Reactions, ds: Result) -> None:
        for name, range_, known in (
            ("reaction_force", found.force, found.force_known),
            ("reaction_moment", found.moment, found.moment_known),
        ):
            values = ds[name].values
            finite = np.isfinite(values)
            known[...] |= finite.any(axis=0)
            size = np.sqrt(np.nansum(values**2, axis=2))
            size[~finite.any(axis=2)] = np.nan
            range_.widen(ds["time"].values, size)


def force_extremes(ds: Result, before: ForceExtremes | None = None) -> ForceExtremes | None:
    """Those of a result, or of one more window; None if it has no forces. `before` is updated."""
    if "effort" not in ds:
        return None
    found = before
    if found is None:
        count, reactions = ds.sizes["actuator"], None
        if "reaction_force" in ds:
            joints = tuple(ds["joint"].values.tolist())
            n = len(joints)
            known = np.zeros((2, n, 3), dtype=bool)
            reactions = Reactions(joints, Range.of(n), Range.of(n), known[0], known[1])
        found = ForceExtremes(
            tuple(ds["actuator"].values.tolist()),
            tuple(ds["effort_unit"].values.tolist()),
            {name: Range.of(count) for name in _RANGED if name in ds},
            Range.of(1),
            reactions,
        )
    found.add(ds)
    return found


def motor_of(graph: Graph, actuator: str) -> Motor | None:
    """The motor of an actuator, if it has a drive."""
    return graph.dynamics.motors.get(graph.index(actuator, "actuators"))


def uses(found: ForceExtremes, graph: Graph) -> Iterator[Use]:
    """How much of each limit of each drive is used."""
    for k, name in enumerate(found.actuators):
        motor = motor_of(graph, name)
        if motor is None:
            continue
        turns = found.units[k] == "N m"
        per = abs(motor.ratio)
        for what, quantity, limit, unit, scale in (
            ("effort", "effort", motor.max_effort, found.units[k], 1.0),
            ("speed", "motor_speed", motor.max_speed, "rad/s" if turns else "m/s", 1 / per),
            ("power", "power", motor.max_power, "W", 1.0),
            ("torque", "motor_torque", motor.max_torque, "N m" if motor.turns else "N", 1.0),
        ):
            peak, time = found.peak(quantity, k)
            if np.isfinite(limit) and np.isfinite(peak):
                yield Use(name, what, scale * abs(peak), time, limit, unit)
