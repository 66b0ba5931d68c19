"""Exported C: it compiles without a warning and does what the solver does, flags included."""

from __future__ import annotations

import ctypes
import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from engines import along

import parakin
from parakin import Status
from parakin.exports import export as exports
from parakin.solving.status import Status as Flag

COMPILER = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O1")
pytestmark = pytest.mark.skipif(COMPILER is None, reason="no C compiler")

FORWARD = ("flight-simulator", "gough-stewart", "delta", "3-rrr", "6-rus", "tricept")


def actuated(name: str) -> list[str]:
    solver = parakin.compile(name, machine_code=False)
    return [c.name for c in solver.graph.coordinates if c.actuated]


def run(folder: Path, *command: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def compiled(folder: Path, *arguments: str) -> None:
    """Compiled without an error or a warning."""
    assert COMPILER is not None
    done = run(folder, COMPILER, *STRICT, *arguments, "-lm")
    assert done.returncode == 0, done.stderr
    assert not done.stderr


class Kernel:
    """The compiled kernel, called as C would."""

    def __init__(self, folder: Path, coordinates: int) -> None:
        compiled(folder, "-fPIC", "-shared", "kernel.c", "-o", "kernel.so")

        class State(ctypes.Structure):
            _fields_ = [
                *((n, ctypes.c_double * coordinates) for n in ("q", "qd", "qdd")),
                ("residual", ctypes.c_double),
                ("conditioning", ctypes.c_double),
                ("stopped_by", ctypes.c_int),
                ("excess", ctypes.c_double),
            ]

        self.library = ctypes.CDLL(str(folder / "kernel.so"))
        self.state = State()
        self.library.kernel_home(ctypes.byref(self.state))

    def solve(self, *orders: np.ndarray) -> int:
        arrays = [(ctypes.c_double * len(order))(*order) for order in orders]
        return int(self.library.kernel_solve(*arrays, ctypes.byref(self.state)))

    @property
    def orders(self) -> np.ndarray:
        return np.array([list(self.state.q), list(self.state.qd), list(self.state.qdd)])


CASES = [(name, False) for name in parakin.catalogue() if name != "flight-simulator-upu"]
CASES += [(name, True) for name in FORWARD]


@pytest.mark.parametrize(("name", "forward"), CASES)
def test_the_test_program_agrees(name: str, forward: bool, tmp_path: Path) -> None:
    driven = actuated(name) if forward else None
    exports.export(parakin.load(name), tmp_path / "kernel.c", driven)
    compiled(tmp_path, "kernel_test.c", "kernel.c", "-o", "kernel_test")
    done = run(tmp_path, str(tmp_path / "kernel_test"))
    assert done.returncode == 0, done.stdout
    assert re.match(r"20 poses, 0 with another status, largest relative difference \d", done.stdout)


def test_the_test_program_knows_poses_beyond_limits_too(tmp_path: Path) -> None:
    limits = {"A": ("100 deg", "200 deg"), "C.velocity": (-1e-3, 1e-3)}
    mechanism = parakin.load("slider-crank").model_copy(update={"limits": limits})
    exports.export(mechanism, tmp_path / "kernel.c")
    compiled(tmp_path, "kernel_test.c", "kernel.c", "-o", "kernel_test")
    done = run(tmp_path, str(tmp_path / "kernel_test"))
    assert done.returncode == 0, done.stdout
    assert done.stdout.startswith("20 poses, 0 with another status, ")


@pytest.mark.parametrize("forward", [False, True])
@pytest.mark.parametrize("name", ["flight-simulator", "gough-stewart", "five-bar"])
def test_a_whole_motion_agrees(name: str, forward: bool, tmp_path: Path) -> None:
    """To 1e-12 of what is compared, accelerations of up to 40 m/s² among it."""
    inverse = parakin.compile(name, machine_code=False)
    motion = along(inverse, 100)
    result = inverse.solve(motion)
    driven = actuated(name) if forward else list(inverse.driven)
    rows = [inverse.coordinates.index(n) for n in driven]
    given = [result[q].values[:, rows] for q in ("position", "velocity", "acceleration")]
    solver = parakin.compile(name, driven, machine_code=False)
    exports.export(parakin.load(name), tmp_path / "kernel.c", driven)
    kernel = Kernel(tmp_path, len(solver.coordinates))
    guess = np.array([solver.home[n] for n in solver.coordinates])
    for y, yd, ydd in zip(*given, strict=True):
        assert kernel.solve(y, yd, ydd) == Status.CONVERGED
        tick = solver.at(y, yd, ydd, guess)
        guess = tick.position
        expected = np.array([tick.position, tick.velocity, tick.acceleration])
        off = np.abs(kernel.orders - expected) / (1.0 + np.abs(expected))
        assert off.max() < 1e-12


def test_what_cannot_be_solved_is_flagged_and_the_last_pose_kept(tmp_path: Path) -> None:
    solver = parakin.compile("flight-simulator", machine_code=False)
    exports.export(solver.mechanism, tmp_path / "kernel.c")
    kernel = Kernel(tmp_path, len(solver.coordinates))
    home, still = np.array([solver.home[n] for n in solver.driven]), np.zeros(3)
    assert kernel.solve(home, still, still) == Status.CONVERGED
    before = kernel.orders
    lengths = (0, 1)  # of the driven coordinates; an angle of 1,000 is one like any other
    for bad, places in ((np.nan, range(3)), (np.inf, range(3)), (1e3, lengths), (-1e300, lengths)):
        for k in places:
            y = home.copy()
            y[k] = bad
            assert kernel.solve(y, still, still) in (Status.OUT_OF_REACH, Status.ITERATION_LIMIT)
            np.testing.assert_array_equal(kernel.orders, before)
    assert kernel.solve(home, still, still) == Status.CONVERGED
    np.testing.assert_array_equal(kernel.orders, before)


def test_limits_and_turns_are_those_of_the_solver(tmp_path: Path) -> None:
    """A crank that turns three times, its rocker being held to less than it swings."""
    mechanism = parakin.load("four-bar").model_copy(
        update={"limits": {"D": (0.0, 1.5)}, "driven": ("A",)}
    )
    exports.export(mechanism, tmp_path / "kernel.c")
    solver = parakin.compile(mechanism, machine_code=False)
    kernel = Kernel(tmp_path, len(solver.coordinates))
    guess = np.array([solver.home[n] for n in solver.coordinates])
    rocker = solver.coordinates.index("D")
    seen = set()
    for angle in solver.home["A"] + np.linspace(0.0, 6 * np.pi, 400):
        status = kernel.solve([angle], [1.0], [0.0])  # type: ignore[arg-type]
        tick = solver.at([angle], [1.0], guess=guess)
        guess = tick.position
        beyond = not 0.0 <= guess[rocker] <= 1.5
        assert status == (Flag.LIMIT_EXCEEDED if beyond else Flag.CONVERGED)
        np.testing.assert_allclose(kernel.orders[0], guess, rtol=0, atol=1e-12)
        seen.add(status)
    assert seen == {Flag.LIMIT_EXCEEDED, Flag.CONVERGED}


def test_the_header_names_everything_with_its_unit(tmp_path: Path) -> None:
    exports.export(parakin.load("flight-simulator"), tmp_path / "kernel.c")
    header = (tmp_path / "kernel.h").read_text()
    solver = parakin.compile("flight-simulator", machine_code=False)
    for name in (*solver.driven, *solver.coordinates):
        unit = solver.graph.coordinates[solver.graph.index(name, "")].unit
        assert f"/* {name} [{unit}, {unit}/s, {unit}/s^2] */" in header
    assert "KERNEL_B1_2 = " in header
    source = (tmp_path / "kernel.c").read_text()
    assert set(re.findall(r"#include (\S+)", source)) == {'"kernel.h"', "<math.h>"}
    assert not re.search(r"\b(malloc|free|printf|static double)\b", source)


def test_names_that_would_end_a_comment_do_not(tmp_path: Path) -> None:
    mechanism = parakin.load("four-bar").model_copy(update={"title": "a */ #error /* b"})
    exports.export(mechanism, tmp_path / "9 lives.c")
    compiled(tmp_path, "9 lives.c", "9 lives_test.c")
    assert "m9_lives_solve" in (tmp_path / "9 lives.h").read_text()


@pytest.mark.parametrize(
    ("flags", "taken"),
    [
        (["-O3"], True),
        (["-O3", "-ffast-math"], False),
        (["-Ofast"], False),
        (["-O2", "-ffinite-math-only"], False),
        (["-O2", "-fno-finite-math-only"], True),
        (["-D_M_FP_FAST"], False),
    ],
)
def test_it_refuses_to_be_compiled_as_if_there_were_no_nan(
    flags: list[str], taken: bool, tmp_path: Path
) -> None:
    assert COMPILER is not None
    parakin.export("four-bar", tmp_path / "kernel.c")
    done = run(tmp_path, COMPILER, "-std=c99", *flags, "-c", "kernel.c")
    assert (done.returncode == 0) == taken
    assert ("takes NaN for a number" in done.stderr) == (not taken)


def test_a_name_that_is_not_utf_8_is_included(tmp_path: Path) -> None:
    name = os.fsdecode(b"b\xff")
    parakin.export("four-bar", tmp_path / f"{name}.c")
    compiled(tmp_path, f"{name}_test.c", f"{name}.c", "-o", "test")
    assert run(tmp_path, "./test").returncode == 0
