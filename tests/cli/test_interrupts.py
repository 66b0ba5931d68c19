"""Ctrl-C: exit code 130, one word, no file, whenever it comes."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from linkage import contents

from parakin.cli.interrupts import Interrupts

pytestmark = pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="no such signals")


# What a shell starts in the background, these tests perhaps, is told to ignore Ctrl-C. It comes
# when a function is called, and not after a time: no test depends on how fast the machine is.
STOPPED = """
import importlib, os, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
module, _, name = sys.argv.pop(1).partition(":")

def stopped(*given, **more):
    os.kill(os.getpid(), signal.SIGINT)
    return kept(*given, **more)

if name == "import":
    import builtins
    kept = builtins.__import__
    def importing(asked, *more):
        if asked.split(".")[0] == module:
            builtins.__import__ = kept
            os.kill(os.getpid(), signal.SIGINT)
            try:
                for k in range(10**9):
                    pass
            except KeyboardInterrupt:
                raise ImportError("as some libraries say")
        return kept(asked, *more)
    builtins.__import__ = importing
else:
    owner = importlib.import_module(module)
    *path, last = name.split(".")
    for part in path:
        owner = getattr(owner, part)
    kept = getattr(owner, last)
    setattr(owner, last, stopped)
from parakin.cli.main import main
sys.exit(main())
"""

CASES = [
    ("parakin.cli.grammar:parser", "check linkage.toml"),
    ("numpy:import", "check linkage.toml"),
    ("rich:import", "list"),
    ("parakin.files.reading:load", "check linkage.toml"),
    ("parakin.kinematics.assembly:home_of", "check linkage.toml"),
    ("parakin.solving.modes:_sorted_out", "modes linkage.toml"),
    ("parakin.planning.ordering:plan_of", "solve linkage.toml turn -o old.csv"),
    ("parakin.kernel.backends:make_kernel", "solve linkage.toml turn -o old.csv"),
    ("parakin.files.datasets:columns", "solve linkage.toml turn -o old.csv"),
    ("parakin.files.datasets:columns", "solve linkage.toml turn -o new.parquet"),
    ("parakin.files.datasets:_append", "solve linkage.toml turn -o old.nc"),
    ("parakin.files.datasets:_DeferredFailure.write", "solve linkage.toml turn -o new.nc"),
    ("parakin.files.datasets:columns", "solve linkage.toml turn -o -"),
    ("os:open", "solve linkage.toml turn -o old.csv"),
    ("parakin.views.plots:histories", "plot linkage.toml turn -o new.pdf"),
    ("matplotlib.figure:Figure.savefig", "plot linkage.toml turn -o old.png"),
    ("parakin.views.film:_write_mp4", "film linkage.toml turn -o new.mp4"),
    ("parakin.views.film:_write_gif", "film linkage.toml turn -o new.gif"),
    ("numpy:asarray", "film linkage.toml turn -o new.mp4"),
    ("parakin.views.report:report", "report linkage.toml turn -o new.html"),
    ("parakin.views.scheme.scheme:save", "draw linkage.toml -o new.svg"),
    ("parakin.exports.c99.code:kernel", "export linkage.toml new.c"),
    ("parakin.exports.export:_write", "export linkage.toml new.c"),
    ("parakin.views.browser.content:Content.load", "view linkage.toml --port 0"),
]


@pytest.mark.parametrize(("where", "command"), CASES)
def test_it_ends_every_command_without_a_trace(
    where: str, command: str, linkage_folder: Path
) -> None:
    before = contents(linkage_folder)
    done = subprocess.run(
        [sys.executable, "-c", STOPPED, where, *command.split()],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        timeout=600,
        check=False,
    )
    assert (done.returncode, done.stderr) == (130, "stopped\n")
    assert contents(linkage_folder) == before


@pytest.fixture
def _heard() -> Any:
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def _forever() -> None:
    while True:
        pass


def _swallowing() -> None:
    with Interrupts() as interrupts:
        try:
            os.kill(os.getpid(), signal.SIGINT)
            _forever()
        except KeyboardInterrupt:
            pass
        assert interrupts.came
        _forever()


def _cleaning(cleaned: list[int]) -> None:
    with Interrupts():
        try:
            os.kill(os.getpid(), signal.SIGINT)
            _forever()
        finally:
            os.kill(os.getpid(), signal.SIGINT)
            cleaned += [sum(range(k)) for k in range(100)]


@pytest.mark.usefixtures("_heard")
def test_what_swallows_it_is_told_again() -> None:
    with pytest.raises(KeyboardInterrupt):
        _swallowing()


@pytest.mark.usefixtures("_heard")
def test_what_cleans_up_is_not_disturbed() -> None:
    cleaned: list[int] = []
    with pytest.raises(KeyboardInterrupt):
        _cleaning(cleaned)
    assert len(cleaned) == 100


@pytest.mark.usefixtures("_heard")
def test_afterwards_signals_are_as_they_were() -> None:
    alarm, hook = signal.getsignal(signal.SIGALRM), sys.unraisablehook
    with Interrupts():
        assert signal.getsignal(signal.SIGINT) is not signal.default_int_handler
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    assert (signal.getsignal(signal.SIGALRM), sys.unraisablehook) == (alarm, hook)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with Interrupts():
        assert signal.getsignal(signal.SIGINT) == signal.SIG_IGN
