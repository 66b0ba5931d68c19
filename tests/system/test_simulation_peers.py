"""A spatial four-bar's motion, against its equation of motion written out, and against engines."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytestmark = pytest.mark.repository
SECONDS = 2.0  # in which the crank turns by 16 rad


@pytest.fixture(autouse=True)
def _benchmarks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(Path(__file__).parents[2])


def test_it_moves_as_its_equation_of_motion_says() -> None:
    """Found: 2e-11 rad and 1e-10 rad/s, as far as the reference is right."""
    from benchmarks.peers import four_bar, four_bar_engines, simulation

    angle, rate = four_bar.reference(four_bar_engines.sampled(SECONDS))
    told = simulation.of_parakin(SECONDS, 1e-12)()
    np.testing.assert_allclose(told.angle, angle, rtol=0, atol=1e-8)
    np.testing.assert_allclose(told.rate, rate, rtol=0, atol=1e-7)


def test_its_reference_keeps_its_energy_and_its_rates_are_those_of_its_places() -> None:
    """The rates are written out; a complex step through the places alone gives them, too."""
    from benchmarks.peers import four_bar

    for q in (0.0, 0.7, 2.0, 4.5):
        there, near = four_bar.placed(q), four_bar.placed(q + 1e-30j)
        for name, body in there.items():
            turn = near[name].axes.imag / 1e-30 @ body.axes.T
            assert [turn[2, 1], turn[0, 2], turn[1, 0]] == pytest.approx(body.spin, abs=1e-14)
            assert near[name].origin.imag / 1e-30 == pytest.approx(body.rate, abs=1e-14)
            assert body.axes.T @ body.axes == pytest.approx(np.eye(3), abs=1e-14)
    angle, rate = four_bar.reference(np.linspace(0.0, 1.0, 11))
    energies = [four_bar.energy(q, qd) for q, qd in zip(angle, rate, strict=True)]
    assert energies == pytest.approx([energies[0]] * 11, abs=1e-10)


@pytest.mark.parametrize(
    ("engine", "way", "option", "within"),
    [
        ("pinocchio", "of_pinocchio_dop853", (1e-11,), 1e-8),  # found: 5e-10
        ("exudyn", "of_exudyn", (2e-4,), 5e-4),  # found: 5e-5; of second order
        ("mujoco", "of_mujoco", (1e-3, True), 5e-4),  # found: 5e-5; its loops give way
    ],
)
def test_engines_agree(engine: str, way: str, option: tuple[float, ...], within: float) -> None:
    pytest.importorskip(engine)
    from benchmarks.peers import four_bar_engines, simulation

    ours = simulation.of_parakin(SECONDS, 1e-11)()
    theirs = getattr(four_bar_engines, way)(SECONDS, *option)()
    np.testing.assert_allclose(theirs.angle, ours.angle, rtol=0, atol=within)
