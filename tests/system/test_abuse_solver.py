"""The solver fed with nonsense: every answer is right or flagged, at once, and always the same.

That an answer is right is seen here by going along the joints with plain rotation matrices, from
the base to both bodies of every joint, and never by parakin's own residual.
"""

from __future__ import annotations

import hashlib
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from oracle import gaps, ordered

import parakin
from parakin import Status
from parakin.kernel.backends import has_machine_code
from parakin.motion.laws import constant, from_laws
from parakin.motion.sampled import from_arrays
from parakin.solving.status import RESIDUAL

FloatArray = NDArray[np.float64]

FAST = has_machine_code()
KILLS = 3
LEGS = tuple(f"P{i}" for i in range(1, 7))
TOLERANCE = 1e-10  # metres, and sines of angles
NEVER = [math.nan, math.inf, -math.inf]
FAR = [1e3, -1e3, 1e6, 1e12, 1e100, 1e154, 1e200, 1e300, -1e300, 1.7e308]


def largest_gap(solver: parakin.Solver, position: FloatArray) -> float:
    """How far the joints of a solver with all coordinates are from closing [m or rad], at worst."""
    graph = solver.graph
    loops = sum(closing for _, closing in ordered(solver))
    assert loops == len(graph.joints) - len(graph.bodies) + 1  # every loop, one by one
    return float(np.max(gaps(solver, position)))


# ---- solvers


@pytest.fixture(scope="module")
def simulator() -> parakin.Solver:
    return parakin.compile("flight-simulator", coordinates="all", derivatives=1)


@pytest.fixture(scope="module")
def hexapod() -> parakin.Solver:
    return parakin.compile("gough-stewart", driven=LEGS, coordinates="all", derivatives=0)


@pytest.fixture(scope="module")
def full() -> dict[bool, parakin.Solver]:
    return {
        False: parakin.compile("flight-simulator"),
        True: parakin.compile("gough-stewart", driven=LEGS),
    }


def judged(solver: parakin.Solver, y: FloatArray, tick: parakin.Tick) -> NDArray[np.bool_]:
    """Which samples are solved; asserts that these are right, and that the others are NaN."""
    status = np.asarray(tick.status)
    good: NDArray[np.bool_] = status == Status.CONVERGED
    assert np.isin(status, [int(s) for s in Status]).all()
    for part in (tick.position, tick.velocity, tick.acceleration):
        assert np.isfinite(part[:, good]).all()
        assert np.isnan(part[:, ~good]).all()
    if good.any():
        kept = np.flatnonzero(good)[:20_000]
        driven = [solver.coordinates.index(name) for name in solver.driven]
        np.testing.assert_allclose(tick.position[driven][:, kept], y[:, kept], rtol=0, atol=1e-12)
        # The promise is relative to what is subtracted: of legs of a kilometre, nanometres.
        size = np.abs(tick.position[:, kept]).max()
        assert largest_gap(solver, tick.position[:, kept]) < max(TOLERANCE, RESIDUAL * size)
    return good


def test_the_judge_knows_right_from_wrong(simulator: parakin.Solver) -> None:
    home = np.array([[simulator.home[name]] for name in simulator.driven])
    tick = simulator.at(home)
    assert largest_gap(simulator, tick.position) < 1e-14
    rows = [k for k, c in enumerate(simulator.coordinates) if not c.endswith("cone")]
    for row in rows:
        off = tick.position.copy()
        off[row] += 1e-6
        assert largest_gap(simulator, off) > 1e-8, simulator.coordinates[row]


# ---- one pose at a time


@pytest.mark.parametrize("number", range(3))
@pytest.mark.parametrize("value", [*NEVER, *FAR])
def test_a_pose_that_cannot_be(simulator: parakin.Solver, value: float, number: int) -> None:
    y = np.array([simulator.home[name] for name in simulator.driven])
    y[number] = value
    tick = simulator.at(y)
    together = simulator.at(np.repeat(y[:, None], 3, axis=1))
    assert set(np.asarray(together.status)) == {tick.status}
    good = judged(simulator, y[:, None], simulator.at(y[:, None]))
    if simulator.driven[number] != "platform.phi" or not math.isfinite(value):
        assert not good.any()  # an angle may be any, a place may not
        assert tick.status != Status.CONVERGED
        assert np.isnan(tick.position).all()


@pytest.mark.parametrize("value", [*NEVER, 1e3, -1e12, 1e200, -1e300])
def test_legs_that_cannot_be(hexapod: parakin.Solver, value: float) -> None:
    home = np.array([hexapod.home[name] for name in LEGS])
    for chosen in ([1, 4], range(6)):
        y = home.copy()
        y[list(chosen)] = value
        begun = time.process_time()
        tick = hexapod.at(y)
        # On NumPy a way is some hundreds of runs of 0.07 s; one that charts help along, twice that.
        assert time.process_time() - begun < (10.0 if hexapod.machine_code else 60.0)
        possible = value == 1e3 and len(chosen) == 6  # legs of a kilometre, side by side
        judged(hexapod, y[:, None], hexapod.at(y[:, None]))
        assert possible or tick.status != Status.CONVERGED
        guess = np.array([hexapod.home.get(name, 0.0) for name in hexapod.coordinates])
        tick = hexapod.at(y, guess=guess)
        assert possible or tick.status != Status.CONVERGED
        judged(hexapod, y[:, None], hexapod.at(y[:, None], guess=guess))


@pytest.mark.parametrize("value", [*NEVER, 1e3, 1e300, 0.0])
def test_guesses_that_lead_nowhere(hexapod: parakin.Solver, value: float) -> None:
    home = np.array([hexapod.home[name] for name in LEGS])
    guess = np.full(len(hexapod.coordinates), value)
    judged(hexapod, home[:, None], hexapod.at(home[:, None], guess=guess[:, None]))


@pytest.mark.parametrize("value", NEVER)
def test_rates_that_are_no_numbers_are_never_passed_on_as_solved(
    simulator: parakin.Solver, value: float
) -> None:
    y = np.array([simulator.home[name] for name in simulator.driven])
    tick = simulator.at(y, np.array([value, 0.0, 0.0]))
    assert tick.status != Status.CONVERGED
    assert np.isnan(tick.position).all()
    assert np.isnan(tick.velocity).all()
    batch = simulator.at(np.repeat(y[:, None], 2, axis=1), np.array([[0, value], [0, 0], [0, 0]]))
    assert np.asarray(batch.status)[0] == Status.CONVERGED
    assert np.asarray(batch.status)[1] != Status.CONVERGED


# ---- poses by the million


def test_a_million_poses_mostly_outside_the_workspace(simulator: parakin.Solver) -> None:
    rng = np.random.default_rng(5)
    total, solved = (1_000_000 if FAST else 20_000), 0
    size = min(total, 50_000)
    home = np.array([[simulator.home[name]] for name in simulator.driven])
    for _ in range(total // size):
        reach = 10.0 ** rng.uniform(-1, 3, size)  # from a decimetre away to a kilometre
        y = home + reach * rng.uniform(-1, 1, (3, size))
        good = judged(simulator, y, simulator.at(y))
        solved += int(good.sum())
        assert not good[np.abs(y[:2] - home[:2]).max(axis=0) > 5.0].any()
    assert 0 < solved < 0.5 * total


def test_a_hundred_thousand_sets_of_legs_mostly_impossible(hexapod: parakin.Solver) -> None:
    rng = np.random.default_rng(6)
    total, solved = (100_000 if FAST else 300), 0
    size = min(total, 20_000)
    home = np.array([[hexapod.home[name]] for name in LEGS])
    for _ in range(total // size):
        reach = 10.0 ** rng.uniform(-1.5, 3, size)
        y = home + reach * rng.uniform(-1, 1, (6, size))
        solved += int(judged(hexapod, y, hexapod.at(y)).sum())
    assert 0 < solved < 0.7 * total


# ---- singular starts


def four_bar(ground: float, coupler: float) -> parakin.Mechanism:
    """Crank and rocker of 0.2 m; flat, where the lengths add up so, at home."""
    from parakin import Body, Frame, Joint, Mechanism

    def hinge(name: str, parent: str, child: str, at: float = 0.0, on: float = 0.0) -> Joint:
        return Joint(
            name=name,
            kind="revolute",
            parent=parent,
            child=child,
            on_parent=Frame(at=(at, 0, 0)),
            on_child=Frame(at=(on, 0, 0)),
        )

    return Mechanism(
        name="flat",
        bodies=tuple(Body(name=name) for name in ("crank", "coupler", "rocker")),
        joints=(
            hinge("A", "base", "crank"),
            hinge("B", "crank", "coupler", 0.2),
            hinge("C", "coupler", "rocker", coupler, 0.2),
            hinge("D", "base", "rocker", ground),
        ),
    )


@pytest.mark.parametrize(("ground", "coupler"), [(0.4, 0.4), (0.0, 0.0), (0.8, 0.4), (0.4, 0.0)])
@pytest.mark.parametrize("driven", ["A", "D"])
def test_a_singular_home_is_refused_or_flagged_or_left_well(
    ground: float, coupler: float, driven: str
) -> None:
    try:
        solver = parakin.compile(
            four_bar(ground, coupler), driven, coordinates="all", machine_code=False
        )
    except parakin.ParakinError as error:
        assert str(error).isprintable()
        return
    y = solver.home[driven] + np.linspace(-4, 4, 401)[None, :]
    judged(solver, y, solver.at(y))
    result = solver.solve(from_arrays("turn", (driven,), np.linspace(0, 1, 101), y[:, 200:301]))
    good = (result.status == Status.CONVERGED).values
    if good.any():
        assert largest_gap(solver, result.position.values.T[:, good]) < TOLERANCE
    assert np.isnan(result.position.values[~good]).all()


# ---- motions


@pytest.mark.parametrize("value", FAR)
@pytest.mark.parametrize("legs", [False, True])
def test_motions_that_begin_far_away(
    full: dict[bool, parakin.Solver], value: float, legs: bool
) -> None:
    solver = full[legs]
    laws = {c: constant(solver.home[c]) for c in solver.driven}
    laws[solver.driven[0]] = constant(value)
    result = solver.solve(from_laws("far", laws, 1.0, 10.0))
    assert (result.status.values != Status.CONVERGED).all()
    assert np.isnan(result.position.values).all()
    assert np.isnan(result.residual.values).all()


@pytest.mark.parametrize("value", NEVER)
def test_motions_of_no_numbers_are_refused(value: float) -> None:
    time_, y = np.linspace(0, 1, 20), np.zeros((1, 20))
    y[0, 7] = value
    with pytest.raises(parakin.InputError):
        from_arrays("nowhere", ("A",), time_, y)
    with pytest.raises(parakin.InputError):
        from_arrays("never", ("A",), np.where(y[0] == 0, time_, value), np.zeros((1, 20)))
    solver = parakin.compile("four-bar", machine_code=False)
    with pytest.raises(parakin.InputError):
        solver.solve(from_laws("nothing", {solver.driven[0]: constant(value)}, 1.0, 10.0))


# ---- the same, always


def digest(*arrays: object) -> str:
    parts = [np.ascontiguousarray(a).tobytes() for a in arrays]
    return hashlib.sha256(b"".join(parts)).hexdigest()


ANSWERS = """
import hashlib, sys
import numpy as np
import parakin

LEGS = [f"P{i}" for i in range(1, 7)]
for name, driven in (("flight-simulator", None), ("gough-stewart", LEGS)):
    solver = parakin.compile(name, driven)
    y = np.array([[solver.home[c]] for c in solver.driven])
    y = y + np.random.default_rng(3).uniform(-0.05, 0.05, (len(y), COUNT))
    for parallel in (False, True):
        tick = solver.at(y, parallel=parallel)
        known = [a for a in tick if a is not None and a is not tick.stops]
        parts = [np.ascontiguousarray(a).tobytes() for a in known]
        print(name, hashlib.sha256(b"".join(parts)).hexdigest())
""".replace("COUNT", "20_000" if FAST else "500")


def test_processes_at_the_same_time_compile_and_answer_alike(tmp_path: Path) -> None:
    """Three at once from an empty cache of machine code, one after them, with one core and two."""

    def begun(**environment: str) -> subprocess.Popen[str]:
        return subprocess.Popen(
            [sys.executable, "-c", ANSWERS],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=os.environ | {"HOME": str(tmp_path)} | environment,
        )

    said = []
    together = [begun(), begun(OMP_NUM_THREADS="1"), begun(PYTHONHASHSEED="7")]
    for number in range(4):
        process = together[number] if number < 3 else begun(OMP_NUM_THREADS="2")
        out, err = process.communicate(timeout=600)
        assert (process.returncode, err) == (0, "")
        said.append(out)
    assert len(set(said)) == 1
    lines = said[0].splitlines()
    assert len(lines) == 4
    assert len(set(lines)) == 2  # in parallel the same as on one core


def test_a_solved_motion_is_the_same_every_time_and_on_all_cores() -> None:
    found = set()
    for parallel in (False, True, False):
        solver = parakin.compile("flight-simulator")
        motion = solver.motion("general", rate=4000 if FAST else 200)
        result = solver.solve(motion, bodies=True, parallel=parallel)
        found.add(
            digest(
                *(
                    result[name].values
                    for name in result.data_vars
                    if result[name].dtype.kind in "fi"
                )
            )
        )
    assert len(found) == 1


# ---- killed while it writes

WRITING = """
import importlib, os, sys
from parakin.cli.main import main

for needed in ("pandas", "h5netcdf", "pyarrow.parquet", "lxml", "yaml"):
    try:
        importlib.import_module(needed)
    except ImportError:
        pass
print("ready", flush=True)
os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
os.dup2(1, 2)
while True:
    for arguments in COMMANDS:
        main(arguments)
"""


def commands(suffix: str, folder: Path) -> tuple[list[list[str]], list[str]]:
    """Two commands that write the same files otherwise, and those files."""
    out = folder / f"out{suffix}"
    if suffix in (".csv", ".nc", ".parquet"):
        motion = next(iter(parakin.load("four-bar").motions))
        return [
            ["solve", "four-bar", motion, "--rate", rate, "-o", str(out)]
            for rate in ("3000", "5000")
        ], [out.name]
    names = {".xml": [], ".urdf": ["out.loops.yaml"], ".c": ["out.h", "out_test.c"]}[suffix]
    return [["export", name, str(out)] for name in ("four-bar", "rssr")], [out.name, *names]


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="the system has no SIGKILL")
@pytest.mark.parametrize("suffix", [".csv", ".nc", ".parquet", ".urdf", ".c"])
def test_a_process_killed_leaves_the_old_file_or_the_new_one(suffix: str, tmp_path: Path) -> None:
    from parakin.cli.main import main

    if suffix in (".nc", ".parquet"):
        pytest.importorskip("h5netcdf" if suffix == ".nc" else "pyarrow")
    if suffix == ".urdf":
        pytest.importorskip("lxml")
    both, names = commands(suffix, tmp_path)
    whole: dict[str, set[bytes]] = {name: set() for name in names}
    for arguments in (*both, *both):
        assert main(arguments) == 0
        for name in names:
            whole[name].add((tmp_path / name).read_bytes())
    assert {len(contents) for contents in whole.values()} <= {1, 2}  # the same from run to run
    rng = np.random.default_rng(9)
    script = WRITING.replace("COMMANDS", repr(both))
    for _ in range(KILLS):
        process = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE)
        assert process.stdout is not None
        assert process.stdout.readline() == b"ready\n"
        # Once it writes in earnest it is killed at any moment: most are in the midst of a file.
        time.sleep(float(rng.uniform(0.0, 1.5)))
        process.send_signal(signal.SIGKILL)
        process.wait()
        process.stdout.close()
        for name in names:
            assert (tmp_path / name).read_bytes() in whole[name]
    left = {path.name for path in tmp_path.iterdir()} - set(names)
    stems = {Path(name).stem for name in names}  # hidden, named after the file they were to be
    assert all(any(name.startswith(f".{stem}-") for stem in stems) for name in left)
    assert all(Path(name).suffix in {Path(n).suffix for n in names} for name in left)
