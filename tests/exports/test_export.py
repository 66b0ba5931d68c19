"""Mechanisms written for other programs: what comes back when read, and what is refused."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from engines import MujocoTwin
from hypothesis import HealthCheck, Phase, given, settings
from literature import JACK
from random_mechanisms import Example, examples

import parakin
from parakin.analysis.mobility import mobility
from parakin.cli.main import main
from parakin.errors import AssemblyError, InputError
from parakin.exports import export as exports
from parakin.files.mechanism_toml import mechanism_from_table
from parakin.kinematics.assembly import assembled
from parakin.model.evaluation import graph_of
from parakin.model.mechanism import Mechanism

mujoco = pytest.importorskip("mujoco")

pytest.importorskip("lxml")

pytest.importorskip("yaml")

NAMES = parakin.catalogue()

SHAPES = ("model.xml", "model.urdf")


def back(mechanism: Mechanism, folder: Path, shape: str) -> Mechanism:
    """The mechanism, written and read again."""
    path, *loops = exports.export(mechanism, folder / shape)
    return parakin.load(path, loops=loops[0] if loops else None)


def home(mechanism: Mechanism) -> tuple[dict[str, float], int]:
    """Coordinates at home as their joints count, and the mobility."""
    graph = graph_of(mechanism)
    at = assembled(graph)
    values = dict(zip([c.name for c in graph.coordinates], at.q.tolist(), strict=True))
    return values, mobility(graph, at).home


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("name", NAMES)
def test_the_catalogue_comes_back(name: str, shape: str, tmp_path: Path) -> None:
    """With the same joints (but for rods, which come back as bodies), home and mobility."""
    mechanism = parakin.load(name)
    again = back(mechanism, tmp_path, shape)
    ours, theirs = home(mechanism), home(again)
    assert ours[1] == theirs[1]
    assert max(abs(value - theirs[0][n]) for n, value in ours[0].items()) < 1e-12
    kinds = {j.name: j.kind for j in mechanism.joints if j.kind != "rod"}
    assert kinds.items() <= {j.name: j.kind for j in again.joints}.items()
    actuated = {j.name for j in mechanism.joints if j.actuated}
    assert actuated == {j.name for j in again.joints if j.actuated}
    assert again.driven == tuple(n for n in again.driven if n.split(".")[0] in actuated)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("name", ["flight-simulator", "delta", "six-bar-watt", "tricept"])
def test_what_comes_back_moves_alike(name: str, shape: str, tmp_path: Path) -> None:
    mechanism = parakin.load(name)
    driven = [j.name for j in mechanism.joints if j.actuated]
    solvers = [
        parakin.compile(m, driven, machine_code=False)
        for m in (mechanism, back(mechanism, tmp_path, shape))
    ]
    rng = np.random.default_rng(0)
    move = 0.02 * solvers[0].graph.length * rng.uniform(-1, 1, (len(driven), 50))
    answers = []
    for solver in solvers:
        start = np.array([[solver.home[n]] for n in driven])
        tick = solver.at(start + move)
        assert not np.any(tick.status)
        names = [n for n in solvers[0].coordinates if n in solver.coordinates]
        rows = [solver.coordinates.index(n) for n in names]
        offsets = np.array([[solver.home[n]] for n in names])
        answers.append(tick.position[rows] - offsets)
    assert len(answers[0]) >= len(driven)
    # (Two plans, each closed to 1e-12 of a length, at moves of up to 60 mm and 0.06 rad.)
    np.testing.assert_allclose(answers[0][: len(answers[1])], answers[1], rtol=0, atol=1e-10)


def test_screws_go_out_and_come_back(tmp_path: Path) -> None:
    """A jack: its screw is a hinge and a slide that are coupled. One turn in MuJoCo is one here."""
    mechanism = mechanism_from_table(tomllib.loads(JACK), "jack")
    solver = parakin.compile(mechanism, machine_code=False)
    twin = MujocoTwin(
        mujoco.MjModel.from_xml_path(str(exports.export(mechanism, tmp_path / "jack.xml")[0]))
    )
    guess = np.array([solver.home[n] for n in solver.coordinates])
    for turn in np.linspace(0.0, 2 * math.pi, 9):
        tick = solver.at([solver.home["H"] + turn], guess=guess)
        guess = tick.position
        twin.solve({"H": solver.home["H"] + turn}, {"H": 0.0}, {"H": 0.0})
        for name, value in zip(solver.coordinates, tick.position, strict=True):
            assert abs(twin.data.qpos[twin.place(name)] - value) < 1e-10, name
    for shape in SHAPES:
        again = back(mechanism, tmp_path, shape)
        ours, theirs = home(mechanism)[0], home(again)[0]
        assert {j.name: j.kind for j in again.joints}["H"] == "helical"
        assert max(abs(value - theirs[n]) for n, value in ours.items()) < 1e-9


@given(examples())
@settings(
    max_examples=25,
    deadline=None,
    derandomize=True,
    database=None,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=list(HealthCheck),
)
def test_random_mechanisms_come_back(
    tmp_path_factory: pytest.TempPathFactory, example: Example
) -> None:
    folder = tmp_path_factory.mktemp("random")
    try:
        ours = home(example.mechanism)
    except AssemblyError:
        return
    for shape in SHAPES:
        theirs = home(back(example.mechanism, folder, shape))
        assert ours[1] == theirs[1], shape
        common = ours[0].keys() & theirs[0].keys()
        turns = [(ours[0][n] - theirs[0][n]) / (2 * math.pi) for n in common]
        assert max(abs(t - round(t)) for t in turns) < 1e-9, shape


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("delta", "model.txt"), "'.txt'; expected .xml (MJCF), .urdf or .c"),
        (("delta", "model"), "no suffix"),
        (("delta", "no/model.xml"), "no such file or directory"),
        (("delta", "model.xml", "--driven", "A1"), "a model leaves open what is driven"),
        (("delta", "model.c", "--driven", "A9"), "unknown coordinate 'A9'"),
        (("delta", "model.xml", "--loops", "a.yaml"), "a URDF; other files contain their loops"),
    ],
)
def test_exports_that_mean_nothing_are_refused(
    arguments: tuple[str, ...],
    said: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["export", *arguments]) == 2
    assert said in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_an_export_that_fails_leaves_the_old_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Several files are written whole, all of them or none."""
    for name in ("k.c", "k.h", "k_test.c"):
        (tmp_path / name).write_text("old")
    write: Callable[..., int] = Path.write_text

    def failing(self: Path, *arguments: str, **named: str) -> int:
        if self.suffix == ".h":
            raise OSError(28, "No space left on device")
        return write(self, *arguments, **named)

    monkeypatch.setattr(Path, "write_text", failing)
    with pytest.raises(InputError):
        exports.export(parakin.load("four-bar"), tmp_path / "k.c")
    assert [p.read_text() for p in tmp_path.iterdir()] == ["old"] * 3
