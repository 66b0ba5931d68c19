"""A solver is its recipe: what it was compiled from goes to other processes, nothing else."""

from __future__ import annotations

import copy
import pickle
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest

import parakin
from parakin import InputError


def _position(solver: parakin.Solver, y: list[float]) -> list[float]:
    found: list[float] = solver.at(y).position.tolist()
    return found


@pytest.mark.parametrize("code", [None, False])
def test_a_solver_comes_out_of_a_pickle_as_it_went_in(code: bool | None) -> None:
    modes = parakin.modes(parakin.compile("five-bar", machine_code=False)).modes
    options = {"derivatives": 1, "near": modes[-1].name, "coordinates": "all", "cut": ("B2",)}
    for solver in (
        parakin.compile("five-bar", machine_code=code),
        parakin.compile("five-bar", machine_code=code, **options),  # type: ignore[arg-type]
    ):
        sent = pickle.dumps(solver)
        assert len(sent) < 10_000  # no code, no numbers
        other = pickle.loads(sent)
        assert other is pickle.loads(sent) is copy.deepcopy(solver)  # once a process
        assert (other.driven, other.coordinates) == (solver.driven, solver.coordinates)
        assert other.derivatives == solver.derivatives
        assert other.home == solver.home
        y = [solver.home[name] + 0.01 for name in solver.driven]
        np.testing.assert_array_equal(other.at(y).position, solver.at(y).position)


def test_a_solver_works_in_another_process() -> None:
    solver = parakin.compile("five-bar", ("A1", "B1"), parameters={"distal": "0.23 m"})
    y = [solver.home[name] + 0.02 for name in solver.driven]
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        found = pool.submit(_position, solver, y).result()
    assert found == solver.at(y).position.tolist()


@pytest.mark.parametrize("bodies", [False, True, ["platform"]])
def test_the_schema_is_that_of_what_is_solved(bodies: bool | list[str]) -> None:
    solver = parakin.compile("flight-simulator", derivatives=3)
    solved, schema = (how("general", bodies=bodies) for how in (solver.solve, solver.schema))
    assert schema.attrs == solved.attrs
    assert list(schema.variables) == list(solved.variables)
    for name, variable in solved.variables.items():
        assert schema[name].dims == variable.dims
        assert schema[name].shape == variable.shape
        assert schema[name].dtype == variable.dtype
        assert schema[name].attrs == variable.attrs
    for name in solved.coords:
        np.testing.assert_array_equal(schema[name], solved[name])
    assert np.isnan(schema.position).all()
    with pytest.raises(InputError, match="driven coordinates"):
        parakin.compile("five-bar").schema(solver.motion("general"))
