"""What must hold for any dimensions, any order of writing, any tree and any place in the world."""

from __future__ import annotations

import functools
import math

import numpy as np
import xarray as xr
from hypothesis import Phase, assume, example, given, settings
from hypothesis import strategies as st
from replays import replayed
from scipy.spatial.transform import Rotation

import parakin
from parakin.algebra.spatial import Pose
from parakin.model.bodies import Frame
from parakin.model.evaluation import graph_of
from parakin.model.expressions import Parameters
from parakin.model.mechanism import Joint, Mechanism
from parakin.model.placement import placement_of

PAPER = parakin.load("flight-simulator")
LENGTHS = [
    name
    for name in PAPER.parameters
    if not name.endswith("_star") and name != "steel"  # a density
]
CUTS = ["A1", "A2", "A3", "B1", "B3", "B4", "C1", "C4", "D1", "D2", "E1", "E2", "E2P"]
# Failures are not shrunk: an example compiles a solver, and shrinking takes minutes.
SLOW = settings(
    max_examples=25, deadline=None, derandomize=True, phases=[Phase.explicit, Phase.generate]
)


@functools.cache
def reference(*driven: str) -> tuple[parakin.Solver, xr.Dataset]:
    solver = parakin.compile(PAPER, driven or None, coordinates="all")
    if not driven:
        return solver, solver.solve(solver.motion("general", rate=40))
    return solver, solver.solve(replayed(reference()[1], driven))


def without_cones(result: xr.Dataset) -> list[str]:
    """All coordinates but cone angles, which have a kink at home."""
    return [n for n in result.coordinate.values.tolist() if not n.endswith(".cone")]


def assert_same(ours: xr.Dataset, theirs: xr.Dataset, names: list[str], bound: float) -> None:
    assert not ours.status.any()
    for quantity in ("position", "velocity", "acceleration"):
        difference = (ours[quantity] - theirs[quantity]).sel(coordinate=names)
        assert float(np.abs(difference).max()) < bound, quantity


@SLOW
@given(st.lists(st.floats(0.8, 1.2), min_size=len(LENGTHS), max_size=len(LENGTHS)))
def test_any_dimensions_that_assemble_close_their_loops(factors: list[float]) -> None:
    values = Parameters(PAPER.parameters).all()
    changed = {name: values[name] * f for name, f in zip(LENGTHS, factors, strict=True)}
    try:
        solver = parakin.compile(PAPER, parameters=changed, coordinates="all", machine_code=False)
    except (parakin.AssemblyError, parakin.DrivenError):
        assume(False)
    result = solver.solve(solver.motion("general", rate=40))
    good = (result.status == 0).values
    assert float(result.residual.max(skipna=True)) <= 1e-13 or not good.any()
    assert np.isfinite(result.position.values[good]).all()
    assert np.isnan(result.position.values[~good]).all()
    assert good[: int(good.sum())].all()  # what is solved comes first, and nothing after a flag


@SLOW
@given(st.permutations(PAPER.joints), st.permutations(PAPER.bodies))
def test_the_order_of_joints_and_bodies_does_not_matter(
    joints: list[Joint], bodies: list[parakin.Body]
) -> None:
    shuffled = PAPER.model_copy(update={"joints": tuple(joints), "bodies": tuple(bodies)})
    solver = parakin.compile(shuffled, coordinates="all", machine_code=False)
    result = solver.solve(solver.motion("general", rate=40))
    theirs = reference()[1]
    assert_same(result, theirs, without_cones(theirs), 1e-12)


@SLOW
@given(st.lists(st.sampled_from(CUTS), min_size=1, max_size=4, unique=True))
def test_the_joints_left_out_of_the_tree_do_not_matter(cut: list[str]) -> None:
    try:
        solver = parakin.compile(PAPER, coordinates="all", machine_code=False, cut=cut)
    except parakin.DrivenError as error:
        assert "cannot be left out" in str(error)
        assume(False)
    left_out = {solver.graph.joints[k].name for k in solver.plan.tree.cuts}
    assert set(cut) <= left_out
    result = solver.solve(solver.motion("general", rate=40))
    theirs = reference()[1]
    assert_same(result, theirs, without_cones(theirs), 1e-11)


def moved(mechanism: Mechanism, Q: Rotation, t: np.ndarray) -> Mechanism:
    """The same mechanism standing elsewhere: every frame on the base turned by Q, then moved."""
    values = Parameters(mechanism.parameters)

    def frame(joint: Joint) -> Frame:
        here: Pose = placement_of(joint.on_parent, values, joint.name)
        axes = Q.as_matrix() @ np.array(here.R)
        at = Q.apply(np.array(here.p)) + t
        return Frame(
            at=tuple(at.tolist()), axis=tuple(axes[:, 2].tolist()), x=tuple(axes[:, 0].tolist())
        )

    joints = tuple(
        j.model_copy(update={"on_parent": frame(j)}) if j.parent == "base" else j
        for j in mechanism.joints
    )
    return mechanism.model_copy(update={"joints": joints})


angles = st.floats(-math.pi, math.pi)


@SLOW
@given(st.tuples(angles, angles, angles), st.tuples(*[st.floats(-3, 3)] * 3))
@example((1.9, 1e-14, -math.pi), (-2.9, -2.2, 0.0))  # a row changes at home, but by rounding
def test_turning_and_moving_the_whole_mechanism_changes_nothing_relative(
    turn: tuple[float, float, float], shift: tuple[float, float, float]
) -> None:
    drives = ("A2", "B3", "C3")
    solver, theirs = reference(*drives)
    Q, t = Rotation.from_euler("ZXY", turn), np.array(shift)
    home = solver.home
    graph = solver.graph
    raw = {c.name: float(solver.plan.home[k]) for k, c in enumerate(graph.coordinates)}
    pose = Rotation.from_euler("ZXY", [raw[f"platform.{n}"] for n in ("psi", "phi", "theta")])
    euler = (Q * pose).as_euler("ZXY")
    assume(abs(abs(euler[1]) - math.pi / 2) > 0.05)  # phi, the middle angle, has a gimbal there
    place = Q.apply([home["platform.x"], home["platform.y"], raw["platform.z"]]) + t
    guess = {c.name: raw[c.name] for c in graph.coordinates if c.name.split(".")[0] != "platform"}
    guess |= dict(zip(("platform.x", "platform.y", "platform.z"), place.tolist(), strict=True))
    guess |= dict(zip(("platform.psi", "platform.phi", "platform.theta"), euler, strict=True))
    elsewhere = moved(PAPER, Q, t).model_copy(
        update={
            "home": {n: home[n] for n in drives},
            "guess": guess,
            "stated": {},
            "driven": drives,
        }
    )
    result = parakin.compile(elsewhere, coordinates="all", machine_code=False).solve(
        replayed(reference()[1], drives)
    )
    joints = [n for n in without_cones(theirs) if not n.startswith("platform")]
    assert_same(result, theirs, joints, 1e-10)


def test_the_graph_is_the_same_from_python_and_from_the_file() -> None:
    again = Mechanism(**{name: getattr(PAPER, name) for name in Mechanism.model_fields})
    assert graph_of(again) == graph_of(PAPER)
