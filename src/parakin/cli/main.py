"""The command line: parse, call, print. Heavy imports wait until a command needs them."""

from __future__ import annotations

import gc
import shlex
import sys
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

from parakin.cli.interrupts import Interrupts
from parakin.cli.streams import WIDE, console, flushed_stdout, hold_closed, say, tell
from parakin.errors import InputError, ParakinError, printable

if TYPE_CHECKING:
    import argparse

_SELDOM = 100_000  # new objects before cycles are looked for; by default 700, which takes a tenth


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command. Returns the exit code: 0 done, 1 some samples flagged, 2 bad input, 130
    stopped by Ctrl-C.
    """
    if arguments is None:  # a process of its own, whose imports and plans stay to its end
        gc.set_threshold(_SELDOM)
    with Interrupts(last=arguments is None) as interrupts:
        try:
            return _run(arguments)
        except Exception:
            if not interrupts.came:
                raise
        except KeyboardInterrupt:
            pass
    tell("stopped", style="bold red")
    return 130


def _run(arguments: Sequence[str] | None) -> int:
    try:
        from parakin.cli.grammar import parser

        hold_closed()
        with flushed_stdout():
            options = parser().parse_args(arguments)
        typed = sys.argv[1:] if arguments is None else arguments
        options.typed = printable(shlex.join(["parakin", *typed]))
        return _command(options)
    except ParakinError as error:
        from rich.text import Text

        tell(Text.assemble(("error:", "bold red"), " ", str(error)))
        return 2
    except BrokenPipeError:  # the reader of stdout has gone, as `head` does: not an error
        return 0


def _command(options: argparse.Namespace) -> int:
    commands = {
        "list": _list,
        "check": _check,
        "modes": _modes,
        "range": _range,
        "workspace": _workspace,
        "certify": _certify,
        "solve": _solve,
        "plot": _solve,  # with other defaults
        "film": _solve,
        "simulate": _simulate,
        "draw": _draw,
        "report": _report,
        "view": _view,
        "export": _export,
    }
    return commands[options.command](options)


def _list(_: argparse.Namespace) -> int:
    from parakin.files.reading import catalogue, load
    from parakin.views.text import catalogue_table

    entries = {name: (title, ", ".join(load(name).motions)) for name, title in catalogue().items()}
    with flushed_stdout():
        width = None if sys.stdout is not None and sys.stdout.isatty() else WIDE
        console(width=width).print(catalogue_table(entries))
    return 0


def _simulate(options: argparse.Namespace) -> int:
    from parakin.cli.solving import simulate

    return simulate(options)


def _export(options: argparse.Namespace) -> int:
    from parakin.cli.inputs import check_outputs, load_mechanism, names_in, preloads
    from parakin.exports.export import check_export, export
    from parakin.model.evaluation import graph_of

    check_outputs(options, check_export(options.output))
    driven = names_in(options.driven, "--driven")
    mechanism = load_mechanism(options)
    preload = preloads(graph_of(mechanism), options.preload) if options.preload else None
    written = export(mechanism, options.output, driven, forces=options.forces, preload=preload)
    say(printable(f"wrote {', '.join(map(str, written))}"))
    return 0


def _view(options: argparse.Namespace) -> int:
    from parakin.cli.inputs import parameters, tell_slips
    from parakin.views.browser.content import Content
    from parakin.views.browser.viewer import exposure, serving

    content = Content(
        options.mechanism,
        parameters(options.set),
        options.loops,
        tuple(options.motions),
        tuple(options.mesh),
        tuple(options.payload),
    )
    served = False
    try:
        with serving(content, options.host, options.port) as viewer, flushed_stdout():
            served = True
            screen = console(width=WIDE)
            exposed = exposure(options.host)
            if exposed:
                screen.print(exposed, style="bold yellow", markup=False)
            tell(*content.findings(viewer.first), style="bold yellow")
            if options.set:
                tell_slips(viewer.first.mechanism)
            screen.print(f"{options.mechanism} at {viewer.url} (Ctrl-C ends)", markup=False)
            sys.stdout.flush()
            while True:
                time.sleep(3600)
    except KeyboardInterrupt:
        if not served:
            raise
    return 0  # Ctrl-C is the usual way to end it


def _check(options: argparse.Namespace) -> int:
    from parakin.analysis.diagnosis import diagnosis
    from parakin.cli.inputs import load_mechanism, parameters
    from parakin.files.reading import expanded
    from parakin.views.text import mechanism_report

    mechanism = load_mechanism(options, warns=False)  # the report does
    if options.expand:
        with flushed_stdout():
            sys.stdout.write(expanded(options.mechanism, parameters(options.set), options.loops))
        return 0
    found = diagnosis(mechanism)
    say(mechanism_report(found))
    if found.refusal is not None:
        raise found.refusal
    return 1 if found.warnings else 0


def _modes(options: argparse.Namespace) -> int:
    from parakin.cli.inputs import load_mechanism, names_in, parameters
    from parakin.model.expressions import Parameters
    from parakin.solving.compiler import compile as compile_mechanism
    from parakin.solving.modes import modes
    from parakin.views.text import modes_report

    if not 1 <= options.starts <= 10**6:
        raise InputError("--starts", str(options.starts), "1 to 1,000,000")
    mechanism = load_mechanism(options)
    driven = names_in(options.driven, "--driven")
    solver = compile_mechanism(mechanism, driven, machine_code=False)
    evaluate = Parameters(mechanism.parameters, mechanism.where).evaluate
    values = {
        name: evaluate(
            text, solver.graph.dimension(solver.graph.index(name, "--at")), f"--at {name}"
        )
        for name, text in parameters(options.at, "--at").items()
    }
    found = modes(solver, values, options.starts)
    say(modes_report(solver.graph, solver.driven, found))
    return 0


def _range(options: argparse.Namespace) -> int:
    from parakin.cli.ranging import ranges

    return ranges(options)


def _workspace(options: argparse.Namespace) -> int:
    from parakin.cli.workspaces import workspaces

    return workspaces(options)


def _certify(options: argparse.Namespace) -> int:
    from parakin.cli.certificates import certificates

    return certificates(options)


def _draw(options: argparse.Namespace) -> int:
    from parakin.cli.inputs import check_outputs, load_mechanism
    from parakin.verbs import draw
    from parakin.views.scheme.scheme import check_scheme

    check_scheme(options.output)
    check_outputs(options, [options.output])
    draw(load_mechanism(options), options.output)
    say(printable(f"wrote {options.output}"))
    return 0


def _solve(options: argparse.Namespace) -> int:
    from parakin.cli.solving import solve

    return solve(options)


def _report(options: argparse.Namespace) -> int:
    from parakin.cli.solving import report

    return report(options)
