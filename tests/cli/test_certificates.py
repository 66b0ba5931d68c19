"""`parakin certify`: what is told, written and refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from parakin.cli.main import main

RIG = str(Path(__file__).parents[2] / "examples" / "rig.toml")
CUBE = ["--within", "platform.x=-50 mm..50 mm", "--within", "platform.z=850 mm..940 mm"]


def test_a_box_is_proved_and_told(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    table, kept = tmp_path / "box.csv", tmp_path / "box.nc"
    for path in (table, kept):
        assert main(["certify", RIG, *CUBE, "-o", str(path)]) == 0
        out, err = capsys.readouterr()
        assert "platform.x = -50.000 to 50.000 mm, platform.y = 0.000 mm" in out
        assert "proved: every pose of it keeps all that is asked" in out
        assert str(path.name) in err
    row = next(line for line in out.splitlines() if line.startswith("P1 [mm]"))
    found = pd.read_csv(table).set_index("coordinate").loc["P1"]
    low, high = (float(word) for word in row.split()[2:4])
    assert low <= 1e3 * found["low"] < low + 1e-3
    assert high - 1e-3 < 1e3 * found["high"] <= high
    with xr.open_dataset(kept) as same:
        assert same.attrs["outcome"] == "proved"
        assert float(same["high"].sel(coordinate="P1")) == found["high"]


def test_what_refutes_it_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["certify", RIG, "--within", "platform.z=850 mm..1.2 m"]) == 1
    out = capsys.readouterr().out
    assert "refuted: P1 > 1.26 m at platform.x = 0.000 mm" in out
    assert "at least" not in out
    assert main(["certify", RIG, *CUBE, "--velocity", "platform.z=0.9 m/s"]) == 1
    assert "refuted: P1.velocity > 0.6 m/s" in capsys.readouterr().out
    assert main(["certify", RIG, *CUBE, "--velocity", "platform.z=0.3 m/s"]) == 0


def test_what_is_not_decided_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    turn = ["--within", "platform.pitch=-8 deg..8 deg"]
    assert main(["certify", RIG, *CUBE, *turn, "--boxes", "3"]) == 1
    out = capsys.readouterr().out
    assert "undecided: " in out
    assert "is not excluded near platform.x" in out


def test_from_another_pose(capsys: pytest.CaptureFixture[str]) -> None:
    within = ["--within", "platform.x=-10 mm..10 mm"]
    assert main(["certify", RIG, *within, "--from", "platform.pitch=10 deg"]) == 0
    assert "platform.pitch = 10.000 deg" in capsys.readouterr().out


def test_no_limits_no_table(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["certify", "3-rpr", "--within", "platform.yaw=-10 deg..10 deg"]) == 0
    out = capsys.readouterr().out
    assert "proved" in out
    assert "limit from" not in out


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ([], "within: found no coordinate"),
        (["--within", "platform.x=1"], "--within: found '1'; expected LOW..HIGH"),
        (["--within", "platform.x=1 deg..2 deg"], "found '1 deg', an angle; expected a length"),
        (["--within", "platform.q=1..2"], "did you mean 'platform.z'?"),
        (["--within", "P1=0.9..1.1"], "found 'P1', which is not driven"),
        (["--within", "platform.x=0..0.1", "--velocity", "platform.x=1 m"], "expected a"),
        (["--within", "platform.x=0..0.1", "--boxes", "0"], "boxes: found 0"),
        (["--within", "platform.x=0..0.1", "-o", "box.stl"], "box.stl"),
    ],
)
def test_what_cannot_be_meant_is_refused(
    options: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["certify", RIG, *options]) == 2
    err = capsys.readouterr().err
    assert message in err
    assert err.count("\n") == 1


def test_nan_is_no_share(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["certify", RIG, "--within", "platform.x=nan..0.1"]) == 2
    assert np.char.find(capsys.readouterr().err, "nan") >= 0
