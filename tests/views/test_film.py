"""Films: as many frames as the time asks for, which differ, read back by Pillow and PyAV."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import parakin
from parakin import Status
from parakin.cli.main import main
from parakin.views import film
from parakin.views.solids.drawing import Drawing, drawing_of

pytest.importorskip("matplotlib")


@pytest.fixture(scope="module")
def solver() -> parakin.Solver:
    return parakin.compile("four-bar", machine_code=False)


@pytest.fixture(scope="module")
def turn(solver: parakin.Solver) -> xr.Dataset:
    return solver.solve("turn", bodies=True)


@pytest.fixture(scope="module")
def drawing(solver: parakin.Solver) -> Drawing:
    return drawing_of(solver.graph)


def test_poses_are_those_of_a_crank(turn: xr.Dataset, drawing: Drawing) -> None:
    R, p = film.poses(drawing, turn)
    angle = turn["position"].sel(coordinate="A").values
    crank, coupler = (drawing.arrangement.graph.bodies.index(name) for name in ("crank", "coupler"))
    np.testing.assert_allclose(R[:, crank, 0, 0], np.cos(angle), atol=1e-12)
    tip = 0.04 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    np.testing.assert_allclose(p[:, coupler, :2], tip, atol=1e-12)
    assert (R[:, 0] == np.eye(3)).all()


def test_an_mp4_is_read_back(turn: xr.Dataset, drawing: Drawing, tmp_path: Path) -> None:
    av = pytest.importorskip("av")
    film.save(drawing, turn, tmp_path / "turn.mp4", title="a turn")
    with av.open(str(tmp_path / "turn.mp4")) as box:
        (stream,) = box.streams.video
        assert (stream.codec_context.name, stream.pix_fmt) == ("h264", "yuv420p")
        assert stream.average_rate == 25
        assert stream.width % 2 == stream.height % 2 == 0
        frames = [frame.to_ndarray(format="rgb24") for frame in box.decode(stream)]
    assert len(frames) == 26  # one second, both ends shown
    assert np.abs(frames[0].astype(int) - frames[12]).max() > 100


def test_a_gif_is_read_back_by_the_command_line(tmp_path: Path) -> None:
    pillow = pytest.importorskip("PIL.Image")
    path = tmp_path / "turn.gif"
    assert main(["solve", "four-bar", "turn", "--animate", str(path)]) == 0
    with pillow.open(path) as image:
        total = 0
        for k in range(image.n_frames):
            image.seek(k)
            total += image.info["duration"]
    assert total == 26 * 40


def test_a_long_motion_is_shown_faster(turn: xr.Dataset) -> None:
    long = turn.assign_coords(time=turn["time"] * 60.0)
    timing = film.timing(long)
    assert timing.speed == pytest.approx(3.0)
    assert len(timing.samples) == 20 * 25 + 1


def test_the_film_ends_where_the_poses_do(turn: xr.Dataset, drawing: Drawing) -> None:
    half = int(np.searchsorted(turn["time"].values, 0.4))
    cut = turn.copy(deep=True)
    cut["body_position"][half + 1 :] = np.nan
    cut["body_orientation"][half + 1 :] = np.nan
    cut["status"][half + 1 :] = Status.OUT_OF_REACH
    timing = film.timing(cut)
    assert timing.ended == f"ends at 0.4 s: {Status.OUT_OF_REACH.words}"
    assert timing.samples.max() == half
    assert len(timing.samples) == 11 + 25
    assert all(np.isfinite(image).all() for image in film.images(drawing, cut))
    cut["body_position"][:] = np.nan
    with pytest.raises(parakin.ParakinError, match="no sample with a pose"):
        film.timing(cut)


def test_a_wrong_suffix_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["solve", "four-bar", "turn", "--animate", str(tmp_path / "a.avi")]) == 2
    assert "found the suffix '.avi'; expected one of: .gif, .mp4" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "module", "library"), [("a.mp4", "av", "PyAV"), ("a.gif", "PIL", "Pillow")]
)
def test_a_missing_package_is_named(
    name: str, module: str, library: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda wanted: None if wanted == module else found(wanted)
    )
    with pytest.raises(parakin.InputError, match=rf"{name}.*{library} is not installed.*\[video\]"):
        film.check_film(Path(name))


def test_a_film_does_not_take_the_place_of_what_is_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recorded = tmp_path / "recorded.mp4"  # whatever its name says
    recorded.write_text("time [s],A [deg]\n0,10\n1,20\n", "utf-8")
    assert main(["solve", "four-bar", str(recorded), "--animate", str(recorded)]) == 2
    assert "a file that the command reads" in capsys.readouterr().err
    assert recorded.read_text("utf-8").startswith("time")


def test_bodies_of_the_film_do_not_get_into_the_table(tmp_path: Path) -> None:
    table, path = tmp_path / "turn.csv", tmp_path / "turn.gif"
    assert main(["solve", "four-bar", "turn", "-o", str(table), "--animate", str(path)]) == 0
    assert "crank" not in table.read_text().splitlines()[0]
