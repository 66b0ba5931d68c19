"""Commands that solve a mechanism along a motion."""

from __future__ import annotations

import argparse
import dataclasses
import sys
from collections.abc import Iterator, Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from parakin.cli.inputs import check_outputs, load_mechanism, parameters, preloads, values_of
from parakin.cli.run import Run
from parakin.cli.streams import WIDE, console, flushed_stdout, say, tell, waiting
from parakin.errors import InputError, printable
from parakin.files import datasets
from parakin.labelled import Labelled
from parakin.model.expressions import Parameters
from parakin.model.units import MASS, TIME
from parakin.motion.motion import Motion
from parakin.solving.compiler import compile as compile_mechanism
from parakin.solving.solver import Solver
from parakin.views import plots
from parakin.views.extremes import extremes
from parakin.views.force_text import drift_words, forces_report, warnings
from parakin.views.text import flag_words, singularities_report, solve_report

if TYPE_CHECKING:
    from rich.console import RenderableType

    from parakin.labelled import Result

_WINDOW = 100_000  # samples
_RATE, _RTOL = 1000.0, 1e-9  # of simulations [Hz]


def solve(options: argparse.Namespace) -> int:
    """Solve, write and summarise; `plot` and `film` are this with other defaults."""
    written = _checked_outputs(options)
    mechanism = load_mechanism(options)
    with waiting("compiling"):
        solver = compile_mechanism(
            mechanism,
            coordinates="all" if options.all or options.coordinates is not None else None,
            derivatives=3 if options.jerk else 2,
        )
    motion = solver.motion(
        options.motion, rate=options.rate, smoothing=options.smooth, max_gap=options.max_gap
    )
    plotted = (
        None
        if options.coordinates is None
        else [name.strip() for name in options.coordinates.split(",")]
    )
    if plotted is not None:
        plots.check_coordinates(plotted, solver.coordinates)
    pictured = options.plot is not None or options.animate is not None or options.singularities
    run = Run(motion, pictured=pictured)
    bodies = options.bodies or options.animate is not None
    windows = _windows(solver, motion, {"bodies": bodies} | _forces(solver, options))
    _write_result(run.watched(windows, console(stderr=True)), options)
    (last, extremes), mechanism = run.totals(), solver.mechanism
    title = ": ".join(filter(None, (f"{mechanism.name}, {motion.name}", mechanism.title)))
    if pictured:
        _draw_pictures(solver, run.picture(), title, options, plotted)
    tell(title, style="bold")
    tell(solve_report(last, extremes, run.seconds))
    if extremes.forces is not None:
        tell(forces_report(extremes.forces, solver.graph))
    if options.singularities:
        tell(_singularities(solver, motion, run.picture()))
    if written:
        tell(printable(f"wrote {', '.join(map(str, written))}"))
    unknown = extremes.forces is not None and extremes.forces.unknown
    return 1 if unknown or extremes.first_flag is not None else 0


def simulate(options: argparse.Namespace) -> int:
    """Simulate, write and summarise."""
    written = _checked_outputs(options)
    mechanism, chosen = load_mechanism(options), "all" if options.all else None
    with waiting("compiling"):
        solver = compile_mechanism(mechanism, coordinates=chosen)
    if solver.plan.idle:  # which move as they like
        idle = [solver.graph.coordinates[k].name for k in solver.plan.idle]
        solver = compile_mechanism(mechanism, [*solver.driven, *idle], coordinates=chosen)
    evaluate = Parameters(solver.mechanism.parameters, solver.mechanism.where).evaluate
    result = solver.simulate(
        evaluate(options.duration, TIME, "--duration"),
        options.efforts,
        start=values_of(solver.graph, options.start, "--start", 0),
        velocity=values_of(solver.graph, options.velocity, "--velocity", 1),
        hold=options.hold,
        loads={
            name: evaluate(mass, MASS, f"--load {name}")
            for name, mass in parameters(options.load, "--load").items()
        },
        method=options.method,
        rtol=_RTOL if options.rtol is None else options.rtol,
        end_at_limits=options.end_at_limits,
        rate=_RATE if options.rate is None else options.rate,
        bodies=options.bodies or options.animate is not None,
    )
    found = extremes(result)
    _write_result(iter([result]), options)
    title = ": ".join(filter(None, (f"{solver.mechanism.name}, simulated", solver.mechanism.title)))
    if options.plot is not None or options.animate is not None:
        _draw_pictures(solver, result, title, options, None)
    tell(title, style="bold")
    tell(solve_report(result, found, None))
    if found.forces is not None:
        tell(forces_report(found.forces, solver.graph))
    tell(drift_words(result))
    if written:
        tell(printable(f"wrote {', '.join(map(str, written))}"))
    return 1 if found.first_flag is not None else 0


def _checked_outputs(options: argparse.Namespace) -> list[Path]:
    """The files to be written. Raises InputError where one cannot be, before any work."""
    if options.output == "-" and sys.stdout is None:
        raise InputError("standard output", "it is closed", "an open stream for the result")
    paths = []
    if options.output not in (None, "-"):
        paths.append(Path(options.output))
        datasets.check_output(paths[0])
    if options.plot is not None:
        plots.check_figure(options.plot)
        paths.append(options.plot)
    if options.animate is not None:
        from parakin.views import film

        film.check_film(options.animate)
        paths.append(options.animate)
    check_outputs(options, paths)
    return paths


def _forces(solver: Solver, options: argparse.Namespace) -> dict[str, Any]:
    """What of forces is asked for, as arguments of `Solver.stream`."""
    reactions = options.reactions
    if isinstance(reactions, str):
        reactions = [name.strip() for name in reactions.split(",")]
    return {
        "forces": options.forces or bool(options.payload or options.preload),
        "reactions": reactions,
        "energies": options.energies,
        "preload": preloads(solver.graph, options.preload),
    }


def _windows(solver: Solver, motion: Motion, asked: dict[str, Any]) -> Iterator[Labelled]:
    windows = solver.windows(motion, _WINDOW, **asked, parallel=True)
    # The first result of a process pays for imports and compiling, which the reported time
    # should not.
    first = dataclasses.replace(motion, count=min(motion.count, 2))
    next(solver.windows(first, 2, **asked), None)
    return windows


def _write_result(windows: Iterator[Result], options: argparse.Namespace) -> None:
    if options.animate is not None and not options.bodies:  # only the film needs them
        windows = map(_without_bodies, windows)
    if options.output == "-":
        with flushed_stdout():
            datasets.write_csv(windows, sys.stdout)
    elif options.output is not None:
        datasets.write(windows, Path(options.output))
    else:
        for _ in windows:
            pass


def _without_bodies(window: Result) -> Result:
    """The axes are those of reactions too."""
    return window.drop_dims(["body", "quaternion", *(["axis"] if "joint" not in window else [])])


def _draw_pictures(
    solver: Solver,
    result: Result,
    title: str,
    options: argparse.Namespace,
    plotted: Sequence[str] | None,
) -> None:
    symbols = solver.mechanism.symbols
    if options.plot is not None:
        plots.save(plots.histories(result, plotted, symbols, title=title), options.plot)
    if options.animate is not None:
        from parakin.views import film
        from parakin.views.solids.drawing import drawing_of

        if isinstance(result, Labelled):
            result = result.dataset()
        film.save(drawing_of(solver.graph), result, options.animate, symbols, title)


def _singularities(solver: Solver, motion: Motion, picture: Labelled) -> RenderableType:
    from parakin.analysis.singularities import singularities

    whole = picture.sizes["time"] == motion.count  # the picture of a long motion is thinned
    return singularities_report(singularities(solver, picture.dataset(), motion if whole else None))


def report(options: argparse.Namespace) -> int:
    """Write a page about a motion."""
    from parakin.views import report as reports

    reports.check_report(options.output)
    check_outputs(options, [options.output])
    mechanism = load_mechanism(options)
    with waiting("compiling"):
        solver = compile_mechanism(mechanism, coordinates="all")
    motion = solver.motion(options.motion)
    screen = console(stderr=True, width=WIDE)
    run = Run(motion, pictured=True)
    asked: dict[str, Any] = {"preload": preloads(solver.graph, options.preload)}
    if options.preload or not solver.no_forces:
        asked |= {"forces": True, "reactions": True}
    for _ in run.watched(solver.windows(motion, _WINDOW, **asked, parallel=True), screen):
        pass
    _, extremes = run.totals()
    solved = reports.Solved(solver, motion, run.picture().dataset(), extremes)
    page = reports.report(solved, options.typed, datetime.now().astimezone())
    reports.write(page, options.output)
    flagged = flag_words(extremes)
    if flagged:
        tell(flagged, style="bold red")
    if extremes.forces is not None:
        tell(*warnings(extremes.forces, solver.graph), style="bold red")
    say(printable(f"wrote {options.output}"))
    unknown = extremes.forces is not None and extremes.forces.unknown
    return 1 if unknown or flagged else 0
