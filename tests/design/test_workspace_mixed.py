"""Workspaces over slides and angles at once, against intervals of slides in closed form for each
angle, and what is said of them.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from scipy.spatial.transform import Rotation

import parakin
from parakin.cli.main import main
from parakin.errors import InputError
from parakin.solving.solver import Solver
from parakin.views.workspace_plot import workspaces
from parakin.views.workspace_shares import shares

CATALOGUE = Path(parakin.__file__).parent / "catalogue"
LOW, HIGH = 0.52, 0.7
LIMITS = "\n".join(f"P{k} = [{LOW}, {HIGH}]" for k in (1, 2, 3))
TILT = np.radians(40.0)  # beyond what the legs allow
LOOK = {"platform.roll": (-TILT, TILT), "platform.pitch": (-TILT, TILT)}


def limited(folder: Path, name: str, limits: str) -> Path:
    path = folder / f"{name}.toml"
    path.write_text((CATALOGUE / f"{name}.toml").read_text("utf-8") + "\n[limits]\n" + limits)
    return path


@pytest.fixture
def rps(tmp_path: Path) -> Solver:
    return parakin.compile(limited(tmp_path, "3-rps", LIMITS))


# The 3-RPS: spherical joints stay in the upright planes of their legs. That makes the platform's
# rotation symmetric in x and y, which gives yaw, and x and y follow.

AROUND = np.radians([0.0, 120.0, 240.0])
OUT = np.stack([np.cos(AROUND), np.sin(AROUND), 0.0 * AROUND])


def legs(roll: np.ndarray, pitch: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of each leg (3, n): how far its top is from its foot's axis, and above the platform's z."""
    yaw = np.arctan2(-np.sin(roll) * np.sin(pitch), np.cos(roll) + np.cos(pitch))
    turns = Rotation.from_euler("XYZ", np.stack([roll, pitch, yaw], axis=-1)).as_matrix()
    tops = 0.25 * turns @ OUT
    tops[:, 0] += 0.125 * (turns[:, 0, 0] - turns[:, 1, 1])[:, None]
    tops[:, 1] -= 0.25 * turns[:, 1, 0][:, None]
    aside = tops[:, 1] * OUT[0] - tops[:, 0] * OUT[1]
    assert np.abs(aside).max() < 1e-14  # in their planes
    flat = ((tops - 0.4 * OUT)[:, :2] * OUT[:2]).sum(axis=1).T
    return np.asarray(flat), np.asarray(tops[:, 2].T)


def heights(roll: np.ndarray, pitch: np.ndarray) -> np.ndarray:
    """How much of z keeps all legs' lengths, the platform being above (n,)."""
    flat, up = legs(roll, pitch)
    low = (np.sqrt(LOW**2 - flat**2) - up).max(axis=0)
    high = (np.sqrt(HIGH**2 - flat**2) - up).min(axis=0)
    return np.asarray(np.maximum(high - low, 0.0))


def integral(count: int) -> float:
    side = np.linspace(-TILT, TILT, count)
    roll, pitch = (each.ravel() for each in np.meshgrid(side, side))
    return float(heights(roll, pitch).mean() * (2.0 * TILT) ** 2 * ((count) / (count - 1)) ** 2)


def test_the_size_in_space_is_the_integral_of_what_is_left_of_z(rps: Solver) -> None:
    exact = integral(1501)
    assert integral(1001) == pytest.approx(exact, rel=1e-5)
    found = parakin.workspace(rps, within=LOOK, points=61)
    assert found.attrs["kind"] == "mixed"
    assert found["over"].values.tolist() == ["platform.z", "platform.roll", "platform.pitch"]
    assert found["over_unit"].values.tolist() == ["m", "rad", "rad"]
    assert float(found["size"]) == pytest.approx(exact, rel=3e-3)
    assert abs(float(found["size"]) - exact) < float(found["size_uncertainty"])
    assert np.isnan(float(found["radius"]))


def test_the_area_of_a_slice_and_its_boundary(rps: Solver) -> None:
    found = parakin.workspace(rps, {"platform.pitch": 0.05}, over=["platform.z", "platform.roll"])
    roll = np.linspace(-TILT, TILT, 200_001)
    exact = float(heights(roll, np.full_like(roll, 0.05)).mean()) * 2.0 * TILT
    assert float(found["size"]) == pytest.approx(exact, rel=2e-4)
    z, roll = found["boundary"].values.reshape(-1, 2).T
    flat, up = legs(roll, np.full_like(roll, 0.05))
    lengths = np.hypot(flat, z + up)
    words = found["stop"].values[found["boundary_stopped_by"].values.ravel()]
    for leg, word in zip(lengths.T, words, strict=True):
        name, _, end, _ = word.split()
        assert leg[int(name[1]) - 1] == pytest.approx(float(end), abs=1e-9)


def test_the_largest_box_has_the_proportions_of_the_extents(rps: Solver) -> None:
    over = ["platform.z", "platform.roll"]
    found = parakin.workspace(rps, over=over)
    extents = np.diff(found["extent"].values, axis=1)[:, 0]
    half = found["half_width"].values
    assert half[0] / half[1] == pytest.approx(extents[0] / extents[1], rel=1e-12)
    corners = np.array([[i, k] for i in (-1, 1) for k in (-1, 1)]) * half
    flat, up = legs(corners[:, 1], 0.0 * half[0] * corners[:, 1])
    lengths = np.hypot(flat, 0.6 + corners[:, 0] + up)
    room = np.minimum(HIGH - lengths, lengths - LOW).min()
    assert room == pytest.approx(0.0, abs=1e-5)
    wide = parakin.workspace(rps, over=over, proportions=dict(zip(over, (0.05, 0.1), strict=True)))
    half = wide["half_width"].values
    assert half[1] / half[0] == pytest.approx(2.0, rel=1e-12)


def test_a_planar_platform_over_a_slide_and_its_turn(tmp_path: Path) -> None:
    """The 3-RPR at y = 0: each leg leaves two intervals of x, of which one is home's."""
    low, high = 0.15, 0.55
    limits = "\n".join(f"P{k} = [{low}, {high}]" for k in (1, 2, 3))
    solver = parakin.compile(limited(tmp_path, "3-rpr", limits))
    found = parakin.workspace(solver, over=["platform.x", "platform.yaw"], points=161)
    (start, end) = found["extent"].values[1]
    yaws = np.linspace(start - 0.01, end + 0.01, 4001)
    xs = np.linspace(-0.8, 0.8, 4001)
    angles = np.radians([-150.0, -30.0, 90.0])
    kept = np.ones((len(xs), len(yaws)), dtype=bool)
    for angle in angles:
        turn = angle + np.radians(30.0) + yaws
        dx = xs[:, None] + 0.15 * np.cos(turn) - 0.5 * np.cos(angle)
        length = np.hypot(dx, 0.15 * np.sin(turn) - 0.5 * np.sin(angle))
        kept &= (length >= low) & (length <= high)
    exact = kept.mean() * 1.6 * np.ptp(yaws)
    total = float(found["size"]) + float(found["islands"].sum())
    assert found.sizes["island"] == 0
    assert total == pytest.approx(exact, rel=1e-3)


def test_kinds_are_told_by_what_is_moved() -> None:
    told = {
        "agile-eye": "orientation",
        "3-rpr": "constant-orientation",
        "seat-3dof": "mixed",
        "delta": "constant-orientation",
    }
    for name, kind in told.items():
        found = parakin.workspace(parakin.compile(name), points=9)
        assert found.attrs["kind"] == kind


def test_what_is_said_has_units_of_its_own(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = str(limited(tmp_path, "3-rps", LIMITS))
    look = [
        "--within",
        "platform.roll=-40 deg..40 deg",
        "--within",
        "platform.pitch=-40 deg..40 deg",
    ]
    assert main(["workspace", path, "--points", "21", *look]) == 0
    said = capsys.readouterr().out
    assert "workspace (mixed) over platform.z, platform.roll, platform.pitch" in said
    (size,) = [line for line in said.splitlines() if line.startswith("size ")]
    assert size.endswith(" m deg²")
    assert float(size.split()[1]) == pytest.approx(np.degrees(1.0) ** 2 * integral(501), rel=0.03)
    (box,) = [line for line in said.splitlines() if line.startswith("largest box")]
    assert [word for word in box.split() if word in ("mm", "deg")] == ["mm", "deg", "deg"]
    assert "largest ball" not in said
    over = ["--over", "platform.z,platform.roll", "--points", "41"]
    sides = ["--proportions", "platform.z=50 mm", "--proportions", "platform.roll=10 deg"]
    assert main(["workspace", path, *over, *sides]) == 0
    assert "m deg\n" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["-o", "space.stl"], "expected three slides to move"),
        (["--proportions", "platform.z=1 deg"], "expected a length"),
        (["--proportions", "platform.q=1"], "platform.q"),
        (["--kind", "constant-orientation"], "expected two or three to move"),
        (["--over", "platform.z,platform.roll", "--kind", "orientation"], "angles alone"),
    ],
)
def test_bad_input_is_one_message(
    options: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["workspace", "3-rps", *options]) == 2
    said = capsys.readouterr().err
    assert said.startswith("error:")
    assert words in said
    assert said.count("\n") == 1


def test_figures_have_the_unit_of_each_axis(rps: Solver) -> None:
    flat: xr.Dataset = parakin.workspace(rps, over=["platform.z", "platform.roll"], points=41)
    (axes,) = workspaces(flat).axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("z [mm]", "roll [deg]")
    assert axes.get_aspect() == "auto"
    ends = flat["extent"].values * np.array([[1e3], [np.degrees(1.0)]])
    assert axes.get_xlim()[0] < ends[0, 0] < ends[0, 1] < axes.get_xlim()[1]
    assert axes.get_ylim()[0] < ends[1, 0] < ends[1, 1] < axes.get_ylim()[1]
    figure = workspaces(parakin.workspace(rps, within=LOOK, points=17))
    labels = [figure.axes[0].get_xlabel(), figure.axes[0].get_ylabel()]
    assert labels == ["z [mm]", "roll [deg]"]
    assert sum(shares(flat).values()) == pytest.approx(1.0)


def test_shares_do_not_depend_on_the_units(rps: Solver) -> None:
    found = parakin.workspace(rps, over=["platform.z", "platform.roll"], points=41)
    scaled = found.copy(deep=True)
    scaled["boundary"] = found["boundary"] * (1e3, np.degrees(1.0))
    scaled["extent"] = (("over", "end"), found["extent"].values * [[1e3], [np.degrees(1.0)]])
    assert shares(scaled) == pytest.approx(shares(found), rel=1e-12)


def test_mixed_coordinates_need_both() -> None:
    with pytest.raises(InputError, match="at least one slide and one angle"):
        parakin.workspace(
            parakin.compile("agile-eye"), over=["platform.roll", "platform.yaw"], kind="mixed"
        )
