"""The command that tells where a mechanism can go."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING

from parakin.cli.inputs import names_in, of_driven, parameters, solver_for, within
from parakin.cli.streams import say, tell
from parakin.design.moving import moving
from parakin.design.workspace import workspace
from parakin.errors import InputError, nearest, printable
from parakin.files import surfaces, tables
from parakin.files.writing import check_suffix
from parakin.model.expressions import Parameters
from parakin.model.units import ANGLE, BARE, LENGTH
from parakin.views import workspace_plot, workspace_text
from parakin.views.plots import check_figure, save

if TYPE_CHECKING:
    import xarray as xr

    from parakin.solving.solver import Solver

_LINES = {"stroke": "stroke_left", "conditioning": "conditioning", "effort": "effort"}


def workspaces(options: argparse.Namespace) -> int:
    """Find, write, draw and tell. Returns 1 where there is no pose to count from."""
    if options.output is not None:
        check_suffix(options.output, (*tables.SUFFIXES, *surfaces.SUFFIXES), {}, "")
        if not _surface(options):
            tables.check_table(options.output)
    if options.plot is not None:
        check_figure(options.plot)
    solver = solver_for(options, (options.output, options.plot))
    kind, over = moving(solver, names_in(options.over, "--over"), options.kind)
    lines = _lines(options, over)
    if _surface(options) and (len(over) != 3 or any(map(solver.graph.is_angle, over))):
        what = f"a workspace over {', '.join(over)}, which is no surface in space"
        raise InputError(str(options.output), what, "three slides to move")
    found = workspace(
        solver,
        of_driven(solver, options.pose, "--from"),
        over=over,
        kind=kind,
        orientations=_orientations(solver, options.orientations),
        within=within(solver, options.within, "--within"),
        points=options.points,
        forces=options.forces or bool(options.payload),
        least_conditioning=options.least_conditioning,
        proportions=_proportions(solver, over, options),
    )
    _deliver(found, options, lines)
    return 1 if found.attrs["stopped"] else 0


def _surface(options: argparse.Namespace) -> bool:
    output = options.output
    return output is not None and output.suffix.lower() in surfaces.SUFFIXES


def _orientations(solver: Solver, text: str | None) -> list[dict[str, float]] | None:
    """Angles by driven coordinate, of each orientation. Raises InputError."""
    if text is None:
        return None
    each = [part.strip() for part in text.split(";") if part.strip()]
    return [of_driven(solver, part.split(","), "--orientations") for part in each]


def _proportions(
    solver: Solver, over: Sequence[str], options: argparse.Namespace
) -> dict[str, float] | None:
    """Bare numbers, or, where slides and angles are mixed, lengths and angles [SI]."""
    evaluate = Parameters(solver.mechanism.parameters, solver.mechanism.where).evaluate
    texts = parameters(options.proportions, "--proportions")
    for name in texts:
        if name not in over:
            raise InputError("--proportions", repr(name), nearest(name, over))
    angles = {name: solver.graph.is_angle(name) for name in over}
    mixed = len(set(angles.values())) > 1
    found = {}
    for name, text in texts.items():
        dimension = (LENGTH, ANGLE)[angles[name]] if mixed else BARE
        found[name] = evaluate(text, dimension, f"--proportions {name}")
    return found or None


def _lines(options: argparse.Namespace, over: Sequence[str]) -> str | None:
    """What the lines in the figure are of, if it is said. Raises InputError."""
    if options.lines is None:
        return None
    if options.lines not in _LINES:
        raise InputError("--lines", repr(options.lines), nearest(options.lines, _LINES))
    if options.plot is None:
        raise InputError("--lines", "no figure", "--plot FILE, to draw them in")
    if len(over) != 2:
        raise InputError("--lines", f"{len(over)} coordinates to move", "two, as of a slice")
    return _LINES[options.lines]


def _deliver(found: xr.Dataset, options: argparse.Namespace, lines: str | None) -> None:
    """Write, draw and tell."""
    written = []
    known = not found.attrs["stopped"]
    figure = None
    if options.plot is not None and known:
        figure = workspace_plot.workspaces(found, title=found.attrs["mechanism"], lines=lines)
    if options.output is not None and known:
        written.append(options.output)
        if _surface(options):
            own = found["boundary_connected"].values
            surfaces.write(found["boundary"].values[own], options.output)
        else:
            tables.write(workspace_text.frame(found), found, options.output)
    if figure is not None:
        written.append(options.plot)
        save(figure, options.plot)
    say(workspace_text.workspace_report(found))
    if not known and (options.output is not None or options.plot is not None):
        tell("no workspace, so nothing was written")
    if written:
        tell(printable(f"wrote {', '.join(map(str, written))}"))
