"""The command that proves what every pose of a box keeps."""

from __future__ import annotations

import argparse

from parakin.cli.inputs import of_driven, solver_for, within
from parakin.cli.streams import say, tell
from parakin.design.certificate import BOXES, certify
from parakin.errors import printable
from parakin.files import tables
from parakin.views import certificate_text


def certificates(options: argparse.Namespace) -> int:
    """Prove, write and tell. Returns 1 where it is not proved."""
    if options.output is not None:
        tables.check_table(options.output)
    solver = solver_for(options, (options.output,))
    velocities = of_driven(solver, options.velocities, "--velocity", order=1)
    found = certify(
        solver,
        within(solver, options.within, "--within"),
        of_driven(solver, options.pose, "--from"),
        velocities=velocities or None,
        least_conditioning=options.least_conditioning,
        boxes=BOXES if options.boxes is None else options.boxes,
    )
    if options.output is not None:
        tables.write(certificate_text.frame(found), found, options.output)
    say(certificate_text.certificate_report(found))
    if options.output is not None:
        tell(printable(f"wrote {options.output}"))
    return 0 if found.attrs["outcome"] == "proved" else 1
