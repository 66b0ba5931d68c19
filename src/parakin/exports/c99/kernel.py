"""The kernel's text: traced functions, tables, and the two functions that a controller calls.

Where Newton iterates, one step of it is a function that is called a fixed number of times, from
the pose before.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from parakin.caching import cached_property
from parakin.exports.c99.names import MADE_BY, Names
from parakin.exports.c99.traced import c_function
from parakin.kernel.outputs import Outputs
from parakin.solving.charts import also_known, layout_of
from parakin.solving.solver import Solver
from parakin.solving.status import LOCKED, RESIDUAL, SINGULAR, TURNS
from parakin.solving.stops import LimitRows

_STRICT = """#if defined(__FAST_MATH__) || defined(_M_FP_FAST) || \\
    (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "-ffast-math takes NaN for a number: compile this file without it"
#endif
"""
_SETTLED = 1e-7  # radians and characteristic lengths: Newton's steps are shorter when it is there


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
        hidden = also_known(solver.plan, numbers, solver.plan.unknowns)
        hidden.sort(key=lambda c: isinstance(c, str))  # cones, which have no rates at zero, last
        self.cones = sum(isinstance(c, str) for c in hidden)
        self.rows = Outputs((*numbers, *hidden), 2)
        self.layout = layout_of(solver.plan, self.rows, len(numbers))
        self.limits = LimitRows.of(solver.graph, self.rows)
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
        if len(self.limits.rows):
            known = (self.limits.rows, self.limits.low, self.limits.high, self.limits.slack)
            table = ",\n".join(
                f"    {{{row}, {', '.join(map(_number, ends))}}}"
                for row, *ends in zip(*(column.tolist() for column in known), strict=True)
            )
            head = "static const struct { int row; double low, high, slack; } limits[] = {\n"
            yield f"/* What is limited, by stop; slack is rounding. */\n{head}{table}\n}};\n"
        if self._unknowns:
            places, stops = zip(*self._unknowns, strict=True)
            n = len(places)
            yield f"""/* The first unknown of each block, and the loop that it closes. */
static const int unknown[{n}] = {{{_listed(places)}}};
static const int loop[{n}] = {{{_listed(stops)}}};
"""
            if any(self._follows):
                yield "/* Whether a block follows from one that is iterated. */"
                yield f"static const int follows[{n}] = {{{_listed(self._follows)}}};\n"
        if len(self._angles):
            yield f"static const int angles[{len(self._angles)}] = {{{_listed(self._angles)}}};\n"

    @cached_property
    def _unknowns(self) -> list[tuple[int, int]]:
        """For each block of the plan, the place of its first unknown and the stop of its loops."""
        place = {c: row for row, c in enumerate(self.rows.coordinates)}
        blocks, stops = self.solver.plan.blocks, self.solver.stops.blocks
        return [(place[b.unknowns[0]], stop) for b, stop in zip(blocks, stops, strict=True)]

    @cached_property
    def _follows(self) -> list[bool]:
        """For each block of the plan, whether it follows from one that is iterated."""
        plan = self.solver.plan
        numbers = range(len(plan.blocks))
        return [any(plan.blocks[k].iterated for k in plan.blocks_before(n)) for n in numbers]

    @cached_property
    def _angles(self) -> list[int]:
        """Places of reported angles, which are counted from the pose before."""
        return [row for row in self.layout.angles.tolist() if row < self.count]

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
    state->stopped_by = 0;
    state->excess = 0.0;
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
            self._limits_checked(),
            self._outputs(bool(undefined)),
            self._limits_flagged(),
            f"    if (undefined)\n        return {macro}_ANGLES_UNDEFINED;\n" if undefined else "",
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
        if self._angles:
            lines.append(f"const double turn = {2 * math.pi!r};")
        if m:
            lines.append(f"double step[{k + m}];")
        if len(self.limits.rows):
            lines.append("double worst = 0.0;")
        if undefined:
            lines.append("double lock;")
        lines.append("int i;")
        if undefined:
            lines.append("int undefined = 0;")
        return "".join(f"    {line}\n" for line in lines) + "\n"

    def _numbers_checked(self) -> str:
        """Refuse infinity and NaN, and angles of more turns than doubles can tell apart."""
        macro = self.names.constant
        lines = f"""\
    state->stopped_by = 0;
    state->excess = 0.0;
    for (i = 0; i < {self.driven}; ++i)
        if (!isfinite(y[i]) || !isfinite(yd[i]) || !isfinite(ydd[i]))
            return {macro}_OUT_OF_REACH;
    for (i = 0; i < {self.count}; ++i)
        if (!isfinite(state->position[i]))
            return {macro}_OUT_OF_REACH;
"""
        angles = {*self._angles, *self.iterated} & set(self.solver.angle_rows)
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
{self._blamed()}\
    if (out[{residual}] != out[{residual}])
        return {macro}_OUT_OF_REACH;
    if (!(out[{residual}] <= {RESIDUAL!r}*out[{self.rows.size}]))
        return {macro}_ITERATION_LIMIT;
    if (out[{conditioning}] < {-SINGULAR!r})
        return {macro}_BRANCH_CHANGE;
    if (!(out[{conditioning}] >= {SINGULAR!r}))
        return {macro}_SINGULAR;
{self._finite()}"""

    def _blamed(self) -> str:
        """Note which loop cannot be closed: of the first unknown that is none, or the only one that
        is iterated. Where Newton has not settled, it is to blame for what follows from it.
        """
        if not self._unknowns:
            return ""
        stops = self.solver.stops.blocks
        iterated = [
            stop for b, stop in zip(self.solver.plan.blocks, stops, strict=True) if b.iterated
        ]
        otherwise = iterated[0] if len(iterated) == 1 else 0
        residual, k, m = self.rows.residual, self.driven, len(self.iterated)
        told, settled = "loop[i]", ""
        if any(self._follows):
            told = f"follows[i] && !settled ? {otherwise} : loop[i]"
            near = _SETTLED * min(1.0, self.solver.graph.length)
            settled = f"""\
        double again[{m}];
        int settled = 1;

        newton_step(step, again);
        for (i = 0; i < {m}; ++i)
            if (!(fabs(again[i] - step[{k} + i]) <= {near!r}))
                settled = 0;
"""
        return f"""\
    if (!(out[{residual}] <= {RESIDUAL!r}*out[{self.rows.size}])) {{
{settled}        state->stopped_by = {otherwise};
        for (i = {len(self._unknowns) - 1}; i >= 0; --i)
            if (out[unknown[i]] != out[unknown[i]])
                state->stopped_by = {told};
    }}
"""

    def _finite(self) -> str:
        """Refuse what has overflowed."""
        n, total = len(self.rows.coordinates), self.rows.motion.stop
        skipped = f"i % {n} < {n - self.cones} && " if self.cones else ""
        return f"""\
    for (i = 0; i < {total}; ++i)
        if ({skipped}!isfinite(out[i]))
            return {self.names.constant}_OUT_OF_REACH;
"""

    def _turns_counted(self) -> str:
        count = len(self._angles)
        if not count:
            return ""
        return f"""\
    for (i = 0; i < {count}; ++i) /* within half a turn of the pose before */
        out[angles[i]] += turn * round((state->position[angles[i]] - out[angles[i]]) / turn);
"""

    def _kept_where_undefined(self) -> str:
        """Make three angles NaN where they are not defined, and note it."""
        lines = ""
        for rows, second, same in self.layout.triples:
            function = "sin" if same else "cos"
            lines += f"    lock = fabs({function}(out[{second}]));\n"
            for order, level in enumerate(LOCKED[:3]):
                lines += f"    if (lock < {level!r}) {{\n        undefined = 1;\n"
                for row in rows.tolist():
                    lines += f"        out[{self.rows.derivative(row, order)}] = NAN;\n"
                lines += "    }\n"
        return lines

    def _outputs(self, undefined: bool) -> str:
        """Write the state; angles that are not defined keep their values, at rest."""
        places = [f"out[{self.rows.order(order).start} + i]" for order in range(3)]
        names = ("position", "velocity", "acceleration")
        values = list(places)
        if undefined:
            kept = ("state->position[i]", "0.0", "0.0")
            values = [f"{x} == {x} ? {x} : {old}" for x, old in zip(places, kept, strict=True)]
        lines = "".join(
            f"        state->{name}[i] = {value};\n"
            for name, value in zip(names, values, strict=True)
        )
        return f"    for (i = 0; i < {self.count}; ++i) {{\n{lines}    }}\n"

    def _limits_checked(self) -> str:
        """Find the limit exceeded by the greatest part of its range."""
        if not len(self.limits.rows):
            return ""
        return f"""\
    for (i = 0; i < {len(self.limits.rows)}; ++i) {{
        const double q = out[limits[i].row], span = limits[i].high - limits[i].low;
        double excess = 0.0, part;
        if (q < limits[i].low - limits[i].slack)
            excess = q - limits[i].low;
        else if (q > limits[i].high + limits[i].slack)
            excess = q - limits[i].high;
        part = fabs(excess) / (isfinite(span) ? span : 1.0);
        if (part > worst) {{
            worst = part;
            state->excess = excess;
            state->stopped_by = 1 + i;
        }}
    }}
"""

    def _limits_flagged(self) -> str:
        if not len(self.limits.rows):
            return ""
        return f"    if (worst > 0.0)\n        return {self.names.constant}_LIMIT_EXCEEDED;\n"


def _number(value: float) -> str:
    """A double in C."""
    if math.isinf(value):
        return "INFINITY" if value > 0 else "-INFINITY"
    return repr(value)


def _listed(values: Iterable[int]) -> str:
    return ", ".join(str(int(value)) for value in values)
