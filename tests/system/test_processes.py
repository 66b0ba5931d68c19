"""Pools of processes and threads: an answer or the error, always, and nothing hangs.

Each pool works in a process of its own, which a watchdog ends with all its children. The watchdog
is no measure of speed: it is there so that what hangs fails.
"""

from __future__ import annotations

import importlib.util
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import xarray as xr

import parakin
from parakin.kernel.backends import has_machine_code

WATCHDOG = 300  # [s]

WORK = """
import concurrent.futures as futures
import copy, multiprocessing, pickle, sys, threading
import numpy as np
import parakin

KINDS = {k.__name__: k for k in (parakin.ParakinError, parakin.AssemblyError,
         parakin.DrivenError, parakin.NotSolvedError, parakin.InputError)}
BAD = {
    "unknown mechanism": lambda s: parakin.load("no-such-mechanism"),
    "unknown driven": lambda s: parakin.compile("five-bar", ["Q"]),
    "dependent": lambda s: parakin.compile("flight-simulator-upu"),
    "not assembled": lambda s: parakin.compile("five-bar", parameters={"distal": "1 mm"}),
    "unknown motion": lambda s: s.solve("no-such-motion"),
    "not solved": lambda s: parakin.require_solved(s.solve(beyond(s))),
    "wrong shape": lambda s: s.at([[1.0, 2.0, 3.0]] * 9),
    "constructed": lambda s: parakin.Mechanism(name="x", bodies=[], joints=[], drivn=["A"]),
}


def beyond(solver):
    laws = {n: parakin.laws.polynomial345(solver.home[n], 9.0, 1.0) for n in solver.driven}
    return parakin.from_laws("beyond", laws, 1.0, 20.0)


def good(solver, motion):
    y = np.repeat([[solver.home[n] + 0.01] for n in solver.driven], 20_000, axis=1)
    solved = solver.solve(motion, bodies=True, parallel=True)
    return solver, motion, solved, solver.at(y, parallel=True), solver.home


def bad(name, solver):
    return BAD[name](solver)


def compare(solver, motion, found):
    expected = good(solver, motion)
    assert found[0].coordinates == solver.coordinates
    assert found[4] == expected[4]  # home, to the last bit
    assert found[2].identical(expected[2])
    assert (found[3].position == expected[3].position).all()
    assert (found[1].samples().position == motion.samples().position).all()


def run(submit, result=lambda job: job.result()):
    solver = parakin.compile("five-bar", ("A1", "B1"), parameters={"distal": "0.23 m"})
    laws = {n: parakin.laws.sine(solver.home[n], 0.02, 1.0) for n in solver.driven}
    motion = parakin.from_laws("wave", laws, 1.0, 50.0)
    jobs = {name: submit(bad, name, solver) for name in BAD}
    for name, job in jobs.items():
        try:
            BAD[name](solver)
        except parakin.ParakinError as error:
            here = error
        try:
            result(job)
        except parakin.ParakinError as error:
            assert isinstance(error, type(here)), name
            if type(error).__module__.startswith("dask"):  # its own kind, which quotes ours
                assert str(here) in str(error), name
                continue
            assert (str(error), error.__dict__.keys()) == (str(here), here.__dict__.keys()), name
        else:
            raise AssertionError(name)
    for job in [submit(good, solver, motion) for _ in range(3)]:
        compare(solver, motion, result(job))
"""

POOLS = {
    "Pool": """
with multiprocessing.get_context(METHOD).Pool(2) as pool:
    run(lambda f, *a: pool.apply_async(f, a), lambda job: job.get())
""",
    "ProcessPoolExecutor": """
with futures.ProcessPoolExecutor(2, multiprocessing.get_context(METHOD)) as pool:
    run(pool.submit)
""",
}
OTHERS = {
    "threads": """
with futures.ThreadPoolExecutor(4) as pool:
    run(pool.submit)
""",
    "joblib": """
import joblib
with joblib.parallel_config(n_jobs=2):
    run(lambda f, *a: (f, a), lambda job: joblib.Parallel()([joblib.delayed(job[0])(*job[1])])[0])
    jobs = [joblib.delayed(bad)("unknown driven", None)] * 3
    try:
        joblib.Parallel()(jobs)
    except parakin.InputError as error:
        assert error.found == "unknown coordinate 'Q'"
""",
    "dask": """
import dask
for scheduler in ("threads", "processes", "sync"):
    run(lambda f, *a: dask.delayed(f)(*a), lambda job: job.compute(scheduler=scheduler))
""",
}


def _ends_well(folder: Path, pool: str, method: str) -> None:
    text = f"{WORK}\nMETHOD = {method!r}\nif __name__ == '__main__':\n"
    text += "".join(f"    {line}\n" for line in [*pool.splitlines(), "print('all well')"])
    (folder / "work.py").write_text(text)
    # Python warns of forks beside threads; that is what is tried here.
    command = [sys.executable, "-W", "ignore::DeprecationWarning", "work.py"]
    with subprocess.Popen(
        command,
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(p for p in sys.path if p)},
    ) as process:
        try:
            said, _ = process.communicate(timeout=WATCHDOG)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            raise AssertionError(f"hangs, having said:\n{process.communicate()[0]}") from None
    assert process.returncode == 0, said
    assert said.endswith("all well\n")


@pytest.mark.parametrize("method", ["fork", "spawn", "forkserver"])
@pytest.mark.parametrize("pool", POOLS)
def test_a_pool_of_processes_answers(pool: str, method: str, tmp_path: Path) -> None:
    import multiprocessing

    if method not in multiprocessing.get_all_start_methods():
        pytest.skip(f"no {method} on this system")
    _ends_well(tmp_path, POOLS[pool], method)


@pytest.mark.parametrize("pool", OTHERS)
def test_other_pools_answer(pool: str, tmp_path: Path) -> None:
    if pool != "threads" and importlib.util.find_spec(pool) is None:
        pytest.skip(f"{pool} is not installed")
    _ends_well(tmp_path, OTHERS[pool], "spawn")


FORKS_BESIDE_THREADS = """
stop = threading.Event()

def busy(solver, y):
    turn = 0
    while not stop.is_set():
        solver.at(y, parallel=True)
        turn += 1
        if turn % 10 == 0:
            parakin.compile("five-bar", derivatives=1)

def in_child(solver, y):
    expected = solver.at(y[:, :1]).position
    assert (solver.at(y, parallel=True).position == expected).all()
    parakin.compile("five-bar", derivatives=turn % 3, machine_code=None)

solver = parakin.compile("delta")
y = np.repeat([[solver.home[n]] for n in solver.driven], 20_000, axis=1)
threads = [threading.Thread(target=busy, args=(solver, y)) for _ in range(2)]
for thread in threads:
    thread.start()
for turn in range(20):
    child = multiprocessing.get_context("fork").Process(target=in_child, args=(solver, y))
    child.start()
    child.join()
    assert child.exitcode == 0
stop.set()
for thread in threads:
    thread.join()
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no forks on this system")
@pytest.mark.skipif(not has_machine_code(), reason="heyoka is not installed")
def test_a_child_forked_while_threads_compile_and_run_works(tmp_path: Path) -> None:
    _ends_well(tmp_path, FORKS_BESIDE_THREADS, "fork")


def test_what_is_solved_and_found_can_be_pickled_and_copied() -> None:
    import copy
    import pickle

    solver = parakin.compile("five-bar", machine_code=False)
    motion = next(iter(solver.mechanism.motions))
    result = solver.solve(motion, bodies=True)
    search = parakin.modes(solver, starts=256)
    found: list[Any] = [
        solver.mechanism,
        solver.mechanism.joints[0],
        solver.motion(motion),
        result,
        solver.schema(motion),
        solver.at([solver.home[name] for name in solver.driven]),
        solver.home,
        solver.graph,
        solver.plan,
        search,
        search.modes[0],
        parakin.check("five-bar"),
        parakin.singularities(solver, result),
        parakin.Status.SINGULAR,
        parakin.history(result, solver.coordinates[0]),
    ]
    for thing in found:
        for other in (copy.copy(thing), copy.deepcopy(thing), pickle.loads(pickle.dumps(thing))):
            assert type(other) is type(thing)
            if isinstance(thing, (xr.Dataset, xr.DataArray)):
                assert other.identical(thing)
            elif not isinstance(thing, parakin.Motion):
                assert repr(other) == repr(thing)
