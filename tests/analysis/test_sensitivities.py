"""Sensitivities against differences of solvers compiled for designs on either side."""

from __future__ import annotations

import numpy as np
import pytest

import parakin
from parakin import InputError, Solver, Status

STEP = 1e-5
FOUR = ((-2, 1.0), (-1, -8.0), (1, 8.0), (2, -1.0))  # a central difference of order four


LEGS = [f"P{i}" for i in range(1, 7)]


@pytest.mark.parametrize(
    ("name", "driven", "free"),
    [
        ("gough-stewart", None, ("r_base", "a_platform", "height")),
        ("gough-stewart", LEGS, ("r_base",)),
        ("flight-simulator", ["A2", "B3", "C3"], ("d1", "l2")),
        ("slider-crank", None, ("a", "b", "offset")),
    ],
)
def test_positions_against_differences_of_solvers_made_anew(
    name: str, driven: list[str] | None, free: tuple[str, ...]
) -> None:
    solver, design, motion = somewhere(name, driven, free)
    found = parakin.sensitivities(solver, *motion, parameters=design)
    assert found.status == 0
    for row, parameter in enumerate(free):
        slope = np.zeros(len(solver.coordinates))
        for k, weight in FOUR:
            changed = design | {parameter: design[parameter] + k * STEP}
            anew = parakin.compile(
                name, driven, coordinates="all", machine_code=False, parameters=changed
            )
            slope += weight * anew.at(*motion).position / (12 * STEP)
        np.testing.assert_allclose(found.by_parameter[:, row], slope, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize(
    ("name", "driven", "free"),
    [
        ("gough-stewart", None, ("r_base", "a_platform", "stroke_0", "height")),
        ("gough-stewart", LEGS, ("r_base", "height")),
        ("flight-simulator", None, ("d1", "l2", "h", "b")),
        ("flight-simulator", ["A2", "B3", "C3"], ("d1", "l2")),
        ("slider-crank", None, ("a", "b", "offset")),
        ("rssr", None, ()),
    ],
)
@pytest.mark.parametrize("quantity", ["position", "velocity", "acceleration"])
def test_against_differences(
    name: str, driven: list[str] | None, free: tuple[str, ...], quantity: str
) -> None:
    solver, design, motion = somewhere(name, driven, free)
    found = parakin.sensitivities(solver, *motion, parameters=design, quantity=quantity)
    assert found.status == 0
    y, yd, ydd = motion
    size = np.abs(getattr(solver.at(*motion, parameters=design), quantity))
    steps, weights = np.array(FOUR).T
    still = [np.repeat(a[:, None], 4, axis=1) for a in (yd, ydd)]
    for row, parameter in enumerate(solver.free):
        many = design | {parameter: design[parameter] + steps * STEP}
        ticks = solver.at(np.repeat(y[:, None], 4, axis=1), *still, parameters=many)
        slope = getattr(ticks, quantity) @ weights / (12 * STEP)
        assert_near(found.by_parameter[:, row], slope, size)
    for row, unit in enumerate(np.eye(len(y))):
        moved = y[:, None] + unit[:, None] * steps * STEP
        ticks = solver.at(moved, *still, parameters=design)
        slope = getattr(ticks, quantity) @ weights / (12 * STEP)
        assert_near(found.by_driven[:, row], slope, size)


def assert_near(found: np.ndarray, slope: np.ndarray, size: np.ndarray) -> None:
    """Alike but for what differences lose of numbers of this size."""
    assert (np.abs(found - slope) <= 2e-7 * (1.0 + np.abs(slope) + size)).all()


def somewhere(
    name: str, driven: list[str] | None, free: tuple[str, ...]
) -> tuple[Solver, dict[str, float], tuple[np.ndarray, ...]]:
    """A solver, a design beside the file's own, and a pose with rates."""
    free = free or tuple(parakin.load(name).parameters)[:4]
    solver = parakin.compile(name, driven, free=free, coordinates="all", machine_code=False)
    design = dict(zip(free, (solver.designs.designs.own * 1.01).tolist(), strict=True))
    rng = np.random.default_rng(3)
    k = len(solver.driven)
    y = np.array([solver.home[c] for c in solver.driven]) + 0.01 * rng.uniform(-1, 1, k)
    yd, ydd = 0.3 * rng.normal(size=(2, k))
    return solver, design, (y, yd, ydd)


def test_a_batch_gives_what_single_poses_give(reading: bool) -> None:
    solver = parakin.compile("gough-stewart", free=["r_base", "height"], machine_code=reading)
    y = np.array([solver.home[k] for k in solver.driven])[:, None] + np.linspace(-0.05, 0.05, 5)
    y[2, 4] = 9.0
    sizes = {"r_base": np.linspace(1.1, 1.3, 5)}
    together = parakin.sensitivities(solver, y, parameters=sizes)
    for k in range(5):
        alone = parakin.sensitivities(solver, y[:, k], parameters={"r_base": sizes["r_base"][k]})
        np.testing.assert_array_equal(alone.by_parameter, together.by_parameter[:, :, k])
        np.testing.assert_array_equal(alone.by_driven, together.by_driven[:, :, k])


def test_a_fixed_design_tells_those_of_what_is_driven() -> None:
    solver = parakin.compile("gough-stewart", machine_code=False)
    y = [0.05, 0.0, 1.15, 0.02, 0.0, 0.1]
    found = parakin.sensitivities(solver, y)
    assert found.by_parameter.shape == (len(solver.coordinates), 0)
    for name, unit in zip(solver.driven, np.eye(6), strict=True):
        rates = solver.at(y, unit).velocity
        slopes = np.array([found.of(c, name) for c in solver.coordinates])
        np.testing.assert_allclose(slopes, rates, atol=1e-13)


def test_what_is_not_solved_has_none() -> None:
    solver = parakin.compile("four-bar", free=["a", "b", "c", "d"], machine_code=False)
    found = parakin.sensitivities(solver, [[0.7, 0.7]], parameters={"b": np.array([0.12, 0.9])})
    good, bad = np.asarray(found.status).tolist()
    assert good == 0
    assert bad in (Status.OUT_OF_REACH, Status.NOT_REACHED)
    assert np.isfinite(found.by_parameter[..., 0]).all()
    assert np.isnan(found.by_parameter[..., 1]).all()


def test_names_are_checked() -> None:
    solver = parakin.compile("four-bar", free=["a"], machine_code=False)
    found = parakin.sensitivities(solver, [0.7])
    with pytest.raises(InputError, match="coordinate: found 'E'"):
        found.of("E", "a")
    with pytest.raises(InputError, match="by: found 'b'"):
        found.of("D", "b")
    with pytest.raises(InputError, match="quantity: found 'jerk'"):
        parakin.sensitivities(solver, [0.7], quantity="jerk")


def test_a_dimension_that_the_loops_tie_has_none_alone() -> None:
    tied = parakin.compile("bennett", free=["b"], machine_code=False)
    found = parakin.sensitivities(tied, [tied.home["A"]])
    assert np.isnan(found.by_parameter).all()
    assert np.isfinite(found.by_driven).all()
    whole = parakin.compile("bennett", free=["a"], machine_code=False)  # b follows
    turned = parakin.sensitivities(whole, [whole.home["A"]])
    np.testing.assert_allclose(turned.by_parameter, 0.0, atol=1e-12)  # scaled, it moves as before


def test_an_empty_batch_has_an_empty_table() -> None:
    for free in ([], ["r_base"]):
        solver = parakin.compile("gough-stewart", free=free, machine_code=False)
        found = parakin.sensitivities(solver, np.zeros((6, 0)))
        assert found.by_driven.shape == (len(solver.coordinates), 6, 0)
