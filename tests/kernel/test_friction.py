"""Friction under load where a joint could as well be loaded the other way."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import parakin
from parakin import Mechanism


def pulled(coefficient: float, slope: float) -> parakin.Solver:
    """A block of 2 kg on a rail along x, and a leg that pulls it along x and up a slope."""
    along = (math.cos(slope), math.sin(slope), 0.0)
    rail, leg = {"axis": (1, 0, 0)}, {"axis": (-1, 0, 0)}
    return parakin.compile(
        Mechanism.model_validate(
            {
                "name": "pulled",
                "up": "y",
                "gravity": 10,
                "driven": ["S"],
                "home": {"P": 1.0},
                "bodies": [{"name": "block", "mass": 2}, {"name": "cylinder"}, {"name": "piston"}],
                "joints": [
                    {"name": "S", "kind": "prismatic", "parent": "base", "child": "block"}
                    | {"on_parent": rail, "on_child": rail}
                    | {"friction": {"coefficient": coefficient}},
                    {"name": "U", "kind": "universal", "parent": "base", "child": "cylinder"}
                    | {"on_parent": {"at": along, "turns": [("z", slope)]}},
                    {"name": "P", "kind": "prismatic", "parent": "cylinder", "child": "piston"}
                    | {"on_parent": leg, "on_child": leg, "actuated": True},
                    {"name": "B", "kind": "spherical", "parent": "piston", "child": "block"},
                ],
            }
        ),
        machine_code=False,
    )


@pytest.mark.parametrize(
    ("coefficient", "slope"), [(0.3, 0.5), (0.5, 1.3), (0.9, 1.3), (0.3, -0.5), (0.25, -1.3)]
)
def test_of_two_answers_the_one_that_grows_from_no_friction(
    coefficient: float, slope: float
) -> None:
    """Steeply pulled, the block could also wedge against the rail from below."""
    forces = pulled(coefficient, slope).at([0.0], [1.0], forces=True, energies=True).forces
    assert forces is not None
    pull = coefficient * 20.0 / (math.cos(slope) + coefficient * math.sin(slope))
    assert forces.effort == pytest.approx([-pull])
    assert forces.lost == pytest.approx(pull * math.cos(slope))


def test_friction_that_locks_is_not_a_number() -> None:
    forces = pulled(0.5, -1.3).at([0.0], [1.0], forces=True).forces
    assert forces is not None
    assert math.isnan(forces.effort[0])


def test_a_schema_of_friction_under_load_is_no_numbers(tmp_path: Path) -> None:
    (tmp_path / "pull.toml").write_text(
        'duration = "1 s"\nrate = "10 Hz"\nlaws = { S = { law = "poly345", by = 0.1 } }\n'
    )
    solver = pulled(0.3, 0.5)
    schema = solver.schema(solver.motion(tmp_path / "pull.toml"), forces=True)
    assert schema.effort.shape == (11, 1)
    assert schema.effort.isnull().all()
