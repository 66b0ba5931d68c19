"""Solvers that arrive: to the last bit those that were sent, and compiled once a process."""

from __future__ import annotations

import copy
import pickle
import threading
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from linkage import process

import parakin
from parakin.solving import recipes

SENT = """
import pickle, sys
import numpy as np

def digest(solver):
    y = np.repeat([[solver.home[n]] for n in solver.driven], 5, axis=1)
    y += 0.01 * np.random.default_rng(0).standard_normal(y.shape)
    tick = solver.at(y)
    numbers = np.array(list(solver.home.values())), tick.position, tick.acceleration, tick.residual
    return [n.tobytes().hex() for n in numbers], solver.coordinates, solver.iterated

if __name__ == "__main__":
    for arrived, expected in pickle.load(open(sys.argv[1], "rb")):
        assert digest(arrived) == expected, arrived
"""


@pytest.mark.parametrize("seed", ["1", "77"])
def test_home_and_results_are_the_same_to_the_last_bit_elsewhere(seed: str, here: object) -> None:
    known: dict[str, Any] = {"__name__": "sent"}
    exec(SENT, known)
    delta = parakin.compile("delta", machine_code=False)
    solvers = [
        delta,
        parakin.compile("delta", near=parakin.modes(delta, starts=512).modes[-1].name),
        parakin.compile("flight-simulator", ("A2", "B3", "C3"), coordinates="all"),
        parakin.compile("gough-stewart", machine_code=False),
        parakin.compile("five-bar", cut=("B2",), parameters={"distal": "0.23 m"}),
    ]
    with open("solvers", "wb") as file:
        pickle.dump([(solver, known["digest"](solver)) for solver in solvers], file)
    done = process("-c", SENT, "solvers", PYTHONHASHSEED=seed, OMP_NUM_THREADS=seed)
    assert (done.returncode, done.stderr) == (0, "")


def test_home_is_sent_and_not_found_again(monkeypatch: pytest.MonkeyPatch) -> None:
    sent = pickle.dumps(parakin.compile("five-bar", machine_code=False))
    monkeypatch.setattr(recipes, "_kept", recipes._Kept())  # as in another process

    def never(*_: object) -> None:
        raise AssertionError("assembled again")

    monkeypatch.setattr("parakin.kinematics.assembly.home_of", never)
    monkeypatch.setattr("parakin.solving.compiler.assembled", never)
    assert pickle.loads(sent).home


def test_threads_that_receive_a_solver_at_once_compile_it_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    sent = pickle.dumps(parakin.compile("five-bar", machine_code=False, derivatives=1))
    monkeypatch.setattr(recipes, "_kept", recipes._Kept())  # as in another process
    made: list[object] = []
    begin = threading.Barrier(8)
    make = recipes._made

    def counted(*given: Any) -> parakin.Solver:
        made.append(given)
        return make(*given)

    monkeypatch.setattr(recipes, "_made", counted)

    def receive(_: int) -> parakin.Solver:
        begin.wait()
        solver: parakin.Solver = pickle.loads(sent)
        return solver

    with ThreadPoolExecutor(8) as pool:
        solvers = list(pool.map(receive, range(8)))
    assert len(made) == 1
    assert all(solver is solvers[0] for solver in solvers)


def test_sent_back_a_solver_is_the_one_that_is_here() -> None:
    solver = parakin.compile("five-bar", machine_code=False)
    assert (
        pickle.loads(pickle.dumps(solver)) is solver is copy.deepcopy(solver) is copy.copy(solver)
    )


def test_solvers_that_arrive_are_kept_but_not_all_of_them() -> None:
    first = parakin.compile("five-bar", machine_code=False, parameters={"distal": 0.231})
    gone = [pickle.dumps(first)]
    del first
    for k in range(recipes._KEPT + 1):
        with_others = {"distal": 0.23 + k / 1e4}
        gone.append(
            pickle.dumps(parakin.compile("five-bar", machine_code=False, parameters=with_others))
        )
    kept = pickle.loads(gone[-1])
    assert pickle.loads(gone[-1]) is kept
    for sent in gone:
        pickle.loads(sent)
    assert len(recipes._kept.last) == recipes._KEPT


def test_names_may_come_from_any_iterable() -> None:
    home = parakin.compile("five-bar", machine_code=False).home
    names = [name for name in home if not name.endswith(".cone")]
    solver = parakin.compile(
        "five-bar",
        (name for name in ("A1", "B1")),  # type: ignore[arg-type]
        coordinates=dict.fromkeys(names).keys(),  # type: ignore[arg-type]
        cut=(name for name in ("B2",)),  # type: ignore[arg-type]
        machine_code=False,
    )
    assert (solver.driven, list(solver.coordinates)) == (("A1", "B1"), names)
    assert pickle.loads(pickle.dumps(solver)).coordinates == solver.coordinates


def test_a_mechanism_that_cannot_be_pickled_is_refused() -> None:
    plain = parakin.load("five-bar")
    odd = plain.model_copy(update={"motions": {"odd": {"laws": lambda t: t}}})
    with pytest.raises(parakin.InputError) as caught:
        parakin.compile(odd, machine_code=False)
    assert caught.value.found.startswith("something that cannot be pickled: ")


@pytest.mark.parametrize("name", ["flight-simulator", "delta"])
def test_threads_that_share_a_solver_get_their_own_answers(name: str) -> None:
    solver = parakin.compile(name)
    y = np.repeat([[solver.home[n]] for n in solver.driven], 200, axis=1)
    y += 0.005 * np.random.default_rng(0).standard_normal(y.shape)
    alone = [solver.at(column).position for column in y.T]
    with ThreadPoolExecutor(8) as pool:
        shared = list(pool.map(lambda column: solver.at(column).position, y.T))
    np.testing.assert_array_equal(shared, alone)
