"""Ticks: what `Solver.at` returns, one pose or a batch."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from parakin import notebook
from parakin.arrays import ORDERS, PER_TIME, BoolArray, FloatArray, IndexArray, StatusArray
from parakin.errors import InputError, nearest
from parakin.solving.forces import Forces
from parakin.solving.status import Status
from parakin.solving.stops import Stops


class Tick(NamedTuple):
    """One pose, or a batch: rows are `coordinates`, SI; `status` is a `Status` (array).

    Derivatives that the solver was not compiled for are arrays of no rows. `iterated` are the
    iterated coordinates, if `position` does not contain them: a next call needs them to start from
    here. `units`: "m" or "rad" for each coordinate. `stopped_by`: the number in `stops` of what
    stopped it, 0 for nothing; `excess`: how far it is above an upper or, if negative, below a lower
    limit [SI], NaN where it exceeds none. `turned`: angles that are limited or have springs and are
    not reported, so that a next call that starts from here counts their turns on. `forces`: those
    behind it, if they were asked for. `ends`: lower and upper limits by number of the stop, (s,) or
    (s, n), of poses of other designs than the file's own; `no_design`: whether one is no design, or
    not on a way from the file's own, whatever the pose.

    Not a Dataset, because building one would take too long in a control loop.
    """

    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    status: int | StatusArray
    residual: float | FloatArray
    conditioning: float | FloatArray
    jerk: FloatArray
    iterated: FloatArray
    coordinates: tuple[str, ...]
    units: tuple[str, ...]
    stopped_by: int | IndexArray
    excess: float | FloatArray
    stops: Stops
    turned: FloatArray
    forces: Forces | None = None
    ends: tuple[FloatArray, FloatArray] | None = None
    no_design: bool | BoolArray = False

    def why(self, pose: int | None = None) -> str:
        """What stopped it, or one pose of a batch: "P6 at 1.262 m, limit 1.260 m", "limb A1, B1
        cannot reach"; the status in words where that is not known, "" where nothing did.

        Raises InputError on a batch if no pose is given.
        """
        if pose is None and self.position.ndim > 1:
            raise InputError("pose", "none, of a batch", "the number of one")
        pose = pose or 0
        status, number, excess = (
            np.atleast_1d(values)[pose] for values in (self.status, self.stopped_by, self.excess)
        )
        if np.atleast_1d(self.no_design)[min(pose, np.size(self.no_design) - 1)]:
            return f"no such design from home: {Status(int(status)).words}"
        stops = self.stops
        if self.ends is not None:
            low, high = (end.reshape(len(end), -1)[:, pose].tolist() for end in self.ends)
            stops = replace(stops, low=tuple(low), high=tuple(high))
        words = stops.words(int(number), float(excess))
        return words or (Status(int(status)).words if status else "")

    def value(self, coordinate: str, quantity: str = "position") -> float | FloatArray:
        """A coordinate's position, velocity, acceleration or jerk, or an actuator's effort or
        power, if forces were asked for: a number or, for a batch, an array (n,). Raises InputError
        on unknown names, and on derivatives that were not compiled.
        """
        known = dict(self._known())
        if self.forces is not None and quantity in ("effort", "power"):
            row = self.forces.of(coordinate, quantity)
            return row if self.position.ndim > 1 else float(row)
        if quantity not in known:
            raise InputError("quantity", repr(quantity), nearest(str(quantity), known))
        if coordinate not in self.coordinates:
            expected = nearest(str(coordinate), self.coordinates)
            raise InputError("coordinate", repr(coordinate), expected)
        row = known[quantity][self.coordinates.index(coordinate)]
        return row if self.position.ndim > 1 else float(row)

    def _known(self) -> list[tuple[str, FloatArray]]:
        """Quantities that were compiled for, and their rows."""
        rows = (self.position, self.velocity, self.acceleration, self.jerk)
        return [(name, values) for name, values in zip(ORDERS, rows, strict=True) if len(values)]

    def _repr_html_(self) -> str:
        if self.position.ndim > 1:
            counts = np.bincount(np.asarray(self.status), minlength=len(Status))
            found = (f"{n:,} {Status(k).words}" for k, n in enumerate(counts.tolist()) if n)
            return notebook.heading(f"{self.position.shape[1]:,} poses", ", ".join(found))
        known = self._known()
        rows = []
        for k, (name, unit) in enumerate(zip(self.coordinates, self.units, strict=True)):
            numbers = [f"{values[k]:z.6g} {unit}" for _, values in known]
            rows.append((name, *(a + b for a, b in zip(numbers, PER_TIME, strict=False))))
        quality = ""
        if np.isfinite(self.residual):  # unless compiled without checks
            quality = f"residual {self.residual:.1e} m, conditioning {self.conditioning:.3f}"
        because = self.why() if self.stopped_by else ""
        quality = "; ".join(text for text in (because, quality) if text)
        return (
            notebook.heading(Status(int(self.status)).words, quality)
            + notebook.table(("coordinate", *(name for name, _ in known)), rows)
            + self._forces_html()
        )

    def _forces_html(self) -> str:
        """A table of the actuators, if forces were asked for."""
        forces = self.forces
        if forces is None:
            return ""
        shown = ["effort", "power"]
        columns = [(forces.effort, ""), (forces.power, "W")]
        if forces.drives:
            shown += ["motor torque, SI", "motor speed, SI", "motor power", "motor current"]
            columns += [(forces.motor_torque, ""), (forces.motor_speed, "")]
            columns += [(forces.motor_power, "W"), (forces.current, "A")]
        rows = []
        for k, (name, unit) in enumerate(zip(forces.actuators, forces.units, strict=True)):
            numbers = [(float(values[k]), of) for values, of in columns]
            numbers[0] = numbers[0][0], unit
            cells = (f"{x:z.6g} {of}".strip() if np.isfinite(x) else "" for x, of in numbers)
            rows.append((name, *cells))
        return notebook.table(("actuator", *shown), rows)
