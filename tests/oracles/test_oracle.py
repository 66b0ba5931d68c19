"""The solver against the oracle: what it answers closes, and it stops where the mechanism does.

Numbers come from `oracle`, which goes along joints with plain rotation matrices. More than a test
can try: `python tests/oracles/oracle.py --long SEED ...`.
"""

from __future__ import annotations

import argparse
import functools
from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, seed, settings
from oracle import (
    Array,
    Reached,
    closes,
    compared,
    gaps,
    placed,
    random_laws,
    random_motion,
    reach,
    units,
)
from random_mechanisms import Example, examples

import parakin
from parakin import Status
from parakin.kernel.backends import has_machine_code
from parakin.model.evaluation import graph_of
from parakin.motion.laws import from_laws, polynomial345

RIGHT = ("refused", "through", "singular", "end")
KEPT: dict[tuple[int, int], Example] = {}


def elsewhere(solver: parakin.Solver, position: Array, hand: Reached) -> float:
    """How far a pose (k,) is from where a hand stands, in units."""
    poses, _, _ = placed(solver, position[:, None])
    off = [0.0]
    for k, pose in hand.bodies.items():
        off += [np.abs(poses[k].R[0] - pose.R).max(), np.abs(poses[k].p[0] - pose.p).max()]
    for k, c in enumerate(solver.graph.coordinates):
        if c.name in hand.values:
            here = position[solver.coordinates.index(c.name)]
            off.append(abs(here - hand.values[c.name]) / units(solver)[k])
    return float(max(off))


def judged(solver: parakin.Solver, name: str, by: float, samples: int = 201) -> tuple[str, str]:
    """Drive one coordinate far, the others held, and say what became of it, and in numbers.

    "through", "singular" and "end" (the mechanism has none or the solver stops where it has) are
    right; "goes on", "ran past", "elsewhere" and "open" are not.
    """
    laws = {n: polynomial345(solver.home[n], by * (n == name), 1.0) for n in solver.driven}
    result = solver.solve(from_laws("far", laws, 1.0, samples - 1.0))
    position = result.position.transpose("coordinate", "time").values
    good = np.isin(result.status.values, (0, 5))
    if not closes(solver, position[:, good]).all():
        return "open", ""
    u = np.linspace(0.0, 1.0, samples)
    parts = u**3 * (10 - 15 * u + 6 * u * u)
    stop = samples if good.all() else int(np.argmin(good))
    low, high = parts[stop - 1], parts[min(stop, samples - 1)]
    end = min(1.0, high + 0.01)
    home = np.array([solver.home[n] for n in solver.driven])
    far = np.array([by * (n == name) for n in solver.driven])
    hand = reach(solver, lambda part: home + end * part * far)
    part = hand.part * end
    numbers = f"solver {low:.6f} to {high:.6f}, hand {part:.6f}, least {hand.least:.1e}"
    numbers += f", lowest {hand.lowest:.1e}"
    if part < low - 1e-4:
        return "ran past", numbers
    if stop == samples:
        off = elsewhere(solver, position[:, -1], hand)
        return ("through" if off < 1e-6 else "elsewhere"), f"{numbers}, off {off:.1e}"
    if part > high + 1e-4:
        return "goes on", f"{numbers}, status {int(result.status.values[stop])}"
    return ("singular" if hand.singular else "end"), numbers


# ---- single poses


def random_poses(
    solver: parakin.Solver, rng: np.random.Generator, count: int
) -> tuple[Array, Array]:
    """Driven values near home and far, and guesses near and far, whatever the mechanism."""
    home = np.array([solver.home[name] for name in solver.coordinates])
    of = dict(zip((c.name for c in solver.graph.coordinates), units(solver), strict=True))
    scales = np.array([of.get(name, 1.0) for name in solver.coordinates])
    rows = [solver.coordinates.index(name) for name in solver.driven]
    size = 10 ** rng.uniform(-3, 0.5, count)
    y = home[rows, None] + scales[rows, None] * size * rng.uniform(-1, 1, (len(rows), count))
    far = 10 ** rng.uniform(-3, 1.5, count) * rng.integers(0, 2, count)
    guess = home[:, None] + scales[:, None] * far * rng.normal(size=(len(home), count))
    return y, guess


def sprinkled(values: Array, rng: np.random.Generator, share: float = 0.03) -> Array:
    """With NaN and infinities in some columns."""
    spoilt = values.copy()
    for column in np.flatnonzero(rng.random(values.shape[1]) < share):
        spoilt[rng.integers(len(values)), column] = rng.choice([np.nan, np.inf, -np.inf])
    return spoilt


# ---- the campaign: mechanisms, and what becomes of them


def solvers(only: Sequence[str] = ()) -> Iterator[parakin.Solver]:
    """Every mechanism of the catalogue, driven as it says, and by its motors where as many do."""
    for name in only or parakin.catalogue():
        mechanism = parakin.load(name)
        motors = tuple(c.name for c in graph_of(mechanism).coordinates if c.actuated)
        for driven in dict.fromkeys((mechanism.driven, motors)):
            if len(driven) == len(mechanism.driven):
                try:
                    yield parakin.compile(mechanism, driven, coordinates="all")
                except parakin.DrivenError as error:
                    print(f"refused: {error}")


def far(example: Example, solver: parakin.Solver) -> tuple[str, float]:
    """A coordinate to drive, and how far: turns right round and more, slides several lengths."""
    name = example.driven[0]
    k = [c.name for c in solver.graph.coordinates].index(name)
    reach_ = 7.0 if solver.graph.coordinates[k].angle else 3.0 * solver.graph.length
    return name, float(np.copysign(reach_, example.by[0]))


def driven_far(example: Example, *, code: bool | None = None) -> tuple[str, str]:
    """What becomes of a random mechanism that is driven far: a verdict, and numbers."""
    try:
        solver = parakin.compile(
            example.mechanism, example.driven, coordinates="all", machine_code=code
        )
    except (parakin.AssemblyError, parakin.DrivenError):
        return "refused", ""
    return judged(solver, *far(example, solver))


def of_motions(seed_: int, motions: int, poses: int, only: Sequence[str]) -> Counter[str]:
    """Counts of samples, of motions and of single poses; prints what is not right."""
    rng = np.random.default_rng(seed_)
    total: Counter[str] = Counter()
    for solver in solvers(only):
        for number in range(motions):
            laws, n = random_laws(solver, rng), int(rng.integers(7, 302))
            found = compared(solver, laws, n)
            total.update(motions=1, samples=n, flagged=found.flagged)
            total.update(wrong=found.wrong, missed=found.missed)
            if found.first >= 0:
                print(f"{solver}: motion {number}, {found}")
        y, guess = random_poses(solver, rng, poses)
        y, guess = sprinkled(y, rng), sprinkled(guess, rng)
        tick = solver.at(y, guess=guess)
        good = np.asarray(tick.status) == 0
        rejected = int((~closes(solver, tick.position[:, good])).sum())
        total.update(poses=poses, solved=int(good.sum()), rejected=rejected)
        if rejected:
            print(f"{solver}: {rejected} poses do not close")
    return total


def of_mechanisms(seed_: int, count: int, code: bool | None = None) -> Counter[str]:
    """Verdicts on random mechanisms; prints those that are not right."""
    verdicts: Counter[str] = Counter()

    @seed(seed_)
    @settings(
        max_examples=count,
        deadline=None,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(examples())
    def one(example: Example) -> None:
        verdict, numbers = driven_far(example, code=code) if example.driven else ("refused", "")
        verdicts[verdict] += 1
        if verdict not in RIGHT:
            number = sum(verdicts.values())
            print(f"seed {seed_}, random mechanism {number}: {verdict}, {numbers}", flush=True)
            KEPT[seed_, number] = example

    one()
    return verdicts


def main() -> None:
    parser = argparse.ArgumentParser(description="Tries the solver against the oracle.")
    parser.add_argument("seeds", type=int, nargs="*", default=[0])
    parser.add_argument("--long", action="store_true", help="some minutes a seed")
    parser.add_argument("--only", nargs="*", default=[], help="mechanisms of the catalogue")
    parser.add_argument("--part", choices=("motions", "mechanisms"), help="one of the two")
    given_ = parser.parse_args()
    motions, poses, count = (20, 20_000, 300) if given_.long else (3, 2_000, 20)
    for number in given_.seeds:
        if given_.part != "mechanisms":
            found = of_motions(number, motions, poses, given_.only)
            print(f"seed {number}: {dict(found)}", flush=True)
        if given_.part != "motions":
            verdicts = of_mechanisms(number, count, False)
            print(f"seed {number}, random mechanisms: {dict(verdicts)}", flush=True)


# ---- tests

CATALOGUE = [name for name in parakin.catalogue() if name != "flight-simulator-upu"]  # a structure


@functools.cache
def compiled(name: str) -> tuple[parakin.Solver, ...]:
    return tuple(solvers([name]))


def rng_of(name: str, number: int) -> np.random.Generator:
    return np.random.default_rng([number, *name.encode()])


def check_alone(solver: parakin.Solver, y: Array, guess: Array | None) -> None:
    """Poses close or are flagged, and answer as they do without those that are no numbers."""
    tick = solver.at(y, guess=guess)
    status = np.asarray(tick.status)
    told = np.isfinite(y).all(axis=0)
    if guess is not None:
        told &= np.isfinite(guess).all(axis=0)
    assert (status[~told] != 0).all()
    good = (status == 0) | (status == Status.LIMIT_EXCEEDED)
    assert good.any()
    assert np.isnan(tick.position[:, ~good]).all()
    assert closes(solver, tick.position[:, good]).all()
    rows = [solver.coordinates.index(name) for name in solver.driven]
    np.testing.assert_allclose(tick.position[rows][:, good], y[:, good], rtol=0, atol=1e-12)
    # Iteration from far off magnifies the rounding in which one pose and a batch differ.
    for i in np.flatnonzero(good)[: 0 if solver.iterated else 20]:
        one = solver.at(y[:, i], guess=None if guess is None else guess[:, i])
        np.testing.assert_allclose(tick.position[:, i], one.position, rtol=0, atol=1e-11)
    alone = solver.at(y[:, told], guess=None if guess is None else guess[:, told])
    np.testing.assert_array_equal(status[told], alone.status)
    np.testing.assert_allclose(tick.position[:, told], alone.position, rtol=0, atol=1e-12)


def test_the_oracle_knows_right_from_wrong() -> None:
    for name in ("flight-simulator", "6-rus", "hexapod-on-3rps"):
        solver = compiled(name)[0]
        home = np.array([[solver.home[n]] for n in solver.coordinates])
        far, skew = gaps(solver, home)
        assert max(float(far[0]), float(skew[0])) < 1e-13
        for row, label in enumerate(solver.coordinates):
            off = home.copy()
            off[row] += 1e-6
            if not label.endswith(".cone"):
                assert sum(float(gap[0]) for gap in gaps(solver, off)) > 1e-8, label


def test_the_hand_stops_where_crank_and_rod_are_in_line() -> None:
    solver = parakin.compile("slider-crank", "D", coordinates="all", machine_code=False)
    a, b, aside = (solver.graph.parameters[name] for name in ("a", "b", "offset"))
    reach_of = {1.0: np.sqrt((a + b) ** 2 - aside**2), -1.0: np.sqrt((b - a) ** 2 - aside**2)}
    home = np.array([solver.home["D"]])
    for way, end in reach_of.items():
        hand = reach(solver, lambda part, way=way: home + way * part)  # type: ignore[misc]
        assert hand.singular
        assert abs(home[0] + way * hand.part - end) < 1e-7


@pytest.mark.parametrize("name", CATALOGUE)
def test_single_poses_close_or_are_flagged(name: str) -> None:
    for solver in compiled(name):
        rng = rng_of(name, 1)
        y, guess = random_poses(solver, rng, 2000)
        y, guess = sprinkled(y, rng), sprinkled(guess, rng)
        check_alone(solver, y, guess)
        check_alone(solver, y[:, :500], None)


@pytest.mark.parametrize("name", CATALOGUE)
def test_coarse_motions_end_where_fine_ones_do(name: str) -> None:
    for solver in compiled(name):
        rng = rng_of(name, 2)
        laws, n = random_laws(solver, rng), int(rng.integers(7, 302))
        found = compared(solver, laws, n)
        assert (found.wrong, found.missed) == (0, 0), found


@pytest.mark.parametrize("name", ["3-rps", "bricard", "five-bar", "flight-simulator", "6-rus"])
def test_windows_do_not_matter(name: str) -> None:
    for solver in compiled(name):
        motion = random_motion(solver, rng_of(name, 3), 151)
        whole = solver.solve(motion)
        for size in (1, 7, 100):
            parts = list(solver.stream(motion, size))
            status = np.concatenate([part.status.values for part in parts])
            np.testing.assert_array_equal(whole.status.values, status)
            position = np.concatenate(
                [part.position.transpose("coordinate", "time").values for part in parts], axis=1
            )
            there = whole.position.transpose("coordinate", "time").values
            np.testing.assert_allclose(there, position, rtol=0, atol=1e-12)


@pytest.mark.skipif(not has_machine_code(), reason="heyoka is not installed")
@pytest.mark.parametrize("name", ["four-bar", "bricard", "five-bar", "delta"])
def test_arrays_end_where_machine_code_does(name: str) -> None:
    for solver in compiled(name):
        arrays = parakin.compile(name, solver.driven, coordinates="all", machine_code=False)
        for number in range(3):
            motion = random_motion(solver, rng_of(name, 4 + number), 61)
            one, other = solver.solve(motion), arrays.solve(motion)
            np.testing.assert_array_equal(one.status.values, other.status.values)


def test_random_mechanisms_stop_where_a_slow_hand_does() -> None:
    verdicts = of_mechanisms(0, 6, False)
    assert set(verdicts) <= set(RIGHT), verdicts
    assert verdicts["through"] + verdicts["singular"] >= 3


if __name__ == "__main__":
    main()
