"""The header's text: places of coordinates, statuses, the state, and the two functions."""

from __future__ import annotations

from collections.abc import Sequence

from parakin.exports.c99.efforts import declaration
from parakin.exports.c99.names import MADE_BY, Names, comment, identifier, unused
from parakin.kernel.force_rows import ForceRows
from parakin.solving.solver import Solver
from parakin.solving.status import Status

_FIXED = ("H", "DRIVEN", "COORDINATES", "ITERATIONS", "NOTHING", "ACTUATORS")  # the file's own
ITERATIONS = 8  # Newton steps a call; from a pose nearby three are enough
_STATUSES = tuple(s for s in Status if s not in (Status.NOT_REACHED, Status.NOT_SMOOTH))


def header(solver: Solver, names: Names, rows: ForceRows | None = None) -> str:
    """The text of the header."""
    macro = names.constant
    used = {f"{macro}_{name}" for name in (*_FIXED, *(status.name for status in _STATUSES))}
    constants = _constants(solver, names, used)
    efforts = declaration(solver, names, rows, used) if rows else ""
    return f"""{_about(solver, names)}#ifndef {macro}_H
#define {macro}_H

#ifdef __cplusplus
extern "C" {{
#endif

{constants}
{_functions(solver, names)}{efforts}
#ifdef __cplusplus
}}
#endif

#endif
"""


def _about(solver: Solver, names: Names) -> str:
    graph = solver.graph
    mechanism = comment(f"{graph.mechanism.name}: {graph.mechanism.title or 'a mechanism'}")
    counted = [c for c in solver.coordinates if graph.index(c, "") in graph.from_home]
    from_home = f"\n * Counted from home: {', '.join(counted)}." if counted else ""
    return f"""/* {names.stem}.h: kinematics of one pose. {MADE_BY}
 *
 * {mechanism}
 * Driven: {comment(", ".join(solver.driven))}.{comment(from_home)}
 * SI units: metres, radians, seconds. Not for -ffast-math: NaN has to stay NaN.
 *
 *     {names.prefix}_state state;
 *     {names.prefix}_home(&state);
 *     for (;;)
 *         if ({names.prefix}_solve(y, yd, ydd, &state) != {names.constant}_CONVERGED)
 *             stop();
 */
"""


def _constants(solver: Solver, names: Names, used: set[str]) -> str:
    macro = names.constant
    iterations = ITERATIONS if solver.iterated else 0
    statuses = ",\n".join(f"    {macro}_{status.name} = {int(status)}" for status in _STATUSES)
    return f"""/* Places in y, yd and ydd. */
enum {{
{_places(solver, solver.driven, f"{macro}_Y_", used)}
}};

/* Places in position, velocity and acceleration. */
enum {{
{_places(solver, solver.coordinates, f"{macro}_", used)}
}};

enum {{
    {macro}_DRIVEN = {len(solver.driven)},
    {macro}_COORDINATES = {len(solver.coordinates)},
    {macro}_ITERATIONS = {iterations} /* Newton steps per call; 0 if all has a closed form */
}};

enum {{
{statuses}
}};

/* What can stop it. */
enum {{
{_stops(solver, macro, used)}
}};
"""


def _stops(solver: Solver, macro: str, used: set[str]) -> str:
    """Members of an enumeration: nothing, limits, and loops with their joints."""
    stops, lines = solver.stops, []
    for number, (name, unit) in enumerate(zip(stops.names, stops.units, strict=True)):
        label, about = f"{macro}_LOOP_{number}", name
        if unit:
            label = f"{macro}_LIMIT_{identifier(name).upper()}"
            about = f"{stops.low[number]:.10g} .. {stops.high[number]:.10g} {unit}"
        if not number:
            label, about = f"{macro}_NOTHING", "no limit and no loop"
        if number:
            label = unused(label, used)
        comma = "," if number < len(stops.names) - 1 else ""
        lines.append(f"    {label} = {number}{comma} /* {comment(about.replace('²', '^2'))} */")
    return "\n".join(lines)


def _places(solver: Solver, coordinates: Sequence[str], prefix: str, used: set[str]) -> str:
    """Members of an enumeration, one per coordinate, under labels that `used` has not yet."""
    units = {c.name: c.unit for c in solver.graph.coordinates}
    lines = []
    for number, coordinate in enumerate(coordinates):
        label = unused(f"{prefix}{identifier(coordinate).upper()}", used)
        unit, comma = units[coordinate], "," if number < len(coordinates) - 1 else ""
        quantities = f"{coordinate} [{unit}, {unit}/s, {unit}/s^2]"
        lines.append(f"    {label} = {number}{comma} /* {quantities} */")
    return "\n".join(lines)


def _functions(solver: Solver, names: Names) -> str:
    name, macro, count = names.prefix, names.constant, len(solver.coordinates)
    return f"""typedef struct {{
    double position[{count}];     /* [m or rad] */
    double velocity[{count}];     /* [m/s or rad/s] */
    double acceleration[{count}]; /* [m/s^2 or rad/s^2] */
    double residual;         /* norm of all closure rows [m] */
    double conditioning;     /* 0 where singular, negative on another branch */
    int stopped_by;          /* what stopped it: 0 for nothing */
    double excess;           /* beyond an upper or, if negative, a lower limit; 0 if none */
}} {name}_state;

/* The mechanism at rest at home. */
void {name}_home({name}_state *state);

/* Solve one pose.
 * y, yd, ydd: driven positions, velocities and accelerations.
 * state: on entry the previous pose, from which angles are counted and iteration starts; on
 * return the new one.
 * Returns a status; stopped_by then tells which limit is exceeded, or which loop cannot be closed.
 * With {macro}_CONVERGED and {macro}_LIMIT_EXCEEDED all of state is new. With
 * {macro}_ANGLES_UNDEFINED only the undefined angles keep their previous values, with rates of
 * zero. With any other, position, velocity and acceleration keep their previous values; residual
 * and conditioning are those found on the attempt.
 * NaN or infinity in y, yd, ydd or state gives {macro}_OUT_OF_REACH. */
int {name}_solve(const double *y, const double *yd, const double *ydd, {name}_state *state);
"""
