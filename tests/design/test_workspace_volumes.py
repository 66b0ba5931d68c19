"""Volumes of Deltas against areas of discs in closed form, one upon another."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from discs import area_of_rings, turned

import parakin

AROUND = np.radians([0.0, 120.0, 240.0])
LOW, HIGH = -30.0, 70.0  # of the arms, downwards from level
ARM, ROD = 0.25, 0.6


def test_the_volume_of_a_linear_delta() -> None:
    """Rails without ends: three upright cylinders about the rods' radius, as high as is looked."""
    solver = parakin.compile("linear-delta")
    found = parakin.workspace(solver, within={"platform.z": (-0.1, 0.2)}, points=61)
    disks = [(0.14 * turned(np.radians(120.0 * k)), 0.0, 0.3) for k in range(3)]
    assert float(found["size"]) == pytest.approx(0.3 * area_of_rings(disks), rel=1e-3)


def elbow(degrees: float) -> tuple[float, float]:
    """How far out and how high it is, the platform's radius taken off."""
    angle = np.radians(degrees)
    return 0.2 - 0.05 + ARM * np.cos(angle), -ARM * np.sin(angle)


def delta_keeps(points: np.ndarray) -> np.ndarray:
    """A Delta's arms by themselves: from level, downwards, -30 to 70 degrees, elbows outwards."""
    kept = np.ones(len(points), dtype=bool)
    for angle in np.radians([0.0, 120.0, 240.0]):
        out = points[:, 0] * np.cos(angle) + points[:, 1] * np.sin(angle) + 0.05 - 0.2
        aside = points[:, 1] * np.cos(angle) - points[:, 0] * np.sin(angle)
        down = -points[:, 2]
        flat = np.hypot(out, down)
        with np.errstate(invalid="ignore"):
            bend = np.arccos((0.25**2 + flat**2 + aside**2 - 0.6**2) / (2.0 * 0.25 * flat))
        arm = np.arctan2(down, out) - bend
        kept &= (arm >= np.radians(-30.0)) & (arm <= np.radians(70.0))
    return kept


def is_between_spheres(points: np.ndarray) -> np.ndarray:
    """Within a rod's length of all elbows as low as they go, and of none as high as it goes."""
    kept = np.ones(len(points), dtype=bool)
    for around in AROUND:
        for end in (LOW, HIGH):
            out, height = elbow(end)
            near = np.linalg.norm(points - [*(out * turned(around)), height], axis=1) <= ROD
            kept &= near if end == HIGH else ~near
    return kept


def area_at(z: float) -> float:
    """Of what is between the spheres at a height: in three discs and outside of three others."""
    rings = []
    for around in AROUND:
        for end in (LOW, HIGH):
            out, height = elbow(end)
            radius = np.sqrt(max(ROD**2 - (z - height) ** 2, 0.0))
            ends = (0.0, radius) if end == HIGH else (radius, 9.0)
            rings.append((out * turned(around), *ends))
    return area_of_rings(rings)


def ends() -> tuple[float, float]:
    """The lowest and the highest point, which are both on the axis."""
    (far, high), (near, low) = elbow(LOW), elbow(HIGH)
    return low - float(np.sqrt(ROD**2 - near**2)), high - float(np.sqrt(ROD**2 - far**2))


def volume(count: int) -> float:
    """By Gauss, between these."""
    bottom, top = ends()
    x, weight = np.polynomial.legendre.leggauss(count)
    heights = 0.5 * (bottom + top) + 0.5 * (top - bottom) * x
    return 0.5 * (top - bottom) * float(weight @ [area_at(z) for z in heights.tolist()])


def test_a_delta_goes_where_it_is_between_spheres() -> None:
    """Where its arms keep their limits, elbows outwards; the whole of it lies in these bounds."""
    points = np.random.default_rng(5).random((1_000_000, 3)) * (1.4, 1.4, 1.0) - (0.7, 0.7, 0.95)
    kept = delta_keeps(points)
    assert np.array_equal(kept & (points[:, 2] < 0.0), is_between_spheres(points))
    assert kept.sum() > 30_000


def test_the_volume_of_a_delta(tmp_path: Path) -> None:
    exact = volume(400)
    assert volume(250) == pytest.approx(exact, rel=2e-4)
    path = tmp_path / "delta.toml"
    text = (Path(parakin.__file__).parent / "catalogue" / "delta.toml").read_text("utf-8")
    rows = [f'A{k} = ["{LOW} deg", "{HIGH} deg"]' for k in (1, 2, 3)]
    path.write_text("\n".join([text, "[limits]", *rows]))
    found = parakin.workspace(parakin.compile(path), points=81)
    assert float(found["size"]) == pytest.approx(exact, rel=1e-3)
    assert abs(float(found["size"]) - exact) < float(found["size_uncertainty"])
    assert found["extent"].values[2] == pytest.approx(ends(), abs=1e-9)
