"""Machine code: the kernel traced once into expressions and compiled by heyoka.

The only module that knows heyoka, which is a wheel on Linux and a conda-forge package elsewhere.
Without it the same kernel is played back on NumPy arrays (`parakin.kernel.tape`), some twenty times
slower. Arithmetic is
IEEE-strict either way, so a NaN stays a NaN.
"""

from __future__ import annotations

import copy
import functools
import importlib.util
import os
import pickle
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

from parakin.algebra.arcs import atan2
from parakin.algebra.spatial import FLOATS, Functions, Scalar
from parakin.arrays import FloatArray
from parakin.kernel.forking import in_children, no_fork
from parakin.kernel.forward import ForwardRows, accelerations
from parakin.kernel.outputs import Outputs
from parakin.kernel.pose import solve_pose
from parakin.kernel.tape import Program, Tape, program
from parakin.planning.plan import Plan

# inputs (n_in,) or (n_in, batch), outputs alike, and whether to use all cores on a batch
Kernel = Callable[[FloatArray, FloatArray, bool], None]

_MANY = 300  # results: from here on compact code is made sooner, and no slower


class Flow(NamedTuple):
    """A state's way: at any times (n,), (n, s), with `times` of its steps; the last state; whether
    it was stopped, or failed.
    """

    output: Any
    last: FloatArray
    stopped: bool
    failed: bool


# A state (s,), what else is taken, begin and end [s], and whether to go on after a step.
Taylor = Callable[
    [FloatArray, FloatArray, tuple[float, float], Callable[[float, FloatArray], bool]], Flow
]
_CODE = "code"  # of a kernel in machine code: heyoka's function

Traced = Callable[[Sequence[Scalar], Functions], list[Scalar]]


def has_machine_code() -> bool:
    """Whether heyoka is installed."""
    return importlib.util.find_spec("heyoka") is not None


def input_count(plan: Plan, outputs: Outputs) -> int:
    """Driven values, then as many derivatives of them; parameters left open, and coordinates at
    home (`Plan.standing`); the guess; what loads take, and angles of springs (`ForceRows.wound`).
    """
    loads = 0
    if outputs.forces is not None:
        loads = plan.graph.dynamics.inputs + len(outputs.forces.wound)
    return (
        _orders(outputs) * len(plan.driven)
        + given_count(plan, outputs)
        + len(plan.iterated)
        + loads
    )


def given_count(plan: Plan, outputs: Outputs) -> int:
    """How many inputs tell the design: none if nothing is left open."""
    if plan.designs is None:
        return 0
    return plan.designs.count + len(plan.standing(outputs.coordinates))


def _orders(outputs: Outputs) -> int:
    return 1 + outputs.derivatives


def make_kernel(plan: Plan, outputs: Outputs, *, machine_code: bool, steps: int) -> Kernel:
    """The plan as a function from arrays to arrays, with `steps` Newton steps where it iterates."""
    traced = partial(_traced, plan, outputs, steps)
    return compiled(traced, input_count(plan, outputs), machine_code=machine_code)


def make_forward_kernel(rows: ForwardRows, *, machine_code: bool) -> Kernel:
    """Forward dynamics as a function from arrays to arrays."""
    return compiled(partial(accelerations, rows), rows.inputs, machine_code=machine_code)


def make_taylor(rows: ForwardRows, rtol: float) -> Taylor:
    """Forward dynamics integrated by heyoka's Taylor series, of as high an order as rtol asks for.
    In compact mode: otherwise it would compile for minutes.
    """
    import heyoka as hy

    hy.set_logger_level_error()
    taken = hy.make_vars(*(f"i{k}" for k in range(rows.state)))
    given = [hy.par[k] for k in range(rows.inputs - rows.state)]
    found = accelerations(rows, [*taken, *given], _symbolic(series=True))
    driven = len(rows.plan.driven)
    rates = [*taken[-1 - driven : -1], *found[: rows.state - driven]]
    equations = list(zip(taken, map(_constant, rates), strict=True))
    with no_fork():
        made = hy.taylor_adaptive(equations, tol=rtol, pars=[0.0] * len(given), compact_mode=True)

    def flow(
        state: FloatArray,
        given: FloatArray,
        span: tuple[float, float],
        goes_on: Callable[[float, FloatArray], bool],
    ) -> Flow:
        way = copy.copy(made)
        way.time, way.state[:], way.pars[:] = span[0], state, given
        outcome, *_, output, _ = way.propagate_until(
            span[1], c_output=True, callback=lambda at: goes_on(at.time, at.state)
        )
        reached = outcome == hy.taylor_outcome.time_limit
        stopped = outcome == hy.taylor_outcome.cb_stop
        return Flow(output, way.state.copy(), stopped, not (reached or stopped))

    return flow


def compiled(traced: Traced, count: int, *, machine_code: bool) -> Kernel:
    """What is traced, from `count` inputs, as a function from arrays to arrays."""
    if not machine_code:
        return _played(traced, count)
    with no_fork():
        return _machine_code(traced, count)


def _traced(
    plan: Plan, outputs: Outputs, steps: int, inputs: Sequence[Scalar], functions: Functions
) -> list[Scalar]:
    n = len(plan.driven)
    orders = [inputs[n * k : n * (k + 1)] for k in range(_orders(outputs))]
    rest = inputs[n * _orders(outputs) :]
    if plan.designs is not None:
        m, standing = plan.designs.count, plan.standing(outputs.coordinates)
        at_home = dict(zip(standing, rest[m:], strict=False))
        plan, rest = plan.opened(rest[:m], at_home, functions), rest[m + len(standing) :]
    guess, loads = rest[: len(plan.iterated)], rest[len(plan.iterated) :]
    return solve_pose(plan, orders, guess, functions, outputs, steps, loads=loads)


def _played(traced: Traced, count: int) -> Kernel:
    made: list[Program] = []

    def kernel(inputs: FloatArray, out: FloatArray, parallel: bool) -> None:  # noqa: ARG001
        if not made:  # many kernels are made and never run
            tape = Tape(count)
            made.append(program(tape, traced(tape.inputs, tape.functions())))
        (made[0].play_alone if inputs.ndim == 1 else made[0].play)(inputs, out)

    return kernel


def _constant(a: Scalar) -> Scalar:
    import heyoka as hy

    return hy.expression(float(a)) if isinstance(a, (int, float)) else a


def _symbolic(*, series: bool = False) -> Functions:
    """The elementary functions of expressions, those of constants being worked out at once.
    series: expressions are to be expanded in time, for which a polynomial of an arc would be long.
    """
    import heyoka as hy

    def lifted(symbolic: Any, plain: Any) -> Callable[..., Scalar]:
        def function(*arguments: Scalar) -> Any:
            if all(type(a) is float for a in arguments):
                return plain(*arguments)
            return symbolic(*(_constant(a) for a in arguments))

        return function

    def minimum(a: Scalar, b: Scalar) -> Any:
        return hy.select(hy.lt(b, a), b, a)

    def copysign(size: Scalar, sign: Scalar) -> Any:
        return hy.select(hy.lt(sign, _constant(0.0)), -size, size)

    def less(a: Scalar, b: Scalar) -> Any:
        return hy.lt(_constant(a), _constant(b))

    def arc(y: Scalar, x: Scalar) -> Any:
        return atan2(y, x, hy.select, less)

    def inverse(a: Scalar) -> Any:
        # heyoka would make (1 / a) b into b / a, and divide once for each b, but for the condition,
        # which never holds.
        return hy.select(hy.lt(a, a), _constant(0.0), 1.0 / a)

    divided = Functions(hy.sin, hy.cos, hy.sqrt, hy.atan2, minimum, copysign, lambda a: 1.0 / a)
    symbolic = divided if series else divided._replace(atan2=arc, inverse=inverse)
    return Functions(*(lifted(f, g) for f, g in zip(symbolic, FLOATS, strict=True)))


def _on_one_core() -> None:
    import heyoka as hy

    hy.set_nthreads(1)


def _machine_code(traced: Traced, count: int) -> Kernel:
    import heyoka as hy

    in_children(_on_one_core)
    hy.set_logger_level_error()  # its warnings (of a cache it cannot write) go to stdout

    inputs = hy.make_vars(*(f"i{k}" for k in range(count)))
    inputs = inputs if isinstance(inputs, list) else [inputs]
    results = traced(list(inputs), _symbolic())
    # LLVM's time grows faster than the length of a kernel, unless parts that are alike share code.
    how = {"compact_mode": True, "opt_level": 1} if len(results) > _MANY else {}
    return _kernel_of(hy.cfunc([_constant(result) for result in results], vars=inputs, **how))


def _kernel_of(code: Any) -> Kernel:
    def kernel(inputs: FloatArray, out: FloatArray, parallel: bool) -> None:
        if inputs.ndim == 1:
            code(inputs, outputs=out)
        elif not parallel:
            code(inputs, outputs=out, batch_parallel=False)
        else:
            with no_fork():
                code(inputs, outputs=out, batch_parallel=True)

    vars(kernel)[_CODE] = code
    return kernel


@functools.cache
def made_by() -> str:
    """What machine code depends on beyond what is traced: heyoka, by version and library, and the
    processor, as LLVM knows it.
    """
    import heyoka as hy
    from heyoka import _core

    hy.set_logger_level_error()
    library, known = os.stat(_core.__file__), hy.llvm_state.get_diskcache_enabled()
    x = hy.make_vars("x")
    with no_fork():
        # Heyoka's own cache may be of gigabytes, and takes half a second to open then.
        hy.llvm_state.set_diskcache_enabled(False)
        try:
            (state, *_) = hy.cfunc([x], vars=[x]).llvm_states
        finally:
            hy.llvm_state.set_diskcache_enabled(known)
    processor = " ".join(str(state).split())
    return f"heyoka {hy.__version__} {library.st_size} {library.st_mtime_ns}, {processor}"


def packed(kernel: Kernel) -> bytes | None:
    """Machine code, to be unpacked by what `made_by` says is the same; None if it is none."""
    code = vars(kernel).get(_CODE)
    return None if code is None else pickle.dumps(code, protocol=5)


def unpacked(content: bytes) -> Kernel:
    """The kernel of packed machine code."""
    import heyoka as hy

    in_children(_on_one_core)
    hy.set_logger_level_error()
    with no_fork():
        return _kernel_of(pickle.loads(content))
