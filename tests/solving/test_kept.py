"""Solvers from the user's cache are, to the last bit, those that are compiled."""

from __future__ import annotations

import os
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from linkage import process

import parakin
from parakin.files import keeping
from parakin.kernel.backends import has_machine_code
from parakin.motion.laws import from_laws, polynomial345
from parakin.solving import kept
from parakin.solving.tracking import Track

pytestmark = pytest.mark.skipif(not has_machine_code(), reason="heyoka is not installed")


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache of the test's own."""
    folder = tmp_path / "kept"
    monkeypatch.setenv(keeping.VARIABLE, str(folder))
    return folder


@pytest.fixture
def hits(monkeypatch: pytest.MonkeyPatch) -> Callable[[], int]:
    """How many solvers came from the cache."""
    found: list[bool] = []
    find = kept.found

    def counted(*arguments: object) -> object:
        made = find(*arguments)  # type: ignore[arg-type]
        found.append(made is not None)
        return made

    monkeypatch.setattr(kept, "found", counted)
    return lambda: sum(found)


def twice(name: str, **options: object) -> tuple[parakin.Solver, parakin.Solver]:
    """Compiled, and from the cache."""
    return (
        parakin.compile(name, **options),  # type: ignore[arg-type]
        parakin.compile(name, **options),  # type: ignore[arg-type]
    )


def same_answers(fresh: parakin.Solver, cached: parakin.Solver) -> None:
    rng = np.random.default_rng(0)
    home = np.array([fresh.home[name] for name in fresh.driven])[:, None]
    inputs = [home + rng.uniform(-0.1, 0.1, (len(home), 50)), *rng.normal(size=(2, len(home), 50))]
    assert fresh.coordinates == cached.coordinates
    assert fresh.home == cached.home
    for ours, theirs in zip(fresh.at(*inputs), cached.at(*inputs), strict=True):
        if isinstance(ours, np.ndarray):
            assert ours.tobytes() == np.asarray(theirs).tobytes()
    one = [rows[:, 0] for rows in inputs]
    assert fresh.at(*one).position.tobytes() == cached.at(*one).position.tobytes()


@pytest.mark.parametrize(
    "name", ["flight-simulator", "gough-stewart", "delta", "3-rrr", "bennett", "six-bar-watt"]
)
def test_answers_are_the_same_to_the_last_bit(
    name: str, place: Path, hits: Callable[[], int]
) -> None:
    fresh, cached = twice(name, coordinates="all")
    assert (hits(), len(list(place.iterdir()))) == (1, 1)
    same_answers(fresh, cached)


def test_a_solver_that_iterates(place: Path, hits: Callable[[], int]) -> None:
    legs = [f"P{k}" for k in range(1, 7)]
    fresh, cached = twice("gough-stewart", driven=legs)
    assert hits() == 1
    same_answers(fresh, cached)


@pytest.mark.parametrize(
    ("name", "motion"), [("flight-simulator", "general"), ("seat-3dof", "sway"), ("delta", "pick")]
)
def test_motions_bodies_and_forces(
    name: str, motion: str, place: Path, hits: Callable[[], int]
) -> None:
    fresh, cached = twice(name)
    assert hits() == 1
    asked = {"bodies": True, "forces": True, "reactions": True, "indeterminate": "minimum-norm"}
    ours, theirs = (s.solve(motion, **asked) for s in (fresh, cached))  # type: ignore[arg-type]
    assert "effort" in ours
    assert ours.identical(theirs)


def test_a_motion_on_which_charts_are_exchanged(
    place: Path, hits: Callable[[], int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The wrist turns through where the angles of the platform lock."""
    used: set[int] = set()
    solve = Track.solve

    def watched(self: Track, *arguments: Any, **named: Any) -> Any:
        pieces, status = solve(self, *arguments, **named)
        used.update(id(piece.chart) for piece in pieces)
        return pieces, status

    monkeypatch.setattr(Track, "solve", watched)
    wrist = ["W1", "W2", "W3", "A1", "A2", "A3"]
    fresh, cached = twice("wrist-on-delta", driven=wrist, coordinates="all")
    assert hits() == 1
    by = {name: polynomial345(fresh.home[name], 2.0 * (name == "W2"), 1.0) for name in wrist}
    motion = from_laws("straight", by, 1.0, 50.0)
    ours, theirs = (solver.solve(motion) for solver in (fresh, cached))
    assert ours.identical(theirs)
    assert len(used) > 2


def test_other_options_are_other_solvers(place: Path, hits: Callable[[], int]) -> None:
    parakin.compile("five-bar")
    for options in (
        {"derivatives": 1},
        {"checks": False},
        {"coordinates": "all"},
        {"parameters": {next(iter(parakin.load("five-bar").parameters)): "0.21 m"}},
        {"driven": parakin.load("five-bar").driven[::-1]},
    ):
        parakin.compile("five-bar", **options)
        assert hits() == 0, options
    assert len(list(place.iterdir())) == 6
    assert parakin.compile("five-bar", derivatives=1).derivatives == 1
    assert hits() == 1


def test_what_is_not_kept(place: Path) -> None:
    """NumPy has no code, and modes and open designs more than one plan."""
    parakin.compile("five-bar", machine_code=False)
    parakin.compile("five-bar", near=dict(parakin.compile("five-bar", machine_code=False).home))
    parakin.compile("five-bar", free=list(parakin.load("five-bar").parameters)[:1])
    assert not place.exists()


def test_a_solver_from_the_cache_is_pickled_as_any(place: Path, hits: Callable[[], int]) -> None:
    fresh, cached = twice("five-bar")
    assert hits() == 1
    assert pickle.dumps(cached) == pickle.dumps(fresh)
    same_answers(fresh, pickle.loads(pickle.dumps(cached)))
    other = cached.with_design({next(iter(cached.mechanism.parameters)): "0.21 m"})
    assert other.home != cached.home


def test_another_process_finds_it_and_answers_the_same(place: Path) -> None:
    script = (
        "import numpy, parakin, sys; from parakin.solving import kept\n"
        "find = kept.found; kept.found = lambda *a: print(k := find(*a), file=sys.stderr) or k\n"
        "s = parakin.compile('flight-simulator')\n"
        "tick = s.at([s.home[n] + 0.01 for n in s.driven], [1, 2, 3], [4, 5, 6])\n"
        "print(*(a.tobytes().hex() for a in tick[:3]))"
    )
    first, second, other = (
        process("-c", script, PYTHONHASHSEED=seed, PARAKIN_CACHE=where)
        for seed, where in (("1", str(place)), ("2", str(place)), ("3", "off"))
    )
    assert first.returncode == second.returncode == 0, first.stderr + second.stderr
    assert first.stdout == second.stdout == other.stdout
    assert first.stderr.strip() == "None"
    assert second.stderr.startswith("Kept(")
    assert len(list(place.iterdir())) == 1


def test_what_cannot_be_unpickled_is_compiled(place: Path, hits: Callable[[], int]) -> None:
    mechanism = parakin.load("five-bar")
    fresh = parakin.compile(mechanism)
    asked = fresh.driven, None, 2, True, (), None
    key = kept.key_of(mechanism, *asked)
    assert key is not None
    for content in (b"", b"no pickle", pickle.dumps(7), pickle.dumps((1, 2, 3, 4, b""))):
        keeping.keep(key, content)
        again = parakin.compile(mechanism)
        assert hits() == 0
        same_answers(fresh, again)
    parakin.compile(mechanism)
    assert hits() == 1


def test_a_folder_that_cannot_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "file"
    file.write_text("mine")
    monkeypatch.setenv(keeping.VARIABLE, str(file))
    fresh, again = twice("five-bar")
    same_answers(fresh, again)
    assert file.read_text() == "mine"


def test_equal_texts_mean_equal_values() -> None:
    values: list[object] = [
        None,
        False,
        0,
        0.0,
        -0.0,
        "0",
        "",
        (),
        [],
        {},
        (1,),
        [1],
        ("a", "b"),
        ("a, b",),
    ]
    values += [{"a": 1, "b": 2}, {"b": 2, "a": 1}, np.float64(0.0), ((1,), 2), (1, (2,))]
    assert len({kept._told(value) for value in values}) == len(values)
    with pytest.raises(TypeError):
        kept._told(object())


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no forks here")
def test_a_forked_child_uses_a_solver_from_the_cache(place: Path) -> None:
    script = (
        "import numpy, os, parakin\n"
        "parakin.compile('five-bar'); s = parakin.compile('five-bar')\n"
        "y = numpy.repeat([[s.home[n]] for n in s.driven], 20_000, axis=1)\n"
        "expected = s.at(y, parallel=True).position.tobytes()\n"
        "if os.fork() == 0:\n"
        "    os._exit(s.at(y, parallel=True).position.tobytes() != expected)\n"
        "print(os.wait()[1])"
    )
    done = process("-W", "ignore", "-c", script, PARAKIN_CACHE=str(place))
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "0"
