"""A rig with a cone limit at two joints, strokes at another, a speed and an acceleration: whatever
looks at its limits stops at the same sample and names the same joint.
"""

from __future__ import annotations

import ctypes
import math
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from scipy.spatial.transform import Rotation

import parakin
from parakin import Status
from parakin.cli.main import main
from parakin.solving.results import stop_words
from parakin.views.browser.drive import Drive
from parakin.views.browser.playback import playback_of
from parakin.views.film import timing

COMPILER = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
FILE = """\
name = "rig"
variant_of = "gough-stewart"
[limits]
P4 = ["0.2 m", "0.5 m"]
S2.cone = [0, "9 deg"]
U3.cone = [0, "8 deg"]
P1.velocity = ["-0.5 m/s", "0.4 m/s"]
P6.acceleration = [-inf, "1.5 m/s^2"]
[motions.aside]
duration = "2 s"
laws = { platform.x = { law = "poly345", by = "0.3 m" } }
[motions.far]
duration = "2 s"
laws = { platform.x = { law = "poly345", by = "3 m" } }
"""


@dataclass(frozen=True)
class Rig:
    path: Path
    solver: parakin.Solver
    everything: parakin.Solver


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Rig:
    path = tmp_path_factory.mktemp("rig") / "rig.toml"
    path.write_text(FILE, "utf-8")
    return Rig(path, parakin.compile(path), parakin.compile(path, coordinates="all"))


def angle(directions: np.ndarray) -> np.ndarray:
    """Between directions (n, 3) and the first."""
    across = np.linalg.norm(np.cross(directions, directions[0]), axis=1)
    return np.asarray(np.arctan2(across, directions @ directions[0]))


def margins(rig: Rig, motion: str) -> dict[str, np.ndarray]:
    """How far beyond each limit the samples of a motion from home are, from the bodies' poses."""
    ds, graph = rig.solver.solve(motion, bodies=True), rig.solver.graph
    time, body = ds["time"].values, ds["body"].values.tolist()
    R = {
        b: Rotation.from_quat(ds["body_orientation"].values[:, body.index(b)], scalar_first=True)
        for b in ("platform", "piston2", "cylinder3")
    }
    centre = ds["body_position"].values[:, body.index("platform")]
    joints = {joint.name: joint for joint in graph.joints}

    def length(k: int) -> np.ndarray:
        top = np.array(joints[f"S{k}"].M.p, dtype=float)
        foot = np.array(joints[f"U{k}"].F.p, dtype=float)
        return np.asarray(np.linalg.norm(centre + R["platform"].apply(top) - foot, axis=1) - 1.0)

    def rate(values: np.ndarray) -> np.ndarray:
        return np.asarray(np.gradient(values, time, edge_order=2))

    pin = np.array(joints["U3"].F.R, dtype=float)[:, 2]
    normal = np.cross(pin, R["cylinder3"].apply([0, 0, 1])[0])
    tilted = R["cylinder3"].apply(R["cylinder3"][0].inv().apply(normal / np.linalg.norm(normal)))
    leg = R["platform"].inv().apply(R["piston2"].apply([0, 0, 1]))
    speed, acceleration = rate(length(1)), rate(rate(length(6)))
    return {
        "P4": np.maximum(0.2 - length(4), length(4) - 0.5),
        "S2.cone": angle(leg) - math.radians(9),
        "U3.cone": angle(tilted) - math.radians(8),
        "P1.velocity": np.maximum(-0.5 - speed, speed - 0.4),
        "P6.acceleration": acceleration - 1.5,
    }


@pytest.mark.parametrize("motion", ["tour", "heave", "aside", "far"])
def test_flags_are_those_of_an_independent_look(rig: Rig, motion: str) -> None:
    ds, beyond = rig.solver.solve(motion), margins(rig, motion)
    worst = np.max([*beyond.values()], axis=0)
    clear = np.abs(worst) > 1e-3  # what differences of the first and second order may be off
    clear[:3] = clear[-3:] = False
    flagged = ds["status"].values == Status.LIMIT_EXCEEDED
    np.testing.assert_array_equal(flagged[clear], (worst > 0)[clear])
    assert clear.mean() > 0.9
    names = ds["stop"].values[ds["stopped_by"].values]
    for name in {*names[flagged].tolist()}:
        assert (beyond[name][names == name] > -1e-3).all()
    for name, margin in beyond.items():  # to rounding, where it is not a difference
        here = (names == name) & ("." not in name or name.endswith("cone"))
        excess = np.abs(ds["excess"].values[here])  # which is negative below a lower limit
        assert np.abs(excess - margin[here]).max(initial=0.0) < 1e-12


@pytest.mark.parametrize("motion", ["tour", "aside", "far"])
def test_the_crossing_lies_between_the_samples(rig: Rig, motion: str) -> None:
    """It is where an independent root of the margin lies, from samples a millisecond apart."""
    ds, beyond = rig.solver.solve(motion), margins(rig, motion)
    time, names = ds["time"].values, ds["stop"].values[ds["stopped_by"].values]
    assert set(names) - {""}
    met: dict[tuple[str, bool], set[float]] = {}
    for name, excess, at in zip(names, ds["excess"].values, ds["first_at"].values, strict=True):
        if name:
            met.setdefault((str(name), bool(excess > 0)), set()).add(float(at))
    assert all(len(first) == 1 for first in met.values())  # one for each end
    for name in set(names) - {""}:
        first = min(at for (stop, _), (at,) in met.items() if stop == name)
        k = int(np.argmax(beyond[name] > 1e-12))
        if k == 0:
            assert first == time[0]
        elif "." not in name or name.endswith("cone"):
            a, b = beyond[name][k - 1 : k + 1]
            root = time[k - 1] - a * (time[k] - time[k - 1]) / (b - a)
            assert first == pytest.approx(root, abs=2e-6)  # the chord's error, h²/8 of curvature


@pytest.mark.parametrize("name", ["P4", "S2.cone", "U3.cone", "P1.velocity"])
def test_coarse_samples_find_the_same_crossing(rig: Rig, name: str) -> None:
    one = rig.solver.mechanism.model_copy(
        update={"limits": {name: rig.solver.mechanism.limits[name]}}
    )
    solver = parakin.compile(one)
    when = []
    for rate in (1000, 7):
        ds = solver.solve(solver.motion("far", rate=rate))
        when.append(min(ds["first_at"].values[ds["stopped_by"].values > 0].tolist()))
    assert when[1] == pytest.approx(when[0], abs=2e-9)


@pytest.mark.parametrize("motion", ["tour", "aside", "far"])
def test_every_path_stops_at_the_same_sample(rig: Rig, motion: str) -> None:
    ds = rig.solver.solve(motion)
    whole = rig.everything.solve(motion)
    windows = list(rig.solver.stream(motion, 333))
    names = [str(name) for name in ds["stop"].values]
    assert [str(name) for name in whole["stop"].values] == names
    for name in ("stopped_by", "status"):
        np.testing.assert_array_equal(whole[name], ds[name])
        np.testing.assert_array_equal(np.concatenate([w[name] for w in windows]), ds[name])
    for name in ("excess", "first_at"):
        parts = np.concatenate([w[name] for w in windows])
        np.testing.assert_allclose(parts, ds[name], rtol=0, atol=1e-13)
        np.testing.assert_allclose(whole[name], ds[name], rtol=0, atol=1e-8)
    assert windows[-1].attrs["stops_met"] == ds.attrs["stops_met"]
    rows = list(rig.solver.driven)
    y, yd, ydd = (
        ds[q].sel(coordinate=rows).values.T for q in ("position", "velocity", "acceleration")
    )
    batch = rig.solver.at(y, yd, ydd)
    status, stopped_by = np.array(batch.status), np.array(batch.stopped_by)
    np.testing.assert_array_equal(stopped_by, ds["stopped_by"])
    np.testing.assert_array_equal(status, ds["status"])
    np.testing.assert_allclose(batch.excess, ds["excess"], rtol=0, atol=1e-13)
    for k in range(0, len(y.T), 97):
        tick = rig.solver.at(y[:, k], yd[:, k], ydd[:, k])
        assert (tick.status, tick.stopped_by) == (status[k], stopped_by[k])
        assert tick.why() == stop_words(ds, k)


@pytest.mark.skipif(COMPILER is None, reason="no C compiler")
@pytest.mark.parametrize("motion", ["tour", "aside", "far"])
def test_the_c_code_stops_there_too(rig: Rig, motion: str, tmp_path: Path) -> None:
    assert main(["export", str(rig.path), str(tmp_path / "rig.c")]) == 0
    flags = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O1", "-fPIC", "-shared")
    made = [str(COMPILER), *flags, "rig.c", "-o", "rig.so", "-lm"]
    subprocess.run(made, cwd=tmp_path, check=True)
    count = len(rig.solver.coordinates)

    class State(ctypes.Structure):
        _fields_ = [
            *((n, ctypes.c_double * count) for n in ("q", "qd", "qdd")),
            ("residual", ctypes.c_double),
            ("conditioning", ctypes.c_double),
            ("stopped_by", ctypes.c_int),
            ("excess", ctypes.c_double),
        ]

    library, state = ctypes.CDLL(str(tmp_path / "rig.so")), State()
    library.rig_home(ctypes.byref(state))
    ds = rig.solver.solve(motion)
    orders = [
        ds[q].sel(coordinate=list(rig.solver.driven)).values
        for q in ("position", "velocity", "acceleration")
    ]
    header = (tmp_path / "rig.h").read_text()
    for k in range(0, ds.sizes["time"], 7):
        given = [(ctypes.c_double * 6)(*order[k]) for order in orders]
        status = library.rig_solve(*given, ctypes.byref(state))
        assert (status, state.stopped_by) == (ds["status"].values[k], ds["stopped_by"].values[k])
        excess = np.nan_to_num(ds["excess"].values[k])
        assert state.excess == pytest.approx(excess, abs=1e-12)
    for number, label in ((1, "LIMIT_P4"), (2, "LIMIT_S2_CONE"), (4, "LIMIT_P1_VELOCITY")):
        assert f"RIG_{label} = {number}, /*" in header


def test_the_command_line_and_the_report_say_it(
    rig: Rig, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    ds = rig.solver.solve("aside")
    k = int(np.argmax(ds["status"].values != 0))
    words = f"{stop_words(ds, k)}, first at t = {float(ds['first_at'].values[k]):.4g} s"
    assert main(["solve", str(rig.path), "aside"]) == 1  # without --all
    said = capsys.readouterr().err
    assert f"the first at sample {k}, t = {float(ds['time'].values[k]):.6g} s" in said
    assert words in said
    assert f"in all: {ds.attrs['stops_met']}" in said
    page = tmp_path / "rig.html"
    assert main(["report", str(rig.path), "aside", "-o", str(page)]) == 1
    text = page.read_text("utf-8")
    assert words in text
    rows = text[text.index("Limits on rates") :]
    assert "P1.velocity" in rows
    assert "P6.acceleration" in rows


def test_the_page_and_the_film_show_it(rig: Rig) -> None:
    playback = playback_of(rig.everything, "aside")
    ds = rig.everything.solve("aside", bodies=True)
    first = int(np.argmax(ds["status"].values != 0))
    named = str(ds["stop"].values[ds["stopped_by"].values[first]]).partition(".velocity")[0]
    beyond = {name for name, when in playback.beyond_limits.items() if when[first]}
    assert named in beyond
    assert not any(when[first - 1] for when in playback.beyond_limits.values())
    assert timing(ds).ended == ""  # values are kept beyond limits, so the film goes on


def test_driven_by_hand_it_stops_at_the_limit(rig: Rig) -> None:
    drive = Drive(rig.everything)
    goal = drive.y.copy()
    goal[0] += 0.3
    stop = drive.to(goal)
    assert stop is not None
    assert stop.status == Status.LIMIT_EXCEEDED
    ds = rig.everything.solve("aside")
    names = ds["stop"].values[ds["stopped_by"].values].tolist()
    first = next(n for n in names if n and "velocity" not in n and "acceleration" not in n)
    assert stop.words == f"{first} is at its limit"
    assert drive.to(rig_home(drive)) is None  # and back


def rig_home(drive: Drive) -> list[float]:
    return [drive.solver.home[name] for name in drive.solver.driven]


def test_modes_are_held_to_cones_and_strokes(rig: Rig) -> None:
    found = parakin.modes(rig.solver, starts=1024)
    home = next(mode for mode in found.modes if mode.name == "home")
    assert home.limits_exceeded == ()
    others = [mode for mode in found.modes if mode.coordinates["P4"] < 0.2]
    assert others
    assert all("P4" in mode.limits_exceeded for mode in others)


def test_check_names_homes_own_violations(
    rig: Rig, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", str(rig.path)]) == 1  # as tour is flagged from its first sample
    capsys.readouterr()
    path = tmp_path / "home.toml"
    path.write_text('name = "home"\nvariant_of = "gough-stewart"\nlimits.P4 = [0, "0.3 m"]\n')
    assert main(["check", str(path)]) == 1
    assert "home is outside limits: P4 at 0.361 m, limit 0.300 m" in capsys.readouterr().out


def test_an_unreachable_pose_names_the_limb() -> None:
    """A Delta whose platform is sent away from one arm, which is then the first to stretch."""
    solver = parakin.compile("delta")
    joints = {joint.name: joint for joint in solver.graph.joints}
    y = np.array([solver.home[name] for name in solver.driven])
    for k in (1, 2, 3):
        hip = np.array(joints[f"A{k}"].F.p, dtype=float)
        away = np.append(-hip[:2] / np.linalg.norm(hip[:2]), 0.0)
        reaches = [r for r in np.linspace(0, 2, 2001) if solver.at(y + r * away).status == 0]
        beyond = solver.at(y + (max(reaches) + 0.002) * away)
        assert beyond.status == Status.OUT_OF_REACH
        assert beyond.why() == f"limb A{k}, B{k} cannot reach"
        _the_way_there(solver, y, away, k)


def _the_way_there(solver: parakin.Solver, y: np.ndarray, away: np.ndarray, k: int) -> None:
    """A motion ends there, at the very moment, for the same reason."""
    time = np.linspace(0.0, 1.0, 101)
    way = y[:, None] + 2.0 * away[:, None] * time**2
    ds = solver.solve(parakin.from_arrays("away", solver.driven, time, way))
    end = int(np.argmax(ds["status"].values != 0))
    assert ds["status"].values[end] == Status.OUT_OF_REACH
    assert stop_words(ds, end) == f"limb A{k}, B{k} cannot reach"
    assert time[end - 1] <= float(ds["first_at"].values[end]) <= time[end]
    assert set(ds["stopped_by"].values[end + 1 :].tolist()) <= {0}


def test_results_keep_it_in_files(rig: Rig, tmp_path: Path) -> None:
    ds = rig.solver.solve("aside")
    parakin.save(rig.solver.stream("aside", 100), tmp_path / "rig.nc")
    with xr.open_dataset(tmp_path / "rig.nc") as read:
        xr.testing.assert_allclose(read.load(), ds, rtol=0, atol=1e-12)
        assert read.attrs["stops_met"] == ds.attrs["stops_met"]


def test_full_turns_of_an_angle_that_is_not_reported_count(tmp_path: Path) -> None:
    """The connecting rod of a slider-crank, which turns once with the crank: in ticks one after the
    other and in C as along the motion.
    """
    limited = parakin.load("slider-crank").model_copy(update={"limits": {"B": (-3.5, math.inf)}})
    whole = parakin.compile(limited, coordinates="all")
    few = parakin.compile(limited, coordinates=["A"])
    law = parakin.laws.polynomial345(whole.home["A"], 2 * math.pi, 1.0)
    motion = parakin.from_laws("turn", {"A": law}, 1.0, 100.0)
    expected = whole.solve(motion)
    beyond = expected["position"].sel(coordinate="B").values < -3.5
    assert 0 < beyond.sum() < len(beyond)
    np.testing.assert_array_equal(expected["status"] == Status.LIMIT_EXCEEDED, beyond)
    np.testing.assert_array_equal(few.solve(motion)["status"], expected["status"])
    driven = expected["position"].sel(coordinate="A").values
    tick = few.at(driven[:1])
    for y, flagged in zip(driven, beyond, strict=True):
        tick = few.at([y], guess=tick)
        assert (tick.status == Status.LIMIT_EXCEEDED) == flagged
    again = few.at(driven[None, -1:], guess=few.at(driven[None, -1:], guess=tick))
    assert again.why(0) == tick.why() != ""
    if COMPILER is not None:
        parakin.export(limited, tmp_path / "crank.c")
        header = (tmp_path / "crank.h").read_text()
        assert "CRANK_B = " in header  # in the state, by which its turns are counted
