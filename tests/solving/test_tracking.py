"""Following a motion: full turns, dead centres, ends of reach, windows and threads."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import xarray as xr

import parakin
from parakin import Body, Frame, Joint, Mechanism, Status
from parakin.motion.laws import Law, constant, from_laws, polynomial345, sine
from parakin.motion.motion import Motion, Samples

CRANK, ROD = 0.05, 0.15
Compiled = Callable[..., parakin.Solver]


def slider_crank() -> Mechanism:
    return Mechanism(
        name="slider-crank",
        bodies=(Body(name="crank"), Body(name="rod"), Body(name="piston")),
        joints=(
            Joint(name="A", kind="revolute", parent="base", child="crank"),
            Joint(
                name="B",
                kind="revolute",
                parent="crank",
                child="rod",
                on_parent=Frame(at=(CRANK, 0, 0)),
            ),
            Joint(
                name="C",
                kind="revolute",
                parent="rod",
                child="piston",
                on_parent=Frame(at=(ROD, 0, 0)),
            ),
            Joint(
                name="D",
                kind="prismatic",
                parent="base",
                child="piston",
                on_parent=Frame(axis=(1, 0, 0)),
                on_child=Frame(axis=(1, 0, 0)),
            ),
        ),
        home={"A": 0.5},
        guess={"B": -0.7, "C": 0.2, "D": 0.19},
    )


def four_bar(ground: float, crank: float, coupler: float, rocker: float) -> Mechanism:
    return Mechanism(
        name="four-bar",
        bodies=(Body(name="crank"), Body(name="coupler"), Body(name="rocker")),
        joints=(
            Joint(name="A", kind="revolute", parent="base", child="crank"),
            Joint(
                name="B",
                kind="revolute",
                parent="crank",
                child="coupler",
                on_parent=Frame(at=(crank, 0, 0)),
            ),
            Joint(
                name="C",
                kind="revolute",
                parent="coupler",
                child="rocker",
                on_parent=Frame(at=(coupler, 0, 0)),
                on_child=Frame(at=(rocker, 0, 0)),
            ),
            Joint(
                name="D",
                kind="revolute",
                parent="base",
                child="rocker",
                on_parent=Frame(at=(ground, 0, 0)),
            ),
        ),
        home={"A": 1.0},
        guess={"B": -0.5, "D": 1.5},
    )


def motion(coordinate: str, law: Law, duration: float, rate: float) -> Motion:
    return from_laws("test", {coordinate: law}, duration, rate)


def test_a_crank_turned_twenty_times_counts_its_turns(reading: bool) -> None:
    solver = parakin.compile(slider_crank(), ["A"], coordinates="all", machine_code=reading)
    turning = polynomial345(0.5, 40 * np.pi, 10.0)
    whole = solver.solve(motion("A", turning, 10.0, 200.0))
    a, b, c, d = (whole.position.sel(coordinate=n).values for n in "ABCD")
    assert not whole.status.any()
    stroke = CRANK * np.cos(a) + np.sqrt(ROD**2 - (CRANK * np.sin(a)) ** 2)
    np.testing.assert_allclose(d, stroke, rtol=0, atol=1e-14)
    lean = -np.arcsin(CRANK / ROD * np.sin(a))  # of the rod, which never turns over
    np.testing.assert_allclose(a + b, lean, rtol=0, atol=1e-12)
    np.testing.assert_allclose(c, -lean, rtol=0, atol=1e-12)
    assert b[0] - b[-1] == pytest.approx(40 * np.pi, abs=1e-12)
    windows = list(solver.stream(motion("A", turning, 10.0, 200.0), 137))
    xr.testing.assert_allclose(xr.concat(windows, "time", data_vars="minimal"), whole, atol=1e-13)


def test_a_piston_cannot_be_driven_through_its_dead_centre(reading: bool) -> None:
    solver = parakin.compile(slider_crank(), ["D"], machine_code=reading)
    start = solver.home["D"]
    towards = solver.solve(motion("D", polynomial345(start, 0.1999 - start, 1.0), 1.0, 1000.0))
    assert not towards.status.any()
    assert float(towards.conditioning.min()) < 0.1
    beyond = solver.solve(motion("D", polynomial345(start, 0.21 - start, 1.0), 1.0, 1000.0))
    first = int(np.argmax(beyond.status.values != 0))
    assert beyond.status.values[first] in (Status.OUT_OF_REACH, Status.SINGULAR)
    assert (beyond.status.values[first + 1 :] == Status.NOT_REACHED).all()
    driven = motion("D", polynomial345(start, 0.21 - start, 1.0), 1.0, 1000.0).samples().position[0]
    assert driven[first - 1] < CRANK + ROD < driven[first] + 1e-9
    # Touching the dead centre exactly and coming back is a singularity met, and said so.
    reach = CRANK + ROD - start
    touch = solver.solve(motion("D", sine(start, reach, 0.5), 1.0, 1000.0))
    assert set(touch.status.values) & {Status.SINGULAR, Status.OUT_OF_REACH, Status.BRANCH_CHANGE}


def test_a_grashof_crank_turns_and_a_double_rocker_stops(reading: bool) -> None:
    grashof = parakin.compile(
        four_bar(4, 1, 3.5, 3), ["A"], coordinates="all", machine_code=reading
    )
    turned = grashof.solve(motion("A", polynomial345(1.0, 4 * np.pi, 2.0), 2.0, 500.0))
    assert not turned.status.any()
    a, d = (turned.position.sel(coordinate=n).values for n in "AD")
    # Freudenstein's equation for crank 1, coupler 3.5, rocker 3, ground 4.
    left = 4 / 1 * np.cos(d) - 4 / 3 * np.cos(a) + (4**2 + 1 + 3**2 - 3.5**2) / (2 * 1 * 3)
    np.testing.assert_allclose(left, np.cos(a - d), rtol=0, atol=1e-12)
    rocker = parakin.compile(four_bar(4, 3, 2, 2.5), ["A"], machine_code=reading)
    stopped = rocker.solve(motion("A", polynomial345(1.0, 2 * np.pi, 2.0), 2.0, 500.0))
    first = int(np.argmax(stopped.status.values != 0))
    assert first > 0
    crank = motion("A", polynomial345(1.0, 2 * np.pi, 2.0), 2.0, 500.0).samples().position[0]
    limit = np.arccos((3**2 + 4**2 - (2 + 2.5) ** 2) / (2 * 3 * 4))  # coupler and rocker in line
    assert crank[first - 1] <= limit <= crank[first]


def forward(inverse: xr.Dataset, every: int = 1) -> Motion:
    drives = inverse.isel(time=slice(None, None, every)).sel(coordinate=["A2", "B3", "C3"])
    rows = [drives[q].values.T.copy() for q in ("position", "velocity", "acceleration")]
    time = drives.time.values

    def window(a: int, b: int) -> Samples:
        return Samples(time[a:b], *(np.ascontiguousarray(r[:, a:b]) for r in rows))

    return Motion("sliders", ("A2", "B3", "C3"), len(time), window, "given")


def test_windows_of_a_followed_motion_join_up(compiled: Compiled) -> None:
    solver = compiled("A2", "B3", "C3")
    sliders = forward(compiled().solve("general"), 3)
    whole = solver.solve(sliders)
    assert not whole.status.any()
    joined = xr.concat(list(solver.stream(sliders, 170)), "time", data_vars="minimal")
    xr.testing.assert_allclose(joined, whole, atol=1e-12)


def test_orientations_go_on_from_window_to_window(compiled: Compiled) -> None:
    solver = compiled()
    whole = solver.solve("general", bodies=["rod"])
    windows = list(solver.stream(solver.motion("general"), 700, bodies=["rod"]))
    joined = np.concatenate([window.body_orientation.values for window in windows])
    np.testing.assert_allclose(joined, whole.body_orientation, rtol=0, atol=1e-14)


def test_coarse_samples_are_followed_to_the_same_poses(compiled: Compiled) -> None:
    solver = compiled("A2", "B3", "C3")
    inverse = compiled().solve("general")
    coarse = solver.solve(forward(inverse, 600))  # 0.6 s apart
    assert not coarse.status.any()
    names = [n for n in solver.coordinates if not n.endswith(".cone")]
    expected = inverse.isel(time=slice(None, None, 600)).position.sel(coordinate=names)
    assert float(np.abs(coarse.position.sel(coordinate=names) - expected).max()) < 1e-12


def test_a_followed_motion_out_of_reach_is_solved_as_far_as_it_goes(compiled: Compiled) -> None:
    solver = compiled("A2", "B3", "C3")
    laws = {name: constant(solver.home[name]) for name in solver.driven}
    laws["B3"] = polynomial345(solver.home["B3"], -0.9, 1.0)
    result = solver.solve(from_laws("pull", laws, 1.0, 1000.0))
    first = int(np.argmax(result.status.values != 0))
    assert 10 < first < 1000
    assert result.status.values[first] not in (Status.CONVERGED, Status.NOT_REACHED)
    assert (result.status.values[first + 1 :] == Status.NOT_REACHED).all()
    assert float(result.residual[:first].max()) < 1e-12
    assert np.isnan(result.position.values[first:]).all()
    with pytest.raises(parakin.NotSolvedError):
        parakin.require_solved(result)


def test_one_pose_needs_no_motion(compiled: Compiled) -> None:
    inverse, solver = compiled(), compiled("A2", "B3", "C3")
    y = [1.9, 1.2, 0.15]
    pose = inverse.at(y, [0.1, 0, 0.2], [0, 1, 0])
    assert pose.status == 0
    at = dict(zip(inverse.coordinates, pose.position, strict=True))
    rates = dict(zip(inverse.coordinates, pose.velocity, strict=True))
    back = solver.at([at[n] for n in solver.driven], [rates[n] for n in solver.driven])
    assert back.status == 0
    place = [solver.coordinates.index(n) for n in inverse.driven]
    np.testing.assert_allclose(back.position[place], y, rtol=0, atol=1e-12)
    np.testing.assert_allclose(back.velocity[place], [0.1, 0, 0.2], rtol=0, atol=1e-12)
    batch = inverse.at(np.array([y, [1.9, 9.0, 0.0]]).T)
    assert list(np.atleast_1d(batch.status)) == [Status.CONVERGED, Status.OUT_OF_REACH]
    assert np.isnan(batch.position[:, 1]).all()
    np.testing.assert_allclose(batch.position[:, 0], pose.position, rtol=0, atol=1e-13)
    for bad in ([1.9, 1.2], [[1.9, 1.2, 0.1]], np.zeros((3, 2, 2))):
        with pytest.raises(parakin.InputError, match=r"\(3,\) or \(3, n\)"):
            inverse.at(bad)
    lost = inverse.at([1.9, np.nan, 0.0])
    assert lost.status == Status.OUT_OF_REACH
    assert np.isnan(lost.position).all()


def test_a_solver_that_iterates_keeps_its_checks(reading: bool) -> None:
    solver = parakin.compile(
        "flight-simulator",
        ["A2", "B3", "C3"],
        coordinates=["platform.x"],
        derivatives=0,
        checks=False,
        machine_code=reading,
    )
    home = [solver.home[name] for name in solver.driven]
    tick = solver.at(home)
    assert tick.status == Status.CONVERGED
    assert tick.position[0] == pytest.approx(1.85, abs=1e-12)
    assert solver.at([9.0, *home[1:]]).status != Status.CONVERGED


def test_a_guess_chooses_the_turn_of_an_angle(reading: bool) -> None:
    solver = parakin.compile(slider_crank(), ["A"], machine_code=reading)
    near = solver.at([0.5])
    far = solver.at([0.5], guess=near.position + 6 * np.pi)
    turned = solver.coordinates.index("B")
    assert far.position[turned] - near.position[turned] == pytest.approx(6 * np.pi, abs=1e-12)


def test_all_cores_give_the_same_numbers(compiled: Compiled) -> None:
    solver = compiled()
    many = solver.motion("general", rate=20_000)
    one, all_ = solver.solve(many), solver.solve(many, parallel=True)
    np.testing.assert_allclose(all_.position, one.position, rtol=0, atol=1e-15)
    np.testing.assert_allclose(all_.acceleration, one.acceleration, rtol=0, atol=1e-13)
