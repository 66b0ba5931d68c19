"""Workspaces on the command line, as tables, as surfaces and as figures."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import trimesh
import xarray as xr
from matplotlib.patches import PathPatch

import parakin
from parakin.cli.main import main
from parakin.errors import InputError
from parakin.views.workspace_plot import workspaces
from parakin.views.workspace_shares import shares

ROOT = Path(__file__).parents[2]
RIG = str(ROOT / "examples" / "rig.toml")
SLICE = ["--over", "platform.x,platform.y", "--points", "41"]


@cache
def rig_slice() -> xr.Dataset:
    return parakin.workspace(parakin.compile(RIG), over=["platform.x", "platform.y"], points=41)


def test_the_rig_is_answered_in_one_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["workspace", RIG, "--over", "platform.x,platform.y"]) == 0
    said = capsys.readouterr().out
    assert "area 0.347068 ± 0.000012 m²" in said
    assert "platform.x [mm]  -375.5  +329.6" in said
    assert "islands, which are not connected to the pose: none" in said
    assert "largest square about the pose: ±" in said


def test_a_box_is_called_what_it_is(capsys: pytest.CaptureFixture[str]) -> None:
    other = ["--proportions", "platform.x=2", "--proportions", "platform.y=1"]
    over = ["--over", "platform.x,platform.y", "--points", "21"]
    assert main(["workspace", RIG, *over, *other]) == 0
    assert "largest rectangle about the pose: ±" in capsys.readouterr().out
    assert main(["workspace", RIG, "--points", "9"]) == 0
    assert "largest cube about the pose: ±" in capsys.readouterr().out


def test_a_grid_is_written_as_a_table(tmp_path: Path) -> None:
    path = tmp_path / "grid.csv"
    assert main(["workspace", RIG, *SLICE, "-o", str(path)]) == 0
    table, found = pd.read_csv(path, keep_default_na=False), rig_slice()
    assert len(table) == found["inside"].size
    assert np.array_equal(table["inside"].to_numpy(), found["inside"].values.ravel())
    words = found["stop"].values[found["stopped_by"].values.ravel()]
    assert np.array_equal(table["stopped_by"].to_numpy(), words)


def test_a_dataset_is_written_whole(tmp_path: Path) -> None:
    path = tmp_path / "grid.nc"
    assert main(["workspace", RIG, *SLICE, "-o", str(path)]) == 0
    with xr.open_dataset(path, engine="h5netcdf") as read:
        assert float(read["size"]) == float(rig_slice()["size"])
        assert read.sizes == rig_slice().sizes


@pytest.mark.parametrize("mechanism", [RIG, "delta"])
def test_a_surface_is_closed_and_holds_the_volume(tmp_path: Path, mechanism: str) -> None:
    path = tmp_path / "surface.stl"
    assert main(["workspace", mechanism, "--points", "31", "-o", str(path)]) == 0
    mesh: Any = trimesh.load(path)
    found = parakin.workspace(parakin.compile(mechanism), points=31)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(1e9 * float(found["size"]), rel=1e-5)


def test_the_boundary_is_shared_out() -> None:
    found = shares(rig_slice())
    assert sum(found.values()) == pytest.approx(1.0)
    assert set(found) == {f"P{k} > 1.26 m" for k in range(1, 7)}


def test_a_slice_is_drawn_as_it_is() -> None:
    figure = workspaces(rig_slice())
    (outline,) = [p for p in figure.axes[0].patches if isinstance(p, PathPatch)]
    (polygon,) = outline.get_path().to_polygons()
    x, y = np.asarray(polygon).T
    area = 0.5 * float((x[:-1] * y[1:] - x[1:] * y[:-1]).sum())
    assert area == pytest.approx(1e6 * float(rig_slice()["size"]), rel=1e-9)


@pytest.mark.parametrize("over", ["platform.x,platform.z", "platform.x,platform.y,platform.z"])
@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_figures_are_written(tmp_path: Path, over: str, suffix: str) -> None:
    path = tmp_path / f"space.{suffix}"
    options = ["--over", over, "--points", "17", "--plot", str(path)]
    assert main(["workspace", RIG, *options]) == 0
    assert path.stat().st_size > 10_000


def test_all_kinds_can_be_asked_for(capsys: pytest.CaptureFixture[str]) -> None:
    turns = "platform.roll=-5 deg; platform.roll=5 deg, platform.pitch=3 deg"
    for kind in ("reachable", "dexterous"):
        assert main(["workspace", RIG, *SLICE, "--kind", kind, "--orientations", turns]) == 0
    options = ["--kind", "orientation", "--points", "17", "--from", "platform.z=850 mm"]
    assert main(["workspace", RIG, *options]) == 0
    said = capsys.readouterr().out
    assert "(reachable)" in said
    assert "deg³" in said
    assert "platform.z = 850.000 mm" in said


def test_what_goes_on_is_said(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["workspace", "3-rpr", "--points", "21"]) == 0
    assert "it goes on beyond what was looked at" in capsys.readouterr().out


def test_a_pose_beyond_a_limit_has_none(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "none.csv"
    options = ["--from", "platform.z=1.3 m", "-o", str(path)]
    assert main(["workspace", RIG, *SLICE, *options]) == 1
    assert "no workspace from there" in capsys.readouterr().out
    assert not path.exists()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--over", "platform.x"], "over"),
        (["--kind", "dextrous"], "kind"),
        (["--kind", "dexterous"], "orientations"),
        (["--kind", "dexterous", "--orientations", "platform.roll"], "NAME=VALUE"),
        (["--kind", "dexterous", "--orientations", " ; "], "orientations"),
        (["--within", "platform.x=1"], "LOW..HIGH"),
        (["--within", "platform.q=-1..1"], "platform.q"),
        (["--within", "platform.x=-1 deg..1 m"], "--within platform.x"),
        (["--proportions", "platform.x=1 m"], "--proportions"),
        (["--from", "P1=1"], "not driven"),
        (["--points", "3"], "points"),
        (["--least-conditioning", "2"], "least_conditioning"),
        (["-o", "grid.txt"], "suffix"),
        (["-o", "slice.stl", "--over", "platform.x,platform.y"], "three slides"),
        (["-o", "turns.stl", "--kind", "orientation"], "three slides"),
        (["--plot", "plot.txt"], "suffix"),
    ],
)
def test_bad_input_is_one_message(
    options: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["workspace", RIG, *options]) == 2
    said = capsys.readouterr().err
    assert said.startswith("error:")
    assert words in said
    assert said.count("\n") == 1


def test_there_is_nothing_to_draw_of_no_workspace() -> None:
    found = parakin.workspace(parakin.compile(RIG), {"platform.z": 1.3})
    with pytest.raises(InputError, match=r"1\.26 m"):
        workspaces(found)
    with pytest.raises(InputError, match="stroke_left"):
        workspaces(rig_slice(), lines="residual")
