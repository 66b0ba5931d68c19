"""Fixtures: commands run in a folder of their own, and one result to compare with."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
import xarray as xr

import parakin
from parakin.cli.main import main

Parakin = Callable[..., tuple[int, str, str]]


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.delenv("FORCE_COLOR", raising=False)
    monkeypatch.setenv("COLUMNS", "80")
    return tmp_path


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Parakin:
    """Runs a command in this process: exit code, stdout, stderr."""

    def command(*arguments: str) -> tuple[int, str, str]:
        capsys.readouterr()
        code = main(arguments)
        return (code, *capsys.readouterr())

    return command


@pytest.fixture(scope="module")
def solver() -> parakin.Solver:
    return parakin.compile("flight-simulator")


@pytest.fixture(scope="module")
def general(solver: parakin.Solver) -> xr.Dataset:
    return solver.solve("general", bodies=True)
