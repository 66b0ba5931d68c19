"""Ranges and workspaces of other designs, against a file that was written with their numbers."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

import parakin
from parakin.errors import InputError
from parakin.solving.solver import Solver

RIG = Path(__file__).parents[2] / "examples" / "rig.toml"
OTHER: dict[str, float | int | str] = {"leg_max": 1.3, "r_base": "900 mm"}


@pytest.fixture(scope="module")
def left_open() -> Solver:
    return parakin.compile(RIG, free=["r_base", "leg_max"])


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Solver:
    text = RIG.read_text("utf-8")
    for old, new in (('r_base = "0.82 m"', 'r_base = "0.9 m"'), ('"1.26 m"', '"1.3 m"')):
        assert text.count(old) == 1
        text = text.replace(old, new)
    file = tmp_path_factory.mktemp("rig") / "other.toml"
    file.write_text(text, "utf-8")
    return parakin.compile(file)


def test_a_range_is_that_of_the_other_design(left_open: Solver, written: Solver) -> None:
    found = parakin.range(left_open, parameters=OTHER)
    expected = parakin.range(written)
    assert found["travel"].values == pytest.approx(expected["travel"].values, abs=1e-12)
    assert (found["stopped_by"].values == expected["stopped_by"].values).all()
    assert "> 1.3 m" in found["stopped_by"].values[2, 1]
    own = parakin.range(left_open)["travel"].values
    assert np.abs(own - found["travel"].values).max() > 0.01
    file = parakin.range(parakin.compile(RIG))["travel"].values
    assert own == pytest.approx(file, abs=1e-12)


def test_so_is_a_workspace(left_open: Solver, written: Solver) -> None:
    over = ["platform.x", "platform.z"]
    found = parakin.workspace(left_open, over=over, points=41, parameters=OTHER)
    expected = parakin.workspace(written, over=over, points=41)
    assert float(found["size"]) == pytest.approx(float(expected["size"]), abs=1e-12)
    assert found["boundary"].values == pytest.approx(expected["boundary"].values, abs=1e-9)


def test_a_parameter_need_not_be_left_open(written: Solver) -> None:
    solver = parakin.compile(RIG)
    found = parakin.range(solver, parameters=OTHER)
    assert found["travel"].values == pytest.approx(
        parakin.range(written)["travel"].values, abs=1e-12
    )


def test_a_solver_of_another_design_is_one_like_any_other(
    left_open: Solver, written: Solver
) -> None:
    other = left_open.with_design(OTHER)
    assert other.free == ()
    assert other.driven == left_open.driven
    assert other.coordinates == left_open.coordinates
    y = [0.02, 0.01, 1.05, 0.1, 0.0, 0.0]
    # 0.9 m and "900 mm" are the same number but for its last digit.
    assert other.at(y).position == pytest.approx(written.at(y).position, abs=1e-12)
    assert other.at(y).position == pytest.approx(
        left_open.at(y, parameters=OTHER).position, abs=1e-12
    )
    assert left_open.with_design(OTHER) is other
    assert left_open.with_design({}) is left_open
    again = pickle.loads(pickle.dumps(other))
    assert again.at(y).position == pytest.approx(other.at(y).position, abs=0.0)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"r_bse": 1.0}, "unknown parameter 'r_bse'; expected one of"),
        ({"r_base": np.nan}, "parameters.r_base: found nan; expected a finite number"),
        ({"r_base": [0.8, 0.9]}, "parameters.r_base: found an array; expected a finite number"),
        ({"r_base": True}, "parameters.r_base: found True; expected a finite number"),
        ({"r_base": None}, "parameters.r_base: found None; expected a finite number"),
        ({"r_base": "nan"}, "unknown parameter 'nan'"),
        ([("r_base", 1.0)], "expected values by the names of parameters"),
        ({"leg_max": "1.26 kg"}, "a mass"),
    ],
)
def test_what_is_no_design_is_refused(
    left_open: Solver, parameters: dict[str, float], message: str
) -> None:
    with pytest.raises(InputError, match="expected") as caught:
        parakin.range(left_open, parameters=parameters)
    assert message in str(caught.value)
    with pytest.raises(InputError, match="expected"):
        parakin.workspace(left_open, parameters=parameters)


def test_a_design_that_cannot_be_assembled_is_refused(left_open: Solver) -> None:
    with pytest.raises(parakin.AssemblyError, match="cannot be assembled"):
        parakin.range(left_open, parameters={"r_base": 9.0})


def test_of_another_mode_it_is_refused() -> None:
    bar = parakin.compile("five-bar", near="2")
    with pytest.raises(InputError, match="compiled without near"):
        bar.with_design({"proximal": 0.16})
