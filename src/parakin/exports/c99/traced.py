"""A kernel traced into a function in C: each operation becomes a statement."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from parakin.algebra.spatial import FLOATS, Functions, Scalar, as_float
from parakin.kernel.backends import input_count
from parakin.kernel.outputs import Outputs
from parakin.kernel.pose import solve_pose
from parakin.solving.solver import Solver


@dataclass
class _Statements:
    """The right-hand sides of `v0 = ...`, `v1 = ...` in traced order, none of them twice."""

    expressions: list[str] = field(default_factory=list)
    known: dict[str, str] = field(default_factory=dict)

    def let(self, expression: str) -> Term:
        """The variable that holds `expression`."""
        if expression not in self.known:
            self.known[expression] = f"v{len(self.expressions)}"
            self.expressions.append(expression)
        return Term(self, self.known[expression])

    def needed_for(self, results: Sequence[str]) -> list[str]:
        """Definitions of the variables that the results depend on."""
        used = set(results)
        lines: list[str] = []
        for number, expression in reversed(list(enumerate(self.expressions))):
            if f"v{number}" in used:
                lines.append(f"    const double v{number} = {expression};")
                used.update(re.findall(r"\bv\d+\b", expression))
        return lines[::-1]


class Term:
    """A scalar whose arithmetic is recorded in C."""

    __slots__ = ("statements", "text")
    __array_ufunc__ = None  # a NumPy number leaves sums and products with it to us

    def __init__(self, statements: _Statements, text: str) -> None:
        self.statements, self.text = statements, text

    def __neg__(self) -> Term:
        return self.statements.let(f"-{self.text}")

    def __add__(self, other: Scalar) -> Term:
        return self.statements.let(f"{self.text} + {_text(other)}")

    def __radd__(self, other: Scalar) -> Term:
        return self.statements.let(f"{_text(other)} + {self.text}")

    def __sub__(self, other: Scalar) -> Term:
        return self.statements.let(f"{self.text} - {_text(other)}")

    def __rsub__(self, other: Scalar) -> Term:
        return self.statements.let(f"{_text(other)} - {self.text}")

    def __mul__(self, other: Scalar) -> Term:
        return self.statements.let(f"{self.text}*{_text(other)}")

    def __rmul__(self, other: Scalar) -> Term:
        return self.statements.let(f"{_text(other)}*{self.text}")

    def __truediv__(self, other: Scalar) -> Term:
        return self.statements.let(f"{self.text}/{_text(other)}")

    def __rtruediv__(self, other: Scalar) -> Term:
        return self.statements.let(f"{_text(other)}/{self.text}")


def _text(a: Scalar) -> str:
    if isinstance(a, Term):
        return a.text
    number = repr(as_float(a))
    return f"({number})" if number.startswith("-") else number


def _functions(statements: _Statements) -> Functions:
    def function(pattern: str, plain: Any) -> Callable[..., Scalar]:
        def apply(*arguments: Scalar) -> Any:
            if not any(isinstance(a, Term) for a in arguments):
                return plain(*arguments)
            return statements.let(pattern.format(*(_text(a) for a in arguments)))

        return apply

    patterns = (
        *("sin({})", "cos({})", "sqrt({})", "atan2({} + 0.0, {} + 0.0)"),
        *("{1} < {0} ? {1} : {0}", "{1} < 0.0 ? -{0} : {0}", "1.0 / {}"),
    )
    return Functions(*(function(p, f) for p, f in zip(patterns, FLOATS, strict=True)))


def c_function(
    solver: Solver,
    name: str,
    outputs: Outputs,
    rows: Sequence[int] | None = None,
) -> str:
    """A function in C from a kernel's inputs to its outputs, with one Newton step if it iterates.

    in: driven positions and as many derivatives as `outputs` has, then the guess of what is
    iterated, and what loads take. out: the rows of `outputs`, or those of them chosen.
    """
    statements = _Statements()
    k = len(solver.driven)
    orders = 1 + outputs.derivatives
    count = input_count(solver.plan, outputs)
    inputs = [Term(statements, f"in[{i}]") for i in range(count)]
    rest = k * orders + len(solver.iterated)
    results = solve_pose(
        solver.plan,
        [inputs[k * order : k * (order + 1)] for order in range(orders)],
        inputs[k * orders : rest],
        _functions(statements),
        outputs,
        1,
        loads=inputs[rest:],
    )
    chosen = range(len(results)) if rows is None else rows
    texts = [_text(results[row]) for row in chosen]
    body = statements.needed_for(texts)
    body += [f"    out[{i}] = {text};" for i, text in enumerate(texts)]
    if not any("in[" in line for line in body):
        body.insert(0, "    (void)in;")
    lines = "\n".join(body)
    return f"static void {name}(const double *in, double *out)\n{{\n{lines}\n}}\n"
