"""Forces in a terminal: peaks, limits, warnings."""

from __future__ import annotations

import io
import re

import numpy as np
import pendulum
import pytest
from rich.console import Console

import parakin
from parakin.views.force_extremes import ForceExtremes, force_extremes
from parakin.views.force_text import figure, forces_report, warnings


def printed(solver: parakin.Solver, found: ForceExtremes) -> str:
    console = Console(file=io.StringIO(), width=1000)
    console.print(forces_report(found, solver.graph))
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue()


def solved(limit: str = pendulum.LIMIT) -> tuple[parakin.Solver, ForceExtremes]:
    solver = parakin.compile(pendulum.pendulum(limit), machine_code=False)
    found = force_extremes(solver.solve("swing", forces=True, reactions=True))
    assert found is not None
    return solver, found


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (1e-12, "0"),
        (12345.678, "12,346"),
        (-19.1347, "-19.13"),
        (0.48866, "0.4887"),
        (2e-7, "2.000e-07"),
        (float("nan"), ""),
    ],
)
def test_numbers_have_four_digits(value: float, text: str) -> None:
    assert figure(value) == text


def test_a_pendulum_s_table() -> None:
    text = printed(*solved())
    effort, power, torque = pendulum.efforts(np.linspace(0.0, 2.0, 20_001))
    (row,) = (line for line in text.splitlines() if line.startswith("A [N m]"))
    assert f" {effort.max():.2f} " in row
    assert f"{power.min():.2f} .. {power.max():.2f}" in row
    used = rf"A, effort +{effort.max():.2f} N m +30 N m +{100 * effort.max() / 30:.0f} %"
    assert re.search(used, text)
    speed = pendulum.AMPLITUDE * pendulum.RATE * pendulum.RATIO * 30 / np.pi
    assert f"{speed:,.0f} rpm" in text
    assert f"{np.abs(torque).max() / pendulum.TORQUE_CONSTANT:.2f}"[:4] in text


def test_what_is_beyond_a_drive_s_limit_is_said() -> None:
    solver, found = solved("10 N m")
    effort, torque = list(warnings(found, solver.graph))
    assert effort.startswith("beyond its drive: A needs an effort of 19.1")
    assert effort.endswith("limit 10 N m")
    assert "a torque of" in torque


def test_efforts_that_are_not_known_are_counted() -> None:
    """And are no peaks, though they are not NaN."""
    solver = parakin.compile(pendulum.pendulum(pendulum.LIMIT), machine_code=False)
    ds = solver.solve("swing", forces=True, reactions=True)
    ds["effort"].values[3:5] = np.nan
    ds["effort"].values[7] = np.inf
    first, second = ds.isel(time=slice(0, 6)), ds.isel(time=slice(6, None))
    found = force_extremes(second, force_extremes(first))
    assert found is not None
    assert (found.unknown, found.solved) == (3, ds.sizes["time"])
    words = next(warnings(found, solver.graph))
    assert words.startswith(f"efforts are not known at 3 of {ds.sizes['time']:,} samples, first at")
    assert f"{float(ds['time'][3]):.6g} s" in words
    assert np.isfinite(found.peak("effort", 0)[0])


def test_near_a_singularity_efforts_grow_without_bound() -> None:
    solver, found = solved("100 N m")
    found.conditioning.low[:] = 0.005
    assert "efforts grow without bound near a type 2 singularity" in printed(solver, found)
    found.conditioning.low[:] = -0.2
    assert "the motion crosses a type 2 singularity" in printed(solver, found)


def test_components_that_rigid_bodies_leave_open() -> None:
    """Parallel hinges of a four-bar take any force along their axes, and moments across them."""
    mechanism = parakin.load("four-bar")
    heavy = [body.model_copy(update={"mass": "1 kg"}) for body in mechanism.bodies]
    solver = parakin.compile(
        mechanism.model_copy(update={"bodies": tuple(heavy)}), machine_code=False
    )
    motion = next(iter(mechanism.motions))
    found = force_extremes(solver.solve(motion, forces=True, reactions=["B"]))
    assert found is not None
    text = printed(solver, found)
    assert "(z indeterminate)" in text
    assert "(x, y indeterminate)" in text
