"""A solver as plain C99, for controllers that are no PC: one pose, no allocation, only libm.

The kernel that NumPy runs and heyoka compiles is traced once more, with scalars that write down
what is done to them. Where Newton iterates, one step of it is a function of its own, called a
fixed number of times from the pose before.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from parakin.algebra.spatial import FLOATS, Functions, Scalar
from parakin.errors import AssemblyError
from parakin.kernel.pose import trace
from parakin.kernel.rows import Outputs
from parakin.model.mechanism import Mechanism
from parakin.solving.charts import layout_of
from parakin.solving.compiler import compile as compile_mechanism
from parakin.solving.solver import Solver
from parakin.solving.status import LOCKED, RESIDUAL, SINGULAR, TURNS, Layout, Status
from parakin.version import __version__

ITERATIONS = 8  # Newton steps a call; from a pose nearby three are enough
_SAMPLES = 20  # poses that the test program knows
_SWING = 0.02  # how far these go from home [rad, or characteristic lengths]
_MADE = f"Made by parakin {__version__}: change the mechanism rather than this."
_STATUSES = tuple(s for s in Status if s not in (Status.NOT_REACHED, Status.NOT_SMOOTH))


def c_code(
    mechanism: Mechanism, stem: str, driven: Sequence[str] | None = None
) -> tuple[str, str, str]:
    """The kernel, its header and a test program; functions are called after `stem`.

    Raises InputError, AssemblyError, DrivenError.
    """
    solver = compile_mechanism(mechanism, driven, machine_code=False)
    if solver.plan.graph.twins and solver.iterated:
        reason = "home is where three angles are not defined"
        raise AssemblyError(f"{mechanism.where}: no C code for these driven coordinates: {reason}")
    outputs = {*solver.coordinates, *solver.iterated}
    if outputs > set(solver.coordinates):  # a state has all that the next pose is found from
        names = [c.name for c in solver.graph.coordinates if c.name in outputs]
        solver = compile_mechanism(mechanism, driven, coordinates=names, machine_code=False)
    name = _identifier(stem)
    return _kernel(solver, name, stem), _header(solver, name, stem), _test(solver, name, stem)


@dataclass
class _Code:
    """Statements in the order in which they were traced, each thing computed once."""

    lines: list[str] = field(default_factory=list)
    known: dict[str, str] = field(default_factory=dict)

    def let(self, expression: str) -> Term:
        if expression not in self.known:
            self.known[expression] = f"v{len(self.lines)}"
            self.lines.append(expression)
        return Term(self, self.known[expression])


class Term:
    """A scalar whose arithmetic is written down as C."""

    __slots__ = ("code", "text")
    __array_ufunc__ = None  # a NumPy number leaves sums and products with it to us

    def __init__(self, code: _Code, text: str) -> None:
        self.code, self.text = code, text

    def __neg__(self) -> Term:
        return self.code.let(f"-{self.text}")

    def __add__(self, other: Scalar) -> Term:
        return self.code.let(f"{self.text} + {_text(other)}")

    def __radd__(self, other: Scalar) -> Term:
        return self.code.let(f"{_text(other)} + {self.text}")

    def __sub__(self, other: Scalar) -> Term:
        return self.code.let(f"{self.text} - {_text(other)}")

    def __rsub__(self, other: Scalar) -> Term:
        return self.code.let(f"{_text(other)} - {self.text}")

    def __mul__(self, other: Scalar) -> Term:
        return self.code.let(f"{self.text}*{_text(other)}")

    def __rmul__(self, other: Scalar) -> Term:
        return self.code.let(f"{_text(other)}*{self.text}")

    def __truediv__(self, other: Scalar) -> Term:
        return self.code.let(f"{self.text}/{_text(other)}")

    def __rtruediv__(self, other: Scalar) -> Term:
        return self.code.let(f"{_text(other)}/{self.text}")


def _text(a: Scalar) -> str:
    if isinstance(a, Term):
        return a.text
    number = repr(float(a))
    return f"({number})" if number.startswith("-") else number


def _functions(code: _Code) -> Functions:
    def function(pattern: str, plain: Any) -> Callable[..., Scalar]:
        def apply(*arguments: Scalar) -> Scalar:
            if not any(isinstance(a, Term) for a in arguments):
                return plain(*arguments)
            return code.let(pattern.format(*(_text(a) for a in arguments)))

        return apply

    patterns = (
        *("sin({})", "cos({})", "sqrt({})", "atan2({}, {})"),
        *("{1} < {0} ? {1} : {0}", "{1} < 0.0 ? -{0} : {0}"),
    )
    return Functions(*(function(p, f) for p, f in zip(patterns, FLOATS, strict=True)))


def _function(solver: Solver, name: str, outputs: Outputs) -> str:
    """A C function from a kernel's inputs to its outputs, with one Newton step if it iterates."""
    code = _Code()
    k = len(solver.driven)
    orders = 1 + outputs.derivatives
    inputs = [Term(code, f"in[{i}]") for i in range(k * orders + len(solver.iterated))]
    results = trace(
        solver.plan,
        [inputs[k * order : k * (order + 1)] for order in range(orders)],
        inputs[k * orders :],
        _functions(code),
        outputs,
        1,
    )
    texts = [_text(result) for result in results]
    used: set[str] = set()
    for text in texts:
        used.add(text)
    body: list[str] = []
    for number, expression in reversed(list(enumerate(code.lines))):
        if f"v{number}" in used:
            body.append(f"    const double v{number} = {expression};")
            used.update(re.findall(r"\bv\d+\b", expression))
    body.reverse()
    body += [f"    out[{i}] = {text};" for i, text in enumerate(texts)]
    if not any("in[" in line for line in body):
        body.insert(0, "    (void)in;")
    lines = "\n".join(body)
    return f"static void {name}(const double *in, double *out)\n{{\n{lines}\n}}\n"


def _kernel(solver: Solver, name: str, stem: str) -> str:
    n, m, k = len(solver.coordinates), len(solver.iterated), len(solver.driven)
    iterated = [solver.coordinates.index(c) for c in solver.iterated]
    layout = _layout(solver)
    parts = [f'/* {stem}.c: see {stem}.h. {_MADE} */\n#include "{stem}.h"\n\n#include <math.h>\n']
    iterate = ""
    if m:
        found = tuple(solver.graph.index(c, "iterated") for c in solver.iterated)
        parts.append(_function(solver, "newton_step", Outputs(found, 0, checks=False)))
        parts.append(f"static const int iterated[{m}] = {{{_listed(iterated)}}};\n")
        iterate = f"""
    for (i = 0; i < {m}; ++i)
        step[{k} + i] = state->position[iterated[i]];
    for (i = 0; i < {name.upper()}_ITERATIONS; ++i)
        newton_step(step, step + {k});
    for (i = 0; i < {m}; ++i)
        in[{3 * k} + i] = step[{k} + i];
"""
    numbers = tuple(solver.graph.index(c, "coordinates") for c in solver.coordinates)
    rows = Outputs(numbers, 2)
    parts.append(_function(solver, "solve_pose", rows))
    home = ", ".join(repr(solver.home[c]) for c in solver.coordinates)
    limited = _limits(solver)
    if limited:
        table = ",\n".join(f"    {{{row}, {low!r}, {high!r}}}" for row, low, high in limited)
        parts.append(
            "static const struct { int row; double low, high; } limits[] = {\n" + table + "\n};\n"
        )
    if len(layout.angles):
        parts.append(
            f"static const int angles[{len(layout.angles)}] = {{{_listed(layout.angles)}}};\n"
        )
    unwrap = ""
    if len(layout.angles):
        unwrap = f"""
    for (i = 0; i < {len(layout.angles)}; ++i) /* within half a turn of the pose before */
        out[angles[i]] += turn * round((state->position[angles[i]] - out[angles[i]]) / turn);
"""
    check = ""
    if limited:
        check = f"""
    for (i = 0; i < {len(limited)}; ++i) {{
        const double q = state->position[limits[i].row];
        if (q < limits[i].low || q > limits[i].high)
            return {name.upper()}_LIMIT_EXCEEDED;
    }}"""
    angles = sorted({*layout.angles.tolist(), *iterated}.intersection(solver.angle_rows))
    numbers_ = f"""
    for (i = 0; i < {n}; ++i)
        if (!isfinite(state->position[i]))
            return {name.upper()}_OUT_OF_REACH;
"""
    numbers_ += "".join(
        f"    if (!(fabs(state->position[{row}]) < {2 * math.pi * TURNS!r}))\n"
        f"        return {name.upper()}_OUT_OF_REACH;\n"
        for row in angles
    )
    undefined, kept = _undefined(layout, name)
    declared = [f"double in[{3 * k + m}], out[{rows.count}];", "int i;"]
    if m:
        declared.insert(1, f"double step[{k + m}];")
    if undefined:
        declared.append("int undefined = 0;")
    if len(layout.angles):
        declared.insert(1, f"const double turn = {2 * math.pi!r};")
    copied = "        step[i] = y[i];\n" if m else ""
    parts.append(
        f"""void {name}_home({name}_state *state)
{{
    static const double home[{n}] = {{{home}}};
    int i;

    for (i = 0; i < {n}; ++i) {{
        state->position[i] = home[i];
        state->velocity[i] = 0.0;
        state->acceleration[i] = 0.0;
    }}
    state->residual = 0.0;
    state->conditioning = 1.0;
}}

int {name}_solve(const double *y, const double *yd, const double *ydd, {name}_state *state)
{{
    {chr(10).join(f"    {line}" for line in declared).strip()}

    for (i = 0; i < {k}; ++i)
        if (!isfinite(y[i]) || !isfinite(yd[i]) || !isfinite(ydd[i]))
            return {name.upper()}_OUT_OF_REACH;{numbers_.rstrip()}
    for (i = 0; i < {k}; ++i) {{
        in[i] = y[i];
        in[{k} + i] = yd[i];
        in[{2 * k} + i] = ydd[i];
{copied}    }}
{iterate.lstrip(chr(10))}    solve_pose(in, out);
    state->residual = out[{rows.residual}];
    state->conditioning = out[{rows.conditioning}];
    if (out[{rows.residual}] != out[{rows.residual}])
        return {name.upper()}_OUT_OF_REACH;
    if (!(out[{rows.residual}] <= {RESIDUAL!r}*out[{rows.size}]))
        return {name.upper()}_ITERATION_LIMIT;
    if (out[{rows.conditioning}] < {-SINGULAR!r})
        return {name.upper()}_BRANCH_CHANGE;
    if (!(out[{rows.conditioning}] >= {SINGULAR!r}))
        return {name.upper()}_SINGULAR;
    for (i = 0; i < {rows.motion.stop}; ++i)
        if (!isfinite(out[i]))
            return {name.upper()}_OUT_OF_REACH;
{unwrap.lstrip(chr(10))}{undefined}    for (i = 0; i < {n}; ++i) {{
        state->position[i] = out[i];
        state->velocity[i] = out[{rows.order(1).start} + i];
        state->acceleration[i] = out[{rows.order(2).start} + i];
    }}{kept}{check}
    return {name.upper()}_CONVERGED;
}}
"""
    )
    return "\n".join(parts)


def _layout(solver: Solver) -> Layout:
    """Of what is reported alone."""
    numbers = tuple(solver.graph.index(c, "coordinates") for c in solver.coordinates)
    return layout_of(solver.plan, Outputs(numbers, 2), len(numbers))


def _undefined(layout: Layout, name: str) -> tuple[str, str]:
    """Where three angles are not defined: how that is seen, and what is said of it."""
    found = ""
    for rows, second, same in layout.triples:
        function = "sin" if same else "cos"
        for order, level in enumerate(LOCKED[:3]):
            found += (
                f"    if (fabs({function}(out[{second}])) < {level!r}) {{\n        undefined = 1;\n"
            )
            for row in rows.tolist():
                kept = f"state->position[{row}]" if order == 0 else "0.0"
                found += f"        out[{layout.outputs.derivative(row, order)}] = {kept};\n"
            found += "    }\n"
    if not found:
        return "", ""
    said = f"\n    if (undefined)\n        return {name.upper()}_ANGLES_UNDEFINED;"
    return found, said


def _limits(solver: Solver) -> list[tuple[int, float, float]]:
    found = []
    for row, name in enumerate(solver.coordinates):
        low, high = solver.graph.limits(name)
        if math.isfinite(low) and math.isfinite(high):
            found.append((row, low, high))
    return found


def _header(solver: Solver, name: str, stem: str) -> str:
    upper = name.upper()
    graph = solver.graph
    units = {c.name: c.unit for c in graph.coordinates}
    used: set[str] = set()

    def constants(names: Sequence[str], prefix: str) -> str:
        lines = []
        for number, coordinate in enumerate(names):
            label = f"{upper}_{prefix}{_identifier(coordinate).upper()}"
            while label in used:
                label += "_"
            used.add(label)
            unit, comma = units[coordinate], "," if number < len(names) - 1 else ""
            said = f"{coordinate} [{unit}, {unit}/s, {unit}/s^2]"
            lines.append(f"    {label} = {number}{comma} /* {said} */")
        return "\n".join(lines)

    statuses = ",\n".join(f"    {upper}_{status.name} = {int(status)}" for status in _STATUSES)
    mechanism = _comment(f"{graph.mechanism.name}: {graph.mechanism.title or 'a mechanism'}")
    counted = [c for c in solver.coordinates if graph.index(c, "") in graph.from_home]
    from_home = f"\n * Counted from home: {', '.join(counted)}." if counted else ""
    iterations = ITERATIONS if solver.iterated else 0
    return f"""/* {stem}.h: kinematics of one pose. {_MADE}
 *
 * {mechanism}
 * Driven: {_comment(", ".join(solver.driven))}.{_comment(from_home)}
 * SI units: metres, radians, seconds. Do not compile with -ffast-math: NaN has to stay NaN.
 *
 *     {name}_state state;
 *     {name}_home(&state);
 *     for (;;)
 *         if ({name}_solve(y, yd, ydd, &state) != {upper}_CONVERGED)
 *             stop();
 */
#ifndef {upper}_H
#define {upper}_H

#ifdef __cplusplus
extern "C" {{
#endif

/* Places in y, yd and ydd. */
enum {{
{constants(solver.driven, "Y_")}
}};

/* Places in position, velocity and acceleration. */
enum {{
{constants(solver.coordinates, "")}
}};

enum {{
    {upper}_DRIVEN = {len(solver.driven)},
    {upper}_COORDINATES = {len(solver.coordinates)},
    {upper}_ITERATIONS = {iterations} /* Newton steps a call; none where there is a closed form */
}};

enum {{
{statuses}
}};

typedef struct {{
    double position[{len(solver.coordinates)}];     /* [m or rad] */
    double velocity[{len(solver.coordinates)}];     /* [m/s or rad/s] */
    double acceleration[{len(solver.coordinates)}]; /* [m/s^2 or rad/s^2] */
    double residual;         /* norm of all closure rows [m] */
    double conditioning;     /* 0 where singular, negative on another branch */
}} {name}_state;

/* The mechanism at rest at home. */
void {name}_home({name}_state *state);

/* Solve one pose.
 * y, yd, ydd: driven positions, velocities and accelerations.
 * state: the pose before, from which angles are counted on and iteration starts; then this one.
 * Returns a status. Of {upper}_ANGLES_UNDEFINED, the three angles alone stay those of the pose
 * before, at rest. Of any other but {upper}_CONVERGED and {upper}_LIMIT_EXCEEDED, position,
 * velocity and acceleration stay those of the pose before; residual and conditioning tell what
 * was met.
 * Numbers that are none, in y, yd, ydd or state, are {upper}_OUT_OF_REACH. */
int {name}_solve(const double *y, const double *yd, const double *ydd, {name}_state *state);

#ifdef __cplusplus
}}
#endif

#endif
"""


def _test(solver: Solver, name: str, stem: str) -> str:
    """A program that compares the kernel with what parakin found when it was exported."""
    upper = name.upper()
    cases, answers = _samples(solver)
    given = ",\n".join("    {" + ", ".join(map(repr, row)) + "}" for row in cases.tolist())
    known = ",\n".join("    {" + ", ".join(map(repr, row)) + "}" for row in answers.tolist())
    k, n = len(solver.driven), len(solver.coordinates)
    return f"""/* {stem}_test.c: compares {stem}.c with parakin's own results. For example:
 *     cc -std=c99 -O2 -o {stem}_test {stem}_test.c {stem}.c -lm && ./{stem}_test
 */
#include "{stem}.h"

#include <math.h>
#include <stdio.h>
#include <time.h>

#define SAMPLES {len(cases)}
#define ROUNDS 20000

/* y, yd, ydd */
static const double given[SAMPLES][{3 * k}] = {{
{given}
}};

/* position, velocity, acceleration */
static const double known[SAMPLES][{3 * n}] = {{
{known}
}};

static double worst = 0.0;

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
    int i, j, flagged = 0;

    {name}_home(&state);
    for (i = 0; i < SAMPLES; ++i) {{
        const double *y = given[i];
        if ({name}_solve(y, y + {k}, y + {2 * k}, &state) != {upper}_CONVERGED)
            ++flagged;
        for (j = 0; j < {n}; ++j) {{
            compare(state.position[j], known[i][j]);
            compare(state.velocity[j], known[i][{n} + j]);
            compare(state.acceleration[j], known[i][{2 * n} + j]);
        }}
    }}
    begun = clock();
    for (i = 0; i < ROUNDS; ++i) {{
        const double *y = given[i % SAMPLES];
        {name}_solve(y, y + {k}, y + {2 * k}, &state);
    }}
    printf("%d poses, %d flagged, largest relative difference %.1e, %.0f ns a pose\\n", SAMPLES,
           flagged, worst, 1e9 * (double)(clock() - begun) / CLOCKS_PER_SEC / ROUNDS);
    return flagged == 0 && worst < 1e-12 ? 0 : 1;
}}
"""


def _samples(solver: Solver) -> tuple[np.ndarray, np.ndarray]:
    """Poses along a swing about home, and their solutions."""
    graph = solver.graph
    home = np.array([solver.home[c] for c in solver.driven])
    angle = np.array([graph.coordinates[k].angle for k in solver.plan.driven])
    swing = np.where(angle, _SWING, _SWING * graph.length)
    guess = np.array([solver.home[c] for c in solver.coordinates])
    cases, answers = [], []
    for i in range(_SAMPLES):
        phase = 2 * math.pi * i / _SAMPLES + np.zeros(len(home))
        phase[1::2] *= 2
        y = home + swing * np.sin(phase)
        yd, ydd = swing * np.cos(phase), -swing * np.sin(phase)
        tick = solver.at(y, yd, ydd, guess)
        if tick.status != Status.CONVERGED:
            continue
        guess = tick.position
        cases.append(np.concatenate([y, yd, ydd]))
        answers.append(np.concatenate([tick.position, tick.velocity, tick.acceleration]))
    if not cases:
        raise AssemblyError(f"{solver.mechanism.where}: home cannot be solved: it is singular")
    return np.array(cases), np.array(answers)


def _listed(values: Sequence[int] | np.ndarray) -> str:
    return ", ".join(str(int(value)) for value in values)


def _identifier(text: str) -> str:
    made = re.sub(r"\W", "_", text, flags=re.ASCII)
    return made if re.match(r"[A-Za-z]", made) else f"m{made}"


def _comment(text: str) -> str:
    """Text that does not end a comment."""
    return text.replace("*/", "* /").replace("/*", "/ *")
