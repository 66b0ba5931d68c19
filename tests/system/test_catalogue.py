"""The catalogue: every entry against a closed form of its own, along its demonstration motions."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import pytest
from catalogue_forms import FORMS
from replays import replayed

import parakin
from parakin.analysis.mobility import mobility
from parakin.kinematics.assembly import assembled
from parakin.model.evaluation import graph_of
from parakin.solving.status import Status

if TYPE_CHECKING:
    import xarray as xr

ELSEWHERE = ("flight-simulator", "flight-simulator-upu")  # tests of their own
ENTRIES = [name for name in parakin.catalogue() if name not in ELSEWHERE]
DEMONSTRATIONS = [(name, motion) for name in ENTRIES for motion in parakin.load(name).motions]

# Grübler-Kutzbach and the true mobility.
MOBILITY = {
    "3-prs": (3, 3),
    "3-rpr": (-3, 3),
    "3-rps": (3, 3),
    "3-rrr": (-3, 3),
    "3-upu": (3, 3),
    "6-pus": (6, 6),
    "6-rus": (6, 6),
    "agile-eye": (-3, 3),
    "bennett": (-2, 1),
    "bricard": (0, 1),
    "delta": (3, 3),
    "delta-revolute": (-9, 3),
    "five-bar": (-1, 2),
    "four-bar": (-2, 1),
    "gough-stewart": (6, 6),
    "hexapod-on-3rps": (9, 9),
    "linear-delta": (3, 3),
    "octahedral-hexapod": (6, 6),
    "rssr": (1, 1),
    "seat-2dof": (2, 2),
    "seat-3dof": (3, 3),
    "six-bar-stephenson": (-5, 1),
    "six-bar-watt": (-5, 1),
    "slider-crank": (-2, 1),
    "tricept": (3, 3),
    "wrist-on-delta": (6, 6),
}


@cache
def solver_of(name: str, *driven: str) -> parakin.Solver:
    return parakin.compile(name, driven or None, coordinates="all", machine_code=False)


@cache
def demonstrated(name: str, motion: str) -> xr.Dataset:
    return solver_of(name).solve(motion)


def deviations(
    solver: parakin.Solver, position: np.ndarray, expected: dict[str, np.ndarray]
) -> dict[str, float]:
    """The largest differences of positions (rows `solver.coordinates`), angles but for turns."""
    angles = {c.name for c in solver.graph.coordinates if c.angle}
    found = {}
    for name, values in expected.items():
        difference = position[solver.coordinates.index(name)] - values
        if name in angles:
            difference = difference - 2 * np.pi * np.round(difference / (2 * np.pi))
        found[name] = float(np.abs(difference).max())
    return found


def without_cones(result: xr.Dataset) -> list[str]:
    return [n for n in result.coordinate.values if not str(n).endswith(".cone")]


@pytest.mark.parametrize(("name", "motion"), DEMONSTRATIONS)
def test_demonstrations_are_closed_and_solved_throughout(name: str, motion: str) -> None:
    result = demonstrated(name, motion)
    assert (result.status == Status.CONVERGED).all()
    assert float(result.residual.max()) <= 1e-12 * result.attrs["characteristic_length"]


@pytest.mark.parametrize(("name", "motion"), DEMONSTRATIONS)
def test_positions_agree_with_a_closed_form(name: str, motion: str) -> None:
    result = demonstrated(name, motion)
    solver = solver_of(name)
    driven = {d: result.position.sel(coordinate=d).values for d in solver.driven}
    expected = FORMS[name](solver.graph.parameters, driven)
    assert expected.keys() >= {*actuated(name)} - driven.keys()
    off = deviations(solver, result.position.values.T, expected)
    assert max(off.values()) < 1e-11, off


@pytest.mark.parametrize("name", ENTRIES)
def test_a_cloud_of_poses_agrees_with_the_closed_form(name: str) -> None:
    solver = solver_of(name)
    angles = {c.name for c in solver.graph.coordinates if c.angle}
    home = np.array([[solver.home[d]] for d in solver.driven])
    units = np.array([[1.0 if d in angles else solver.graph.length] for d in solver.driven])
    y = home + 0.08 * units * np.random.default_rng(1).uniform(-1, 1, (len(home), 100))
    poses = solver.at(y)
    assert not np.any(poses.status)
    driven = dict(zip(solver.driven, y, strict=True))
    off = deviations(solver, poses.position, FORMS[name](solver.graph.parameters, driven))
    assert max(off.values()) < 1e-11, off


@pytest.mark.parametrize(("name", "motion"), DEMONSTRATIONS)
def test_derivatives_agree_with_differences(name: str, motion: str) -> None:
    """Sixth-order central differences of positions, and of velocities."""
    result = demonstrated(name, motion)
    step = float(result.time[1] - result.time[0])
    weights = np.array([-1, 9, -45, 0, 45, -9, 1]) / (60 * step)
    result = result.sel(coordinate=without_cones(result))  # cones have kinks at zero
    for low, high, bound in (("position", "velocity", 1e-8), ("velocity", "acceleration", 1e-7)):
        values = result[low].values
        slope = sum(w * values[i : len(values) - 6 + i] for i, w in enumerate(weights))
        exact = result[high].values[3:-3]
        np.testing.assert_allclose(exact, slope, rtol=0, atol=bound * max(1, np.abs(exact).max()))


def actuated(name: str) -> tuple[str, ...]:
    return tuple(c.name for c in graph_of(parakin.load(name)).coordinates if c.actuated)


FORWARD = [name for name in ENTRIES if set(actuated(name)) != set(parakin.load(name).driven)]


@pytest.mark.parametrize("name", FORWARD)
def test_actuators_give_the_platform_back(name: str) -> None:
    inverse = demonstrated(name, next(iter(parakin.load(name).motions)))
    inverse = inverse.isel(time=slice(0, 400))
    forward = solver_of(name, *actuated(name)).solve(replayed(inverse, actuated(name)))
    assert (forward.status == Status.CONVERGED).all()
    for quantity, bound in (("position", 1e-10), ("velocity", 1e-9), ("acceleration", 1e-8)):
        difference = (forward[quantity] - inverse[quantity]).sel(coordinate=without_cones(inverse))
        size = max(1.0, float(np.abs(inverse[quantity]).max()))
        assert float(np.abs(difference).max()) < bound * size


OTHERWISE = [
    ("four-bar", "turn", "C"),
    ("slider-crank", "turn", "B"),
    ("five-bar", "circle", "A1 B2"),
    ("six-bar-watt", "turn", "G"),
    ("six-bar-stephenson", "turn", "G"),  # not a chain of dyads from there
    ("rssr", "turn", "D"),
    ("bennett", "turn", "B"),
    ("bricard", "fold", "D"),
    ("3-rrr", "tour", "A1 B2 C3"),
    ("3-rpr", "tour", "A1 A2 A3"),
    ("agile-eye", "look", "B1 B2 B3"),
    ("tricept", "circle", "U1.1 P2 P0"),
    ("3-upu", "tour", "U1.1 U2.1 P3"),
    ("delta", "spiral", "A1 A2 platform.z"),
    ("delta-revolute", "spiral", "C1 C2 A3"),
    ("gough-stewart", "tour", "P1 P2 P3 platform.yaw platform.pitch platform.roll"),
    ("6-rus", "tour", "A1 A2 A3 A4 A5 platform.z"),
    ("seat-3dof", "sway", "A1 A2 P"),
]


@pytest.mark.parametrize(("name", "motion", "driven"), OTHERWISE)
def test_passive_and_mixed_drives_give_the_same(name: str, motion: str, driven: str) -> None:
    usual = demonstrated(name, motion).isel(time=slice(0, 300))
    ours = solver_of(name, *driven.split()).solve(replayed(usual, driven.split()))
    assert (ours.status == Status.CONVERGED).all()
    difference = (ours.position - usual.position).sel(coordinate=without_cones(usual))
    assert float(np.abs(difference).max()) < 1e-11


def test_dead_centres_of_a_passive_drive_are_flagged() -> None:
    """The rod of a slider-crank turns back where d rod / d crank = 0, that is at A = 90 deg."""
    usual = demonstrated("slider-crank", "turn")
    ours = solver_of("slider-crank", "C").solve(replayed(usual, ["C"]))
    flagged = int(np.argmax(ours.status.values != 0))
    before, after = usual.position.sel(coordinate="A").values[[flagged - 1, flagged]]
    assert before < np.pi / 2 < after
    assert (ours.status[flagged + 1 :] == Status.NOT_REACHED).all()


@pytest.mark.parametrize("name", ENTRIES)
def test_mobility(name: str) -> None:
    graph = graph_of(parakin.load(name))
    found = mobility(graph, assembled(graph), len(graph.mechanism.driven))
    grubler, true = MOBILITY[name]
    assert (found.grubler, found.home, set(found.nearby)) == (grubler, true, {true})
    assert found.wanted == true


def test_every_entry_has_a_title_a_source_and_a_demonstration() -> None:
    for name in ENTRIES:
        mechanism = parakin.load(name)
        assert mechanism.name == name
        assert mechanism.title
        assert mechanism.source
        assert mechanism.driven
        assert mechanism.motions
        assert name in MOBILITY
        assert name in FORMS


def test_published_values_of_nortons_examples() -> None:
    """Design of Machinery, examples 4-1 (open: 20.298 and 57.325 deg) and 4-2 (126.84 mm)."""
    home = solver_of("four-bar").home
    assert round(float(np.degrees(home["A"] + home["B"])), 3) == 20.298
    assert round(float(np.degrees(home["D"])), 3) == 57.325
    home = solver_of("slider-crank").home
    assert round(1e3 * home["D"], 2) == 126.84
    assert round(float(np.degrees(home["A"] + home["B"])) + 180, 2) == 152.91


@pytest.mark.parametrize("alpha", ["75 deg", "60 deg", "105 deg"])
def test_bricard_of_other_twists(alpha: str) -> None:
    mechanism = parakin.load("bricard", {"alpha": alpha})
    solver = parakin.compile(mechanism, coordinates="all", machine_code=False)
    result = solver.solve("fold")
    assert (result.status == Status.CONVERGED).all()
    driven = {"A": result.position.sel(coordinate="A").values}
    expected = FORMS["bricard"](solver.graph.parameters, driven)
    off = deviations(solver, result.position.values.T, expected)
    assert max(off.values()) < 1e-11, off


@pytest.mark.parametrize("name", ["bennett", "bricard"])
def test_overconstrained_loops_with_one_twist_changed_are_rigid(name: str) -> None:
    mechanism = parakin.load(name)
    joints = [
        j.model_copy(update={"on_parent": j.on_parent.model_copy(update={"turns": (("x", 0.6),)})})
        if j.name == "B"
        else j
        for j in mechanism.joints
    ]
    changed = mechanism.model_copy(update={"joints": tuple(joints)})
    with pytest.raises((parakin.AssemblyError, parakin.DrivenError)):
        parakin.compile(changed)
