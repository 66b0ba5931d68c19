"""Working and assembly modes: as many as the textbooks count, and solvers that stay on theirs."""

from __future__ import annotations

import numpy as np
import pytest

import parakin
from parakin.cli.main import main
from parakin.planning.forms import CosineAngle, TangentAngle
from parakin.planning.plan import Plan

SLIDERS = ["A2", "B3", "C3"]


@pytest.mark.parametrize(
    ("name", "driven", "count"),
    [
        ("four-bar", None, 2),
        ("slider-crank", None, 2),
        ("five-bar", None, 4),  # two elbows, each up or down
        ("3-rrr", None, 8),  # 2^3 working modes
        ("3-rpr", ["P1", "P2", "P3"], 2),  # planar 3-RPR: at most 6, symmetric home fewer
        ("flight-simulator", None, 16),  # 2^3: a leg through its pivot or not; and upside down
    ],
)
def test_as_many_branches_as_there_are(name: str, driven: list[str] | None, count: int) -> None:
    solver = parakin.compile(name, driven, machine_code=False)
    search = parakin.modes(solver)
    assert search.modes[0].name == "home"
    for coordinate in solver.coordinates:
        at_home = search.modes[0].coordinates[coordinate]
        assert at_home == pytest.approx(solver.home[coordinate], abs=1e-9)
    assert len(search.modes) == count
    assert search.unseen < 0.01


def test_every_branch_closes_and_answers_to_its_name() -> None:
    solver = parakin.compile("flight-simulator", SLIDERS, machine_code=False)
    home = [solver.home[n] for n in SLIDERS]
    seen = []
    for branch in parakin.modes(solver).modes:
        other = parakin.compile(
            "flight-simulator", SLIDERS, near=branch.coordinates, machine_code=False
        )
        tick = other.at(home)
        assert tick.status == 0
        assert float(tick.residual) < 1e-12
        at = dict(zip(other.coordinates, tick.position, strict=True))
        for name in ("platform.x", "platform.y"):
            assert at[name] == pytest.approx(branch.coordinates[name], abs=1e-9)
        seen.append((round(at["platform.x"], 6), round(at["platform.y"], 6), round(at["A4"], 6)))
    assert len(set(seen)) == len(seen) > 1


def test_what_is_counted_from_home_is_counted_from_there_on_every_branch() -> None:
    solver = parakin.compile("flight-simulator", machine_code=False)
    for branch in parakin.modes(solver).modes[:4]:
        other = parakin.compile("flight-simulator", near=branch.coordinates, machine_code=False)
        tick = other.at([other.home[name] for name in other.driven])
        at = dict(zip(other.coordinates, tick.position, strict=True))
        for name in SLIDERS:
            assert other.home[name] == pytest.approx(branch.coordinates[name], abs=1e-9)
            assert at[name] == pytest.approx(branch.coordinates[name], abs=1e-9)


def test_a_branch_is_asked_for_by_name() -> None:
    search = parakin.modes(parakin.compile("five-bar", machine_code=False))
    for branch in search.modes:
        solver = parakin.compile("five-bar", near=branch.name, machine_code=False)
        for name in ("A1", "A2"):
            turned = solver.home[name] - branch.coordinates[name]
            assert np.cos(turned) == pytest.approx(1.0, abs=1e-12)
    with pytest.raises(parakin.InputError, match="unknown assembly mode 'up'"):
        parakin.compile("five-bar", near="up", machine_code=False)


def test_values_elsewhere_than_home_are_searched() -> None:
    solver = parakin.compile("four-bar", machine_code=False)
    (name,) = solver.driven
    moved = solver.home[name] + 0.3
    search = parakin.modes(solver, {name: moved})
    assert all(b.coordinates[name] == pytest.approx(moved) for b in search.modes)
    expected = solver.at([moved])
    at = dict(zip(solver.coordinates, expected.position, strict=True))
    nearest = search.modes[0].coordinates
    assert all(nearest[n] == pytest.approx(at[n], abs=1e-9) for n in solver.coordinates)
    with pytest.raises(parakin.InputError, match="'B'"):
        parakin.modes(solver, {"B": 0.0})


@pytest.mark.parametrize(
    ("name", "count"),
    [("gough-stewart", 8), ("octahedral-hexapod", 8), ("3-rps", 8), ("delta", 16)],
)
def test_most_starts_lead_somewhere(name: str, count: int) -> None:
    """(8 of an octahedral hexapod's 16 assemblies are complex here; counts by SciPy's
    Levenberg-Marquardt from 1,500 starts.)
    """
    motors = [
        c.name for c in parakin.compile(name, machine_code=False).graph.coordinates if c.actuated
    ]
    search = parakin.modes(parakin.compile(name, motors, machine_code=False), starts=1024)
    assert len(search.modes) == count
    assert sum(branch.found for branch in search.modes) > 600


def test_a_nearly_singular_home_is_solved_from() -> None:
    """Where home's Jacobian is all but singular, what is driven is still known to be driven."""
    pose = {"platform.yaw": np.pi / 2 - 3e-5}
    mechanism = parakin.load("gough-stewart")
    home = {name: value for name, value in mechanism.home.items() if name in mechanism.driven}
    turned = mechanism.model_copy(update={"home": {**home, **pose}})
    solver = parakin.compile(turned, [f"P{i}" for i in range(1, 7)], machine_code=False)
    assert set(solver.plan.affine) >= set(solver.plan.driven)
    assert solver.at([solver.home[name] for name in solver.driven]).status == 0


def test_a_plan_is_not_changed_by_a_search() -> None:
    solver = parakin.compile("five-bar", machine_code=False)
    before: Plan = solver.plan
    forms = [block.form for block in before.blocks]
    two_roots = [form for form in forms if isinstance(form, (TangentAngle, CosineAngle))]
    assert two_roots
    parakin.modes(solver)
    assert [block.form for block in solver.plan.blocks] == forms
    assert all(np.isscalar(form.sign) for form in two_roots)


def test_the_command_lists_them(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["modes", "four-bar"]) == 0
    said = capsys.readouterr().out
    assert "home" in said
    assert "A search, not a proof" in said
    assert main(["modes", "flight-simulator", "--driven", "A2,B3,C3", "--at", "A2=20 mm"]) == 0
    assert "platform.phi [deg]" in capsys.readouterr().out
    assert main(["modes", "four-bar", "--at", "A=20 mm"]) == 2
    assert "an angle" in capsys.readouterr().err
