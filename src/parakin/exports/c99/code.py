"""C code for a mechanism and a choice of driven coordinates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from parakin.errors import AssemblyError
from parakin.exports.c99 import efforts
from parakin.exports.c99.comparison import comparison
from parakin.exports.c99.header import header
from parakin.exports.c99.kernel import kernel
from parakin.exports.c99.names import Names
from parakin.model.mechanism import Mechanism
from parakin.solving.compiler import compile as compile_mechanism


def c_code(
    mechanism: Mechanism,
    stem: str,
    driven: Sequence[str] | None = None,
    *,
    forces: bool = False,
    preload: Mapping[str, float] | None = None,
) -> tuple[str, str, str]:
    """The kernel, its header and a test program, as text; functions are named after `stem`.

    driven: the driven coordinates, by default the mechanism's own. forces: a function of the
    actuators' efforts too. preload: efforts [N or N m] that those of redundant actuators are to be
    nearest to. Raises InputError, AssemblyError, DrivenError.
    """
    solver = compile_mechanism(mechanism, driven, machine_code=False)
    if solver.plan.graph.twins and solver.iterated:
        reason = "home is where three angles are not defined"
        raise AssemblyError(f"{mechanism.where}: no C code for these driven coordinates: {reason}")
    graph = solver.graph
    limited = {limit.coordinate for limit in graph.limited} - {*graph.cones}  # in whatever turn
    outputs = {*solver.coordinates, *solver.iterated, *filter(graph.is_angle, limited)}
    if outputs > set(solver.coordinates):  # the next pose is found from this one's state alone
        wanted = [c.name for c in graph.coordinates if c.name in outputs]
        solver = compile_mechanism(mechanism, driven, coordinates=wanted, machine_code=False)
    names = Names(stem)
    rows = efforts.force_rows(solver, preload) if forces else None
    code = kernel(solver, names) + (efforts.definition(solver, names, rows) if rows else "")
    return code, header(solver, names, rows), comparison(solver, names, rows)
