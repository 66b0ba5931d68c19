"""What commands take: a mechanism with its parameters, and files that may be written."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from parakin.cli.streams import tell, waiting
from parakin.errors import InputError

if TYPE_CHECKING:
    from parakin.model.graph import Graph
    from parakin.model.mechanism import Mechanism
    from parakin.solving.solver import Solver


def parameters(settings: Sequence[str], option: str = "--set") -> dict[str, str]:
    """Values by name of `NAME=VALUE` settings. Raises InputError on any other form."""
    found: dict[str, str] = {}
    for setting in settings:
        name, equals, value = setting.partition("=")
        if not equals or not name.strip() or not value.strip():
            raise InputError(option, repr(setting), "NAME=VALUE")
        if name.strip() in found and option != "--set":
            raise InputError(option, f"{name.strip()} twice", "one value each")
        found[name.strip()] = value.strip()
    return found


def load_mechanism(options: argparse.Namespace, *, warns: bool = True) -> Mechanism:
    """The mechanism that the options name. If they set parameters, what is likely a slip of units
    is told, unless the command `warns` not. Raises InputError.
    """
    from parakin.files.reading import load

    mechanism = load(options.mechanism, parameters(options.set), options.loops)
    for text in getattr(options, "payload", ()):
        mechanism = mechanism.with_payload(text)
    if options.set and warns:
        tell_slips(mechanism)
    return mechanism


def tell_slips(mechanism: Mechanism) -> None:
    """Tell on stderr what is likely a slip of units, as `parakin check` does."""
    from parakin.analysis.diagnosis import unit_slips

    tell(*(f"warning: {each}" for each in unit_slips(mechanism)), style="bold yellow")


def solver_for(options: argparse.Namespace, paths: Iterable[Path | None]) -> Solver:
    """A solver of what the options name for the coordinates that they move, by default the
    platform's, once files that may be written have been checked. Raises InputError, AssemblyError,
    DrivenError.
    """
    from parakin.design.choice import driven_for
    from parakin.solving.compiler import compile as compile_mechanism

    check_outputs(options, [path for path in paths if path is not None])
    mechanism = load_mechanism(options)
    driven = names_in(options.driven, "--driven") or driven_for(mechanism)
    with waiting("compiling"):
        return compile_mechanism(mechanism, driven)


def preloads(graph: Graph, settings: Sequence[str]) -> dict[str, float] | None:
    """Efforts by coordinate [N or N m] of `NAME=VALUE` settings, of which "none" names none; None
    if there are no settings. Raises InputError.
    """
    from parakin.model.expressions import Parameters
    from parakin.model.units import FORCE, TORQUE

    if not settings:
        return None
    if "none" in settings and len(settings) > 1:
        raise InputError("--preload", "none and others", "none alone, or NAME=VALUE")
    texts = parameters([text for text in settings if text != "none"], "--preload")
    evaluate = Parameters(graph.mechanism.parameters, graph.mechanism.where).evaluate
    return {
        name: evaluate(text, TORQUE if graph.is_angle(name) else FORCE, f"--preload {name}")
        for name, text in texts.items()
    }


def values_of(graph: Graph, settings: Sequence[str], option: str, order: int) -> dict[str, float]:
    """Positions (order 0) or rates (1) by coordinate [SI] of `NAME=VALUE` settings. Raises
    InputError.
    """
    from parakin.model.expressions import Parameters
    from parakin.model.units import ANGLE, ANGULAR_VELOCITY, LENGTH, VELOCITY

    evaluate = Parameters(graph.mechanism.parameters, graph.mechanism.where).evaluate
    angles, lengths = ((ANGLE, LENGTH), (ANGULAR_VELOCITY, VELOCITY))[order]
    return {
        name: evaluate(text, angles if graph.is_angle(name) else lengths, f"{option} {name}")
        for name, text in parameters(settings, option).items()
    }


def names_in(text: str | None, option: str) -> list[str] | None:
    """Names separated by commas, if any are given. Raises InputError where one is missing."""
    if text is None:
        return None
    names = [name.strip() for name in text.split(",")]
    if not all(names):
        raise InputError(option, repr(text), "names separated by commas")
    return names


def of_driven(
    solver: Solver, settings: Sequence[str], option: str, order: int = 0
) -> dict[str, float]:
    """Positions, or rates (order 1), by driven coordinate [SI]. Raises InputError."""
    check_driven(solver, parameters(settings, option), option)
    return values_of(solver.graph, settings, option, order)


def check_driven(solver: Solver, names: Iterable[str], option: str) -> None:
    """Raises InputError on names of anything but driven coordinates."""
    from parakin.design import asked

    for name in names:
        asked.check_driven(solver, name, option)


def within(solver: Solver, settings: Sequence[str], option: str) -> dict[str, tuple[float, float]]:
    """Both ends, by driven coordinate [SI], of `NAME=LOW..HIGH` settings. Raises InputError."""
    from parakin.model.expressions import Parameters
    from parakin.model.units import ANGLE, LENGTH

    found = {}
    evaluate = Parameters(solver.mechanism.parameters, solver.mechanism.where).evaluate
    texts = parameters(settings, option)
    check_driven(solver, texts, option)
    for name, text in texts.items():
        low, dots, high = text.partition("..")
        if not dots:
            raise InputError(option, repr(text), "LOW..HIGH, e.g. '-0.2 m..0.3 m'")
        dimension = ANGLE if solver.graph.is_angle(name) else LENGTH
        ends = [evaluate(end.strip(), dimension, f"{option} {name}") for end in (low, high)]
        found[name] = (ends[0], ends[1])
    return found


def check_outputs(options: argparse.Namespace, paths: Iterable[Path]) -> None:
    """Raises InputError on files that cannot be written, and on those that the command reads."""
    from parakin.files.writing import check_writable

    read = [options.mechanism, options.loops]
    read += [getattr(options, name, None) for name in ("motion", "efforts")]
    for path in paths:
        _refuse_input(path, read)
        check_writable(path)


def _refuse_input(path: Path, read: Sequence[str | None]) -> None:
    for name in read:
        if name is None or not os.path.exists(path) or not os.path.exists(name):
            continue
        if os.path.samefile(path, name):
            raise InputError(str(path), "a file that the command reads", "another file to write")
