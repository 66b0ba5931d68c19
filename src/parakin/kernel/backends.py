"""Machine code: the kernel traced once into expressions and compiled by heyoka.

The only module that knows heyoka, which is a wheel on Linux and a conda-forge package elsewhere.
Without it the same kernel runs on NumPy arrays, about a hundred times slower. Arithmetic is
IEEE-strict either way, so a NaN stays a NaN.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from parakin.algebra.spatial import ARRAYS, FLOATS, Functions, Scalar, as_array
from parakin.arrays import FloatArray
from parakin.kernel.forking import in_children, no_fork
from parakin.kernel.forward import ForwardRows, accelerations
from parakin.kernel.outputs import Outputs
from parakin.kernel.pose import solve_pose
from parakin.planning.plan import Plan

# inputs (n_in,) or (n_in, batch), outputs alike, and whether to use all cores on a batch
Kernel = Callable[[FloatArray, FloatArray, bool], None]
Traced = Callable[[Sequence[Scalar], Functions], list[Scalar]]


def has_machine_code() -> bool:
    """Whether heyoka is installed."""
    return importlib.util.find_spec("heyoka") is not None


def input_count(plan: Plan, outputs: Outputs) -> int:
    """Driven values, then as many derivatives of them, the guess, and what loads take, with the
    angles of springs (`ForceRows.wound`).
    """
    loads = 0
    if outputs.forces is not None:
        loads = plan.graph.dynamics.inputs + len(outputs.forces.wound)
    return _orders(outputs) * len(plan.driven) + len(plan.iterated) + loads


def _orders(outputs: Outputs) -> int:
    return 1 + outputs.derivatives


def make_kernel(plan: Plan, outputs: Outputs, *, machine_code: bool, steps: int) -> Kernel:
    """The plan as a function from arrays to arrays, with `steps` Newton steps where it iterates."""
    traced = partial(_traced, plan, outputs, steps)
    return _made(traced, input_count(plan, outputs), machine_code=machine_code)


def make_forward_kernel(rows: ForwardRows, *, machine_code: bool) -> Kernel:
    """Forward dynamics as a function from arrays to arrays."""
    return _made(partial(accelerations, rows), rows.inputs, machine_code=machine_code)


def _made(traced: Traced, count: int, *, machine_code: bool) -> Kernel:
    if not machine_code:
        return _arrays(traced)
    with no_fork():
        return _machine_code(traced, count)


def _traced(
    plan: Plan, outputs: Outputs, steps: int, inputs: Sequence[Scalar], functions: Functions
) -> list[Scalar]:
    n = len(plan.driven)
    orders = [inputs[n * k : n * (k + 1)] for k in range(_orders(outputs))]
    rest = inputs[n * _orders(outputs) :]
    guess, loads = rest[: len(plan.iterated)], rest[len(plan.iterated) :]
    return solve_pose(plan, orders, guess, functions, outputs, steps, loads=loads)


def _arrays(traced: Traced) -> Kernel:
    def kernel(inputs: FloatArray, out: FloatArray, parallel: bool) -> None:  # noqa: ARG001
        with np.errstate(all="ignore"):  # what cannot be reached is NaN, and flagged as such
            results = traced(list(inputs), ARRAYS)
        for row, value in enumerate(results):
            out[row] = as_array(value)

    return kernel


def _on_one_core() -> None:
    import heyoka as hy

    hy.set_nthreads(1)


def _machine_code(traced: Traced, count: int) -> Kernel:
    import heyoka as hy

    in_children(_on_one_core)
    hy.set_logger_level_error()  # its warnings (of a cache it cannot write) go to stdout

    def constant(a: Scalar) -> Scalar:
        return hy.expression(float(a)) if isinstance(a, (int, float)) else a

    def lifted(symbolic: Any, plain: Any) -> Callable[..., Scalar]:
        """The function on expressions, constants being worked out at once."""

        def function(*arguments: Scalar) -> Any:
            if all(type(a) is float for a in arguments):
                return plain(*arguments)
            return symbolic(*(constant(a) for a in arguments))

        return function

    def minimum(a: Scalar, b: Scalar) -> Any:
        return hy.select(hy.lt(b, a), b, a)

    def copysign(size: Scalar, sign: Scalar) -> Any:
        return hy.select(hy.lt(sign, constant(0.0)), -size, size)

    symbolic = Functions(hy.sin, hy.cos, hy.sqrt, hy.atan2, minimum, copysign)
    functions = Functions(*(lifted(f, g) for f, g in zip(symbolic, FLOATS, strict=True)))
    inputs = hy.make_vars(*(f"i{k}" for k in range(count)))
    inputs = inputs if isinstance(inputs, list) else [inputs]
    results = traced(list(inputs), functions)
    code = hy.cfunc([constant(result) for result in results], vars=inputs)

    def kernel(inputs: FloatArray, out: FloatArray, parallel: bool) -> None:
        if inputs.ndim == 1:
            code(inputs, outputs=out)
        elif not parallel:
            code(inputs, outputs=out, batch_parallel=False)
        else:
            with no_fork():
                code(inputs, outputs=out, batch_parallel=True)

    return kernel
