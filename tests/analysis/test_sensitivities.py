"""Sensitivities against differences of solvers compiled for designs on either side."""

from __future__ import annotations

import numpy as np
import pytest

import parakin
from parakin import InputError, Status

STEP = 1e-5
FOUR = ((-2, 1.0), (-1, -8.0), (1, 8.0), (2, -1.0))  # a central difference of order four


@pytest.mark.parametrize(
    ("name", "driven", "free"),
    [
        ("gough-stewart", None, ("r_base", "a_platform", "stroke_0", "height")),
        ("gough-stewart", [f"P{i}" for i in range(1, 7)], ("r_base", "a_platform", "height")),
        ("flight-simulator", None, ("d1", "l2", "h", "b")),
        ("flight-simulator", ["A2", "B3", "C3"], ("d1", "l2")),
        ("delta", None, ("r_base", "lower")),
    ],
)
@pytest.mark.parametrize("quantity", ["position", "velocity", "acceleration"])
def test_against_differences(
    name: str, driven: list[str] | None, free: tuple[str, ...], quantity: str
) -> None:
    known = parakin.load(name).parameters
    free = tuple(f for f in free if f in known) or tuple(known)[:2]
    solver = parakin.compile(name, driven, free=free, coordinates="all", machine_code=False)
    own = solver.designs.designs.own
    design = dict(zip(free, (own * 1.01).tolist(), strict=True))
    rng = np.random.default_rng(3)
    y = np.array([solver.home[k] for k in solver.driven]) + 0.01 * rng.uniform(
        -1, 1, len(solver.driven)
    )
    rates = 0.3 * rng.normal(size=(2, len(y)))
    found = parakin.sensitivities(solver, y, *rates, parameters=design, quantity=quantity)
    assert found.status == 0

    def there(changed: dict[str, float], moved: np.ndarray) -> np.ndarray:
        anew = parakin.compile(
            name, driven, coordinates="all", machine_code=False, parameters=changed
        )
        return np.asarray(getattr(anew.at(moved, *rates), quantity))

    for row, parameter in enumerate(free):
        steps = [
            weight * there(design | {parameter: design[parameter] + k * STEP}, y)
            for k, weight in FOUR
        ]
        slope = sum(steps) / (12 * STEP)
        np.testing.assert_allclose(found.by_parameter[:, row], slope, rtol=2e-7, atol=2e-7)
    for row in range(len(y)):
        unit = np.eye(len(y))[row]
        steps = [weight * there(design, y + k * STEP * unit) for k, weight in FOUR]
        slope = sum(steps) / (12 * STEP)
        np.testing.assert_allclose(found.by_driven[:, row], slope, rtol=2e-7, atol=2e-7)


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
