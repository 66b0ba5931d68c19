"""Standard output that is full, and errors in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from linkage import contents


@pytest.fixture(autouse=True)
def _here(linkage_folder: Path) -> None:
    """Every test runs in the folder."""


def run(
    *arguments: str, start: tuple[str, ...] = ("-m", "parakin"), stdout: str = os.devnull
) -> tuple[int, str]:
    """parakin in a process of its own: exit code and what it says on stderr."""
    with open(stdout, "w") as target:
        done = subprocess.run(
            [sys.executable, *start, *arguments],
            stdout=target,
            stderr=subprocess.PIPE,
            text=True,
            env={k: v for k, v in os.environ.items() if k != "PYTHONUNBUFFERED"},
            timeout=600,
            check=False,
        )
    return done.returncode, done.stderr


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["check", "flight-simulatr"], "did you mean 'flight-simulator'?"),
        (["check", "linkage.toml", "--set", "r=l.__class__"], "it is more than arithmetic"),
        (["chek"], "did you mean 'check'?"),
        (
            ["solve", "linkage.toml", "motion.toml", "-o", "nowhere/x.csv"],
            "nowhere/x.csv: found no",
        ),
    ],
)
def test_a_process_says_one_thing_and_exits_with_2(
    arguments: list[str], said: str, linkage_folder: Path
) -> None:
    before = contents(linkage_folder)
    code, err = run(*arguments, stdout=f"{linkage_folder.parent}/stdout")
    assert code == 2
    assert Path(f"{linkage_folder.parent}/stdout").read_text() == ""
    assert err.startswith("error: ")
    assert said in err
    assert err.count("\n") == 1
    assert contents(linkage_folder) == before


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="the system has no /dev/full")
@pytest.mark.parametrize(
    "arguments",
    [
        ["solve", "flight-simulator", "general", "-o", "-"],
        ["check", "linkage.toml"],
        ["list"],
        ["--help"],
    ],
)
def test_a_standard_output_that_takes_no_more(arguments: list[str]) -> None:
    code, err = run(*arguments, stdout="/dev/full")
    assert code == 2
    assert err == (
        "error: standard output: found no space left on device; expected a stream that accepts "
        "all output\n"
    )
