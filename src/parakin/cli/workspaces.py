"""The command that tells where a mechanism can go."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from parakin.cli.inputs import moving, names_in, of_driven, parameters, within
from parakin.cli.streams import say, tell
from parakin.design.workspace import workspace
from parakin.errors import InputError, printable
from parakin.files import surfaces, tables
from parakin.files.writing import check_suffix
from parakin.model.expressions import Parameters
from parakin.model.units import BARE
from parakin.views import workspace_plot, workspace_text
from parakin.views.plots import check_figure, save

if TYPE_CHECKING:
    import xarray as xr

    from parakin.solving.solver import Solver


def workspaces(options: argparse.Namespace) -> int:
    """Find, write, draw and tell. Returns 1 where there is no pose to count from."""
    if options.output is not None:
        check_suffix(options.output, (*tables.SUFFIXES, *surfaces.SUFFIXES), {}, "")
        if not _surface(options):
            tables.check_table(options.output)
    if options.plot is not None:
        check_figure(options.plot)
    solver = moving(options, (options.output, options.plot))
    over = names_in(options.over, "--over")
    if _surface(options) and (options.kind == "orientation" or (over and len(over) != 3)):
        raise InputError(str(options.output), "no surface in space", "three slides to move")
    found = workspace(
        solver,
        of_driven(solver, options.pose, "--from"),
        over=over,
        kind=options.kind,
        orientations=_orientations(solver, options.orientations),
        within=within(solver, options.within, "--within"),
        points=options.points,
        least_conditioning=options.least_conditioning,
        proportions=_proportions(solver, options),
    )
    if _surface(options) and found.sizes["over"] != 3:
        raise InputError(str(options.output), "no surface in space", "three slides to move")
    _deliver(found, options)
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


def _proportions(solver: Solver, options: argparse.Namespace) -> dict[str, float] | None:
    evaluate = Parameters(solver.mechanism.parameters, solver.mechanism.where).evaluate
    texts = parameters(options.proportions, "--proportions")
    found = {name: evaluate(text, BARE, f"--proportions {name}") for name, text in texts.items()}
    return found or None


def _deliver(found: xr.Dataset, options: argparse.Namespace) -> None:
    """Write, draw and tell."""
    written = []
    known = not found.attrs["stopped"]
    if options.output is not None and known:
        written.append(options.output)
        if _surface(options):
            own = found["boundary_connected"].values
            surfaces.write(found["boundary"].values[own], options.output)
        else:
            tables.write(workspace_text.frame(found), found, options.output)
    if options.plot is not None and known:
        written.append(options.plot)
        title = found.attrs["mechanism"]
        save(workspace_plot.workspaces(found, title=title), options.plot)
    say(workspace_text.workspace_report(found))
    if not known and (options.output is not None or options.plot is not None):
        tell("no workspace, so nothing was written")
    if written:
        tell(printable(f"wrote {', '.join(map(str, written))}"))
