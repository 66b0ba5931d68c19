"""Many simulations at once, against single ones and closed forms; and what is refused."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import parakin
from parakin import InputError, Status
from parakin.solving.applied import State

BLOCK = """
name = "block"
driven = ["X"]
home.X = 0
[bodies]
block = { mass = 4 }
[joints.X]
kind = "prismatic"
parent = "base"
child = "block"
on_parent = { axis = [1, 0, 0] }
on_child = { axis = [1, 0, 0] }
actuated = true
"""


def block(folder: Path, more: str = "", **options: Any) -> parakin.Solver:
    (folder / "block.toml").write_text(BLOCK + more)
    return parakin.compile(folder / "block.toml", **options)


@pytest.mark.parametrize("machine_code", [False, None])
def test_runs_are_as_they_are_alone(machine_code: bool | None) -> None:
    """Starts, rates, payloads and efforts of a hexapod."""
    mechanism = parakin.load("gough-stewart").with_payload("100 kg at platform")
    hexapod = parakin.compile(mechanism, machine_code=machine_code)
    held = hexapod.at([hexapod.home[n] for n in hexapod.driven], forces=True).forces
    assert held is not None
    efforts: dict[str, Any] = dict(zip(held.actuators, held.effort.tolist(), strict=True))
    efforts["P1"] = np.array([0.0, 500.0, efforts["P1"]])
    (payload,) = (load.name for load in hexapod.graph.dynamics.loads)
    starts: dict[str, Any] = {"platform.z": np.array([1.0, 1.05, 1.1]), "platform.pitch": 0.05}
    rates = {"platform.x": np.array([0.3, 0.0, -0.2])}
    masses = {payload: np.array([0.0, 50.0, 300.0])}
    ds = parakin.simulate_batch(
        hexapod, 0.1, efforts, start=starts, velocity=rates, loads=masses, rate=50
    )
    assert (ds["status"] == 0).all()
    assert ds["position"].dims == ("run", "time", "coordinate")
    for run in range(3):
        alone = hexapod.simulate(
            0.1,
            {**efforts, "P1": float(efforts["P1"][run])},
            start={name: float(np.broadcast_to(v, 3)[run]) for name, v in starts.items()},
            velocity={name: float(v[run]) for name, v in rates.items()},
            loads={payload: float(masses[payload][run])},
            rate=50,
            rtol=1e-12,
        )
        one = ds.isel(run=run)
        for order in ("position", "velocity", "acceleration", "effort"):
            size = float(abs(alone[order]).max())
            assert one[order].values == pytest.approx(alone[order].values, abs=1e-8 * size)
    assert float(abs(ds["energy_drift"]).max()) < 1e-6
    assert float(ds["closure_drift"].max()) < 1e-9


def test_the_method_is_of_fourth_order(tmp_path: Path) -> None:
    """400 N/m on 4 kg: x = cos(10 t)."""
    spring = block(tmp_path, "spring = { stiffness = 400 }\n")
    errors = []
    for step in (0.02, 0.01):
        ds = parakin.simulate_batch(spring, 1.0, start={"X": 1.0}, step=step, rate=10)
        exact = np.cos(10 * ds["time"].values)
        errors.append(np.abs(ds["position"].values[0, :, 0] - exact).max())
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.1)


@pytest.mark.parametrize("how", ["table", "law", "servo", "function"])
def test_efforts_of_runs(tmp_path: Path, how: str) -> None:
    sizes = np.array([1.0, 2.0, -3.0])
    law = {"law": "sine", "amplitude": "8 N", "frequency": f"{1 / (2 * math.pi)!r} Hz"}

    def function(state: State) -> dict[str, Any]:
        return {"X": 8.0 * sizes * math.sin(state.time) + 0.0 * state.position["X"]}

    efforts: Any = {
        "table": {"X": 4 * sizes},
        "law": {"X": law},
        "servo": {"X": {"stiffness": 400, "target": 0.0}},
        "function": function,
    }[how]
    start = {"table": None, "function": {"X": np.zeros(3)}}.get(how, {"X": sizes})
    ds = parakin.simulate_batch(block(tmp_path), 2.0, efforts, start=start, rate=20)
    t = ds["time"].values
    expected = {
        "table": sizes[:, None] * t**2 / 2,
        "law": sizes[:, None] + 2.0 * (t - np.sin(t)),
        "servo": sizes[:, None] * np.cos(10 * t),
        "function": sizes[:, None] * 2.0 * (t - np.sin(t)),
    }[how]
    assert ds["position"].values[:, :, 0] == pytest.approx(expected, abs=1e-6)


def test_runs_that_cannot_go_on_are_flagged(tmp_path: Path) -> None:
    """One starts out of reach; one meets a singularity; one goes on beyond a limit."""
    mechanism = parakin.load("slider-crank")
    told = {"mass": 1.0, "inertia": (0.01,) * 3}
    bodies = tuple(
        b if b.name == mechanism.base else b.model_copy(update=told) for b in mechanism.bodies
    )
    slide = next(j.name for j in mechanism.joints if j.kind == "prismatic")
    by_slide = parakin.compile(mechanism.model_copy(update={"bodies": bodies}), [slide])
    home = by_slide.home[slide]
    starts = {slide: np.array([home, home + 9.0, home])}
    rates = {slide: np.array([0.0, 0.0, 0.5])}
    ds = parakin.simulate_batch(by_slide, 0.1, start=starts, velocity=rates, rate=1000)
    status = ds["status"].values
    assert (status[0] == 0).all()
    assert status[1, 0] == Status.OUT_OF_REACH
    assert (status[1, 1:] == Status.NOT_REACHED).all()
    ended = int(np.flatnonzero(status[2])[0])
    assert status[2, ended] == Status.SINGULAR
    assert (status[2, ended + 1 :] == Status.NOT_REACHED).all()
    for name in ("position", "velocity", "effort", "energy_drift", "closure_drift"):
        assert np.isnan(ds[name].values[1]).all()
        assert np.isnan(ds[name].values[2, ended:]).all()
        assert np.isfinite(ds[name].values[2, :ended]).all()
        assert np.isfinite(ds[name].values[0]).all()
    limited = block(tmp_path, "[limits]\nX = [-1, 0.5]\n")
    ds = parakin.simulate_batch(limited, 1.0, velocity={"X": [0.4, 1.0]}, rate=100)
    assert (ds["status"].values[0] == 0).all()
    assert ds["status"].values[1, -1] == Status.LIMIT_EXCEEDED
    assert float(ds["position"][1, -1, 0]) == pytest.approx(1.0, abs=1e-12)


def test_threads_change_nothing() -> None:
    pytest.importorskip("heyoka")
    delta = parakin.compile("delta")
    starts = {"platform.z": delta.home["platform.z"] + np.linspace(-0.02, 0.02, 501)}
    one, other = (
        parakin.simulate_batch(delta, 0.02, start=starts, rate=100, parallel=parallel)
        for parallel in (False, True)
    )
    assert one.identical(other)


REFUSED: list[tuple[dict[str, Any], str]] = [
    ({"start": {"X": [1.0, 2.0]}, "velocity": {"X": [1.0]}}, r"velocity of X: found shape \(1,\)"),
    ({"start": {"X": [[1.0, 2.0]]}}, r"start of X: found shape \(1, 2\)"),
    ({"start": {"X": []}}, r"start of X: found shape \(0,\)"),
    ({"start": {"Y": [1.0]}}, "start: found 'Y', not driven"),
    ({"start": {"X": [1.0, math.nan]}}, "start of X: .*finite"),
    ({"start": {"X": ["a", "b"]}}, "start of X: .*numbers"),
    ({"start": {"X": [1 + 2j]}}, "start of X: .*numbers"),
    ({"start": {"X": [True]}}, "start of X: .*numbers"),
    ({"start": {"X": [10**400]}}, "start of X: .*numbers"),
    ({"start": {"X": np.ma.array([1.0, 2.0], mask=[False, True])}}, "start of X: .*numbers"),
    ({"efforts": {"Y": [1.0]}}, "efforts: found 'Y', not actuated"),
    ({"efforts": {"Y": 1.0}}, "efforts: found 'Y', not actuated"),
    ({"efforts": {"X": [math.inf]}}, "efforts of X: .*finite"),
    ({"efforts": lambda _: {"X": np.array([math.nan])}}, "efforts at 0 s: .*finite"),
    ({"loads": {"p": [1.0, 2.0]}}, "unknown payload or wrench 'p'"),
    ({"efforts": lambda _: {"X": np.zeros(2)}}, r"efforts at 0 s: .*arrays \(1,\)"),
    ({"step": 0.0}, "step: found 0"),
    ({"step": math.nan}, "step: found nan"),
    ({"rate": -1.0}, "rate: found -1"),
    ({"duration": math.inf}, "duration: found inf"),
]


@pytest.mark.parametrize(("given", "message"), REFUSED)
def test_what_is_refused(tmp_path: Path, given: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        parakin.simulate_batch(block(tmp_path, machine_code=False), **{"duration": 1.0, **given})


def test_a_solver_that_hides_what_it_iterates_is_refused() -> None:
    hidden = parakin.compile("gough-stewart", coordinates=["platform.z"])
    if hidden.iterated:
        with pytest.raises(InputError, match="one that does not report"):
            parakin.simulate_batch(hidden, 0.1)
    legs = parakin.compile("gough-stewart", [f"P{k}" for k in range(1, 7)], coordinates=["P1"])
    with pytest.raises(InputError, match="one that does not report"):
        parakin.simulate_batch(legs, 0.1)
