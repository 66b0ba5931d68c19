"""The command line: parse, call, print. Heavy imports wait until a command needs them."""

from __future__ import annotations

import argparse
import dataclasses
import io
import os
import shlex
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from parakin.cli.grammar import parser
from parakin.errors import InputError, ParakinError, reason

if TYPE_CHECKING:
    import xarray as xr
    from rich.console import Console

    from parakin.model.mechanism import Mechanism
    from parakin.views.extremes import Extremes

_WINDOW = 100_000
_PATIENCE = 1.0  # seconds before there is a progress bar
_WIDE = 1000  # columns; rows of numbers are never folded


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command. Returns the exit code: 0 done, 1 some samples flagged, 2 bad input."""
    try:
        with _stdout_told():
            options = parser().parse_args(arguments)
        typed = sys.argv[1:] if arguments is None else arguments
        options.said = shlex.join(["parakin", *typed])
        return _command(options)
    except ParakinError as error:
        console = _console(stderr=True)
        console.print("error:", style="bold red", end=" ")
        console.print(str(error), markup=False)
        return 2
    except BrokenPipeError:  # the reader of stdout went away, as `head` does: no mistake
        return 0
    except KeyboardInterrupt:
        _console(stderr=True).print("stopped", style="bold red")
        return 130


def _command(options: argparse.Namespace) -> int:
    commands = {
        "list": _list,
        "check": _check,
        "modes": _modes,
        "solve": _solve,
        "plot": _solve,
        "film": _solve,
        "draw": _draw,
        "report": _report,
        "view": _view,
        "export": _export,
    }
    return commands[options.command](options)


@contextmanager
def _stdout_told() -> Iterator[None]:
    """Flushes stdout at the end; raises InputError where it takes no more."""
    try:
        try:
            yield
        finally:
            if sys.stdout is not None:
                sys.stdout.flush()
    except OSError as error:
        with open(os.devnull, "w") as nothing:  # for Python's own flush at exit
            os.dup2(nothing.fileno(), sys.stdout.fileno())
        if isinstance(error, BrokenPipeError):
            raise
        raise InputError("standard output", reason(error), "a stream that takes it all") from None


def _console(*, stderr: bool = False, width: int | None = None) -> Console:
    from rich.console import Console

    if not stderr and isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # as stderr does: ü where there is none
    colours = None if os.environ.get("NO_COLOR") else "auto"
    return Console(
        stderr=stderr,
        width=width,
        color_system=colours,  # type: ignore[arg-type]
        soft_wrap=True,
        highlight=False,
    )


def _list(_: argparse.Namespace) -> int:
    from parakin.files.reading import catalogue, load
    from parakin.views.text import catalogue_table

    entries = {name: (title, ", ".join(load(name).motions)) for name, title in catalogue().items()}
    with _stdout_told():
        width = None if sys.stdout is not None and sys.stdout.isatty() else _WIDE
        _console(width=width).print(catalogue_table(entries))
    return 0


def _parameters(settings: Sequence[str], option: str = "--set") -> dict[str, str]:
    found: dict[str, str] = {}
    for setting in settings:
        name, equals, value = setting.partition("=")
        if not equals or not name.strip() or not value.strip():
            raise InputError(option, repr(setting), "NAME=VALUE")
        found[name.strip()] = value.strip()
    return found


def _load(options: argparse.Namespace) -> Mechanism:
    from parakin.files.reading import load

    return load(options.mechanism, _parameters(options.set), options.loops)


def _export(options: argparse.Namespace) -> int:
    from parakin.exports.suffixes import check_export, export

    for path in check_export(options.output):
        _refuse_input(path, (options.mechanism, options.loops))
    driven = options.driven.split(",") if options.driven else None
    written = export(_load(options), options.output, driven)
    with _stdout_told():
        _console(width=_WIDE).print(f"wrote {', '.join(map(str, written))}", markup=False)
    return 0


def _view(options: argparse.Namespace) -> int:
    from parakin.views.browser.content import Content
    from parakin.views.browser.viewer import exposure, serving

    content = Content(
        options.mechanism,
        _parameters(options.set),
        options.loops,
        tuple(options.motions),
        tuple(options.mesh),
    )
    ends = suppress(KeyboardInterrupt)  # Ctrl-C is how it is meant to end
    with serving(content, options.host, options.port) as viewer, ends, _stdout_told():
        console = _console(width=_WIDE)
        exposed = exposure(options.host)
        if exposed:
            console.print(exposed, style="bold yellow", markup=False)
        console.print(f"{options.mechanism} at {viewer.url} (Ctrl-C ends)", markup=False)
        sys.stdout.flush()
        while True:
            time.sleep(3600)
    return 0


def _check(options: argparse.Namespace) -> int:
    from parakin.analysis.mobility import mobility
    from parakin.files.reading import expanded
    from parakin.kinematics.assembly import assembled
    from parakin.model.graph import graph_of
    from parakin.verbs import check_motions
    from parakin.views.text import mechanism_report

    mechanism = _load(options)
    if options.expand:
        with _stdout_told():
            sys.stdout.write(expanded(options.mechanism, _parameters(options.set), options.loops))
        return 0
    graph = graph_of(mechanism)
    home = assembled(graph)
    found = mobility(graph, home, len(graph.mechanism.driven))
    check_motions(graph, home)
    with _stdout_told():
        _console(width=_WIDE).print(mechanism_report(graph, home.q, found))
    return 0


def _modes(options: argparse.Namespace) -> int:
    from parakin.model.expressions import Parameters
    from parakin.solving.compiler import compile as compile_mechanism
    from parakin.solving.modes import modes
    from parakin.views.text import modes_report

    if not 1 <= options.starts <= 10**6:
        raise InputError("--starts", str(options.starts), "1 to 1,000,000")
    mechanism = _load(options)
    driven = options.driven.split(",") if options.driven else None
    solver = compile_mechanism(mechanism, driven, machine_code=False)
    evaluate = Parameters(mechanism.parameters, mechanism.where).evaluate
    values = {
        name: evaluate(
            text, solver.graph.dimension(solver.graph.index(name, "--at")), f"--at {name}"
        )
        for name, text in _parameters(options.at, "--at").items()
    }
    found = modes(solver, values, options.starts)
    with _stdout_told():
        _console(width=_WIDE).print(modes_report(solver.graph, solver.driven, found))
    return 0


def _draw(options: argparse.Namespace) -> int:
    from parakin.files.writing import check_writable
    from parakin.verbs import draw
    from parakin.views.scheme.scheme import check_scheme

    check_scheme(options.output)
    _refuse_input(options.output, (options.mechanism, options.loops))
    check_writable(options.output)
    draw(_load(options), options.output)
    with _stdout_told():
        _console(width=_WIDE).print(f"wrote {options.output}", markup=False)
    return 0


def _solve(options: argparse.Namespace) -> int:
    from parakin.files import tables
    from parakin.files.writing import check_writable
    from parakin.solving.compiler import compile as compile_mechanism
    from parakin.views import plots
    from parakin.views.text import singularities_report, solve_report

    to_stdout = options.output == "-"
    output = None if options.output is None or to_stdout else Path(options.output)
    if to_stdout and sys.stdout is None:
        raise InputError("standard output", "it is closed", "an open stream for the result")
    if output is not None:
        tables.check_output(output)
    if options.plot is not None:
        plots.check_figure(options.plot)
    if options.animate is not None:
        from parakin.views import film

        film.check_film(options.animate)
    for path in (output, options.plot, options.animate):
        if path is not None:
            _refuse_input(path, (options.mechanism, options.loops, options.motion))
            check_writable(path)
    mechanism = _load(options)
    solver = compile_mechanism(
        mechanism,
        coordinates="all" if options.all else None,
        derivatives=3 if options.jerk else 2,
    )
    motion = solver.motion(
        options.motion, rate=options.rate, smoothing=options.smooth, max_gap=options.max_gap
    )
    animated = options.animate is not None
    bodies = options.bodies or animated
    # The first result of a process pays for imports and compiling, which the time told should not.
    first = dataclasses.replace(motion, count=min(motion.count, 2))
    next(solver.stream(first, bodies=bodies), None)
    run = _Run(motion.count, options.plot is not None or options.singularities or animated)
    windows = run.watched(
        solver.stream(motion, _WINDOW, bodies=bodies, parallel=True),
        _console(stderr=True),
    )
    if animated and not options.bodies:  # the film's alone
        windows = (window.drop_dims(["body", "axis", "quaternion"]) for window in windows)
    if output is not None:
        tables.write(windows, output)
    elif to_stdout:
        with _stdout_told():
            tables.write_csv(windows, sys.stdout)
    else:
        for _ in windows:
            pass
    if run.last is None or run.found is None:
        raise InputError(f"motion {motion.name}", "no samples", "at least one")
    title = f"{mechanism.name}, {motion.name}: {mechanism.title or 'a mechanism'}"
    if options.plot is not None:
        figure = plots.histories(run.picture(), symbols=mechanism.symbols, title=title)
        plots.save(figure, options.plot)
    if animated:
        from parakin.views import film
        from parakin.views.solids.drawing import drawing_of

        film.save(
            drawing_of(solver.graph), run.picture(), options.animate, mechanism.symbols, title
        )
    console = _console(stderr=True, width=_WIDE)
    console.print(title, style="bold", markup=False)
    console.print(solve_report(run.last, run.found, run.seconds))
    if options.singularities:
        from parakin.analysis.singularities import singularities

        picture = run.picture()
        whole = picture.sizes["time"] == motion.count  # a long motion is thinned
        console.print(
            singularities_report(singularities(solver, picture, motion if whole else None))
        )
    written = [str(path) for path in (output, options.plot, options.animate) if path is not None]
    if written:
        console.print(f"wrote {', '.join(written)}", markup=False)
    return 1 if run.found.first_flag is not None else 0


def _report(options: argparse.Namespace) -> int:
    from parakin.files.writing import check_writable
    from parakin.solving.compiler import compile as compile_mechanism
    from parakin.views import report
    from parakin.views.text import flag_words

    report.check_report(options.output)
    _refuse_input(options.output, (options.mechanism, options.loops, options.motion))
    check_writable(options.output)
    solver = compile_mechanism(_load(options), coordinates="all")
    motion = solver.motion(options.motion)
    console = _console(stderr=True, width=_WIDE)
    run = _Run(motion.count, True)
    for _ in run.watched(solver.stream(motion, _WINDOW, parallel=True), console):
        pass
    if run.found is None:
        raise InputError(f"motion {motion.name}", "no samples", "at least one")
    solved = report.Solved(solver, motion, run.picture(), run.found)
    report.write(report.report(solved, options.said, datetime.now().astimezone()), options.output)
    flagged = flag_words(run.found)
    if flagged:
        console.print(flagged, style="bold red", markup=False)
    with _stdout_told():
        _console(width=_WIDE).print(f"wrote {options.output}", markup=False)
    return 1 if flagged else 0


def _refuse_input(path: Path, read: Sequence[str | None]) -> None:
    for name in read:
        if name is None or not os.path.exists(path) or not os.path.exists(name):
            continue
        if os.path.samefile(path, name):
            raise InputError(str(path), "a file that is read", "another one to write")


class _Run:
    """Windows on their way to a file: timed, summed up, shown, and thinned for the figure."""

    def __init__(self, count: int, pictured: bool) -> None:
        self.seconds = 0.0
        self.last: xr.Dataset | None = None
        self.found: Extremes | None = None
        self._count = count
        self._stride = max(1, count // 20_000)
        self._thinned: list[xr.Dataset] | None = [] if pictured else None

    def watched(self, windows: Iterator[xr.Dataset], console: Console) -> Iterator[xr.Dataset]:
        from rich.progress import Progress

        from parakin.views.extremes import extremes
        from parakin.views.thinning import every

        begun = time.perf_counter()
        with ExitStack() as stack:
            bar, task = None, None
            while True:
                start = time.perf_counter()
                window = next(windows, None)
                self.seconds += time.perf_counter() - start
                if window is None:
                    return
                begin = 0 if self.found is None else self.found.samples
                self.found = extremes(window, self.found)
                self.last = window
                if self._thinned is not None:
                    self._thinned.append(every(self._stride, window, begin))
                yield window
                if bar is None and console.is_terminal and time.perf_counter() - begun > _PATIENCE:
                    bar = stack.enter_context(Progress(console=console, transient=True))
                    task = bar.add_task("solving", total=self._count)
                if bar is not None and task is not None:
                    bar.update(task, completed=self.found.samples)

    def picture(self) -> xr.Dataset:
        from parakin.views.thinning import joined

        assert self._thinned is not None
        return joined(self._thinned)
