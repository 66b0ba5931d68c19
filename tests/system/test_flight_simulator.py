"""The paper's mechanism, against a closed form of its plane geometry and the values of NOTES."""

from __future__ import annotations

from collections.abc import Callable

import closed_form
import numpy as np
import pytest
from replays import replayed

import parakin
from parakin.analysis.mobility import mobility
from parakin.kinematics.assembly import assembled
from parakin.model.evaluation import graph_of
from parakin.motion.laws import from_laws, polynomial345
from parakin.solving.status import Status

UNKNOWNS = "A1 A2 A3 B1.1 B1.2 B3 C1.1 C1.2 C3 D1 E1 E2P".split()
EXAMPLES = {1: "vertical", 2: "rectilinear", 3: "general"}
PAPER = closed_form.Parameters()
Compiled = Callable[..., parakin.Solver]


@pytest.mark.parametrize("example", EXAMPLES)
def test_all_unknowns_agree_with_the_closed_form(compiled: Compiled, example: int) -> None:
    result = compiled().solve(EXAMPLES[example])
    names = [*UNKNOWNS, "A4", "platform.psi"]
    for i in range(0, 3001, 250):
        y, yd, ydd = closed_form.example(example, closed_form.MP.mpf(i) / 1000)
        exact = closed_form.state(PAPER, y, yd, ydd)
        ours = result.isel(time=i).sel(coordinate=names)
        expected = [exact["psi" if n == "platform.psi" else n] for n in names]
        for order, quantity in enumerate(("position", "velocity", "acceleration")):
            np.testing.assert_allclose(
                ours[quantity], [float(e[order]) for e in expected], rtol=0, atol=1e-12
            )


@pytest.mark.parametrize("example", EXAMPLES)
def test_every_loop_is_closed_at_every_sample(compiled: Compiled, example: int) -> None:
    result = compiled().solve(EXAMPLES[example])
    assert (result.status == Status.CONVERGED).all()
    assert float(result.residual.max()) <= 1e-13


def test_reference_values_of_the_general_evolution(compiled: Compiled) -> None:
    at_one_second = compiled().solve("general").sel(time=1.0)
    table = {
        "A2": (0.0165156318, 0.0301135217, 0.0204906800),
        "B3": (-0.0184882742, -0.0286864726, 0.0113278630),
        "C3": (0.1118410600, 0.2071525692, 0.1458868034),
    }
    for name, values in table.items():
        row = at_one_second.sel(coordinate=name)
        assert [round(float(row[q]), 10) for q in ("position", "velocity", "acceleration")] == list(
            values
        )


@pytest.mark.parametrize(
    ("motion", "strokes"),
    [
        ("vertical", (-0.03758, 0.16948, 0.16948)),
        ("rectilinear", (0.06943, 0.17281, 0.17281)),
        ("general", (0.06943, -0.01972, 0.46829)),
    ],
)
def test_strokes_at_the_end(compiled: Compiled, motion: str, strokes: tuple[float, ...]) -> None:
    result = compiled().solve(motion)
    moved = (result.position - result.home).isel(time=-1)
    for name, stroke in zip(("A2", "B3", "C3"), strokes, strict=True):
        assert round(float(moved.sel(coordinate=name)), 5) == stroke


@pytest.mark.parametrize(
    ("motion", "degrees"), [("vertical", 10.6), ("rectilinear", 7.4), ("general", 7.4)]
)
def test_psi_is_parasitic(compiled: Compiled, motion: str, degrees: float) -> None:
    psi = compiled().solve(motion).position.sel(coordinate="platform.psi")
    assert abs(float(psi[0])) < 1e-15
    assert round(float(np.degrees(psi[-1])), 1) == degrees


def test_home_is_assembled_on_the_papers_branch() -> None:
    graph = graph_of(parakin.load("flight-simulator"))
    home = {c.name: q for c, q in zip(graph.coordinates, assembled(graph).q, strict=True)}
    exact = closed_form.home(PAPER)
    degrees = {name: round(float(np.degrees(q)), 4) for name, q in home.items()}
    assert f"{home['platform.psi']:.13f}" == "0.0376701440560"
    assert (degrees["A1"], degrees["B1.2"], degrees["D1"]) == (66.7016, 55.7131, 125.1961)
    assert round(float(np.degrees(home["E1"])), 3) == 64.753
    assert round(home["E2P"], 6) == 0.611555
    # How far the printed constants are from closing.
    assert round(1e3 * home["A2"], 3) == 0.254
    assert round(1e3 * home["B3"], 3) == round(1e3 * home["C3"], 3) == 1.353
    assert abs(home["A2"] - float(exact.A1A3 - PAPER.s_A - PAPER.l1)) < 1e-14
    assert abs(home["B3"] - float(exact.B1B4 - PAPER.s_B - PAPER.l2)) < 1e-14


def test_mobility_is_three_though_counted_minus_three() -> None:
    graph = graph_of(parakin.load("flight-simulator"))
    found = mobility(graph, assembled(graph), 3)
    assert (found.grubler, found.home, set(found.nearby)) == (-3, 3, {3})
    assert found.cuts == ("B4", "C4", "D2", "E2")
    # Twelve coordinates and phi, ten independent rows; the rest of the rows say nothing new.
    assert (found.tree_coordinates, found.rank, found.redundant) == (13, 10, 6)
    assert found.to_blame == ()


def test_literal_upu_legs_leave_one_freedom_and_are_named() -> None:
    graph = graph_of(parakin.load("flight-simulator-upu"))
    found = mobility(graph, assembled(graph), 3)
    assert (found.grubler, found.home, set(found.nearby)) == (-5, 1, {1})
    assert (found.to_blame, found.mobility_if_spherical) == (("B4", "C4"), 3)
    with pytest.raises(parakin.DrivenError, match="mobility 1"):
        parakin.compile("flight-simulator-upu")


def test_corrected_equation_11_holds_and_the_printed_one_does_not(compiled: Compiled) -> None:
    result = compiled().solve("general")
    worst = 0.0
    for t in (0.4, 1.0, 1.5, 2.7):
        y, yd, ydd = closed_form.example(3, t)
        at = closed_form.state(PAPER, y, yd, ydd)
        ours = result.sel(time=t, method="nearest").sel(coordinate=["A2", "B3", "C3"]).velocity
        corrected = [float(v) for v in closed_form.corrected_eq_11(PAPER, at, yd)]
        printed = [float(v) for v in closed_form.printed_eq_11(PAPER, at, yd)]
        np.testing.assert_allclose(ours, corrected, rtol=0, atol=1e-12)
        np.testing.assert_allclose(ours[:2], printed[:2], rtol=0, atol=1e-12)
        worst = max(worst, abs(float(ours[2]) - printed[2]))
        if t == 1.5:
            assert (round(float(ours[2]), 4), round(printed[2], 4)) == (0.2491, 0.2093)
    assert worst > 0.03


def test_sliders_found_from_the_platform_give_the_platform_back(compiled: Compiled) -> None:
    inverse = compiled().solve("general")
    forward = compiled("A2", "B3", "C3").solve(replayed(inverse, ["A2", "B3", "C3"]))
    assert (forward.status == Status.CONVERGED).all()
    for quantity, bound in (("position", 1e-13), ("velocity", 1e-13), ("acceleration", 1e-12)):
        joints = [n for n in forward.coordinate.values if not n.endswith(".cone")]
        difference = (forward[quantity] - inverse[quantity]).sel(coordinate=joints)
        assert float(np.abs(difference).max()) < bound


def test_a_motion_out_of_the_workspace_is_solved_as_far_as_it_goes(compiled: Compiled) -> None:
    # Point G can rise until the rod's D2 is l3 from D1: the closed form says to which height.
    solver = compiled()
    x, y, phi = (solver.home[name] for name in solver.driven)
    motion = from_laws(
        "up",
        {
            "platform.x": polynomial345(x, 0.0, 1.0),
            "platform.y": polynomial345(y, 3.0, 1.0),
            "platform.phi": polynomial345(phi, 0.0, 1.0),
        },
        1.0,
        1000.0,
    )
    result = solver.solve(motion)
    status = result.status.values
    last = int(np.argmax(status != 0)) - 1
    assert status[last + 1] in (Status.OUT_OF_REACH, Status.SINGULAR)
    assert (status[last + 2 :] == Status.NOT_REACHED).all()
    assert np.isfinite(result.position.values[: last + 1]).all()
    assert np.isnan(result.position.values[last + 1 :]).all()
    height = result.position.sel(coordinate="platform.y").values
    reached = closed_form.state(PAPER, (x, height[last], 0), (0, 0, 0), (0, 0, 0))
    assert abs(float(reached["A2"][0]) - float(result.position[last].sel(coordinate="A2"))) < 1e-9
    asked = motion.samples().position[1, last + 1]
    with pytest.raises(ValueError, match="out of reach"):
        closed_form.state(PAPER, (x, asked, 0), (0, 0, 0), (0, 0, 0))
    with pytest.raises(parakin.NotSolvedError, match=f"the first, {last + 1} at"):
        parakin.require_solved(result)


def test_limits_are_flagged_and_values_kept(reading: bool) -> None:
    mechanism = parakin.load("flight-simulator").model_copy(
        update={"limits": {"C3": (-0.1, "300 mm"), "B4.cone": (0, "50 deg")}}
    )
    solver = parakin.compile(mechanism, coordinates="all", machine_code=reading)
    result = solver.solve("general")
    beyond = (result.position.sel(coordinate="C3") > 0.3).values
    beyond |= (result.position.sel(coordinate="B4.cone") > np.radians(50)).values
    assert 100 < beyond.sum() < 3000
    assert ((result.status == Status.LIMIT_EXCEEDED).values == beyond).all()
    assert np.isfinite(result.position.values).all()
