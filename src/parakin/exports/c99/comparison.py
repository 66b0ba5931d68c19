"""The text of a program that compares the kernel with what parakin found when it was exported."""

from __future__ import annotations

import math

import numpy as np

from parakin.arrays import FloatArray
from parakin.errors import AssemblyError
from parakin.exports.c99.efforts import load_values, samples
from parakin.exports.c99.names import Names
from parakin.kernel.force_rows import ForceRows
from parakin.solving.solver import Solver
from parakin.solving.status import Status

_SAMPLES = 20  # poses that the test program knows
_SWING = 0.02  # how far these go from home [rad, or characteristic lengths]


def comparison(solver: Solver, names: Names, rows: ForceRows | None = None) -> str:
    """The text of the program. Raises AssemblyError where home is singular."""
    given, known, status = _samples(solver)
    stem = names.stem
    checks = _effort_checks(solver, names, rows) if rows else ("", "", "")
    return f"""/* {stem}_test.c: compares {stem}.c with parakin's own results. For example:
 *     cc -std=c99 -O2 -o {stem}_test {stem}_test.c {stem}.c -lm && ./{stem}_test
 */
#include "{stem}.h"

#include <math.h>
#include <stdio.h>
#include <time.h>

#define SAMPLES {len(given)}
#define ROUNDS 20000

/* y, yd, ydd */
static const double given[SAMPLES][{given.shape[1]}] = {{
{_rows(given)}
}};

/* position, velocity, acceleration */
static const double known[SAMPLES][{known.shape[1]}] = {{
{_rows(known)}
}};

static const int status[SAMPLES] = {{{", ".join(map(str, status))}}};

{_forces_known(solver, rows, given) if rows else ""}\
{_main(len(solver.driven), len(solver.coordinates), names, checks)}"""


def _rows(table: FloatArray) -> str:
    return ",\n".join("    {" + ", ".join(map(repr, row)) + "}" for row in table.tolist())


def _forces_known(solver: Solver, rows: ForceRows, given: FloatArray) -> str:
    efforts = samples(solver, rows, given)
    loads = load_values(solver)
    text = f"""static const double efforts[SAMPLES][{efforts.shape[1]}] = {{
{_rows(efforts)}
}};

"""
    if loads:
        text += f"static const double loads[{len(loads)}] = {{{', '.join(map(repr, loads))}}};\n\n"
    return text


def _effort_checks(solver: Solver, names: Names, rows: ForceRows) -> tuple[str, str, str]:
    """What is declared, what is compared at each pose, and what is timed."""
    k, loads = len(solver.driven), "loads, " if solver.graph.dynamics.inputs else ""
    count = len(rows.actuated)
    return (
        f"    double effort[{count}];\n",
        f"""\
        if ({names.prefix}_efforts(y, y + {k}, y + {2 * k}, {loads}&state, effort) != 0)
            ++wrong;
        for (j = 0; j < {count}; ++j)
            compare(effort[j], efforts[i][j]);
""",
        f"""    begun = clock();
    for (i = 0; i < ROUNDS; ++i) {{
        const double *y = given[i % SAMPLES];
        {names.prefix}_efforts(y, y + {k}, y + {2 * k}, {loads}&state, effort);
    }}
    printf("%.0f ns for the efforts of a pose\\n",
           1e9 * (double)(clock() - begun) / CLOCKS_PER_SEC / ROUNDS);
""",
    )


def _main(k: int, n: int, names: Names, efforts: tuple[str, str, str]) -> str:
    """For `k` driven coordinates and `n` altogether."""
    name = names.prefix
    return f"""static double worst = 0.0;

static void compare(double found, double expected)
{{
    const double off = fabs(found - expected) / (1.0 + fabs(expected));
    if (!(off <= worst))
        worst = off;
}}

int main(void)
{{
    {name}_state state;
    clock_t begun;
{efforts[0]}    int i, j, wrong = 0;

    {name}_home(&state);
    for (i = 0; i < SAMPLES; ++i) {{
        const double *y = given[i];
        if ({name}_solve(y, y + {k}, y + {2 * k}, &state) != status[i])
            ++wrong;
        for (j = 0; j < {n}; ++j) {{
            compare(state.position[j], known[i][j]);
            compare(state.velocity[j], known[i][{n} + j]);
            compare(state.acceleration[j], known[i][{2 * n} + j]);
        }}
{efforts[1]}    }}
    begun = clock();
    for (i = 0; i < ROUNDS; ++i) {{
        const double *y = given[i % SAMPLES];
        {name}_solve(y, y + {k}, y + {2 * k}, &state);
    }}
    printf("%d poses, %d with another status, largest relative difference %.1e, %.0f ns a pose\\n",
           SAMPLES, wrong, worst, 1e9 * (double)(clock() - begun) / CLOCKS_PER_SEC / ROUNDS);
{efforts[2]}    return wrong == 0 && worst < 1e-12 ? 0 : 1;
}}
"""


def _samples(solver: Solver) -> tuple[FloatArray, FloatArray, list[int]]:
    """Driven values along a swing about home (poses, 3k), their solutions (poses, 3n), which may be
    beyond limits, and the status of each.
    """
    graph = solver.graph
    home = np.array([solver.home[c] for c in solver.driven])
    angle = np.array([graph.coordinates[k].angle for k in solver.plan.driven])
    swing = np.where(angle, _SWING, _SWING * graph.length)
    guess = np.array([solver.home[c] for c in solver.coordinates])
    cases, answers, status = [], [], []
    for i in range(_SAMPLES):
        phase = 2 * math.pi * i / _SAMPLES + np.zeros(len(home))
        phase[1::2] *= 2
        y = home + swing * np.sin(phase)
        yd, ydd = swing * np.cos(phase), -swing * np.sin(phase)
        tick = solver.at(y, yd, ydd, guess)
        if tick.status not in (Status.CONVERGED, Status.LIMIT_EXCEEDED):
            continue
        guess = tick.position
        cases.append(np.concatenate([y, yd, ydd]))
        status.append(int(tick.status))
        answers.append(np.concatenate([tick.position, tick.velocity, tick.acceleration]))
    if not cases:
        raise AssemblyError(f"{solver.mechanism.where}: home cannot be solved: it is singular")
    return np.array(cases), np.array(answers), status
