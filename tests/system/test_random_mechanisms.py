"""Random closed mechanisms: solved rightly, flagged, or refused with a reason, never wrong unsaid.

Failures are not shrunk: every example compiles solvers, and shrinking takes minutes.
"""

from __future__ import annotations

import re
import warnings

import numpy as np
import pytest
import xarray as xr
from closed_form import MP, Jet, jet
from hypothesis import HealthCheck, Phase, event, given, settings
from jets import jet_functions
from random_mechanisms import Example, closed_by, examples
from replays import replayed

import parakin
from parakin.kernel.backends import has_machine_code
from parakin.kernel.outputs import Outputs
from parakin.kernel.pose import solve_pose
from parakin.motion.laws import from_laws, polynomial345

REASONS = (
    r"driven .*(depend on one another|cannot move|not determined|the mobility is)",
    r"joints of the driven coordinates form a closed loop",
    r"every joint of the loop of \w+ is helical or driven",
    r"home is singular for these driven coordinates",
    r"(undetermined|cannot be assembled|axes opposed)",
    r"no driven coordinates are given",
)
SAMPLES = 60


def settled(count: int) -> settings:
    return settings(
        max_examples=count,
        deadline=None,
        derandomize=True,
        database=None,
        phases=[Phase.explicit, Phase.generate],
        suppress_health_check=list(HealthCheck),
    )


def compiled(
    example: Example, driven: tuple[str, ...], *, code: bool = False
) -> parakin.Solver | None:
    """The solver, or none where it is refused with a reason."""
    try:
        return parakin.compile(
            example.mechanism, driven, coordinates="all", derivatives=3, machine_code=code
        )
    except (parakin.AssemblyError, parakin.DrivenError) as error:
        assert any(re.search(reason, str(error)) for reason in REASONS), str(error)
        assert "\n" not in str(error)
        event(f"refused ({'bad' if example.bad else 'good'} choice)")
        return None


def numbers(result: xr.Dataset, quantity: str) -> dict[str, np.ndarray]:
    """By coordinate. Cone angles are left out: their rates are not defined where they are zero."""
    names = [n for n in result.coordinate.values.tolist() if not n.endswith(".cone")]
    return {n: result[quantity].sel(coordinate=n).values for n in names}


def moved(example: Example, solver: parakin.Solver) -> xr.Dataset:
    laws = {
        n: polynomial345(solver.home[n], by, 1.0)
        for n, by in zip(example.driven, example.by, strict=True)
    }
    return solver.solve(from_laws("random", laws, 1.0, SAMPLES - 1.0))


def check_samples(example: Example, solver: parakin.Solver, result: xr.Dataset) -> np.ndarray:
    good = np.asarray(result.status.values == 0)
    assert good[0]  # home itself
    q, v, a = (numbers(result, name) for name in ("position", "velocity", "acceleration"))
    for values in (q, v, a):
        table = np.array(list(values.values()))
        assert np.isfinite(table[:, good]).all()
        assert np.isnan(table[:, ~good]).all()
    assert float(result.residual.values[good].max()) <= 1e-12 * solver.graph.length
    held = {name: values[good] for name, values in q.items()}
    # The same by SciPy's rotations, all coordinates and all joints taken at their word.
    assert float(closed_by(example.mechanism, held).max()) < 1e-11 * max(1.0, solver.graph.length)
    # Nothing jumps to another branch: steps are what velocities and accelerations make of them,
    # unless a singularity is so near that they change too much from one sample to the next.
    h = np.diff(result.time.values[good])
    Q, V, A = (np.array(list(values.values()))[:, good] for values in (q, v, a))
    expected = h * (V[:, 1:] + V[:, :-1]) / 2 - h**2 * (A[:, 1:] - A[:, :-1]) / 12
    off = np.abs(np.diff(Q) - expected).max(axis=0)
    sure = np.minimum.accumulate(result.conditioning.values[good])[1:] > 0.03
    assert (off <= 0.5 * np.abs(h * V[:, 1:]).max(axis=0) + 1e-3)[sure].all()
    return good


def check_rates(solver: parakin.Solver, result: xr.Dataset, i: int) -> None:
    """One sample's rates against automatic differentiation of its positions."""
    orders = ("position", "velocity", "acceleration", "jerk")
    q, v, a, j = (numbers(result, name) for name in orders)
    coordinates = solver.graph.coordinates
    drives = [Jet(*(MP.mpf(float(of[n][i])) for of in (q, v, a, j))) for n in solver.driven]
    started = [Jet(MP.mpf(float(q[coordinates[k].name][i]))) for k in solver.plan.iterated]
    outputs = Outputs(tuple(range(len(coordinates))), derivatives=0, checks=False)
    found = solve_pose(solver.plan, [drives], started, jet_functions(), outputs, 3)
    exact = {c.name: jet(x) for c, x in zip(coordinates, found, strict=True)}
    for ours, part in ((v, "rate"), (a, "accel"), (j, "jerk")):
        size = max(1.0, *(abs(float(values[i])) for values in ours.values()))
        for name, values in ours.items():
            difference = abs(float(values[i]) - float(getattr(exact[name], part)))
            assert difference <= 1e-9 * size, (name, part, difference, size)


def check_inverse(example: Example, result: xr.Dataset, good: np.ndarray, *, code: bool) -> None:
    """The motion as another choice of driven coordinates sees it is the same motion."""
    other = compiled(example, example.other, code=code)
    if other is None:
        return
    again = other.solve(replayed(result.isel(time=good), example.other))
    # The two lose what digits their conditioning takes.
    fine = (again.status.values == 0) & (again.conditioning.values > 1e-3)
    fine &= result.conditioning.values[good] > 1e-3
    event("inverse: " + ("all" if fine.all() else "some" if fine.any() else "none"))
    first, second = numbers(result, "position"), numbers(again, "position")
    for name, values in second.items():
        difference = np.abs(values - first[name][good])[fine]
        assert difference.max(initial=0.0) <= 1e-9, name


def check(example: Example, *, code: bool) -> None:
    if not example.driven:
        event("a structure")
        with pytest.raises(parakin.DrivenError, match="no driven coordinates"):
            parakin.compile(example.mechanism, (), machine_code=False)
        return
    solver = compiled(example, example.driven, code=code)
    if solver is None:
        return
    for name, value in example.home.items():
        assert abs(solver.home[name] - value) < 1e-9, name
    result = moved(example, solver)
    good = check_samples(example, solver, result)
    event("solved " + ("throughout" if good.all() else "up to a flag"))
    trusted = np.flatnonzero(good & (result.conditioning.values > 1e-2))
    if len(trusted):
        check_rates(solver, result, int(trusted[len(trusted) // 2]))
    if not example.bad:
        check_inverse(example, result, good, code=code)


@settled(45)
@given(examples())
def test_random_mechanisms_are_solved_flagged_or_refused(example: Example) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check(example, code=False)


@pytest.mark.skipif(not has_machine_code(), reason="heyoka is not installed")
@settled(6)
@given(examples())
def test_random_mechanisms_in_machine_code(example: Example) -> None:
    check(example, code=True)
