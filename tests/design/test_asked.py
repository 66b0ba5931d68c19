"""What is asked by name: numbers in SI, and text with units."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import parakin
from parakin.errors import InputError
from parakin.solving.solver import Solver

RIG = Path(__file__).parents[2] / "examples" / "rig.toml"


@pytest.fixture(scope="module")
def rig() -> Solver:
    return parakin.compile(RIG)


def test_a_range_takes_text_with_units(rig: Solver) -> None:
    given = parakin.range(rig, {"platform.x": 0.02}, offsets={"platform.pitch": np.radians(10)})
    found = parakin.range(rig, {"platform.x": "2 cm"}, offsets={"platform.pitch": "10 deg"})
    assert found["pose"].values == pytest.approx(given["pose"].values, abs=1e-15)
    assert found["travel"].values == pytest.approx(given["travel"].values, abs=1e-12)
    named = parakin.range(rig, {"platform.x": "r_base/41"})  # 0.82 m
    assert named["pose"].values[0] == pytest.approx(0.02, abs=1e-15)


def test_so_does_a_workspace(rig: Solver) -> None:
    over = ["platform.x", "platform.z"]
    given = parakin.workspace(
        rig,
        over=over,
        orientations=[{"platform.pitch": np.radians(5)}],
        within={"platform.x": (-0.1, 0.2)},
        kind="dexterous",
        points=21,
    )
    found = parakin.workspace(
        rig,
        over=over,
        orientations=[{"platform.pitch": "5 deg"}],
        within={"platform.x": ("-100 mm", "20 cm")},
        kind="dexterous",
        points=21,
    )
    assert float(found["size"]) == pytest.approx(float(given["size"]), rel=1e-9)
    assert found["extent"].values[0] == pytest.approx([-0.1, 0.2], abs=1e-9)


@pytest.mark.parametrize(
    ("pose", "message"),
    [
        ({"platform.x": "2 deg"}, "pose of platform.x: found '2 deg', an angle; expected a length"),
        ({"platform.x": "2 x"}, "pose of platform.x: found '2 x'"),
        ({"platform.x": np.nan}, "pose of platform.x: found nan; expected a finite number, or te"),
        ({"platform.x": "1e999"}, "pose of platform.x: found '1e999'"),
        ({"platform.x": [1.0]}, "pose of platform.x: found [1.0]; expected a finite number"),
        ({"P1": "1 m"}, "pose: found 'P1', which is not driven"),
    ],
)
def test_bad_text_is_refused(rig: Solver, pose: dict[str, float], message: str) -> None:
    for ask in (parakin.range, parakin.workspace):
        with pytest.raises(InputError, match="expected") as caught:
            ask(rig, pose)
        assert message in str(caught.value)


@pytest.mark.parametrize("ends", [("1 deg", 1.0), (np.nan, 1.0), (1.0,), "01", (-1.0, None)])
def test_bad_ends_are_refused(rig: Solver, ends: tuple[float, float]) -> None:
    with pytest.raises(InputError, match=r"within of platform\.x: found"):
        parakin.workspace(rig, within={"platform.x": ends})
