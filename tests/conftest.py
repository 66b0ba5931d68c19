"""Fixtures: solvers in machine code and on NumPy arrays, and a folder of files to be spoilt."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest
import xarray as xr
from hypothesis import settings
from linkage import LINKAGE, MOTION, Refusal, contents

import parakin
from parakin.cli.main import main
from parakin.kernel.backends import has_machine_code

Parakin = Callable[..., tuple[int, str, str]]

# What is tested is compiled anew, and the user's cache left alone; in processes of tests, too.
os.environ["PARAKIN_CACHE"] = "off"

# The same examples in every run, so that what fails is what was changed; others on request.
settings.register_profile("same", derandomize=True)
settings.register_profile("random", derandomize=False)
settings.load_profile("same")

READINGS = [
    pytest.param(
        True,
        id="machine-code",
        marks=pytest.mark.skipif(not has_machine_code(), reason="heyoka is not installed"),
    ),
    pytest.param(False, id="arrays"),
]


@pytest.fixture(scope="session", params=READINGS)
def reading(request: pytest.FixtureRequest) -> bool:
    """Whether machine code is used."""
    return bool(request.param)


@pytest.fixture(scope="session")
def compiled(reading: bool) -> Callable[..., parakin.Solver]:
    """The flight simulator, compiled once per choice of driven coordinates."""
    kept: dict[tuple[str, ...], parakin.Solver] = {}

    def solver(*driven: str) -> parakin.Solver:
        if driven not in kept:
            kept[driven] = parakin.compile(
                "flight-simulator", driven or None, coordinates="all", machine_code=reading
            )
        return kept[driven]

    return solver


@pytest.fixture
def linkage_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a good mechanism, a good motion and old results."""
    monkeypatch.chdir(tmp_path)
    Path("linkage.toml").write_text(LINKAGE)
    Path("motion.toml").write_text(MOTION)
    for name in ("old.csv", "old.nc", "old.parquet", "old.png"):
        Path(name).write_text("old")
    return tmp_path


@pytest.fixture
def refusal(linkage_folder: Path, capsys: pytest.CaptureFixture[str]) -> Refusal:
    """Runs a command that must be refused; gives its message."""

    def run(*arguments: str) -> str:
        before = contents(linkage_folder)
        capsys.readouterr()
        code = main(arguments)
        out, err = capsys.readouterr()
        assert (code, out) == (2, "")
        assert err.startswith("error: ")
        assert err.count("\n") == 1
        assert err.endswith("\n")
        assert contents(linkage_folder) == before
        return err.removeprefix("error: ").rstrip("\n")

    return run


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder to run commands in, without colours and 80 columns wide."""
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
