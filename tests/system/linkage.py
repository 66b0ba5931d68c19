"""A four-bar linkage and a motion of it, as files to be spoilt, for tests of bad input."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

LINKAGE = """
name = "linkage"
title = "a crank, a coupler and a rocker"
driven = ["A"]

[parameters]
r = "0.2 m"
l = "500 mm"
reach = "r + l"

[guess]
A = "70 deg"

[bodies]
crank = {}
coupler = { points = { P = [0, 0, 0] } }
rocker = {}

[joints.A]
kind = "revolute"
parent = "base"
child = "crank"
actuated = true

[joints.B]
kind = "revolute"
parent = "crank"
child = "coupler"
on_parent = { at = ["r", 0, 0] }

[joints.C]
kind = "revolute"
parent = "coupler"
child = "rocker"
on_parent = { at = ["l", 0, 0] }
on_child = { at = ["0.4 m", 0, 0] }

[joints.D]
kind = "revolute"
parent = "base"
child = "rocker"
on_parent = { at = ["0.5 m", 0, 0] }

[motions.turn]
duration = "2 s"
laws = { A = { law = "poly345", by = "40 deg" } }
"""
MOTION = """
duration = "2 s"
rate = 50

[laws]
A = { law = "poly345", by = "40 deg" }
"""

Refusal = Callable[..., str]
"""Runs a command that must be refused; gives its message."""


def contents(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and not path.is_symlink()
    }


def edited(text: str, old: str, new: str) -> str:
    assert text.count(old) > 0, old
    return text.replace(old, new, 1)


ARM = """
name = "arm"
driven = ["shoulder", "slide"]
home = { shoulder = "10 deg", slide = "100 mm" }
bodies = { upper = {}, lower = {} }

[joints.shoulder]
kind = "revolute"
parent = "base"
child = "upper"

[joints.slide]
kind = "prismatic"
parent = "upper"
child = "lower"
on_parent = { at = [0.5, 0, 0] }

[motions.wave]
duration = "2 s"
laws.shoulder = { law = "poly345", by = "40 deg" }
laws.slide = { law = "sine", amplitude = "50 mm", frequency = 1 }
"""


def in_a_process(
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


def process(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Python in a process of its own, with these variables set."""
    return subprocess.run(
        [sys.executable, *arguments],
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
        env=os.environ | environment,
    )
