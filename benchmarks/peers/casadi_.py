"""CasADi: closure as SX expressions, its own Newton iteration, derivatives by its own means.

The rates solve linear systems in the closure's Jacobians. Batches are CasADi's `map`, on one
thread, and calls go through its buffers, which copy nothing. Compiled, the same functions are
generated as C and built by gcc; of CasADi's two Newton methods only `fast_newton` can be.
"""

from __future__ import annotations

import os
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from benchmarks.baselines import D1, D2, D3, D4, D5, L1, L2, L3, L4, S_A, S_B, S_C, B, H
from benchmarks.peers.dimensions import AXES, FEET, STROKE_0, TOPS
from benchmarks.peers.ways import (
    CLOSED,
    COUNT,
    POSE,
    SLIDERS,
    VARIABLES,
    Answer,
    Both,
    Floats,
    Way,
    others,
)

COMPILE = ("gcc", "-O3", "-march=native", "-shared", "-fPIC")


def flight_simulator(compiled: bool = False) -> Both:
    q = ca.SX.sym("q", len(VARIABLES))
    x, y, phi, a, la, a3, f, g, lb, i, j, lc, d, e, s = ca.vertsplit(q)
    gamma = a - a3
    rod = ca.vertcat(ca.cos(gamma), ca.sin(gamma), 0)
    arm = B / 2 * ca.vertcat(ca.sin(phi) * rod[1], -ca.sin(phi) * rod[0], ca.cos(phi))
    side_b = ca.vertcat(-ca.sin(f) * ca.sin(g), ca.cos(f) * ca.sin(g), -ca.cos(g))
    side_c = ca.vertcat(-ca.sin(i) * ca.sin(j), ca.cos(i) * ca.sin(j), ca.cos(j))
    foot, G = D2 + D3 + D4, ca.vertcat(x, y, 0)
    plane = ca.vertcat(
        (S_A + L1 + la) * ca.vertcat(ca.cos(a), ca.sin(a)) + H * rod[:2] - G[:2],
        ca.vertcat(D2 + D3, 0) + L3 * ca.vertcat(ca.cos(d), ca.sin(d)) + (H - D1) * rod[:2] - G[:2],
        ca.vertcat(D2, 0) + L4 * ca.vertcat(ca.cos(e), ca.sin(e)) + (H - D1 - s) * rod[:2] - G[:2],
    )
    sides = ca.vertcat(
        ca.vertcat(foot, 0, D5) + (S_B + L2 + lb) * side_b - G - arm,
        ca.vertcat(foot, 0, -D5) + (S_C + L2 + lc) * side_c - G + arm,
    )
    closure = ca.vertcat(plane, sides)
    qd = ca.SX.sym("qd", len(VARIABLES))
    jacobian = ca.jacobian(closure, q)
    drift = ca.jtimes(jacobian @ qd, q, qd)
    terms = ca.Function("terms", [q, qd], [jacobian, drift])

    def way(driven: list[int]) -> Way:
        rest = others(driven)
        rows = ca.Function("rows", [q[rest], q[driven]], [closure])
        given, guess = ca.MX.sym("given", len(driven), 3), ca.MX.sym("guess", len(rest))
        position = root_of(rows, compiled)(guess, given[:, 0])
        places = np.argsort([*driven, *rest])  # from driven and found to all

        def all_of(order: int, found: Any) -> Any:
            return ca.vertcat(given[:, order], found)[places.tolist()]

        by_all, _ = terms(all_of(0, position), 0)
        by_rest, by_driven = by_all[:, rest], by_all[:, driven]
        velocity = -ca.solve(by_rest, by_driven @ given[:, 1], "qr")
        _, remainder = terms(all_of(0, position), all_of(1, velocity))
        acceleration = -ca.solve(by_rest, by_driven @ given[:, 2] + remainder, "qr")
        answer = ca.horzcat(position, velocity, acceleration)
        return called(ca.Function("solve", [given, guess], [answer]), compiled)

    return Both(way(POSE), way(SLIDERS))


def hexapod(compiled: bool = False) -> Both:
    pose = ca.SX.sym("pose", 6)
    turn = ca.SX.eye(3)
    for k in range(3):
        axis, angle = ca.skew(np.eye(3)[k]), pose[3 + k]
        turn = turn @ (ca.SX.eye(3) + ca.sin(angle) * axis + (1 - ca.cos(angle)) * axis @ axis)
    joints, lengths = [], []
    for foot, top, axes in zip(FEET, TOPS, AXES, strict=True):
        leg = axes.T @ (pose[:3] + turn @ top - foot)
        length = ca.norm_2(leg)
        bend = ca.atan2(ca.norm_2(leg[:2]), leg[2])
        joints += [ca.atan2(leg[0], -leg[1]), bend, length - STROKE_0]
        lengths.append(length)
    guess, strokes = ca.SX.sym("guess", 18), ca.SX.sym("strokes", 6)
    inverse = ca.Function("solve", [pose, guess], [ca.vertcat(*joints)])
    rows = ca.Function("rows", [pose, strokes], [ca.vertcat(*lengths) - STROKE_0 - strokes])
    given, start = ca.MX.sym("given", 6), ca.MX.sym("guess", 6)
    forward = ca.Function("solve", [given, start], [root_of(rows, compiled)(start, given)])
    return Both(called(inverse, compiled), called(forward, compiled))


def root_of(rows: Any, compiled: bool) -> Any:
    method = "fast_newton" if compiled else "newton"
    return ca.rootfinder("root", method, rows, {"abstol": CLOSED})


def called(solve: Any, compiled: bool) -> Way:
    """One pose and batches of the usual size, as functions of arrays."""
    functions = [solve, solve.map(COUNT)]
    if compiled:
        functions = built(functions)
    one, many = (buffered(function) for function in functions)

    def for_one(given: Floats, guess: Floats) -> Answer:
        return one(np.ascontiguousarray(given), np.ascontiguousarray(guess)).copy()

    def for_many(given: Floats, guess: Floats) -> Answer:
        # CasADi's columns are our rows
        found = many(np.ascontiguousarray(given.transpose(2, 0, 1)), np.ascontiguousarray(guess.T))
        answers: Floats = found.reshape(COUNT, len(given), -1).transpose(1, 2, 0)
        return answers.copy()

    return Way(for_one, for_many)


def buffered(function: Any) -> Callable[[Floats, Floats], Floats]:
    buffer, trigger = function.buffer()
    answer = np.empty(function.size_out(0)[::-1])
    buffer.set_res(0, answer.data)

    def call(given: Floats, guess: Floats) -> Floats:
        buffer.set_arg(0, given.data)
        buffer.set_arg(1, guess.data)
        trigger()
        return answer

    return call


def built(functions: list[Any]) -> list[Any]:
    """The same functions from generated C."""
    with tempfile.TemporaryDirectory() as folder:
        code = ca.CodeGenerator("solve.c")
        for function in functions:
            code.add(function)
        code.generate(folder + os.sep)
        library = str(Path(folder, "solve.so"))
        subprocess.run([*COMPILE, str(Path(folder, "solve.c")), "-o", library, "-lm"], check=True)
        return [ca.external(function.name(), library) for function in functions]
