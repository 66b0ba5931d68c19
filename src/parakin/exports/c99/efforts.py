"""The texts about efforts: a function for feed-forward control, its declaration, its comparison."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from parakin.arrays import FloatArray
from parakin.errors import InputError
from parakin.exports.c99.names import Names, comment, identifier, unused
from parakin.exports.c99.traced import c_function
from parakin.kernel.force_rows import ForceRows
from parakin.kernel.outputs import Outputs
from parakin.solving.forces import FOUND
from parakin.solving.solver import Solver


def force_rows(solver: Solver, preload: Mapping[str, float] | None = None) -> ForceRows:
    """What the function needs of a pose's forces. preload: efforts [N or N m] that those of
    redundant actuators are to be nearest to. Raises InputError where there are none, or where the
    mechanism does not determine them.
    """
    mechanics = solver.mechanics
    asked = mechanics.asked(reactions=False, energies=False, preload=preload, indeterminate="nan")
    rows = mechanics.rows(asked, mechanics.reference)
    for k in rows.wound:
        name = solver.plan.graph.coordinates[k].name
        if name not in solver.coordinates:
            found = f"a spring on {name}, an angle that is not reported"
            raise InputError("coordinates", found, f"{name} among them, so that its turns count")
    return rows


def definition(solver: Solver, names: Names, rows: ForceRows) -> str:
    """The function itself, and the traced one that it calls."""
    name, macro = names.prefix, names.constant
    k, m, loads = len(solver.driven), len(solver.iterated), solver.graph.dynamics.inputs
    count = len(rows.actuated)
    outputs = Outputs((), 2, checks=False, forces=rows)
    chosen = list(range(count))
    locked, given, iterated = "", "", ""
    if rows.loaded:
        chosen.append(rows.friction_step)
        locked = f"""\
    for (i = 0; i < {count}; ++i) /* friction under load that was not found, where it locks */
        if (!(out[{count}] <= {FOUND!r}*(1.0 + fabs(out[i]))))
            return {macro}_SINGULAR;
"""
    springs = [solver.coordinates.index(solver.plan.graph.coordinates[k].name) for k in rows.wound]
    wound = "".join(
        f"    in[{3 * k + m + loads + i}] = state->position[{row}];\n"
        for i, row in enumerate(springs)
    )
    traced = c_function(solver, "efforts_behind", outputs, chosen)
    if m:
        iterated = f"""\
    for (i = 0; i < {m}; ++i)
        in[{3 * k} + i] = state->position[iterated[i]];
"""
    if loads:
        given = f"""\
    for (i = 0; i < {loads}; ++i)
        in[{3 * k + m} + i] = loads[i];
"""
    unused = "" if m or springs else "    (void)state;\n"
    return f"""
{traced}
int {name}_efforts({_parameters(solver, names)})
{{
    double in[{3 * k + m + loads + len(springs)}], out[{len(chosen)}];
    int i;

{unused}\
    for (i = 0; i < {k}; ++i) {{
        in[i] = y[i];
        in[{k} + i] = yd[i];
        in[{2 * k} + i] = ydd[i];
    }}
{iterated}{given}{wound}\
    efforts_behind(in, out);
    for (i = 0; i < {count}; ++i)
        if (!isfinite(out[i]))
            return {macro}_SINGULAR;
{locked}\
    for (i = 0; i < {count}; ++i)
        effort[i] = out[i];
    return {macro}_CONVERGED;
}}
"""


def _parameters(solver: Solver, names: Names) -> str:
    loads = "const double *loads, " if solver.graph.dynamics.inputs else ""
    return (
        f"const double *y, const double *yd, const double *ydd, {loads}"
        f"const {names.prefix}_state *state, double *effort"
    )


def declaration(solver: Solver, names: Names, rows: ForceRows, used: set[str]) -> str:
    """For the header: places of actuators and loads, and the function. used: labels that are."""
    macro, places = names.constant, []
    for number, k in enumerate(rows.actuated):
        coordinate = solver.plan.graph.coordinates[k]
        unit = "N m" if coordinate.angle else "N"
        places.append((f"{macro}_EFFORT_", coordinate.name, f"{coordinate.name} [{unit}]", number))
    taken = 0
    for load in solver.graph.dynamics.loads:
        places.append((f"{macro}_LOAD_", load.name, f"{load.name}: mass [kg]", taken))
        taken += 1
    for wrench in solver.graph.dynamics.wrenches:
        if wrench.inputs:
            what = "factor" if wrench.inputs == 1 else "force [N], then moment [N m]"
            places.append((f"{macro}_LOAD_", wrench.name, f"{wrench.name}: {what}", taken))
            taken += wrench.inputs
    lines = []
    for prefix, of, about, number in places:
        label = unused(f"{prefix}{identifier(of).upper()}", used)
        lines.append(f"    {label} = {number}, /* {comment(about)} */")
    taking = f" loads: {taken} numbers." if taken else ""
    return f"""
/* Places in effort{" and loads" if taken else ""}. */
enum {{
{chr(10).join(lines)}
    {macro}_ACTUATORS = {len(rows.actuated)}
}};

/* The efforts of the actuators for a pose and its motion, for feed-forward control.
 * y, yd, ydd: as of {names.prefix}_solve.{taking} state: what that returned for them.
 * effort: {len(rows.actuated)} numbers; friction at rest is none.
 * Returns {macro}_CONVERGED, or {macro}_SINGULAR where they are not finite: effort is then what it
 * was. */
int {names.prefix}_efforts({_parameters(solver, names)});
"""


def samples(solver: Solver, rows: ForceRows, given: FloatArray) -> FloatArray:
    """Efforts at poses (n, 3k) of the comparison, (n, m)."""
    graph, preload = solver.graph, None
    if len(rows.actuated) > len(solver.driven):
        names = (graph.coordinates[k].name for k in rows.actuated)
        preload = dict(zip(names, rows.preload, strict=False))  # none: the least
    y, yd, ydd = given.reshape(len(given), 3, -1).transpose(1, 2, 0)
    guess = solver.at(y[:, 0])
    loads = {w.name: [1.0] * w.inputs for w in graph.dynamics.wrenches if w.inputs}
    found = []
    for k in range(len(given)):
        rates = yd[:, k], ydd[:, k]
        guess = solver.at(y[:, k], *rates, guess, forces=True, loads=loads, preload=preload)
        assert guess.forces is not None
        found.append(guess.forces.effort)
    return np.array(found)


def load_values(solver: Solver) -> list[float]:
    """What the comparison gives: the file's masses, and ones."""
    dynamics = solver.graph.dynamics
    masses = [load.mass.mass for load in dynamics.loads]
    return masses + [1.0] * sum(wrench.inputs for wrench in dynamics.wrenches)
