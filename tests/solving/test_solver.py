"""The solver: one pose, a batch, windows of a motion, and what it says of itself."""

from __future__ import annotations

import math

import numpy as np
import pytest

import parakin
from parakin import InputError, Status
from parakin.motion.laws import constant, from_laws, polynomial345


def rocker(crank: float) -> float:
    """Of the four-bar 40, 120, 80 on 100 mm, by the law of cosines."""
    a, b, c, d = 0.04, 0.12, 0.08, 0.1
    across = math.sqrt(a * a + d * d - 2 * a * d * math.cos(crank))
    below = math.atan2(-a * math.sin(crank), d - a * math.cos(crank))
    return math.pi + below - math.acos((c * c + across**2 - b * b) / (2 * c * across))


@pytest.mark.parametrize("crank", np.linspace(-3.0, 3.0, 7))
def test_one_pose_is_that_of_its_triangles(crank: float) -> None:
    solver = parakin.compile("four-bar", coordinates=["D"], machine_code=False)
    tick = solver.at([crank])
    assert tick.status == Status.CONVERGED
    assert math.cos(tick.position[0] - rocker(crank)) > 1 - 1e-14


@pytest.mark.parametrize("machine_code", [False, None])
def test_a_batch_gives_what_single_calls_give(machine_code: bool | None) -> None:
    solver = parakin.compile("gough-stewart", machine_code=machine_code)
    rng = np.random.default_rng(0)
    home = np.array([solver.home[name] for name in solver.driven])
    y = home[:, None] + 0.1 * rng.uniform(-1, 1, (6, 17))
    yd, ydd = rng.normal(size=(2, 6, 17))
    batch = solver.at(y, yd, ydd)
    for k in range(17):
        alone = solver.at(y[:, k], yd[:, k], ydd[:, k])
        for name in ("position", "velocity", "acceleration"):
            one, other = getattr(alone, name), getattr(batch, name)[:, k]
            np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-13)
        assert alone.status == np.asarray(batch.status)[k]


@pytest.mark.parametrize("size", [1, 7, 50, 1000])
def test_windows_change_nothing(size: int) -> None:
    solver = parakin.compile("flight-simulator", machine_code=False)
    motion = solver.motion("general", rate=100.0)
    whole = solver.solve(motion)
    parts = list(solver.stream(motion, size))
    assert sum(part.sizes["time"] for part in parts) == whole.sizes["time"]
    for name in ("position", "velocity", "acceleration", "status"):
        joined = np.concatenate([part[name].values for part in parts])
        np.testing.assert_allclose(joined, whole[name].values, rtol=0, atol=1e-13)


@pytest.mark.parametrize("size", [0, -1, 1.5, None])
def test_windows_of_no_samples_are_refused(size: object) -> None:
    solver = parakin.compile("four-bar", machine_code=False)
    with pytest.raises(InputError, match="size: found"):
        next(solver.stream("turn", size))  # type: ignore[arg-type]


def test_a_stream_takes_what_solve_takes() -> None:
    solver = parakin.compile("four-bar", machine_code=False)
    (whole,) = solver.stream("turn")
    assert whole.identical(solver.solve("turn"))


def test_what_it_does_not_know_how_to_solve_is_refused() -> None:
    solver = parakin.compile("four-bar", machine_code=False)
    motion = from_laws("other", {"D": constant(1.0)}, 1.0, 10.0)
    with pytest.raises(InputError, match="the driven coordinates A"):
        solver.solve(motion)
    for options in ({"derivatives": 1}, {"checks": False}):
        lean = parakin.compile("four-bar", machine_code=False, **options)
        with pytest.raises(InputError, match="without accelerations or checks"):
            lean.solve("turn")


def test_limits_are_flagged_and_their_values_kept() -> None:
    mechanism = parakin.load("four-bar")
    mechanism = mechanism.model_copy(update={"limits": {"D": ("0 deg", "100 deg")}})
    solver = parakin.compile(mechanism, coordinates=["D"], machine_code=False)
    turning = from_laws("turn", {"A": polynomial345(solver.home["A"], 6.28, 1.0)}, 1.0, 100.0)
    result = solver.solve(turning)
    beyond = result.status.values == Status.LIMIT_EXCEEDED
    angles = result.position.values[:, 0]
    np.testing.assert_array_equal(beyond, (angles > math.radians(100)) | (angles < 0))
    assert beyond.any()
    assert np.isfinite(angles).all()


def test_bodies_stand_at_a_tick_where_a_motion_puts_them() -> None:
    solver = parakin.compile("flight-simulator", machine_code=False)
    motion = solver.motion("general", rate=50.0)
    result = solver.solve(motion, bodies=True)
    samples = motion.reordered(solver.driven).samples()
    for k in (0, 40, 149):
        y = samples.position[:, k]
        position, wxyz = solver.poses(y, solver.at(y))
        np.testing.assert_allclose(position, result.body_position.values[k], atol=1e-14)
        there = result.body_orientation.values[k]
        aligned = np.sign(np.sum(wxyz * there, axis=1))[:, None]
        np.testing.assert_allclose(wxyz * aligned, there, atol=1e-13)


def test_it_says_what_it_is() -> None:
    solver = parakin.compile("four-bar", machine_code=False)
    assert repr(solver) == "<Solver four-bar, driven by A, NumPy>"
    assert solver.angle_rows == [0, 1, 2][: len(solver.coordinates)]
    page = solver._repr_html_()
    assert "four-bar" in page
    assert all(f"<td>{name}</td>" in page for name in solver.coordinates)
