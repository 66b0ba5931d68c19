"""Standard output and standard error: what goes where, and when one takes no more."""

from __future__ import annotations

import io
import os
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import pytest
from linkage import ARM, contents, in_a_process, process
from rich.console import Console

from parakin.cli import streams


@pytest.fixture(autouse=True)
def _here(linkage_folder: Path) -> None:
    """Every test runs in the folder."""


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
    code, err = in_a_process(*arguments, stdout=f"{linkage_folder.parent}/stdout")
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
    code, err = in_a_process(*arguments, stdout="/dev/full")
    assert code == 2
    assert err == (
        "error: standard output: found no space left on device; expected a stream that accepts "
        "all output\n"
    )


SOLVE = ("solve", "flight-simulator", "general")

Parakin = Callable[..., tuple[int, str, str]]


def test_square_brackets_in_a_title_are_shown_as_they_are(run: Parakin) -> None:
    Path("arm.toml").write_text(ARM.replace('name = "arm"', 'name = "arm"\ntitle = "[/b] [red]x"'))
    assert run("solve", "arm.toml", "wave")[2].startswith("arm, wave: [/b] [red]x\n")
    assert run("check", "arm.toml")[1].startswith("arm: [/b] [red]x\n")


def test_colours_are_obeyed_and_refused(run: Parakin, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm-256color")
    assert "\x1b[1;31merror" in run("check", "nothing")[2]
    assert "\x1b[" in run("check", "flight-simulator-upu")[1]
    monkeypatch.setenv("NO_COLOR", "1")
    assert "\x1b[" not in run("check", "nothing")[2]
    assert "\x1b[" not in run("check", "flight-simulator-upu")[1]
    assert "\x1b[" not in run("list")[1]
    assert "\x1b[" not in run(*SOLVE, "--rate", "10")[2]


def test_letters_that_the_terminal_lacks_are_spelt_out() -> None:
    done = process("-m", "parakin", "check", "flight-simulator", PYTHONIOENCODING="ascii")
    assert (done.returncode, done.stderr) == (0, "")
    assert r"Gr\xfcbler-Kutzbach: -3" in done.stdout


def test_a_reader_that_leaves_early_is_no_mistake() -> None:
    command = f"{sys.executable} -m parakin solve flight-simulator general -o - | head -n 1"
    done = subprocess.run(
        ["bash", "-c", f"set -o pipefail; {command}"],
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
        env={k: v for k, v in os.environ.items() if k != "PYTHONUNBUFFERED"},
    )
    assert done.returncode == 0
    assert done.stdout.startswith("time,A1.position,")
    assert done.stdout.count("\n") == 1
    assert done.stderr == ""


COMMANDS = [
    ("solve linkage.toml motion.toml", 0),
    ("solve linkage.toml motion.toml -o x.csv --singularities", 0),
    ("report linkage.toml motion.toml -o x.html", 0),
    ("plot linkage.toml motion.toml -o x.png", 0),
    ("film linkage.toml motion.toml -o x.mp4", 0),
    ("check linkage.toml", 1),
    ("check nothing", 2),
    ("view nothing", 2),
    ("nothing", 2),
]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="the system has no /dev/full")
@pytest.mark.parametrize("stderr", ["2>/dev/full", "2>&-", "0<&- 2>&-", "0<&- >&- 2>&-"])
@pytest.mark.parametrize(("command", "expected"), COMMANDS)
def test_a_stderr_that_takes_nothing_changes_no_exit_code(
    command: str, expected: int, stderr: str, linkage_folder: Path
) -> None:
    line = f"{sys.executable} -m parakin {command} {stderr}"
    done = subprocess.run(["bash", "-c", line], timeout=600, check=False, stdout=subprocess.DEVNULL)
    assert done.returncode == expected
    output = Path(command.rsplit(maxsplit=1)[-1])
    if output.name.startswith("x."):
        assert output.stat().st_size


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="the system has no /dev/full")
def test_neither_takes_anything() -> None:
    for command, expected in (("check linkage.toml", 2), ("solve linkage.toml motion.toml", 0)):
        line = f"{sys.executable} -m parakin {command} >/dev/full 2>/dev/full"
        assert subprocess.run(["bash", "-c", line], timeout=600, check=False).returncode == expected


def test_no_file_takes_the_number_of_a_closed_stream() -> None:
    told = (
        "import os\nfrom parakin.cli.main import main\nmain(['nothing'])\n"
        "assert os.open('free', os.O_CREAT) > 2"
    )
    line = f'{sys.executable} -c "{told}" 0<&- >&- 2>&-'
    assert subprocess.run(["bash", "-c", line], timeout=600, check=False).returncode == 0


@pytest.mark.parametrize("terminal", [True, False])
def test_a_long_wait_is_told_of_on_a_terminal_alone(
    terminal: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    class AtOnce(threading.Timer):
        def start(self) -> None:
            self.function()

        def join(self, timeout: float | None = None) -> None:
            pass

    written = io.StringIO()
    shown = Console(file=written, force_terminal=terminal, color_system=None)
    monkeypatch.setattr(streams, "console", lambda **_: shown)
    monkeypatch.setattr(threading, "Timer", AtOnce)
    with streams.waiting("compiling"):
        pass
    assert ("compiling" in written.getvalue()) == terminal
