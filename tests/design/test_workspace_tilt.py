"""The largest tilt in every direction, against cones of a spherical joint and plain vectors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

import parakin
from parakin.cli.main import main
from parakin.solving.solver import Solver

TILTS = ["platform.roll", "platform.pitch"]
BALL = """
name = "ball"
driven = ["platform.{0}", "platform.{1}", "platform.{2}"]
[platform]
body = "platform"
angles = [["{0}", "{3}"], ["{1}", "{4}"], ["{2}", "{5}"]]
[bodies.platform]
[joints.S]
kind = "spherical"
parent = "base"
child = "platform"
actuated = true
[limits]
"S.cone" = [0, "{6} deg"]
"""
XYZ = ("roll", "pitch", "yaw", "x", "y", "z")


def ball(folder: Path, cone: float, angles: tuple[str, ...] = XYZ) -> Solver:
    """A platform on a spherical joint, whose z axis stays in a cone."""
    path = folder / "ball.toml"
    path.write_text(BALL.format(*angles, cone))
    return parakin.compile(path)


@pytest.mark.parametrize(
    ("cone", "away", "left"),
    [
        (30.0, {}, 30.0),
        (30.0, {"roll": 12.0}, 18.0),
        (60.0, {"pitch": -35.0}, 25.0),
        (60.0, {"roll": 5.0, "yaw": 50.0}, 55.0),
    ],
)
def test_it_is_what_a_cone_leaves(
    tmp_path: Path, cone: float, away: dict[str, float], left: float
) -> None:
    pose = {f"platform.{name}": float(np.radians(angle)) for name, angle in away.items()}
    found = parakin.workspace(ball(tmp_path, cone), pose, over=TILTS)
    assert np.degrees(float(found["tilt"])) == pytest.approx(left, rel=3e-4)


def test_both_angles_count_where_the_pose_is_tilted_to_both_sides(tmp_path: Path) -> None:
    """In the plane of the angles it would be another figure."""
    angles = np.radians([40.0, 35.0])
    pose = dict(zip(TILTS, angles.tolist(), strict=True))
    found = parakin.workspace(ball(tmp_path, 75.0), pose, over=TILTS)
    z = Rotation.from_euler("XYZ", [*angles, 0.0]).apply([0.0, 0.0, 1.0])
    left = np.radians(75.0) - np.arccos(z[2])
    assert float(found["tilt"]) == pytest.approx(left, rel=3e-4)
    assert abs(float(found["radius"]) - left) > 0.02


def test_the_order_of_the_angles_is_the_files(tmp_path: Path) -> None:
    """Turned by yaw first, then by pitch and roll: yaw tilts nothing."""
    solver = ball(tmp_path, 70.0, ("yaw", "pitch", "roll", "z", "y", "x"))
    pose = {"platform.yaw": 0.9, "platform.pitch": 0.4, "platform.roll": -0.3}
    found = parakin.workspace(solver, pose, over=TILTS)
    z = Rotation.from_euler("ZYX", [0.9, 0.4, -0.3]).apply([0.0, 0.0, 1.0])
    left = np.radians(70.0) - np.arccos(z[2])
    assert float(found["tilt"]) == pytest.approx(left, rel=3e-4)
    assert np.isnan(parakin.workspace(solver, over=["platform.yaw", "platform.roll"])["tilt"])


@pytest.mark.parametrize(("pitch", "left"), [(0.0, 120.0), (60.0, 60.0)])
def test_directions_that_come_twice_count_once(tmp_path: Path, pitch: float, left: float) -> None:
    """At a pitch beyond 90° directions come again, turned by a roll of 180°; and a roll of 180° is
    one of -180°.
    """
    pose = {"platform.pitch": float(np.radians(pitch))}
    found = parakin.workspace(ball(tmp_path, 120.0), pose, over=TILTS)
    assert np.degrees(float(found["tilt"])) == pytest.approx(left, rel=1e-3)


def test_what_was_not_looked_at_counts_as_beyond(tmp_path: Path) -> None:
    look = {"platform.roll": (-0.2, 3.2)}
    found = parakin.workspace(ball(tmp_path, 60.0), over=TILTS, within=look)
    assert float(found["tilt"]) == pytest.approx(0.2, rel=1e-4)


def test_what_does_not_tilt_to_all_sides_has_none(tmp_path: Path) -> None:
    solver = ball(tmp_path, 30.0)
    assert np.isnan(parakin.workspace(solver, over=["platform.roll", "platform.yaw"])["tilt"])
    assert np.isnan(parakin.workspace(solver, points=9)["tilt"])
    assert np.isnan(parakin.workspace(parakin.compile("seat-3dof"), points=9)["tilt"])
    upright = {"platform.pitch": np.pi / 2.0}  # there roll turns it about its own z axis
    assert np.isnan(parakin.workspace(ball(tmp_path, 120.0), upright, over=TILTS)["tilt"])


def test_of_a_rig_it_is_that_of_plain_vectors() -> None:
    """Directions all around, each as far as the legs' lengths let it."""
    rig = Path(__file__).parents[2] / "examples" / "rig.toml"
    solver = parakin.compile(rig)
    height = solver.home["platform.z"] - 0.05

    def circle(r: float, apart: float, first: float) -> np.ndarray:
        middle = first + 120.0 * np.repeat(np.arange(3), 2)
        angle = np.radians(middle + np.tile([-0.5, 0.5], 3) * apart)
        return r * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=-1)

    base, top = circle(0.82, 14.0, 0.0), np.roll(circle(0.61, 18.0, -60.0), -1, axis=0)

    def room(tilt: float, around: float) -> float:
        x, y = np.sin(tilt) * np.cos(around), np.sin(tilt) * np.sin(around)
        angles = [np.arctan2(-y, np.cos(tilt)), np.arcsin(x), 0.0]
        feet = base - np.array([0.0, 0.0, height])
        lengths = np.linalg.norm(Rotation.from_euler("XYZ", angles).apply(top) - feet, axis=1)
        return float(min(1.26 - lengths.max(), lengths.min() - 0.86))

    def least(arounds: np.ndarray) -> tuple[float, float]:
        each = [brentq(room, 0.0, 0.6, args=(around,), xtol=1e-12) for around in arounds]
        return min(each), float(arounds[int(np.argmin(each))])

    _, near = least(np.radians(np.arange(0.0, 360.0, 2.0)))
    exact, _ = least(near + np.radians(np.linspace(-3.0, 3.0, 201)))
    loose = solver.mechanism.model_dump(exclude_unset=True)
    loose["limits"] = {name: ends for name, ends in loose["limits"].items() if "cone" not in name}
    found = parakin.workspace(
        parakin.compile(parakin.Mechanism(**loose)), {"platform.z": height}, over=TILTS
    )
    assert float(found["tilt"]) == pytest.approx(exact, rel=3e-4)


def test_it_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ball(tmp_path, 30.0)
    path = str(tmp_path / "ball.toml")
    over = ["--over", "platform.roll,platform.pitch"]
    assert main(["workspace", path, *over, "--from", "platform.roll=12 deg"]) == 0
    assert "largest tilt in every direction: 18.00 deg\n" in capsys.readouterr().out
    assert main(["workspace", path, "--over", "platform.roll,platform.yaw"]) == 0
    assert "tilt in every" not in capsys.readouterr().out
