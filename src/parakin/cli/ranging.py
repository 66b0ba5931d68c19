"""The command that tells how far, how fast and how hard a mechanism moves."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from parakin.cli.inputs import of_driven, solver_for
from parakin.cli.streams import say, tell
from parakin.design.range import range as range_of
from parakin.errors import printable
from parakin.files import tables
from parakin.model.expressions import Parameters
from parakin.model.units import FREQUENCY
from parakin.views import range_plot, range_text
from parakin.views.plots import check_figure, save

if TYPE_CHECKING:
    import xarray as xr


def ranges(options: argparse.Namespace) -> int:
    """Find, write, draw and tell. Returns 1 where there is no pose to count from."""
    if options.output is not None:
        tables.check_table(options.output)
    if options.plot is not None:
        check_figure(options.plot)
    solver = solver_for(options, (options.output, options.plot))
    frequency = None
    if options.frequency is not None:
        mechanism = solver.mechanism
        evaluate = Parameters(mechanism.parameters, mechanism.where).evaluate
        frequency = evaluate(options.frequency, FREQUENCY, "--frequency")
    found = range_of(
        solver,
        of_driven(solver, options.pose, "--from"),
        offsets=of_driven(solver, options.offsets, "--with"),
        pairs=options.pairs,
        frequency=frequency,
        forces=options.forces or bool(options.payload),
        least_conditioning=options.least_conditioning,
    )
    _deliver(found, options)
    return 1 if found.attrs["stopped"] else 0


def _deliver(found: xr.Dataset, options: argparse.Namespace) -> None:
    """Write, draw and tell."""
    written = []
    if options.output is not None:
        written.append(options.output)
        tables.write(range_text.frame(found), found, options.output)
    if options.plot is not None and not found.attrs["stopped"]:
        written.append(options.plot)
        save(range_plot.ranges(found, title=found.attrs["mechanism"]), options.plot)
    say(range_text.range_report(found))
    if options.plot is not None and options.plot not in written:
        tell(printable(f"no range to draw, so {options.plot} was not written"))
    if written:
        tell(printable(f"wrote {', '.join(map(str, written))}"))
