"""Forces over time: laws, CSV files beside the mechanism's, and what is refused."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import parakin
from parakin import InputError

TEXT = """
name = "block"
driven = ["S"]
gravity = 0
bodies.block = { mass = 2 }
joints.S = { kind = "prismatic", parent = "base", child = "block", actuated = true }
motions.rest = { duration = "2 s", rate = 4 }
"""
LAW = """
[forces.w]
kind = "wrench"
at = "block"
force = [0, 0, "3 N"]
law = { law = "sine", amplitude = 2, frequency = "0.25 Hz" }
"""
CSV = """
[forces.w]
kind = "wrench"
at = "block"
csv = "gust.csv"
"""
GUST = "time,fx,fy,fz [kN],mx,my,mz [N m]\n0,0,0,0,0,0,0\n1,0,0,0.01,0,0,0\n2,0,0,0,0,0,0\n"


def solver(folder: Path, more: str) -> parakin.Solver:
    (folder / "block.toml").write_text(TEXT + more)
    return parakin.compile(folder / "block.toml")


def test_a_law_multiplies_the_force(tmp_path: Path) -> None:
    ds = solver(tmp_path, LAW).solve("rest", forces=True, energies=True)
    pushed = 3 * 2 * np.sin(2 * math.pi * 0.25 * ds["time"].values)
    assert ds["effort"].values[:, 0] == pytest.approx(-pushed)


def test_a_file_gives_all_six_linearly_between_its_samples(tmp_path: Path) -> None:
    (tmp_path / "gust.csv").write_text(GUST)
    ds = solver(tmp_path, CSV).solve("rest", forces=True)
    pushed = 10 * (1 - np.abs(ds["time"].values - 1))
    assert ds["effort"].values[:, 0] == pytest.approx(-pushed)


def test_one_pose_is_told_what_acts(tmp_path: Path) -> None:
    block = solver(tmp_path, LAW)
    forces = block.at([0.0], forces=True, loads={"w": 0.5}).forces
    assert forces is not None
    assert forces.effort == pytest.approx([-1.5])
    with pytest.raises(InputError, match="'w', which changes with time"):
        block.at([0.0], forces=True)
    for wrong, said in (([1, 2, 3], "shape"), ("a lot", "numbers"), (math.nan, "not finite")):
        with pytest.raises(InputError, match=said):
            block.at([0.0], forces=True, loads={"w": wrong})


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (CSV.replace("gust.csv", "../gust.csv"), "expected a file in the folder of the mechanism"),
        (CSV.replace("gust.csv", "/etc/passwd"), "expected a file in the folder of the mechanism"),
        (CSV.replace("gust.csv", "none.csv"), "none.csv"),
        (CSV.replace("gust.csv", "short.csv"), "forces from 0 s to 1 s"),
        (CSV.replace("gust.csv", "back.csv"), "at times that increase"),
        (LAW.replace('"sine"', '"sinus"'), "forces.w.law"),
        (LAW.replace(', amplitude = 2, frequency = "0.25 Hz"', ""), "forces.w.law"),
        (LAW.replace("amplitude = 2", 'amplitude = "2 N"'), "forces.w.law.amplitude"),
        (
            LAW.replace(
                'law = "sine", amplitude = 2, frequency = "0.25 Hz"', 'law = "cosine", by = 1'
            ),
            "without a duration",
        ),
    ],
)
def test_what_is_no_history_is_refused(tmp_path: Path, more: str, said: str) -> None:
    (tmp_path / "short.csv").write_text(GUST[: GUST.index("2,0")])
    (tmp_path / "back.csv").write_text(GUST.replace("2,0", "0.5,0"))
    with pytest.raises(InputError) as refusal:
        solver(tmp_path, more).solve("rest", forces=True)
    assert said in str(refusal.value)
