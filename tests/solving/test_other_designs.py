"""Poses of other designs, against solvers compiled for these."""

from __future__ import annotations

import pickle
from collections.abc import Mapping

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import parakin
from parakin import InputError, Solver, Status, Tick

LEGS = [f"P{i}" for i in range(1, 7)]
SIZES = {"r_base": 1.3, "r_platform": 0.62, "a_base": 0.2, "height": 1.18, "stroke_0": 0.9}


def thrown(solver: Solver, n: int, size: float = 0.02) -> list[np.ndarray]:
    """Positions around home, rates and second rates, (k, n) each."""
    rng = np.random.default_rng(5)
    units = [
        1.0 if c.angle else solver.graph.length
        for c in (solver.graph.coordinates[k] for k in solver.plan.driven)
    ]
    home = np.array([[solver.home[name]] for name in solver.driven])
    y = home + size * np.array(units)[:, None] * rng.uniform(-1, 1, (len(home), n))
    return [y, 0.1 * rng.normal(size=y.shape), rng.normal(size=y.shape)]


def statuses(tick: Tick) -> np.ndarray:
    return np.asarray(tick.status)


def assert_alike(found: Tick, anew: Tick, tolerance: float = 1e-13) -> None:
    """Alike to a tolerance over the conditioning, for each order once more."""
    np.testing.assert_array_equal(found.status, anew.status)
    over = np.maximum(np.atleast_1d(np.abs(anew.conditioning)), 1e-6)
    orders = ("position", "velocity", "acceleration")
    for power, quantity in enumerate(orders, start=1):
        a, b = getattr(found, quantity), getattr(anew, quantity)
        size = 1.0 + np.nanmax(np.abs(b), axis=0, initial=0.0)
        off = np.abs(a - b) / size
        np.testing.assert_array_equal(np.isnan(a), np.isnan(b))
        assert np.nanmax(off * over**power, initial=0.0) < tolerance, quantity


# What closes a paradoxical loop ties its dimensions together; these may vary one by one.
_TIED = {"bennett": ("a", "alpha", "beta"), "bricard": ("a",)}
_NAMES = sorted({*parakin.catalogue()} - {"flight-simulator-upu"})  # whose driven can hardly move


@pytest.mark.parametrize("name", _NAMES)
def test_every_mechanism_of_the_catalogue_as_if_made_anew(name: str) -> None:
    mechanism = parakin.load(name)
    free = _TIED.get(name, tuple(mechanism.parameters)[:12])
    solver = parakin.compile(mechanism, free=free, machine_code=False)
    rng = np.random.default_rng(1)
    own = solver.designs.designs.own
    for _ in range(2):
        away = own + 0.01 * rng.uniform(-1, 1, len(own)) * np.where(own, np.abs(own), 0.05)
        design = dict(zip(free, away.tolist(), strict=True))
        anew = parakin.compile(mechanism, parameters=design, machine_code=False)
        motion = thrown(anew, 20)
        assert_alike(solver.at(*motion, parameters=design), anew.at(*motion), 3e-13)


@pytest.mark.parametrize("driven", [None, LEGS])
def test_a_hexapod_as_if_made_anew(driven: list[str] | None, reading: bool) -> None:
    solver = parakin.compile(
        "gough-stewart", driven, free=[*SIZES], coordinates="all", machine_code=reading
    )
    anew = parakin.compile(
        "gough-stewart", driven, parameters=SIZES, coordinates="all", machine_code=reading
    )
    motion = thrown(anew, 40, 0.01)
    found, other = solver.at(*motion, parameters=SIZES), anew.at(*motion)
    for quantity in ("position", "velocity"):
        a, b = getattr(found, quantity), getattr(other, quantity)
        np.testing.assert_allclose(a, b, rtol=1e-11, atol=1e-11)
    assert not np.any(found.status)


def test_coordinates_counted_from_home_are_counted_from_the_home_of_the_design() -> None:
    own = parakin.compile("flight-simulator", free=["l2", "d4", "h"], machine_code=False)
    values = own.designs.designs.own * [1.02, 0.99, 1.01]
    sizes = dict(zip(own.free, values.tolist(), strict=True))
    solver = parakin.compile("flight-simulator", free=[*sizes])
    anew = parakin.compile("flight-simulator", parameters=sizes)
    assert "platform.psi" in anew.mechanism.from_home
    assert anew.plan.own_home[solver.graph.index("platform.psi", "")] != pytest.approx(
        solver.plan.own_home[solver.graph.index("platform.psi", "")], abs=1e-6
    )
    motion = thrown(anew, 20)
    assert_alike(solver.at(*motion, parameters=sizes), anew.at(*motion))


def designs_of(n: int) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(8)
    return {name: value * rng.uniform(0.95, 1.05, n) for name, value in SIZES.items()}


@pytest.mark.parametrize("driven", [None, LEGS])
def test_a_batch_of_designs_gives_what_single_designs_give(
    driven: list[str] | None, reading: bool
) -> None:
    solver = parakin.compile("gough-stewart", driven, free=[*SIZES], machine_code=reading)
    y = thrown(solver, 6, 0.01)[0]
    many = designs_of(6)
    many["r_base"][2] = np.nan
    many["r_platform"][4] = 40.0
    together = solver.at(y, parameters=many)
    assert statuses(together)[2] != 0
    assert (statuses(together)[4] != 0) == (driven is not None)  # no legs are that short
    for k in (1, 2, 4):
        alone = solver.at(y[:, k], parameters={name: v[k] for name, v in many.items()})
        assert alone.status == statuses(together)[k]
        np.testing.assert_array_equal(alone.position, together.position[:, k])
        np.testing.assert_array_equal(alone.velocity, together.velocity[:, k])
    np.testing.assert_array_equal(
        solver.at(y[:, 1], parameters=many).position[:, 3],
        solver.at(y[:, 1], parameters={name: v[3] for name, v in many.items()}).position,
    )


def test_a_guess_leads_to_the_same_pose() -> None:
    solver = parakin.compile("gough-stewart", LEGS, free=[*SIZES], machine_code=False)
    y = thrown(solver, 5, 0.005)[0]
    first = solver.at(y, parameters=SIZES)
    assert not np.any(first.status)
    again = solver.at(y, guess=first, parameters=SIZES)
    np.testing.assert_allclose(again.position, first.position, atol=1e-13)


def test_the_own_design_is_the_default() -> None:
    solver = parakin.compile("gough-stewart", free=["r_base", "height"], machine_code=False)
    motion = thrown(solver, 10)
    assert_alike(solver.at(*motion, parameters={}), solver.at(*motion))


def test_lengths_may_be_given_with_units() -> None:
    solver = parakin.compile("gough-stewart", free="r_base", machine_code=False)
    home = [solver.home[k] for k in solver.driven]
    a = solver.at(home, parameters={"r_base": "1300 mm"})
    b = solver.at(home, parameters={"r_base": 1.3})
    np.testing.assert_allclose(a.position, b.position, rtol=1e-15)


def linkage(**parameters: float) -> dict[str, float]:
    return {"a": 0.04, "b": 0.12, "c": 0.08, "d": 0.1} | parameters


@pytest.mark.parametrize(
    ("design", "closes"),
    [
        (linkage(), True),
        (linkage(a=0.05, d=0.11), True),
        (linkage(b=0.5), False),  # longer than all others together
        (linkage(d=0.4), False),
        (linkage(a=np.nan), False),
        (linkage(c=np.inf), False),
    ],
)
def test_a_design_that_does_not_close_is_flagged(
    design: Mapping[str, float], closes: bool, reading: bool
) -> None:
    solver = parakin.compile("four-bar", free=["a", "b", "c", "d"], machine_code=reading)
    tick = solver.at([0.7], parameters=design)
    assert (tick.status == Status.CONVERGED) is closes
    assert np.isfinite(tick.position).all() == closes
    assert tick.why().startswith("no such design from home: ") is not closes


@settings(
    max_examples=40,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(st.tuples(*[st.floats(0.5, 1.6)] * 4), st.floats(-3.0, 3.0))
def test_a_four_bar_is_solved_or_flagged(
    four_bars: Solver, by: tuple[float, ...], angle: float
) -> None:
    """Against the triangle that coupler and rocker make."""
    a, b, c, d = (size * x for size, x in zip((0.04, 0.12, 0.08, 0.1), by, strict=True))
    tick = four_bars.at([angle], parameters={"a": a, "b": b, "c": c, "d": d})
    x, y = a * np.cos(angle) - d, a * np.sin(angle)  # the coupler's start from the rocker's pivot
    cosine = (x * x + y * y + c * c - b * b) / (2.0 * c * np.hypot(x, y))
    if tick.status != 0:
        return
    assert abs(cosine) <= 1.0 + 1e-9
    rocker = np.arctan2(y, x) - np.arccos(np.clip(cosine, -1.0, 1.0))  # open, not crossed
    off = np.angle(np.exp(1j * (float(tick.value("D")) - rocker)))
    assert abs(off) < 1e-7


@pytest.fixture(scope="module")
def four_bars() -> Solver:
    return parakin.compile("four-bar", free=["a", "b", "c", "d"], machine_code=False)


def test_a_design_beyond_a_singularity_is_not_reached_through_it() -> None:
    """At home the crank points at 40°. Where the coupler has grown to reach from its end past the
    rocker's pivot to the rocker's end the linkage is flat there; a longer one has no home.
    """
    solver = parakin.compile("four-bar", free=["b"], machine_code=False)
    a, c, d, angle = 0.04, 0.08, 0.1, np.radians(40.0)
    flat = c + np.hypot(d - a * np.cos(angle), a * np.sin(angle))
    b = flat * (1.0 + np.array([-1e-3, -1e-6, 1e-9, 1e-3]))
    tick = solver.at(np.full((1, 4), angle), parameters={"b": b})
    assert (statuses(tick)[:2] == 0).all()
    assert (statuses(tick)[2:] != 0).all()


def test_limits_are_those_of_the_design() -> None:
    mechanism = parakin.load("gough-stewart")
    reach = {f"P{i}": ["0.9*stroke_0 - 1", "0.5*stroke_0"] for i in range(1, 7)}
    mechanism = mechanism.model_copy(update={"limits": reach})
    solver = parakin.compile(mechanism, free=["stroke_0"], machine_code=False)
    y = [0.0, 0.0, 1.25, 0.0, 0.0, 0.0]
    own = solver.at(y)
    strokes = np.array([0.9, 1.0, 1.2])
    ticks = solver.at(y, parameters={"stroke_0": strokes})
    length = own.value("P1") + 1.0
    beyond = length - strokes > 0.5 * strokes
    assert beyond.any()
    assert not beyond.all()
    np.testing.assert_array_equal(statuses(ticks) == Status.LIMIT_EXCEEDED, beyond)
    excess = length - 1.5 * strokes
    np.testing.assert_allclose(np.asarray(ticks.excess)[beyond], excess[beyond], atol=1e-12)
    assert ticks.why(0)[2:] == f" at {length - 0.9:.3f} m, limit 0.450 m"
    alone = solver.at(y, parameters={"stroke_0": 0.9})
    assert alone.why() == ticks.why(0)
    # A range that is none is no design.
    assert solver.at(y, parameters={"stroke_0": 4.0}).status == Status.OUT_OF_REACH


def test_a_solver_goes_to_other_processes_with_what_it_leaves_open() -> None:
    solver = parakin.compile("four-bar", free=["b"], machine_code=False)
    again = pickle.loads(pickle.dumps(solver))  # our own
    assert again.free == ("b",)
    tick = again.at([0.7], parameters={"b": 0.13})
    np.testing.assert_array_equal(tick.position, solver.at([0.7], parameters={"b": 0.13}).position)


def test_a_solver_of_positions_alone_without_checks() -> None:
    solver = parakin.compile(
        "gough-stewart", free=["r_base"], derivatives=0, checks=False, machine_code=False
    )
    y = [solver.home[k] for k in solver.driven]
    tick = solver.at(y, parameters={"r_base": np.array([1.1, np.nan])})
    assert statuses(tick).tolist() == [0, Status.OUT_OF_REACH]
    assert np.isfinite(tick.position[:, 0]).all()
    assert np.isnan(tick.position[:, 1]).all()


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ({"r_base": "1 kg"}, r"parameters.r_base: found '1 kg'"),
        ({"r_bas": 1.0}, "a parameter that is not left open"),
        ({"height": 1.0}, "a parameter that is not left open"),
        ({"r_base": [1.0, 2.0]}, "2 designs, 3 poses"),
        ({"r_base": [[1.0, 2.0]]}, "numbers, or arrays of one length"),
        ({"r_base": [1.0, 2.0], "a_base": [0.1, 0.2, 0.3]}, "arrays of one length"),
        ({"r_base": object()}, "expected numbers"),
    ],
)
def test_parameters_are_checked(parameters: dict[str, object], words: str) -> None:
    solver = parakin.compile("gough-stewart", free=["r_base", "a_base"], machine_code=False)
    with pytest.raises(InputError, match=words):
        solver.at(np.zeros((6, 3)), parameters=parameters)  # type: ignore[arg-type]


def test_what_cannot_be_had_is_refused() -> None:
    with pytest.raises(InputError, match="a solver of one design"):
        parakin.compile("four-bar", machine_code=False).at([0.7], parameters={"b": 0.1})
    with pytest.raises(InputError, match="another mode, with parameters left open"):
        parakin.compile("four-bar", free="b", near={"A": 0.7, "D": -1.0}, machine_code=False)
    hexapod = parakin.compile("gough-stewart", free=["r_base"], machine_code=False)
    with pytest.raises(InputError, match="forces of another design"):
        hexapod.at(np.zeros(6), parameters={"r_base": 1.0}, forces=True)


def test_a_design_on_whose_way_the_solvers_own_plan_is_singular_is_flagged_or_right() -> None:
    """The file's home gives the crank; this solver is driven by the rocker, which stands still at
    an end of its swing.
    """
    solver = parakin.compile("four-bar", "D", free=["a", "b", "c", "d"], coordinates="all")
    rng = np.random.default_rng(0)
    sizes = np.array([0.04, 0.12, 0.08, 0.1])[:, None] * rng.uniform(0.5, 1.6, (4, 40))
    right = 0
    for column in sizes.T.tolist():
        design = dict(zip("abcd", column, strict=True))
        try:
            anew = parakin.compile("four-bar", "D", parameters=design, machine_code=False)
        except parakin.ParakinError:
            continue
        y = [anew.home["D"] + 0.02]
        found, other = solver.at(y, parameters=design), anew.at(y)
        if found.status == 0:
            right += 1
            off = found.value("A") - other.value("A")
            assert np.cos(off) == pytest.approx(1.0, abs=1e-12)
    assert right > 10


def test_expressions_are_in_what_is_given_beside_them() -> None:
    solver = parakin.compile("gough-stewart", free=["r_base", "r_platform"], machine_code=False)
    y = [0.0, 0.0, 1.1, 0.05, 0.1, 0.0]
    found = solver.at(y, parameters={"r_platform": 0.5, "r_base": "2*r_platform"})
    assert found.value("P1") == solver.at(y, parameters={"r_platform": 0.5, "r_base": 1.0}).value(
        "P1"
    )
    with pytest.raises(InputError, match="the cycle r_base -> r_base"):
        solver.at(y, parameters={"r_base": "2*r_base"})


def slide(**parameters: float | str) -> parakin.Mechanism:
    """A slide whose foot stands at `place`; its limits are around home, at `here`."""
    return parakin.Mechanism(
        name="slide",
        parameters={"small": 0.0, "place": "2*small", "inv": 1.0, "here": 0.0} | parameters,
        bodies=[{"name": "base"}, {"name": "arm", "points": {"tip": ["place", 0, 0]}}],
        joints=[
            {
                "name": "T",
                "kind": "revolute",
                "parent": "base",
                "child": "arm",
                "on_parent": {"at": ["place", 0, 0]},
            }
        ],
        platform={"body": "arm"},
        home={"T": "here"},
        limits={"T": ["here - 0.5", "here + 0.5"]},
        driven=["T"],
    )


@pytest.mark.parametrize("own", [0.0, 5.6e-17, 1e-9, 2e-4])
def test_what_is_small_in_the_file_is_left_open_too(own: float) -> None:
    solver = parakin.compile(slide(small=own), free="small", machine_code=False)
    assert solver.at([0.0], parameters={"small": 0.05}).value("platform.x") == pytest.approx(0.1)
    found = parakin.sensitivities(solver, [0.0])
    assert found.of("platform.x", "small") == pytest.approx(2.0)


def test_powers_of_what_is_small_are_left_open() -> None:
    mechanism = slide(small=2e-4, place="small*small*small*small/1e-12")
    solver = parakin.compile(mechanism, free="small", machine_code=False)
    x = solver.at([0.0], parameters={"small": 3e-4}).value("platform.x")
    assert x == pytest.approx(3e-4**4 / 1e-12, rel=1e-12)


def test_what_was_infinite_on_the_way_is_no_design() -> None:
    solver = parakin.compile(slide(small=1.0, inv="1/small", place="1/inv"), free="small")
    tick = solver.at([0.0], parameters={"small": np.array([0.5, 0.0])})
    assert statuses(tick)[0] == 0
    assert statuses(tick)[1] in (Status.OUT_OF_REACH, Status.NOT_REACHED)


@pytest.mark.parametrize("here", [0.3, 2.0, 3.5, 6.0])
def test_angles_are_counted_on_to_the_home_of_the_design(here: float) -> None:
    solver = parakin.compile(slide(), ["platform.yaw"], free="here", machine_code=False)
    anew = parakin.compile(slide(here=here), ["platform.yaw"], machine_code=False)
    y = [anew.home["platform.yaw"] + 0.1]
    found, other = solver.at(y, parameters={"here": here}), anew.at(y)
    assert found.value("T") == pytest.approx(other.value("T"), abs=1e-12)
    assert found.status == other.status == 0


def test_a_batch_may_be_empty() -> None:
    solver = parakin.compile("gough-stewart", free=["r_base"], machine_code=False)
    assert statuses(solver.at(np.zeros((6, 0)), parameters={"r_base": 1.2})).shape == (0,)
    assert statuses(solver.at(np.zeros((6, 0)), parameters={"r_base": []})).shape == (0,)


@pytest.mark.parametrize("free", [[1], 5, b"b", ["b", None]])
def test_names_left_open_are_checked(free: object) -> None:
    with pytest.raises(InputError, match="free"):
        parakin.compile("four-bar", free=free, machine_code=False)  # type: ignore[arg-type]


@pytest.mark.parametrize("parameters", [[1], "b", {1: 2}])
def test_parameters_are_by_name(parameters: object) -> None:
    solver = parakin.compile("four-bar", free="b", machine_code=False)
    with pytest.raises(InputError, match="parameters"):
        solver.at([0.7], parameters=parameters)  # type: ignore[arg-type]


def test_a_home_where_angles_lock_may_be_left() -> None:
    """Pitched by 90° at home, where the platform's other two angles are the same."""
    mechanism = slide(small=0.2, place="small").model_copy(
        update={
            "platform": parakin.Platform(
                body="arm", angles=(("psi", "x"), ("phi", "z"), ("t", "y"))
            )
        }
    )
    solver = parakin.compile(mechanism.model_copy(update={"driven": ("T",)}), free="small")
    assert solver.at([0.1], parameters={"small": 0.3}).status in (0, Status.ANGLES_UNDEFINED)
