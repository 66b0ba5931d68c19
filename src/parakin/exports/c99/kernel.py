"""The kernel's text: traced functions, tables, and the two functions that a controller calls.

Where Newton iterates, one step of it is a function that is called a fixed number of times, from
the pose before.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import cached_property

from parakin.exports.c99.names import MADE_BY, Names
from parakin.exports.c99.traced import c_function
from parakin.kernel.outputs import Outputs
from parakin.solving.charts import layout_of
from parakin.solving.solver import Solver
from parakin.solving.status import LOCKED, RESIDUAL, SINGULAR, TURNS

_STRICT = """#if defined(__FAST_MATH__) || defined(_M_FP_FAST) || \\
    (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "-ffast-math takes NaN for a number: compile this file without it"
#endif
"""


def kernel(solver: Solver, names: Names) -> str:
    """The text of the kernel."""
    return _Kernel(solver, names).text()


class _Kernel:
    """What the texts of one kernel need to know.

    Each method that writes a part of the solving function gives whole lines of C, or nothing
    where the mechanism does not need that part.
    """

    def __init__(self, solver: Solver, names: Names) -> None:
        numbers = tuple(solver.graph.index(c, "coordinates") for c in solver.coordinates)
        self.solver, self.names = solver, names
        self.rows = Outputs(numbers, 2)
        self.layout = layout_of(solver.plan, self.rows, len(numbers))
        self.iterated = [solver.coordinates.index(c) for c in solver.iterated]
        self.driven, self.count = len(solver.driven), len(solver.coordinates)

    def text(self) -> str:
        stem = self.names.stem
        head = (
            f'/* {stem}.c: see {stem}.h. {MADE_BY} */\n#include "{stem}.h"\n\n#include <math.h>\n'
            f"\n{_STRICT}"
        )
        return "\n".join([head, *self._functions(), *self._tables(), self._home(), self._solve()])

    def _functions(self) -> Iterable[str]:
        if self.iterated:
            found = tuple(self.solver.graph.index(c, "iterated") for c in self.solver.iterated)
            yield c_function(self.solver, "newton_step", Outputs(found, 0, checks=False))
            yield f"static const int iterated[{len(found)}] = {{{_listed(self.iterated)}}};\n"
        yield c_function(self.solver, "solve_pose", self.rows)

    def _tables(self) -> Iterable[str]:
        if self._limits:
            table = ",\n".join(
                f"    {{{row}, {low!r}, {high!r}}}" for row, low, high in self._limits
            )
            head = "static const struct { int row; double low, high; } limits[] = {\n"
            yield f"{head}{table}\n}};\n"
        if len(self.layout.angles):
            angles = self.layout.angles
            yield f"static const int angles[{len(angles)}] = {{{_listed(angles)}}};\n"

    @cached_property
    def _limits(self) -> list[tuple[int, float, float]]:
        """Rows of coordinates that are limited, with their limits."""
        pairs = [self.solver.graph.limits(name) for name in self.solver.coordinates]
        return [
            (row, low, high)
            for row, (low, high) in enumerate(pairs)
            if math.isfinite(low) and math.isfinite(high)
        ]

    def _home(self) -> str:
        name, n = self.names.prefix, self.count
        home = ", ".join(repr(self.solver.home[c]) for c in self.solver.coordinates)
        return f"""void {name}_home({name}_state *state)
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
"""

    def _solve(self) -> str:
        name, macro = self.names.prefix, self.names.constant
        undefined = self._kept_where_undefined()
        body = [
            self._variables(bool(undefined)),
            self._numbers_checked(),
            self._inputs(),
            self._newton(),
            self._pose_checked(),
            self._turns_counted(),
            undefined,
            self._outputs(),
            f"    if (undefined)\n        return {macro}_ANGLES_UNDEFINED;\n" if undefined else "",
            self._limits_checked(),
        ]
        return f"""\
int {name}_solve(const double *y, const double *yd, const double *ydd, {name}_state *state)
{{
{"".join(body)}    return {macro}_CONVERGED;
}}
"""

    def _variables(self, undefined: bool) -> str:
        k, m = self.driven, len(self.iterated)
        lines = [f"double in[{3 * k + m}], out[{self.rows.count}];"]
        if len(self.layout.angles):
            lines.append(f"const double turn = {2 * math.pi!r};")
        if m:
            lines.append(f"double step[{k + m}];")
        lines.append("int i;")
        if undefined:
            lines.append("int undefined = 0;")
        return "".join(f"    {line}\n" for line in lines) + "\n"

    def _numbers_checked(self) -> str:
        """Refuse infinity and NaN, and angles of more turns than doubles can tell apart."""
        macro = self.names.constant
        lines = f"""\
    for (i = 0; i < {self.driven}; ++i)
        if (!isfinite(y[i]) || !isfinite(yd[i]) || !isfinite(ydd[i]))
            return {macro}_OUT_OF_REACH;
    for (i = 0; i < {self.count}; ++i)
        if (!isfinite(state->position[i]))
            return {macro}_OUT_OF_REACH;
"""
        angles = {*self.layout.angles.tolist(), *self.iterated} & set(self.solver.angle_rows)
        for row in sorted(angles):
            lines += f"    if (!(fabs(state->position[{row}]) < {2 * math.pi * TURNS!r}))\n"
            lines += f"        return {macro}_OUT_OF_REACH;\n"
        return lines

    def _inputs(self) -> str:
        k = self.driven
        start = "        step[i] = y[i];\n" if self.iterated else ""
        return f"""\
    for (i = 0; i < {k}; ++i) {{
        in[i] = y[i];
        in[{k} + i] = yd[i];
        in[{2 * k} + i] = ydd[i];
{start}    }}
"""

    def _newton(self) -> str:
        k, m = self.driven, len(self.iterated)
        if not m:
            return ""
        return f"""\
    for (i = 0; i < {m}; ++i)
        step[{k} + i] = state->position[iterated[i]];
    for (i = 0; i < {self.names.constant}_ITERATIONS; ++i)
        newton_step(step, step + {k});
    for (i = 0; i < {m}; ++i)
        in[{3 * k} + i] = step[{k} + i];
"""

    def _pose_checked(self) -> str:
        """Call the kernel, and refuse what is not closed, singular, or on another branch."""
        macro, residual, conditioning = (
            self.names.constant,
            self.rows.residual,
            self.rows.conditioning,
        )
        return f"""\
    solve_pose(in, out);
    state->residual = out[{residual}];
    state->conditioning = out[{conditioning}];
    if (out[{residual}] != out[{residual}])
        return {macro}_OUT_OF_REACH;
    if (!(out[{residual}] <= {RESIDUAL!r}*out[{self.rows.size}]))
        return {macro}_ITERATION_LIMIT;
    if (out[{conditioning}] < {-SINGULAR!r})
        return {macro}_BRANCH_CHANGE;
    if (!(out[{conditioning}] >= {SINGULAR!r}))
        return {macro}_SINGULAR;
    for (i = 0; i < {self.rows.motion.stop}; ++i)
        if (!isfinite(out[i]))
            return {macro}_OUT_OF_REACH;
"""

    def _turns_counted(self) -> str:
        count = len(self.layout.angles)
        if not count:
            return ""
        return f"""\
    for (i = 0; i < {count}; ++i) /* within half a turn of the pose before */
        out[angles[i]] += turn * round((state->position[angles[i]] - out[angles[i]]) / turn);
"""

    def _kept_where_undefined(self) -> str:
        """Keep three angles at rest where they are not defined, and note it."""
        lines = ""
        for rows, second, same in self.layout.triples:
            function = "sin" if same else "cos"
            for order, level in enumerate(LOCKED[:3]):
                lines += f"    if (fabs({function}(out[{second}])) < {level!r}) {{\n"
                lines += "        undefined = 1;\n"
                for row in rows.tolist():
                    kept = f"state->position[{row}]" if order == 0 else "0.0"
                    lines += f"        out[{self.rows.derivative(row, order)}] = {kept};\n"
                lines += "    }\n"
        return lines

    def _outputs(self) -> str:
        return f"""\
    for (i = 0; i < {self.count}; ++i) {{
        state->position[i] = out[i];
        state->velocity[i] = out[{self.rows.order(1).start} + i];
        state->acceleration[i] = out[{self.rows.order(2).start} + i];
    }}
"""

    def _limits_checked(self) -> str:
        if not self._limits:
            return ""
        return f"""\
    for (i = 0; i < {len(self._limits)}; ++i) {{
        const double q = state->position[limits[i].row];
        if (q < limits[i].low || q > limits[i].high)
            return {self.names.constant}_LIMIT_EXCEEDED;
    }}
"""


def _listed(values: Iterable[int]) -> str:
    return ", ".join(str(int(value)) for value in values)
