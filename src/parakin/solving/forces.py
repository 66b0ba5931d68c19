"""Forces behind a motion: what of them is asked for, and what becomes of a kernel's rows."""

from __future__ import annotations

import math
import numbers
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from parakin.arrays import BoolArray, FloatArray
from parakin.caching import cached_property
from parakin.errors import InputError, nearest
from parakin.files.force_histories import History, histories
from parakin.kernel.actuation import conditioning_at_home
from parakin.kernel.force_rows import ForceRows, Loaded
from parakin.kinematics.assembly import home_and_around
from parakin.kinematics.closure import Row
from parakin.kinematics.configuration import Configuration, configure
from parakin.mechanics.reactions import SIZE, JointAt, indeterminate, joints_at
from parakin.model.evaluation import graph_of
from parakin.planning.holding import holding_rows
from parakin.planning.plan import Plan
from parakin.solving.motors import at_motors

FOUND = 1e-9  # of the efforts: a last step to friction under load that found it
NOT_KNOWN = ("nan", "minimum-norm")


class Window(NamedTuple):
    """Where a window starts, of a motion of so many samples."""

    start: int
    samples: int


class Asked(NamedTuple):
    """What is asked for: names of joints whose reactions are, whether energies, efforts that
    redundant actuators are to be nearest to (None refuses such), and whether what is indeterminate
    is to be of minimum norm.
    """

    joints: tuple[str, ...] = ()
    energies: bool = False
    preload: tuple[tuple[str, float], ...] | None = None
    least: bool = False


class Forces(NamedTuple):
    """Forces behind poses. Arrays have a row for each actuator or joint; for a batch, one column,
    or last place, for each pose. SI. idle: coordinates of idle freedoms; drives: actuators that
    have one.

    effort: of the actuators [N or N m]; band: how far Coulomb friction at rest may change it
    either way; power [W] that they give. conditioning: how firmly they hold what is driven,
    compared with home; signed, and zero where no effort can (a type 2 singularity). motor_torque,
    its band, motor_speed, motor_power and current: of drives, NaN where there is none.
    reaction_force, reaction_moment: on each joint's child, at its origin on it, along its axes on
    the parent (joints, 3). imbalance: how far efforts and reactions together miss balance [N].
    idle_effort: what holds idle freedoms at home. kinetic, potential [J], lost, applied [W]:
    energies and powers, NaN unless asked for.
    """

    actuators: tuple[str, ...]
    units: tuple[str, ...]
    joints: tuple[str, ...]
    idle: tuple[str, ...]
    drives: tuple[str, ...]
    effort: FloatArray
    band: FloatArray
    power: FloatArray
    conditioning: float | FloatArray
    motor_torque: FloatArray
    motor_band: FloatArray
    motor_speed: FloatArray
    motor_power: FloatArray
    current: FloatArray
    reaction_force: FloatArray
    reaction_moment: FloatArray
    imbalance: float | FloatArray
    idle_effort: FloatArray
    kinetic: float | FloatArray
    potential: float | FloatArray
    lost: float | FloatArray
    applied: float | FloatArray

    def of(self, actuator: str, quantity: str) -> FloatArray:
        """An actuator's effort or power. Raises InputError on an unknown one."""
        if actuator not in self.actuators:
            raise InputError("coordinate", repr(actuator), nearest(str(actuator), self.actuators))
        rows = self.effort if quantity == "effort" else self.power
        found: FloatArray = rows[self.actuators.index(actuator)]
        return found


@dataclass(frozen=True, eq=False)
class Mechanics:
    """What a plan's forces need to know beside it. Raises InputError where there are none."""

    plan: Plan
    _rows: dict[tuple[Asked, float], ForceRows] = field(default_factory=dict)

    @cached_property
    def actuated(self) -> tuple[int, ...]:
        """The actuated coordinates or, if the file names none, those driven."""
        plan, known = self.plan, self.plan.graph.plain.coordinates
        where = plan.graph.mechanism.where
        found = tuple(k for k, c in enumerate(known) if c.actuated)
        if found:
            return found
        platform = plan.graph.platform
        if any(plan.graph.coordinates[k].joint == platform for k in plan.driven):
            expected = "joints with actuated = true, to make the forces"
            raise InputError(f"{where}: joints", "none that is actuated", expected)
        return plan.driven

    @cached_property
    def samples(self) -> list[Configuration]:
        """Home, and closed configurations near it."""
        graph, tree = self.plan.graph, self.plan.tree
        home = configure(graph, graph.posed_tree(), configure(graph, tree, self.plan.home).q)
        return home_and_around(graph, tree, home, 3)

    @cached_property
    def holding(self) -> tuple[Row, ...]:
        """Closure rows that hold what the plan need not solve for."""
        return holding_rows(self.plan, self.samples)

    @cached_property
    def joints(self) -> Mapping[str, JointAt]:
        """Joints as declared, by name."""
        mechanism = self.plan.graph.mechanism
        declared = graph_of(mechanism).joints[: len(mechanism.joints)]
        return {joint.name: joint for joint in joints_at(self.plan.graph, declared)}

    @cached_property
    def indeterminate(self) -> Mapping[str, BoolArray]:
        """By joint, which components of its reaction are, (6,)."""
        joints = tuple(self.joints.values())
        found = indeterminate(self.plan.graph, self.plan.tree, joints, self.samples)
        return dict(zip(self.joints, found, strict=True))

    @cached_property
    def histories(self) -> Mapping[str, History]:
        """Of wrenches that change with time."""
        return histories(self.plan.graph.mechanism, self.plan.graph.dynamics.wrenches)

    def check_histories(
        self, times: FloatArray, given: Mapping[str, ArrayLike] | None = None
    ) -> None:
        """Raises InputError where wrenches that are not `given` are not known at these times (n,)
        [s].
        """
        for name in self.changing(given):
            self.histories[name](times)

    def changing(self, given: Mapping[str, ArrayLike] | None) -> list[str]:
        """The wrenches that change with time, but for those `given`."""
        wrenches = self.plan.graph.dynamics.wrenches
        return [w.name for w in wrenches if w.inputs and w.name not in (given or {})]

    def rows(self, asked: Asked, reference: float) -> ForceRows:
        """What a kernel has to return. reference: the conditioning of the actuators at home."""
        if (asked, reference) not in self._rows:
            self._rows[asked, reference] = self._made_rows(asked, reference)
        return self._rows[asked, reference]

    def _made_rows(self, asked: Asked, reference: float) -> ForceRows:
        names = {c.name: k for k, c in enumerate(self.plan.graph.coordinates)}
        held = bool(asked.joints or self.loaded) and not asked.least
        preload = {names[name]: value for name, value in asked.preload or ()}
        return ForceRows(
            self.actuated,
            self.plan.idle,
            tuple(self.joints[name] for name in asked.joints),
            self.holding if held else (),
            asked.least,
            asked.energies,
            tuple(preload.get(k, 0.0) for k in self.actuated) if preload else (),
            reference,
            self.loaded,
            wound(self.plan),
        )

    @cached_property
    def loaded(self) -> tuple[Loaded, ...]:
        """Joints whose friction grows with what they carry. Raises InputError where that is
        indeterminate.
        """
        graph = self.plan.graph
        found = []
        for k, lever in graph.dynamics.levers.items():
            name = graph.coordinates[k].name
            if self.indeterminate[name][:2].any():
                place = f"{graph.mechanism.where}: joints.{name}.friction.coefficient"
                what = "a joint whose load is indeterminate for rigid bodies"
                raise InputError(
                    place, what, "coulomb friction, or other kinds of joints (`parakin check`)"
                )
            found.append(Loaded(k, self.joints[name], lever))
        return tuple(found)

    @cached_property
    def reference(self) -> float:
        """The conditioning of the actuators at home."""
        return conditioning_at_home(self.plan, self.actuated)

    @cached_property
    def refusal(self) -> str:
        """Why there are no forces of a mechanism as it is; "" if there are."""
        try:
            self._check(None)
        except InputError as error:
            return str(error)
        return ""

    def asked(
        self,
        *,
        reactions: bool | Sequence[str],
        energies: bool,
        preload: Mapping[str, float] | None,
        indeterminate: str,
    ) -> Asked:
        """What a caller asks for. Raises InputError where it cannot be had."""
        self._check(preload)
        if indeterminate not in NOT_KNOWN:
            raise InputError(
                "indeterminate", repr(indeterminate), nearest(indeterminate, NOT_KNOWN)
            )
        names = tuple(self.joints) if reactions is True else tuple(reactions or ())
        if isinstance(reactions, str):
            names = (reactions,)
        for name in names:
            if name not in self.joints:
                expected = nearest(str(name), self.joints)
                raise InputError("reactions", f"unknown joint {name!r}", expected)
        given = None if preload is None else tuple(preload.items())
        return Asked(names, energies, given, indeterminate == "minimum-norm")

    def _check(self, preload: Mapping[str, float] | None) -> None:
        graph, where = self.plan.graph, self.plan.graph.mechanism.where
        if not graph.dynamics.any:
            expected = "a mass of some body, a spring, friction or a force"
            raise InputError(f"{where}: bodies", "nothing that makes forces", expected)
        actuated, driven = len(self.actuated), len(self.plan.driven)
        if actuated < driven:
            found = f"{actuated} actuated coordinates for {driven} freedoms"
            raise InputError(f"{where}: joints", found, f"{driven}, so that efforts are determined")
        names = [graph.coordinates[k].name for k in self.actuated]
        if actuated > driven and preload is None:
            freedoms = "1 freedom" if driven == 1 else f"{driven} freedoms"
            found = f"{actuated} actuators for {freedoms}: efforts are not determined"
            expected = (
                "a preload, from which they differ least, or none for the least efforts: "
                "preload={} in Python, --preload none on the command line"
            )
            raise InputError(f"{where}: joints", found, expected)
        for name, value in (preload or {}).items():
            if name not in names:
                raise InputError("preload", f"{name!r}, not actuated", nearest(name, names))
            if not is_finite(value):
                raise InputError(f"preload of {name}", repr(value), "a finite number")

    def loads(
        self,
        time: FloatArray | None,
        n: int,
        given: Mapping[str, ArrayLike] | None = None,
        window: Window | None = None,
    ) -> FloatArray:
        """What payloads and wrenches take at n times or poses, (inputs, n).

        time: None where there is none, so that wrenches that change with it must be `given`, by
        name: payloads' masses [kg], wrenches' factors, or all six components, each for all poses
        or one for each. window: of a motion, for all samples of which they are given. Raises
        InputError.
        """
        window = window or Window(0, n)
        dynamics = self.plan.graph.dynamics
        given = dict(given or {})
        rows: list[FloatArray] = []
        for load in dynamics.loads:
            mass = _spread(given.pop(load.name, load.mass.mass), 1, window, load.name)[:, :n]
            if not (mass >= 0.0).all():
                raise InputError(f"loads of {load.name}", "a mass below zero", "zero or more")
            rows.append(mass)
        for wrench in dynamics.wrenches:
            if not wrench.inputs:
                continue
            if wrench.name in given:
                values = _spread(given.pop(wrench.name), wrench.inputs, window, wrench.name)
                rows.append(values[:, :n])
            elif time is None:
                what = "its factor" if wrench.inputs == 1 else "its force and moment"
                found = f"nothing of {wrench.name!r}, which changes with time"
                raise InputError("loads", found, f"{what} at this pose")
            else:
                rows.append(self.histories[wrench.name](time))
        if given:
            known = [load.name for load in dynamics.loads]
            known += [wrench.name for wrench in dynamics.wrenches if wrench.inputs]
            name = next(iter(given))
            expected = nearest(name, known) if known else "none: the file has no payload"
            raise InputError("loads", f"unknown payload or wrench {name!r}", expected)
        return np.concatenate(rows) if rows else np.zeros((0, n))

    def _blank_locked(self, rows: ForceRows, out: FloatArray) -> FloatArray:
        """Where friction under load was not found, as it locks the mechanism, nothing is known."""
        sizes = np.abs(out[rows.effort]).max(axis=0)
        lost = ~(out[rows.friction_step] <= FOUND * (1.0 + sizes))
        return np.where(lost, np.nan, out)

    def forces(self, asked: Asked, rows: ForceRows, out: FloatArray) -> Forces:
        """From a kernel's rows (rows, ...) to what they mean."""
        graph = self.plan.graph
        coordinates = [graph.coordinates[k] for k in self.actuated]
        if rows.loaded:
            out = self._blank_locked(rows, out)
        effort, band, velocity = out[rows.effort], out[rows.band], out[rows.velocity]
        motors = [graph.dynamics.motors.get(k) for k in self.actuated]
        torque, motor_band, speed, current = at_motors(
            motors, effort, band, velocity, out[rows.acceleration]
        )
        reactions = out[rows.reactions].reshape(len(asked.joints), SIZE, *out.shape[1:])
        if asked.joints and not asked.least:
            unknown = np.array([self.indeterminate[name] for name in asked.joints])
            reactions = np.where(
                unknown.reshape(*unknown.shape, *[1] * (out.ndim - 1)), np.nan, reactions
            )
        nothing = np.full(out.shape[1:], np.nan)
        kinetic, potential, lost, applied = out[rows.energy] if asked.energies else [nothing] * 4
        return Forces(
            tuple(c.name for c in coordinates),
            tuple("N m" if c.angle else "N" for c in coordinates),
            asked.joints,
            tuple(graph.coordinates[k].name for k in rows.idle),
            tuple(c.name for c, motor in zip(coordinates, motors, strict=True) if motor),
            effort,
            band,
            effort * velocity,
            _plain(out[rows.conditioning]),
            torque,
            motor_band,
            speed,
            torque * speed,
            current,
            reactions[:, :3],
            reactions[:, 3:],
            _plain(out[rows.imbalance] if asked.joints else nothing),
            out[rows.held],
            *(_plain(each) for each in (kinetic, potential, lost, applied)),
        )


def wound(plan: Plan) -> tuple[int, ...]:
    """Angles with springs or stops that are not driven: these tell one full turn from the next."""
    graph = plan.graph
    passive = graph.dynamics.passive
    held = [k for k, each in passive.items() if (each.stiffness or each.stop)]
    return tuple(k for k in held if graph.coordinates[k].angle and k not in plan.driven)


def is_finite(value: object) -> bool:
    """Whether it is a real number, and finite as a float."""
    try:
        return isinstance(value, numbers.Real) and math.isfinite(value)
    except OverflowError:  # an integer beyond floats
        return False


def _plain(value: FloatArray) -> float | FloatArray:
    return float(value) if np.ndim(value) == 0 else value


def _spread(value: ArrayLike, rows: int, window: Window, name: str) -> FloatArray:
    """One value for all poses, or one for each, as (rows, n), from the first of a window on."""
    n = window.samples
    try:
        if np.iscomplexobj(value):
            raise TypeError
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"loads of {name}", repr(value)[:80], "numbers") from None
    if array.shape in ((), (n,)) and rows == 1:
        array = np.broadcast_to(array, (1, n))
    elif array.shape == (rows,):
        array = np.broadcast_to(array[:, None], (rows, n))
    if array.shape != (rows, n):
        expected = f"one number, or {n}" if rows == 1 else f"({rows},) or ({rows}, {n})"
        raise InputError(f"loads of {name}", f"shape {array.shape}", expected)
    array = array[:, window.start :]
    if not np.isfinite(array).all():
        raise InputError(f"loads of {name}", "numbers that are not finite", "finite ones")
    return np.array(array)
