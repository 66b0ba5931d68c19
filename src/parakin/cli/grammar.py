"""The grammar of the command line: commands and their options."""

from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import NoReturn, TypeAlias

from parakin.cli.design_options import (
    add_certify_options,
    add_range_options,
    add_workspace_options,
)
from parakin.cli.options import add_driven, add_mechanism, add_payload, add_settings, number
from parakin.errors import InputError, ParakinError, nearest
from parakin.version import __version__

_COMMANDS = (
    "list",
    "check",
    "modes",
    "range",
    "workspace",
    "certify",
    "solve",
    "plot",
    "film",
    "simulate",
    "view",
    "draw",
    "report",
    "export",
)
_EPILOG = """examples:
  parakin solve flight-simulator general -o general.csv --plot general.png
  parakin check flight-simulator --set l3=1.35
  parakin solve my-robot.toml samples.csv -o -
  parakin view flight-simulator
  parakin report flight-simulator general -o general.html

exit codes: 0 done, 1 some samples are flagged, 2 bad input, 130 stopped by Ctrl-C"""


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        """Raise an error of one line, as for any other bad input, instead of printing usage."""
        unknown = re.match(r"argument COMMAND: invalid choice: '(.*?)'", message)
        if unknown:
            name = unknown[1]
            raise InputError("command", f"unknown name {name!r}", nearest(name, _COMMANDS))
        raise ParakinError(f"{message}; see {self.prog} --help")


_Commands: TypeAlias = "argparse._SubParsersAction[_Parser]"


def parser() -> argparse.ArgumentParser:
    """The parser. Parsing raises ParakinError on bad input."""
    top = _Parser(
        prog="parakin",
        description="Parallel mechanisms: positions, velocities and accelerations of every joint "
        "and body along a motion, and the forces behind it.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    top.add_argument("--version", action="version", version=f"parakin {__version__}")
    commands = top.add_subparsers(dest="command", required=True, metavar="COMMAND")
    commands.add_parser("list", help="mechanisms of the catalogue, and their motions")
    adding = (
        _add_check,
        _add_modes,
        _add_range,
        _add_workspace,
        _add_certify,
        _add_solve,
        _add_pictures,
        _add_simulate,
        _add_view,
        _add_draw,
        _add_report,
        _add_export,
    )
    for add in adding:
        add(commands)
    return top


def _add_check(commands: _Commands) -> None:
    check = commands.add_parser("check", help="assemble a mechanism and explain its mobility")
    add_mechanism(check)
    check.add_argument(
        "--expand", action="store_true", help="print the file, repeated limbs written out"
    )


def _add_modes(commands: _Commands) -> None:
    modes = commands.add_parser(
        "modes", help="search for the assembly modes at given driven values"
    )
    add_mechanism(modes)
    add_driven(modes, "driven coordinates")
    add_settings(modes, "--at", "a driven value other than home's: a quantity such as '20 mm'")
    modes.add_argument("--starts", metavar="N", type=int, default=8192, help="random starts (8192)")


def _add_range(commands: _Commands) -> None:
    text = "how far, how fast and how hard it moves from a pose, and what stops it"
    add_range_options(commands.add_parser("range", help=text))


def _add_workspace(commands: _Commands) -> None:
    text = "where the platform can go, its boundary, and what limits it where"
    add_workspace_options(commands.add_parser("workspace", help=text))


def _add_certify(commands: _Commands) -> None:
    text = "prove that every pose of a box keeps all limits, or find one that does not"
    add_certify_options(commands.add_parser("certify", help=text))


def _add_solve(commands: _Commands) -> None:
    solve = commands.add_parser("solve", help="solve a mechanism along a motion")
    add_mechanism(solve)
    _add_motion(solve)
    solve.add_argument(
        "-o", "--output", metavar="FILE", help="write .csv, .nc or .parquet; '-' is CSV to stdout"
    )
    solve.add_argument("--plot", metavar="FILE", type=Path, help="figure: .png, .svg or .pdf")
    solve.add_argument("--animate", metavar="FILE", type=Path, help="film: .mp4 or .gif")
    solve.add_argument(
        "--singularities",
        action="store_true",
        help="how near the motion comes to singularities of each kind",
    )
    solve.add_argument("--jerk", action="store_true", help="the third derivative too")
    solve.add_argument("--bodies", action="store_true", help="every body's motion too")
    solve.add_argument("--all", action="store_true", help="joints outside the tree too")
    _add_forces(solve)
    solve.add_argument("--energies", action="store_true", help="energies and lost power too")
    solve.set_defaults(coordinates=None)
    _add_sampling(solve)


def _add_pictures(commands: _Commands) -> None:
    """`plot` and `film`: only the picture that `solve` can add to its other outputs."""
    unasked = dict.fromkeys(("output", "plot", "animate"))
    unasked |= dict.fromkeys(("singularities", "jerk", "bodies", "all", "energies"), False)
    unasked["coordinates"] = None
    pictures = (
        ("plot", "plot", "plot a motion's time histories", "figure: .png, .svg or .pdf"),
        ("film", "animate", "film a motion", "film: .mp4 or .gif"),
    )
    for name, dest, does, file in pictures:
        picture = commands.add_parser(name, help=does)
        add_mechanism(picture)
        _add_motion(picture)
        _add_output(picture, file, dest)
        _add_sampling(picture)
        _add_forces(picture)
        picture.set_defaults(**unasked | {dest: None})
        if name == "plot":
            picture.add_argument(
                "--coordinates",
                metavar="NAMES",
                help="coordinates to plot, comma-separated; the actuated ones by default",
            )


def _add_simulate(commands: _Commands) -> None:
    simulate = commands.add_parser("simulate", help="the motion that forces make")
    add_mechanism(simulate)
    simulate.add_argument(
        "--duration", metavar="TIME", default="1 s", help="how long, e.g. '500 ms' (1 s)"
    )
    simulate.add_argument(
        "--efforts",
        metavar="FILE",
        help="efforts of the actuators: a TOML table `efforts` of numbers, laws and servos, or a "
        "CSV file; none by default",
    )
    simulate.add_argument(
        "--hold",
        action="store_true",
        help="actuators without efforts of their own keep those that hold the start",
    )
    for name, what in (("start", "position"), ("velocity", "rate")):
        add_settings(simulate, f"--{name}", f"{what} of a driven coordinate to begin with")
    load = "another mass of a payload, by its name ('payload' of --payload)"
    add_settings(simulate, "--load", load)
    simulate.add_argument("--method", choices=("dop853", "radau", "taylor"), default="dop853")
    simulate.add_argument("--rtol", metavar="PART", type=number, help="tolerance (1e-9)")
    simulate.add_argument("--end-at-limits", action="store_true", help="tell nothing beyond")
    simulate.add_argument(
        "-o", "--output", metavar="FILE", help="write .csv, .nc or .parquet; '-' is CSV to stdout"
    )
    simulate.add_argument("--plot", metavar="FILE", type=Path, help="figure: .png, .svg or .pdf")
    simulate.add_argument("--animate", metavar="FILE", type=Path, help="film: .mp4 or .gif")
    simulate.add_argument("--bodies", action="store_true", help="every body's motion too")
    simulate.add_argument("--all", action="store_true", help="joints outside the tree too")
    simulate.add_argument("--rate", metavar="HZ", type=number, help="samples per second (1000)")
    add_payload(simulate)


def _add_view(commands: _Commands) -> None:
    view = commands.add_parser("view", help="see a mechanism move in the browser")
    add_mechanism(view)
    view.add_argument("motions", metavar="MOTION", nargs="*", help="motions in TOML or CSV files")
    mesh = "a mesh that the mechanism's file names; no other is read"
    add_settings(view, "--mesh", mesh, metavar="FILE")
    add_payload(view)
    view.add_argument("--host", metavar="ADDRESS", default="127.0.0.1", help="address to serve at")
    view.add_argument("--port", metavar="N", type=int, default=8080, help="port to serve at (8080)")


def _add_draw(commands: _Commands) -> None:
    draw = commands.add_parser("draw", help="draw a mechanism's kinematic scheme")
    add_mechanism(draw)
    _add_output(draw, "scheme: .svg, .pdf or .png")


def _add_report(commands: _Commands) -> None:
    report = commands.add_parser("report", help="write a page about a motion, to send or print")
    add_mechanism(report)
    _add_motion(report)
    _add_output(report, "page: .html")
    _add_preload(report)
    add_payload(report)


def _add_export(commands: _Commands) -> None:
    export = commands.add_parser("export", help="write a mechanism for other programs")
    add_mechanism(export)
    export.add_argument(
        "output",
        metavar="FILE",
        type=Path,
        help="model.xml (MuJoCo), model.urdf (with model.loops.yaml) or kernel.c (with kernel.h "
        "and kernel_test.c)",
    )
    add_driven(export, "driven coordinates, the input of the C code")
    export.add_argument("--forces", action="store_true", help="efforts in the C code too")
    _add_preload(export)
    add_payload(export)


def _add_forces(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--forces", action="store_true", help="efforts and power of the actuators, drives' torques"
    )
    command.add_argument(
        "--reactions",
        metavar="JOINTS",
        nargs="?",
        const=True,
        default=False,
        help="forces in these joints too, comma-separated; in all joints by default",
    )
    _add_preload(command)
    add_payload(command)


def _add_preload(command: argparse.ArgumentParser) -> None:
    text = (
        "effort that redundant actuators are to be near, e.g. --preload 'P1=200 N'; "
        "--preload none for the least efforts"
    )
    add_settings(command, "--preload", text)


def _add_motion(command: argparse.ArgumentParser) -> None:
    command.add_argument("motion", metavar="MOTION", help="a motion's name, or a TOML or CSV file")


def _add_output(command: argparse.ArgumentParser, what: str, dest: str = "output") -> None:
    command.add_argument(
        "-o", "--output", dest=dest, metavar="FILE", type=Path, required=True, help=what
    )


def _add_sampling(command: argparse.ArgumentParser) -> None:
    command.add_argument("--rate", metavar="HZ", type=number, help="samples per second, for laws")
    command.add_argument(
        "--smooth", metavar="SIGMA", type=number, help="noise of sampled positions, SI"
    )
    command.add_argument(
        "--max-gap", metavar="S", type=number, help="longest step allowed between samples"
    )
