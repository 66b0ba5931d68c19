"""Results on their way to a file: windows, progress, interrupts."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from parakin.files import datasets

SOLVE = ("solve", "flight-simulator", "general")

Parakin = Callable[..., tuple[int, str, str]]


def test_a_long_motion_is_written_in_windows_and_drawn(run: Parakin) -> None:
    code, _, err = run(*SOLVE, "--rate", "40000", "-o", "long.nc", "--plot", "long.png")
    assert code == 0
    assert "120,001 samples solved" in err
    with xr.open_dataset("long.nc") as ds:
        assert ds.sizes["time"] == 120_001
        np.testing.assert_allclose(np.diff(ds["time"]), 1 / 40000, rtol=1e-9)
        assert int(ds["status"].max()) == 0


def test_a_progress_bar_comes_only_when_it_takes_long(
    run: Parakin, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm-256color")
    assert "solving" not in run(*SOLVE, "--rate", "10")[2]
    monkeypatch.setattr("parakin.cli.run._PATIENCE", -1.0)
    assert "solving" in run(*SOLVE, "--rate", "10")[2]
    monkeypatch.delenv("FORCE_COLOR")
    assert "solving" not in run(*SOLVE, "--rate", "10")[2]


def test_an_interrupt_leaves_no_file(
    run: Parakin, here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(windows: Iterator[xr.Dataset], stream: io.TextIOBase) -> None:
        stream.write("time,")
        next(windows)
        raise KeyboardInterrupt

    monkeypatch.setattr(datasets, "write_csv", interrupted)
    code, out, err = run(*SOLVE, "--rate", "10", "-o", "stopped.csv")
    assert (code, out, err) == (130, "", "stopped\n")
    assert not list(here.iterdir())
