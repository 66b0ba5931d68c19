"""One rule for all that is followed: change points, folds, plans that die, angles that lock, and
nothing that depends on how a motion was sampled, windowed or formulated.

Right answers come from closed forms of the linkages and from `tests/oracles/oracle.py`.
"""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from oracle import gaps
from replays import replayed
from scipy.spatial.transform import Rotation

import parakin
from parakin import Body, Frame, Joint, Mechanism, Status
from parakin.motion.course import Course, hermite
from parakin.motion.laws import constant, cosine, from_laws, polynomial345, sine, sines
from parakin.motion.sampled import from_arrays
from parakin.planning import closed_forms

LOOP = """
name = "loop"
driven = ["j1"]
bodies = { b1 = {}, b2 = {}, b3 = {} }
home = { j1 = 0 }
guess = { j2 = "-0.2 m", "r.1" = 0, "r.2" = 0 }
[joints.j1]
kind = "revolute"
parent = "base"
child = "b1"
on_parent = { axis = [1, 0, 0], x = [0, 1, 0] }
on_child = { axis = [1, 0, 0], x = [0, 1, 0] }
actuated = true
[joints.j2]
kind = "prismatic"
parent = "base"
child = "b2"
on_parent = { at = [1.2, 0, 0], axis = [1, 0, 0], x = [0, 1, 0] }
on_child = { axis = [1, 0, 0], x = [0, 1, 0] }
[joints.r]
kind = "universal"
parent = "b2"
child = "b3"
on_parent = { at = [0, 0.2, 0], axis = [0, 1, 0], x = [0, 0, 1] }
on_child = { axis = [0, 0, 1], x = [0, -1, 0] }
[joints.s]
kind = "spherical"
parent = "b3"
child = "b1"
on_parent = { at = [-1, 0.3, 0.1] }
on_child = { at = [0, 0.5, 0.1] }
"""

EYE = """
name = "eye"
driven = ["A1", "A2", "A3"]
guess = { "platform.phi" = -0.4, "platform.theta" = 0.65, "platform.psi" = 0.32 }
[bodies]
eye = {}
[platform]
body = "eye"
angles = [["phi", "z"], ["theta", "y"], ["psi", "x"]]
[limbs.leg]
count = 3
bodies = { "prox{i}" = {}, "dist{i}" = {} }
home = { "A{i}" = "t" }
[limbs.leg.each]
bx = [1, 0, 0]
by = [0, 1, 0]
bz = [0, 0, 1]
wx = [0, 1, 0]
wy = [0, 0, 1]
wz = [1, 0, 0]
vx = [0, 0, -1]
vy = [-1, 0, 0]
vz = [0, -1, 0]
t = [0.3, 0.5, -0.4]
[limbs.leg.joints."A{i}"]
kind = "revolute"
parent = "base"
child = "prox{i}"
actuated = true
on_parent = { axis = ["bx", "by", "bz"], x = ["wx", "wy", "wz"] }
on_child = { axis = ["bx", "by", "bz"], x = ["wx", "wy", "wz"] }
[limbs.leg.joints."B{i}"]
kind = "revolute"
parent = "prox{i}"
child = "dist{i}"
on_parent = { axis = ["wx", "wy", "wz"] }
on_child = { axis = [0, 0, 1] }
[limbs.leg.joints."C{i}"]
kind = "revolute"
parent = "dist{i}"
child = "eye"
on_parent = { axis = [1, 0, 0] }
on_child = { axis = ["vx", "vy", "vz"] }
"""


def hinge(name: str, parent: str, child: str, at: float = 0.0, on: float = 0.0) -> Joint:
    frames = Frame(at=(at, 0, 0)), Frame(at=(on, 0, 0))
    return Joint(
        name=name,
        kind="revolute",
        parent=parent,
        child=child,
        on_parent=frames[0],
        on_child=frames[1],
    )


def four_bar(crank: float, coupler: float, rocker: float, ground: float) -> Mechanism:
    return Mechanism(
        name="four-bar",
        bodies=tuple(Body(name=name) for name in ("crank", "coupler", "rocker")),
        joints=(
            hinge("A", "base", "crank"),
            hinge("B", "crank", "coupler", crank),
            hinge("C", "coupler", "rocker", coupler, rocker),
            hinge("D", "base", "rocker", ground),
        ),
        guess={"A": 1.0, "B": -0.3, "C": 0.5, "D": 2.0},
    )


@pytest.fixture
def loop(tmp_path: Path) -> Path:
    path = tmp_path / "loop.toml"
    path.write_text(LOOP, "utf-8")
    return path


@pytest.fixture
def eye(tmp_path: Path) -> Path:
    path = tmp_path / "eye.toml"
    path.write_text(EYE, "utf-8")
    return path


@pytest.mark.parametrize("reading", [False, None])
@pytest.mark.parametrize(
    ("lengths", "flat"),
    [((0.2, 0.5, 0.4, 0.3), 2 * np.pi), ((0.2, 0.3, 0.4, 0.5), np.pi)],
)
def test_a_change_point_ends_a_motion_however_it_is_sampled(
    lengths: tuple[float, float, float, float], flat: float, reading: bool | None
) -> None:
    """Links that add up can be laid flat, and unfolded to either side."""
    crank, coupler, rocker, ground = lengths
    reach = ground - crank * np.cos(flat)  # from crank pin to rocker's pivot, in line
    assert min(abs(reach - coupler - rocker), abs(reach - abs(coupler - rocker))) < 1e-12
    solver = parakin.compile(four_bar(*lengths), ["A"], machine_code=reading)
    start = solver.home["A"]
    for law in (polynomial345(start, 2 * np.pi, 1.0), lambda t: (start + 6 * t, 6 + 0 * t, 0 * t)):
        for samples in (3, 10, 31, 100, 401) if reading is None else (10,):
            result = solver.solve(from_laws("turn", {"A": law}, 1.0, samples - 1.0))
            crank_at = law(result.time.values)[0]
            np.testing.assert_array_equal(result.status.values == 0, crank_at < flat)
            later = result.status.values[crank_at >= flat]
            if len(later):
                assert later[0] in (Status.BRANCH_CHANGE, Status.SINGULAR)
                assert (later[1:] == Status.NOT_REACHED).all()


def test_a_motion_out_and_back_is_seen_between_its_ends() -> None:
    """Out of reach in the middle, and asked for at its two resting ends alone."""
    solver = parakin.compile("slider-crank", ["D"])
    out = solver.home["D"]
    away = sine(out, 10.0, 0.5)  # metres, for half a second and back
    result = solver.solve(from_laws("out and back", {"D": away}, 1.0, 1.0))
    assert result.status.values.tolist() == [Status.CONVERGED, Status.OUT_OF_REACH]


def test_turns_are_counted_however_coarsely_they_are_asked_for() -> None:
    solver = parakin.compile("slider-crank", ["A"], coordinates="all")
    start = solver.home["A"]
    law = polynomial345(start, 40 * np.pi, 1.0)
    coarse = parakin.require_solved(solver.solve(from_laws("turn", {"A": law}, 1.0, 2.0)))
    assert float(coarse.position.sel(coordinate="A")[-1]) == pytest.approx(start + 40 * np.pi)
    turned = coarse.position.sel(coordinate="B").values
    assert turned[0] - turned[-1] == pytest.approx(40 * np.pi, abs=1e-10)


def test_a_motion_that_is_not_smooth_is_said_not_to_be() -> None:
    solver = parakin.compile("four-bar")
    home = solver.home["A"]

    def jumping(t: np.ndarray) -> tuple[np.ndarray, ...]:
        return home + 0.3 * (t > 0.5), 0 * t, 0 * t

    result = solver.solve(from_laws("jump", {"A": jumping}, 1.0, 100.0))
    status = result.status.values
    assert not status[:51].any()
    assert status[51] == Status.NOT_SMOOTH
    assert (status[52:] == Status.NOT_REACHED).all()


def test_accelerations_may_jump() -> None:
    """The paper's own laws start and stop so; others rest while one begins."""
    solver = parakin.compile("delta")
    x = solver.driven[0]
    laws = {name: constant(solver.home[name]) for name in solver.driven}
    laws[x] = cosine(solver.home[x], 0.05, 0.4, 0.3)
    parakin.require_solved(solver.solve(from_laws("begin", laws, 1.0, 7.0)))


@pytest.mark.parametrize("reading", [False, None])
def test_a_plan_that_dies_flags_nothing(loop: Path, reading: bool | None) -> None:
    """A regular loop goes round and round, whatever rows it is solved by; its branch is one."""
    law = polynomial345(0.0, 4 * np.pi, 1.0)
    motion = from_laws("round", {"j1": law}, 1.0, 60.0)
    found = []
    for cut in ([], ["j2"]):
        solver = parakin.compile(loop, cut=cut, coordinates="all", machine_code=reading)
        result = parakin.require_solved(solver.solve(motion))
        point, turn = gaps(solver, result.position.values.T)
        assert point.max() < 1e-13
        assert turn.max() < 1e-13
        found.append(result.position)
    np.testing.assert_allclose(found[0], found[1], atol=1e-11)
    solver = parakin.compile(loop, coordinates="all")
    angles = np.array([[0.5, 1.0, 1.6, 2.2, 3.0, -1.0, -2.0, -3.0]])
    there = solver.at(angles)
    assert not np.any(there.status)
    for column, angle in enumerate(angles[0]):
        walked = solver.solve(from_laws("to", {"j1": polynomial345(0.0, angle, 1.0)}, 1.0, 10.0))
        off = there.position[:, column] - walked.position.values[-1]
        turned = [not c.startswith("j2") for c in solver.coordinates]
        off -= 2 * np.pi * np.round(off / (2 * np.pi)) * turned
        np.testing.assert_allclose(off, 0.0, atol=1e-12)


@pytest.mark.parametrize("reading", [False, None])
def test_another_chart_takes_over_where_rows_die(
    loop: Path, reading: bool | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Rows that come to say the same at 90 degrees, as they would be chosen near home."""
    steady = parakin.compile(loop, coordinates="all", machine_code=reading)
    monkeypatch.setattr(closed_forms, "steady", lambda *_: True)
    solver = parakin.compile(loop, coordinates="all", machine_code=reading)
    assert solver.plan.blocks != steady.plan.blocks
    motion = from_laws("round", {"j1": polynomial345(0.0, 4 * np.pi, 1.0)}, 1.0, 60.0)
    whole = parakin.require_solved(solver.solve(motion))
    np.testing.assert_allclose(whole.position, steady.solve(motion).position, atol=1e-11)
    for size in (1, 7):
        joined = xr.concat(list(solver.stream(motion, size)), "time", data_vars="minimal")
        np.testing.assert_array_equal(joined.status, whole.status)
        np.testing.assert_allclose(joined.position, whole.position, atol=1e-11)


@pytest.mark.parametrize("size", [1, 7, 100])
@pytest.mark.parametrize("case", ["six-bar-stephenson F", "delta A1,A2,A3", "bricard A"])
def test_windows_change_nothing(case: str, size: int) -> None:
    name, driven = case.split()
    solver = parakin.compile(name, driven.split(","))
    rng = np.random.default_rng(len(name))
    laws = {}
    for coordinate in solver.driven:
        terms = [(float(rng.uniform(-1, 1)), float(rng.uniform(0.2, 2)), 0.0) for _ in range(2)]
        laws[coordinate] = sines(solver.home[coordinate], terms)
    motion = from_laws("wild", laws, 1.0, 150.0)
    whole = solver.solve(motion)
    joined = xr.concat(list(solver.stream(motion, size)), "time", data_vars="minimal")
    np.testing.assert_array_equal(joined.status, whole.status)
    np.testing.assert_allclose(joined.position, whole.position, atol=1e-12)


def test_what_was_recorded_is_followed_like_the_law_it_came_from() -> None:
    solver = parakin.compile("six-bar-stephenson", ["F"])
    law = sines(solver.home["F"], [(0.4, 1.0, 0.0)])
    motion = from_laws("law", {"F": law}, 1.0, 400.0)
    samples = motion.samples()
    recorded = from_arrays("recorded", ["F"], samples.time, *samples.orders[:3])
    by_law, by_record = solver.solve(motion), solver.solve(recorded)
    np.testing.assert_array_equal(by_law.status, by_record.status)


def test_steps_are_the_motions_own() -> None:
    laws = {"x": sines(0.0, [(1.0, 2.0, 0.0)]), "y": cosine(0.0, 1.0, 0.7, 0.2)}
    motions = [from_laws("a", laws, 3.0, rate) for rate in (1000.0, 2.0)]
    one, other = (Course(motion).steps(-np.inf, 3.0) for motion in motions)
    np.testing.assert_array_equal(one, other)
    assert {0.0, 0.2, 3.0} <= set(one.tolist())
    assert np.diff(one).max() < 0.5 / 8  # eight in a period at least
    piecewise: list[float] = []
    for until in np.linspace(0.0, 3.0, 50):
        after = piecewise[-1] if piecewise else -np.inf
        if after < until:
            piecewise += Course(motions[0]).steps(after, until).tolist()
    np.testing.assert_array_equal(piecewise, one)


def test_the_quintic_between_samples_is_exact_for_quintics() -> None:
    polynomial = np.polynomial.Polynomial([1.0, -2.0, 0.5, 3.0, -1.0, 0.7])
    nodes = np.array([0.0, 0.4, 1.0])
    values = np.array([[polynomial.deriv(k)(nodes) if k else polynomial(nodes)] for k in range(3)])
    at = np.linspace(0.0, 1.0, 11)
    for order in range(3):
        expected = polynomial.deriv(order)(at) if order else polynomial(at)
        np.testing.assert_allclose(hermite(nodes, values, at, order)[0], expected, atol=1e-12)


# ---- one pose


@pytest.mark.parametrize("name", ["3-prs", "3-rps"])
def test_axes_that_point_against_each_other_are_not_closed(name: str) -> None:
    driven = ("S1.2", "S3.3", "P2" if name == "3-prs" else "A2")
    solver = parakin.compile(name, driven, coordinates="all")
    rng = np.random.default_rng(0)
    home = np.array([[solver.home[c]] for c in solver.driven])
    y = home + rng.uniform(-1, 1, (3, 4000)) * 10.0 ** rng.uniform(-2, -0.3, 4000)
    guess = np.array([solver.home[c] for c in solver.coordinates])
    tick = solver.at(y, guess=guess)
    good = np.asarray(tick.status) == 0
    assert good.sum() > 1000
    point, turn = gaps(solver, tick.position[:, good])
    assert point.max() < 1e-9
    assert turn.max() < 1e-9


def test_rules_of_homes_branch_are_not_told_of_another() -> None:
    """A Tricept turned over: the platform's yaw is half a turn, and was said to be none."""
    solver = parakin.compile("tricept", ["P1", "P2", "P3"], coordinates="all")
    guess = np.array([solver.home[c] for c in solver.coordinates])
    for name, value in {"U0.1": -1.194, "U0.2": -3.439, "P0": 3.052}.items():
        guess[solver.coordinates.index(name)] = value
    tick = solver.at([solver.home[c] for c in solver.driven], guess=guess)
    assert tick.status == 0
    assert max(gap.max() for gap in gaps(solver, tick.position[:, None])) < 1e-12


def test_a_guess_that_is_no_number_flags_its_own_column_alone() -> None:
    solver = parakin.compile("four-bar", coordinates="all")
    y = solver.home["A"] + np.linspace(0, 2 * np.pi, 13)[None]
    plain = solver.at(y)
    guess = plain.position + 4 * np.pi
    for value in (np.nan, np.inf, 1e17):
        bad = guess.copy()
        bad[1, 3] = value
        tick = solver.at(y, guess=bad)
        assert np.flatnonzero(tick.status).tolist() == [3]
        assert np.isnan(tick.position[:, 3]).all()
        others = np.arange(13) != 3
        np.testing.assert_allclose(tick.position[1:, others], guess[1:, others], atol=1e-9)
        assert solver.at(y[:, 3], guess=bad[:, 3]).status == np.asarray(tick.status)[3]


@pytest.mark.parametrize("shape", [(3,), (4, 2), (4, 1), (13, 4), ()])
def test_a_guess_of_a_wrong_shape_is_refused(shape: tuple[int, ...]) -> None:
    solver = parakin.compile("four-bar", coordinates="all")
    with pytest.raises(parakin.InputError, match="guess"):
        solver.at(np.full((1, 13), solver.home["A"]), guess=np.zeros(shape))
    with pytest.raises(parakin.InputError, match="guess"):
        solver.at([solver.home["A"]], guess=np.zeros((4, 1)))


def test_a_tick_carries_what_is_not_reported() -> None:
    legs = [f"P{i}" for i in range(1, 7)]
    few = parakin.compile("gough-stewart", legs, coordinates=["platform.x", "U1.1"])
    assert few.coordinates == ("platform.x", "U1.1")
    whole = parakin.compile("gough-stewart", legs, coordinates="all")
    y = np.array([few.home[leg] for leg in legs])
    tick, full = few.at(y), whole.at(y)
    rows = [whole.coordinates.index(name) for name in few.coordinates]
    for step in range(5):
        y = y + 0.01 * np.sin(step + np.arange(6))
        tick, full = few.at(y, guess=tick), whole.at(y, guess=full)
        assert tick.status == full.status == 0
        np.testing.assert_allclose(tick.position, full.position[rows], atol=1e-12)
    with pytest.raises(parakin.InputError, match="a Tick"):
        few.at(y, guess=tick.position)
    with pytest.raises(parakin.InputError, match="another solver"):
        few.at(y, guess=full._replace(position=tick.position))
    rest = few.solve(from_laws("rest", {n: constant(few.home[n]) for n in legs}, 0.1, 10.0))
    assert rest.coordinate.values.tolist() == ["platform.x", "U1.1"]
    assert not rest.status.any()


@pytest.mark.parametrize("reading", [False, None])
def test_a_number_that_is_none_is_flagged_in_no_loop_too(reading: bool | None) -> None:
    mechanism = four_bar(0.2, 0.5, 0.4, 0.45)
    hand = mechanism.model_copy(
        update={
            "bodies": (*mechanism.bodies, Body(name="hand")),
            "joints": (*mechanism.joints, hinge("H", "rocker", "hand", 0.4)),
        }
    )
    solver = parakin.compile(hand, ["A", "H"], coordinates="all", machine_code=reading)
    for value in (np.nan, np.inf, -np.inf):
        assert solver.at([1.0, value]).status == Status.OUT_OF_REACH
        batch = solver.at(np.array([[1.0, 1.0], [value, 0.5]]))
        assert list(np.asarray(batch.status)) == [Status.OUT_OF_REACH, Status.CONVERGED]


def test_what_was_subtracted_is_not_hidden_by_its_size() -> None:
    """A platform a thousand kilometres up closes to what doubles can hold there, and says so."""
    solver = parakin.compile("3-rps", coordinates="all")
    near = solver.at([solver.home[c] for c in solver.driven])
    far = solver.at([1e6 if c == "platform.z" else solver.home[c] for c in solver.driven])
    assert float(near.residual) < 1e-14
    assert float(far.residual) > 1e-11


# ---- where three angles are not defined


def test_an_eye_has_eight_assemblies_whatever_its_angles(eye: Path) -> None:
    solver = parakin.compile(eye, coordinates="all")
    found = parakin.modes(solver).modes
    assert len(found) == 8
    for branch in found:
        position = np.array([[branch.coordinates[c]] for c in solver.coordinates])
        assert max(gap.max() for gap in gaps(solver, position)) < 1e-9
        other = parakin.compile(eye, coordinates="all", near=branch.coordinates, machine_code=False)
        tick = other.at([other.home[c] for c in other.driven])
        assert tick.status in (Status.CONVERGED, Status.ANGLES_UNDEFINED)
        turns = [k for k, c in enumerate(other.coordinates) if not c.startswith("platform.")]
        np.testing.assert_allclose(tick.position[turns], position[turns, 0], atol=1e-9)


def test_at_the_lock_those_angles_alone_are_not_told() -> None:
    solver = parakin.compile("3-rps", coordinates="all")
    flat = [0.0 if c == "platform.z" else solver.home[c] for c in solver.driven]
    tick = solver.at(flat, np.ones(3))
    assert tick.status == Status.ANGLES_UNDEFINED
    told = ~np.isnan(tick.velocity)
    names = {c for c, known in zip(solver.coordinates, told, strict=True) if not known}
    assert names == {f"S{i}.{k}" for i in (1, 2, 3) for k in (1, 2, 3)}
    after = solver.at([0.01, *flat[1:]], guess=tick)
    assert after.status == 0
    law = polynomial345(0.05, -0.1, 1.0)
    laws = {c: constant(solver.home[c]) for c in solver.driven} | {"platform.z": law}
    through = solver.solve(from_laws("through", laws, 1.0, 10.0))
    assert through.status.values.tolist() == [0] * 5 + [Status.ANGLES_UNDEFINED] + [0] * 5


def test_forward_kinematics_passes_where_angles_lock() -> None:
    inverse = parakin.compile("octahedral-hexapod")
    laws = {c: constant(inverse.home[c]) for c in inverse.driven}
    laws["platform.pitch"] = polynomial345(inverse.home["platform.pitch"], 2.0, 1.0)
    result = parakin.require_solved(inverse.solve(from_laws("over", laws, 1.0, 100.0)))
    legs = [f"P{i}" for i in range(1, 7)]
    forward = parakin.compile("octahedral-hexapod", legs)
    passed = parakin.require_solved(forward.solve(replayed(result, legs), bodies=["platform"]))
    angles = [f"platform.{name}" for name in ("roll", "pitch", "yaw")]
    pose = result.position.sel(coordinate=angles).values
    turned = Rotation.from_quat(passed.body_orientation.values[:, 0], scalar_first=True)
    off = turned.inv() * Rotation.from_euler("XYZ", pose)
    assert float(off.magnitude().max()) < 1e-9
    joined = xr.concat(list(forward.stream(replayed(result, legs), 7)), "time", data_vars="minimal")
    np.testing.assert_allclose(joined.position, passed.position, atol=1e-9)


@pytest.mark.parametrize("reported", ["all", ["platform.x", "platform.yaw"], ["platform.x"]])
def test_a_pose_may_be_asked_for_at_the_lock_and_beyond(reported: str | list[str]) -> None:
    """Legs from the inverse kinematics, which solves for no angle of the platform's."""
    inverse = parakin.compile("octahedral-hexapod", coordinates="all")
    legs = [f"P{i}" for i in range(1, 7)]
    rows = [inverse.coordinates.index(leg) for leg in legs]
    home = np.array([inverse.home[c] for c in inverse.driven])
    rates = np.array([0.1, -0.2, 0.1, 0.3, 0.2, -0.1])
    pitch = inverse.driven.index("platform.pitch")

    forward = parakin.compile("octahedral-hexapod", legs, coordinates=reported)

    def at_pitch(value: float, guess: parakin.Tick | None) -> parakin.Tick:
        pose = home + 0.1 * rates
        pose[pitch] = value
        found = inverse.at(pose, rates, rates)
        y, yd, ydd = (a[rows] for a in (found.position, found.velocity, found.acceleration))
        return forward.at(y, yd, ydd, guess=guess)

    tick = at_pitch(0.0, None)
    for value in np.linspace(0.1, 1.5, 60):
        tick = at_pitch(value, tick)
        assert tick.status == 0
    told = reported != ["platform.x"]
    lock = np.pi / 2
    for value in (lock - 1e-7, lock, lock, lock + 1e-7, lock + 0.01, lock + 0.2):
        tick = at_pitch(value, tick)
        near = told and abs(value - lock) < 3e-4  # where rounding leaves accelerations no digits
        assert tick.status == (Status.ANGLES_UNDEFINED if near else 0)
        x = forward.coordinates.index("platform.x")
        orders = tick.position[x], tick.velocity[x], tick.acceleration[x]
        right = home[0] + 0.1 * rates[0], rates[0], rates[0]
        np.testing.assert_allclose(orders, right, rtol=0, atol=1e-8)
    if reported == "all":
        turns = [forward.coordinates.index(f"platform.{c}") for c in ("roll", "pitch", "yaw")]
        pose = Rotation.from_euler("XYZ", tick.position[turns])
        there = [0.1 * rates[3], lock + 0.2, 0.1 * rates[5]]
        assert (pose.inv() * Rotation.from_euler("XYZ", there)).magnitude() < 1e-9


WRIST = ["W1", "W2", "W3", "A1", "A2", "A3"]


@pytest.mark.parametrize("angle", [1.58, 2.0, -2.0])
def test_the_walk_from_home_passes_where_angles_lock(angle: float) -> None:
    """The wrist's second angle turned through where the platform's lock, the others at home."""
    solver = parakin.compile("wrist-on-delta", WRIST, coordinates="all")
    home = np.array([solver.home[c] for c in WRIST])
    turned = home + angle * (np.array(WRIST) == "W2")
    other = home + 0.1
    batch = solver.at(np.column_stack([turned, np.full(6, np.nan), other]))
    alone = solver.at(turned)
    np.testing.assert_array_equal(batch.status, [0, Status.OUT_OF_REACH, 0])
    assert alone.status == 0
    np.testing.assert_array_equal(batch.position[:, 0], alone.position)
    np.testing.assert_array_equal(batch.position[:, 2], solver.at(other).position)

    by = {c: polynomial345(h, t - h, 1.0) for c, h, t in zip(WRIST, home, turned, strict=True)}
    followed = solver.solve(from_laws("straight", by, 1.0, 50.0)).position.values[-1]
    places = [solver.coordinates.index(f"platform.{c}") for c in "xyz"]
    turns = [solver.coordinates.index(f"platform.{c}") for c in ("roll", "pitch", "yaw")]
    np.testing.assert_allclose(alone.position[places], followed[places], atol=1e-12)
    one, same = (Rotation.from_euler("XYZ", p[turns]) for p in (alone.position, followed))
    assert (one.inv() * same).magnitude() < 1e-9


def test_a_chart_that_does_not_serve_is_forgotten() -> None:
    atlas = parakin.compile("four-bar").atlas
    chart = atlas.home
    at = chart.configuration(np.array([0.3]), chart.run(np.array([[0.3], [0.0], [0.0]]))[:, 0])
    (made,) = atlas.others(chart, at, at)
    assert made is not chart
    (again,) = atlas.others(chart, at, at)
    assert again is not made


@pytest.mark.parametrize("derivatives", [0, 1, 2, 3])
def test_positions_alone_go_on_with_other_charts_too(derivatives: int) -> None:
    """Where angles lock and without a guess: what is known beside positions does not matter."""
    solver = parakin.compile("wrist-on-delta", WRIST, derivatives=derivatives)
    home = np.array([solver.home[c] for c in WRIST])
    turned = home + 2.0 * (np.array(WRIST) == "W2")
    whole = parakin.compile("wrist-on-delta", WRIST)
    tick, right = solver.at(turned), whole.at(turned)
    assert (tick.status, right.status) == (0, 0)
    np.testing.assert_allclose(tick.position, right.position, atol=1e-12)
    lock = home + 0.5 * np.pi * (np.array(WRIST) == "W2")
    assert (solver.at(lock).status, whole.at(lock).status) == (8, 8)


HEXAPOD = "octahedral-hexapod", [f"P{i}" for i in range(1, 7)]


@functools.cache
def hexapod_by_pose() -> parakin.Solver:
    return parakin.compile(HEXAPOD[0], coordinates="all")


def legs_at(pitch: float, *moved: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Lengths of the octahedral hexapod's legs, velocities of some kind, and all coordinates."""
    inverse = hexapod_by_pose()
    pose = np.array([inverse.home[c] for c in inverse.driven])
    pose += [*moved, *np.zeros(6 - len(moved))]
    pose[inverse.driven.index("platform.pitch")] = pitch
    rates = np.array([0.1, -0.2, 0.1, 0.3, 0.2, -0.1])
    found = inverse.at(pose, rates, rates)
    rows = [inverse.coordinates.index(leg) for leg in HEXAPOD[1]]
    return found.position[rows], found.velocity[rows], np.nan_to_num(found.position)


def test_no_other_branch_is_taken_at_the_lock() -> None:
    """The legs' determinant by the platform's twist (finite differences of the inverse kinematics)
    is -2.1 at home and +0.66 to +0.71 all along here.
    """
    forward = parakin.compile(*HEXAPOD, coordinates="all")
    for off in (1e-1, 1e-3, 1e-5, 1e-6, 1e-8, 0.0):
        moved = 0.0766, 0.0638, 0.0163, 0.3043, 0.0, -0.018
        y, _, guess = legs_at(-np.pi / 2 + off, *moved)
        assert forward.at(y, guess=guess).status == Status.BRANCH_CHANGE


def test_at_the_lock_a_column_is_judged_as_anywhere() -> None:
    forward = parakin.compile(*HEXAPOD, coordinates="all")
    y, yd, _ = legs_at(np.pi / 2, 0.01, -0.02, 0.01, 0.03, 0.0, -0.01)
    _, _, guess = legs_at(np.pi / 2 - 0.07, 0.01, -0.02, 0.01, 0.03, 0.0, -0.01)
    fine = forward.at(y, yd, guess=guess)
    assert fine.status == Status.ANGLES_UNDEFINED
    assert forward.at(y, np.full(6, np.nan), guess=guess).status == Status.OUT_OF_REACH
    assert forward.at(y, yd, guess=guess, within=1e-3).status == Status.BRANCH_CHANGE
    for name, bad in (("U1.1", np.nan), ("S1.1", np.inf), ("S1.1", 1e300)):
        guesses = np.repeat(guess[:, None], 3, axis=1)
        guesses[forward.coordinates.index(name), 1] = bad
        tick = forward.at(np.tile(y, (3, 1)).T, np.tile(yd, (3, 1)).T, guess=guesses)
        assert np.asarray(tick.status).tolist() == [8, 2, 8]
        np.testing.assert_array_equal(tick.velocity[:, 0], fine.velocity)
    # what was asked for before does not matter
    for x in (0.3, -0.2):
        other, _, guess_ = legs_at(np.pi / 2, x, -0.02, 0.01, 0.03)
        forward.at(other, guess=guess_)
    assert forward.at(y, yd, guess=guess).conditioning == pytest.approx(fine.conditioning, 1e-12)


def test_derivatives_of_angles_are_told_as_long_as_they_have_digits() -> None:
    forward = parakin.compile(*HEXAPOD)
    inverse = hexapod_by_pose()
    turns = [forward.coordinates.index(f"platform.{c}") for c in ("roll", "pitch", "yaw")]
    for off in np.geomspace(3e-9, 1e-2, 40):
        y, yd, pose = legs_at(np.pi / 2 - off)
        guess = [pose[inverse.coordinates.index(c)] + 0.01 for c in forward.coordinates]
        tick = forward.at(y, yd, guess=guess)
        assert tick.status in (Status.CONVERGED, Status.ANGLES_UNDEFINED)
        told = np.isfinite(tick.velocity[turns])
        assert told.all() or tick.status == Status.ANGLES_UNDEFINED
        assert told.all() if off > 1.1e-5 else off > 1e-6 or not told.any()
        right = np.array([0.3, 0.2, -0.1])
        np.testing.assert_allclose(tick.velocity[turns][told], right[told], rtol=0, atol=3e-5)


@pytest.mark.parametrize("size", [1, 7])
def test_windows_do_not_change_why_a_motion_ends(size: int) -> None:
    solver = parakin.compile("delta")
    by = {"platform.z": -2.0}
    laws = {c: polynomial345(solver.home[c], by.get(c, 0.0), 1e-6) for c in solver.driven}
    motion = from_laws("fast", laws, 1e-6, 60e6)
    whole = solver.solve(motion).status.values
    parts = [part.status.values for part in solver.stream(motion, size)]
    np.testing.assert_array_equal(np.concatenate(parts), whole)
    assert (whole != 0).any()


def test_a_thousand_turns_are_turned() -> None:
    solver = parakin.compile("four-bar")
    law = polynomial345(solver.home["A"], 2000 * np.pi, 1.0)
    result = parakin.require_solved(solver.solve(from_laws("turns", {"A": law}, 1.0, 1000)))
    ends = result.position.values[[0, -1]]
    turned = (ends[1] - ends[0]) / (2 * np.pi)
    np.testing.assert_allclose(turned, np.round(turned), rtol=0, atol=1e-9)


def test_walks_from_home_answer_alone_as_in_a_batch() -> None:
    """Also where the walk ends, whose verdict a closed pose must not hide."""
    solver = parakin.compile("3-rpr", ("P1", "P2", "P3"))
    assert solver.iterated
    home = np.array([solver.home[name] for name in solver.driven])
    way = np.random.default_rng(3).normal(size=(len(home), 9)) * np.geomspace(1e-3, 3.0, 9)
    batch = solver.at(home[:, None] + way)
    status = np.asarray(batch.status)
    assert (status == 0).any()
    assert (status != 0).any()
    for i in range(9):
        alone = solver.at(home + way[:, i])
        assert alone.status == status[i]
        np.testing.assert_allclose(alone.position, batch.position[:, i], rtol=0, atol=1e-13)
