"""Efforts in workspaces against the balance of forces and moments on a platform: all else has no
mass.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

import parakin
from parakin.cli.main import main
from parakin.design.strength import Efforts
from parakin.errors import InputError
from parakin.solving.solver import Solver
from parakin.views.workspace_plot import workspaces

RIG = Path(__file__).parents[2] / "examples" / "rig.toml"
MASS, MOST, G = 400.0, 2200.0, 9.80665
XZ = ["platform.x", "platform.z"]
LOOK = {"platform.x": (-0.9, 0.9), "platform.z": (0.2, 1.6)}


@cache
def rig(*, limited: bool = False, most: float | None = MOST) -> Solver:
    """The rig with all its mass in the platform, without limits of strokes and cones."""
    data = parakin.load(RIG).model_dump(exclude_unset=True)
    for body in data["bodies"]:
        if body["name"] == "platform":
            body |= {"mass": MASS, "com": (0.0, 0.0, 0.0), "inertia": (50.0, 60.0, 90.0)}
    for joint in data["joints"]:
        if joint["name"].startswith("P") and most is not None:
            joint["drive"] = {"max_effort": most}
    if not limited:
        data["limits"] = {}
    return parakin.compile(parakin.Mechanism(**data))


def circle(radius: float, degrees: list[float]) -> np.ndarray:
    angle = np.radians(degrees)
    return radius * np.array([np.cos(angle), np.sin(angle), 0.0 * angle])


BASE = circle(0.82, [-7, 7, 113, 127, 233, 247])
TOP = circle(0.61, [-51, 51, 69, 171, 189, -69])


def shares(points: np.ndarray, pitch: float = 0.0, mass: float = MASS) -> np.ndarray:
    """Pushes of the legs that hold the weight at points (n, 3), as parts of what they give (n, 6):
    their forces add up to it, and their moments about its centre to nothing.
    """
    arms = Rotation.from_euler("XYZ", [0.0, pitch, 0.0]).as_matrix() @ TOP
    legs = points[:, :, None] + arms - BASE
    along = legs / np.linalg.norm(legs, axis=1, keepdims=True)
    moments = np.cross(np.broadcast_to(arms, along.shape), along, axis=1)
    weight = np.array([0.0, 0.0, mass * G, 0.0, 0.0, 0.0])
    wrenches = np.concatenate([along, moments], axis=1)
    return np.asarray(np.linalg.solve(wrenches, weight[:, None])[:, :, 0] / MOST)


def nodes(found: Any) -> np.ndarray:
    """The points of a grid over x and z (n, 3)."""
    x, z = np.meshgrid(found["platform.x"], found["platform.z"], indexing="ij")
    return np.stack([x.ravel(), 0.0 * x.ravel(), z.ravel()], axis=-1)


def test_efforts_at_nodes_are_those_of_the_balance() -> None:
    found = parakin.workspace(rig(), over=XZ, within=LOOK, points=41)
    inside = found["inside"].values.ravel()
    expected = np.abs(shares(nodes(found)[inside])).max(axis=1)
    assert found["effort"].values.ravel()[inside] == pytest.approx(expected, rel=1e-9)
    assert np.isnan(found["effort"].values.ravel()[~inside]).all()
    assert expected.max() > 1.0  # told, but no limit
    assert found["effort"].attrs["not_known"] == ""


def test_efforts_bound_where_they_are_asked_to() -> None:
    found = parakin.workspace(rig(), over=XZ, within=LOOK, forces=True, points=61)
    points = nodes(found)
    looked = (points[:, [0, 2]] >= (-0.9, 0.2)) & (points[:, [0, 2]] <= (0.9, 1.6))
    kept = looked.all(axis=1) & (np.abs(shares(points)).max(axis=1) <= 1.0)
    assert np.array_equal(found["inside"].values.ravel(), kept)
    assert kept.sum() < 0.9 * looked.all(axis=1).sum()
    x, z = found["boundary"].values.reshape(-1, 2).T
    there = shares(np.stack([x, 0.0 * x, z], axis=-1))
    words = found["stop"].values[found["boundary_stopped_by"].values.ravel()]
    assert sum("effort" in word for word in words) > 50
    for share, word in zip(there, words, strict=True):
        if "effort" in word:
            assert np.abs(share).max() == pytest.approx(1.0, abs=1e-7)
            assert share[int(word[1]) - 1] == pytest.approx(1.0 if ">" in word else -1.0, abs=1e-6)
            assert word[2:] in (".effort > 2200 N", ".effort < -2200 N")


def test_limits_of_strokes_and_of_efforts_count_together() -> None:
    look = {"platform.x": (-0.6, 0.6), "platform.z": (0.4, 1.3)}
    solver = rig(limited=True, most=0.5 * MOST)
    both = parakin.workspace(solver, over=XZ, within=look, forces=True, points=81)
    alone = parakin.workspace(solver, over=XZ, within=look, points=81)
    held = np.abs(shares(nodes(both))).max(axis=1) <= 0.5
    strokes = alone["inside"].values.ravel()
    assert np.array_equal(both["inside"].values.ravel(), strokes & held)
    assert 0 < (strokes & held).sum() < strokes.sum()


def test_loads_and_orientations_count() -> None:
    heavy = parakin.compile(rig().mechanism.with_payload("1 kg at platform"))
    pitches = [{"platform.pitch": -0.2}, {"platform.pitch": 0.15}]
    for kind, pick in (("dexterous", np.max), ("reachable", np.min)):
        found = parakin.workspace(
            *(heavy,),
            over=XZ,
            within=LOOK,
            kind=kind,
            orientations=pitches,
            loads={"payload": 100.0},
            forces=True,
            points=31,
        )
        points = nodes(found)
        each = [np.abs(shares(points, p, MASS + 100.0)).max(axis=1) for p in (-0.2, 0.15)]
        inside = found["inside"].values.ravel()
        worst = pick(np.array(each), axis=0)
        assert (worst[inside] <= 1.0).all()
        assert found["effort"].values.ravel()[inside] == pytest.approx(worst[inside], rel=1e-9)


def test_a_pose_that_is_too_much_for_the_drives_has_none() -> None:
    found = parakin.workspace(rig(most=300.0), over=XZ, forces=True)
    assert found.attrs["stopped"] == "P1.effort > 300 N"  # at home all six push alike


def test_efforts_that_are_not_numbers_are_not_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    def unknown(_: Efforts, __: Any, ___: Any, y: np.ndarray) -> np.ndarray:
        return np.full((6, y.shape[1]), np.nan)

    monkeypatch.setattr(Efforts, "shares", unknown)
    found = parakin.workspace(rig(), over=XZ, forces=True)
    assert found.attrs["stopped"] == "efforts not known"


def test_what_is_not_known_says_why_and_is_refused() -> None:
    bare, weak = parakin.compile(RIG), rig(most=None)
    for solver, words in ((bare, "nothing that makes forces"), (weak, "no drive has a max_effort")):
        found = parakin.workspace(solver, over=XZ, within=LOOK, points=11)
        assert words in found["effort"].attrs["not_known"]
        assert np.isnan(found["effort"].values).all()
        with pytest.raises(InputError, match=words):
            parakin.workspace(solver, over=XZ, forces=True)
        with pytest.raises(InputError, match=words):
            parakin.range(solver, forces=True)
        with pytest.raises(InputError, match=f"effort, which is not known: .*{words}"):
            workspaces(found, lines="effort")
    for function in (parakin.workspace, parakin.range):
        with pytest.raises(InputError, match="cargo"):
            function(rig(), loads={"cargo": 1.0})
    unlimited = parakin.workspace(rig(), over=XZ, within=LOOK, points=11)
    with pytest.raises(InputError, match="no slide has limits"):
        workspaces(unlimited, lines="stroke_left")


def test_lines_of_effort_end_at_all_that_a_drive_gives() -> None:
    found = parakin.workspace(rig(), over=XZ, within=LOOK, points=41)
    assert float(found["effort"].max()) > 1.0
    (axes,) = workspaces(found, lines="effort").axes
    assert axes.get_title(loc="left") == "lines: effort at rest [% of max_effort]"
    assert [text.get_text() for text in axes.texts]
    assert all(0.0 < float(text.get_text()) <= 100.0 for text in axes.texts)


def test_all_labels_are_on_the_figure() -> None:
    figure = workspaces(parakin.workspace(rig(), over=XZ, within=LOOK, points=41))
    (axes,) = figure.axes
    assert axes.yaxis.label.get_window_extent().x0 >= 0.0
    assert axes.xaxis.label.get_window_extent().y0 >= 0.0


def test_payloads_are_limits_on_the_command_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    look = ["--within", "platform.x=-1 m..1 m", "--within", "platform.z=0.05 m..2 m"]
    over = ["--over", "platform.x,platform.z", "--points", "21", *look]
    path, picture = tmp_path / "grid.csv", tmp_path / "slice.png"
    files = ["-o", str(path), "--plot", str(picture), "--lines", "effort"]
    payload = ["--payload", "100 kg at platform"]
    assert main(["workspace", "gough-stewart", *over, *payload, *files]) == 0
    assert "effort > 4000 N" in capsys.readouterr().out
    assert picture.stat().st_size > 10_000
    table = pd.read_csv(path)
    assert table["effort"][table["inside"]].max() <= 1.0
    assert main(["workspace", "gough-stewart", *over]) == 0
    assert "effort" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--forces"], "nothing that makes forces"),
        (["--payload", "100 kg at platform"], "no drive has a max_effort"),
        (["--lines", "efort", "--plot", "slice.png"], "did you mean 'effort'"),
        (["--lines", "effort"], "expected --plot FILE"),
        (
            ["--lines", "stroke", "--plot", "x.png", "--over", "platform.x,platform.y,platform.z"],
            "--lines: found 3 coordinates to move; expected two",
        ),
    ],
)
def test_bad_input_is_one_message(
    options: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    over = [] if "--over" in options else ["--over", "platform.x,platform.y"]
    assert main(["workspace", str(RIG), *over, "--points", "11", *options]) == 2
    said = capsys.readouterr().err
    assert said.startswith("error:")
    assert words in said
    assert said.count("\n") == 1


def test_a_figure_of_what_is_not_known_is_not_drawn(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "slice.png"
    lines = ["--lines", "effort", "--plot", str(path)]
    over = ["--over", "platform.x,platform.y", "--points", "11"]
    assert main(["workspace", str(RIG), *over, *lines]) == 2
    assert "lines: found effort, which is not known" in capsys.readouterr().err
    assert not path.exists()
