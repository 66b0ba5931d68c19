"""`parakin range`: tables, files, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from parakin.cli.main import main

RIG = str(Path(__file__).parents[2] / "examples" / "rig.toml")


def test_the_rig_is_told_in_millimetres_and_degrees(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["range", RIG, "--frequency", "0.5 Hz"]) == 0
    out = capsys.readouterr().out
    x = next(line for line in out.splitlines() if line.startswith("platform.x [mm]"))
    assert x.split()[2:8] == ["-375.542", "P1", ">", "1.26", "m", "+329.630"]
    assert "±" not in out
    assert "sine at 0.5 Hz" in out
    assert "platform.z = 893.716 mm" in out
    assert "-71.6 deg/s" in out


def test_ranges_are_counted_from_elsewhere(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["range", RIG, "--with", "platform.pitch=10 deg"]) == 0
    first = capsys.readouterr().out
    assert "-186.994" in first
    assert "+126.225" in first
    assert main(["range", RIG, "--from", "platform.pitch=10 deg"]) == 0
    assert capsys.readouterr().out == first


def test_what_stops_the_way_there_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["range", RIG, "--with", "platform.pitch=40 deg"]) == 1
    assert "57.03 % of the way P4 > 1.26 m stops it" in capsys.readouterr().out
    assert main(["range", RIG, "--from", "platform.x=1 m"]) == 1
    assert "no range from there: P" in capsys.readouterr().out


def test_forces_and_payloads_count(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["range", "gough-stewart", "--payload", "200 kg at platform"]) == 0
    out = capsys.readouterr().out
    assert "effort > 4000 N" in out
    assert "acceleration down" in out
    assert "force or moment down" in out


def test_any_mechanism_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["range", "slider-crank"]) == 0
    assert "free  nothing" in capsys.readouterr().out
    assert main(["range", "gough-stewart", "--driven", "P1, P2,P3,P4,P5,P6"]) == 0
    assert "P1 [mm]" in capsys.readouterr().out


def test_files_are_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("range.csv", "range.nc", "range.svg"):
        option = "--plot" if name.endswith("svg") else "-o"
        assert main(["range", RIG, "--pairs", option, str(tmp_path / name)]) == 0
        assert name in capsys.readouterr().err
    table = pd.read_csv(tmp_path / "range.csv")
    alone = table[table["with"].isna()]
    assert len(alone) == 12
    assert len(table) == 12 + 15 * 72
    with xr.open_dataset(tmp_path / "range.nc") as kept:
        travel = kept["travel"].values
    assert travel.ravel() == pytest.approx(alone["travel"].values, abs=1e-15)
    assert np.isfinite(travel).all()
    assert "P4 &gt; 1.26 m" in (tmp_path / "range.svg").read_text("utf-8")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--from", "platfrm.x=1 m"], "did you mean 'platform.x'?"),
        (["--from", "U1.1=1 deg"], "--from: found 'U1.1', which is not driven"),
        (["--with", "platform.x=1 deg"], "found '1 deg', an angle; expected a length"),
        (["--with", "platform.x"], "expected NAME=VALUE"),
        (["--frequency", "5 m"], "found '5 m', a length; expected a frequency"),
        (["--frequency", "0 Hz"], "frequency: found 0.0"),
        (["--least-conditioning", "2"], "expected a number between 0 and 1"),
        (["--driven", "P1"], "mobility is 6"),
        (["--forces"], "nothing that makes forces"),
        (["--plot", "range.bmp"], "found the suffix '.bmp'"),
        (["-o", "range.txt"], "found the suffix '.txt'"),
        (["-o", RIG + ".nowhere/range.csv"], "a file that can be written"),
    ],
)
def test_bad_input_is_one_message(
    options: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["range", RIG, *options]) == 2
    err = capsys.readouterr().err
    assert message in err
    assert err.startswith("error: ")
    assert err.count("\n") == 1


@pytest.mark.parametrize("names", ["", ",", "platform.x,"])
def test_names_that_are_missing_are_told(names: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["range", RIG, "--driven", names]) == 2
    assert "names separated by commas" in capsys.readouterr().err


def test_a_figure_that_is_not_drawn_is_told(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    picture = tmp_path / "range.png"
    with_ = ["--with", "platform.pitch=40 deg", "--plot", str(picture)]
    assert main(["range", RIG, *with_]) == 1
    assert f"{picture.name} was not written" in capsys.readouterr().err.replace("\n", "")
    assert not picture.exists()
