"""Figures that others have published, and what parakin makes of the same mechanisms.

Each case says where its figures stand and computes ours through the public interface.
`python tests/oracles/published_cases.py` prints the tables of docs/published.md. A figure is quoted as
its source prints it, or cut to fewer digits where the source says less than it prints; the case
then says so.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, partial

import closed_form
import numpy as np
import xarray as xr
from literature import GOLDBERG
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import parakin
from parakin.analysis.mobility import Mobility, mobility
from parakin.files.mechanism_toml import mechanism_from_table
from parakin.kinematics.assembly import assembled
from parakin.model.evaluation import graph_of
from parakin.motion.laws import constant, from_laws, polynomial345
from parakin.solving.modes import Mode, Search

FloatArray = NDArray[np.float64]
State = dict[str, tuple[float, float, float]]  # position, velocity, acceleration by coordinate


@dataclass(frozen=True)
class Figure:
    """One published figure.

    published: as quoted, which says how many digits count. turn: what angles are told apart by, 0
    for other figures. within: how far ours may be off, half a unit of the last digit if not given.
    """

    what: str
    published: str
    ours: Callable[[], float]
    unit: str = ""
    turn: float = 0.0
    within: float | None = None

    @property
    def decimals(self) -> int:
        return len(self.published.partition(".")[2])

    @cached_property
    def value(self) -> float:
        """Ours; an angle within half a turn of the published one."""
        ours = float(self.ours())
        if self.turn:
            ours -= self.turn * round((ours - float(self.published)) / self.turn)
        return ours

    @property
    def allowed(self) -> float:
        return 0.5 * 10.0**-self.decimals if self.within is None else self.within

    @property
    def agrees(self) -> bool:
        rounding = 1e-12 * max(1.0, abs(float(self.published)))
        return abs(self.value - float(self.published)) <= self.allowed + rounding


@dataclass(frozen=True)
class Case:
    """A mechanism of one source. note: what a reader has to know of the figures. wrong: why the
    source is in error; its figures then have to differ from ours.
    """

    family: str
    mechanism: str
    source: str
    figures: tuple[Figure, ...]
    note: str = ""
    wrong: str = ""


def mechanism(text: str) -> parakin.Mechanism:
    return mechanism_from_table(tomllib.loads(text), "published")


def compiled(
    source: parakin.Mechanism | str,
    driven: Sequence[str] = (),
    parameters: Mapping[str, float] | None = None,
) -> parakin.Solver:
    """On arrays: these are single poses, not worth compiling for."""
    return parakin.compile(
        source,
        driven or None,
        coordinates="all",
        machine_code=False,
        parameters=parameters,
    )


def state(
    solver: parakin.Solver,
    y: Sequence[float],
    yd: Sequence[float] | None = None,
    ydd: Sequence[float] | None = None,
) -> State:
    """All coordinates where the driven ones have these positions, velocities, accelerations."""
    tick = solver.at(y, yd, ydd)
    status = int(tick.status)
    if status:
        raise parakin.NotSolvedError(parakin.Status(status).words)
    orders = (tick.position, tick.velocity, tick.acceleration)
    return {
        name: (float(orders[0][k]), float(orders[1][k]), float(orders[2][k]))
        for k, name in enumerate(solver.coordinates)
    }


def freedom(source: parakin.Mechanism | str) -> Mobility:
    graph = graph_of(parakin.load(source) if isinstance(source, str) else source)
    return mobility(graph, assembled(graph), len(graph.mechanism.driven))


def with_balls(source: str, *joints: str) -> parakin.Mechanism:
    """A mechanism of the catalogue, its joints whose names begin so made spherical."""
    original = parakin.load(source)
    made = [
        joint.model_copy(update={"kind": "spherical", "actuated": False})
        if joint.name.startswith(joints)
        else joint
        for joint in original.joints
    ]
    return original.model_copy(update={"joints": tuple(made), "guess": {}})


# Planar linkages

ANDREWS = """
name = "squeezer"
title = "Andrews' squeezing mechanism, seven bodies"
driven = ["beta"]
[parameters]
rr = 7e-3
d = 28e-3
ss = 35e-3
e = 20e-3
u = 40e-3
zf = 20e-3
zt = 40e-3
xa = -69.34e-3
ya = -2.27e-3
xb = -36.35e-3
yb = 32.73e-3
[home]
beta = -0.0617138900142764
[guess]
gamma = 0.46
phi = 0.22
delta = 0.49
omega = -0.22
epsilon = 1.23
[bodies]
K1 = {}
K2 = {}
K3 = {}
K4 = {}
K5 = {}
K6 = {}
K7 = {}
[joints]
beta = { kind = "revolute", parent = "base", child = "K1", actuated = true }
theta = { kind = "revolute", parent = "K1", child = "K2", on_parent = { at = ["rr", 0, 0] } }
gamma = { kind = "revolute", parent = "base", child = "K3", on_parent = { at = ["xb", "yb", 0] } }
delta = { kind = "revolute", parent = "base", child = "K5", on_parent = { at = ["xa", "ya", 0] } }
phi = { kind = "revolute", parent = "K5", child = "K4", on_parent = { at = ["zt", 0, 0] } }
epsilon = { kind = "revolute", parent = "base", child = "K7", on_parent = { at = ["xa", "ya", 0] } }
omega = { kind = "revolute", parent = "K7", child = "K6", on_parent = { at = [0, "-u", 0] } }
P3 = { kind = "revolute", parent = "K2", child = "K3", on_parent = { at = ["-d", 0, 0] }, on_child = { at = [0, "-ss", 0] } }
P4 = { kind = "revolute", parent = "K2", child = "K4", on_parent = { at = ["-d", 0, 0] }, on_child = { at = [0, "-e", 0] } }
P6 = { kind = "revolute", parent = "K2", child = "K6", on_parent = { at = ["-d", 0, 0] }, on_child = { at = ["zf", 0, 0] } }
"""

SIX_BAR = """
name = "six-bar"
driven = ["A"]
[home]
A = "10 deg"
[guess]
T = 0.31
R = 2.42
O = 0.94
L = -0.1
[bodies]
crank = {}
ternary = {}
rocker = {}
link = {}
output = {}
[joints]
A = { kind = "revolute", parent = "base", child = "crank", actuated = true }
T = { kind = "revolute", parent = "crank", child = "ternary", on_parent = { at = [1.5, 0, 0] } }
R = { kind = "revolute", parent = "base", child = "rocker", on_parent = { at = [6, 0, 0] } }
P = { kind = "revolute", parent = "ternary", child = "rocker", on_parent = { at = [3, 0, 0] }, on_child = { at = [2.5, 0, 0] } }
L = { kind = "revolute", parent = "ternary", child = "link", on_parent = { at = [1.5, 1, 0] } }
O = { kind = "revolute", parent = "base", child = "output", on_parent = { at = [3, 1, 0] } }
Q = { kind = "revolute", parent = "link", child = "output", on_parent = { at = [2, 0, 0] }, on_child = { at = [2, 0, 0] } }
"""

WINDOWS = """
name = "two windows"
title = "N-four-bar mechanism of two windows"
driven = ["A"]
[home]
A = "{angle} deg"
[guess]
B = "{angle} deg"
C = "{angle} deg"
D = "-{angle} deg"
E = "-{angle} deg"
[bodies]
left = {{}}
middle = {{}}
right = {{}}
top1 = {{}}
top2 = {{}}
[joints]
A = {{ kind = "revolute", parent = "base", child = "left", actuated = true }}
B = {{ kind = "revolute", parent = "base", child = "middle", on_parent = {{ at = [1, 0, 0] }} }}
C = {{ kind = "revolute", parent = "base", child = "right", on_parent = {{ at = [2, 0, 0] }} }}
D = {{ kind = "revolute", parent = "left", child = "top1", on_parent = {{ at = [1, 0, 0] }} }}
E = {{ kind = "revolute", parent = "middle", child = "top2", on_parent = {{ at = [1, 0, 0] }} }}
F = {{ kind = "revolute", parent = "top1", child = "middle", on_parent = {{ at = [1, 0, 0] }}, on_child = {{ at = [1, 0, 0] }} }}
G = {{ kind = "revolute", parent = "top2", child = "right", on_parent = {{ at = [1, 0, 0] }}, on_child = {{ at = [1, 0, 0] }} }}
"""


@cache
def squeezer(*orders: float) -> State:
    """With the crank at these position, velocity, acceleration."""
    return state(compiled(mechanism(ANDREWS)), *([order] for order in orders))


START = partial(squeezer, -0.0617138900142764496)
END = partial(squeezer, 15.81077119629904, 1139.920302151208, -24631.76316945196)


def _angles(at: Callable[[], State], order: int, *rows: tuple[str, str]) -> tuple[Figure, ...]:
    """Joint angles, or their rates, of one state: name and published figure."""
    what, unit = (("", "rad"), ("speed of ", "rad/s"), ("acceleration of ", "rad/s²"))[order]
    return tuple(
        Figure(
            f"{what}{name}",
            published,
            lambda name=name: at()[name][order],  # type: ignore[misc]
            unit,
            turn=0.0 if order else 2 * np.pi,
        )
        for name, published in rows
    )


@cache
def six_bar() -> State:
    return state(compiled(mechanism(SIX_BAR)), [np.radians(10)], [1.0], [0.0])


def turned(at: Callable[[], State], order: int, *joints: str) -> Callable[[], float]:
    """The sum of joint coordinates: a body's turn in the base."""
    return lambda: sum(at()[joint][order] for joint in joints)


@cache
def slider_crank() -> State:
    solver = compiled("slider-crank", parameters={"a": 1.0, "b": 3.0, "offset": 0.0})
    return state(solver, [np.radians(15)], [1.0], [0.0])


@cache
def norton(name: str) -> State:
    solver = compiled(name)
    return state(solver, [solver.home["A"]])


@cache
def five_bar() -> Search:
    """The four working modes with the pen at (0, 300 mm)."""
    solver = compiled("five-bar", parameters={"base": 0.25, "proximal": 0.205, "distal": 0.205})
    return parakin.modes(solver, {"platform.x": 0.0, "platform.y": 0.3})


def extreme(
    search: Callable[[], Search], of: Callable[[Sequence[float]], float], name: str
) -> Callable[[], float]:
    return lambda: of([branch.coordinates[name] for branch in search().modes])


PLANAR = (
    Case(
        "Planar linkages",
        "four-bar, 40-120-80-100 mm, crank at 40°, open",
        "R. L. Norton, *Design of Machinery*, example 4-1",
        (
            Figure(
                "coupler",
                "20.298",
                lambda: np.degrees(turned(partial(norton, "four-bar"), 0, "A", "B")()),
                "°",
                360,
            ),
            Figure(
                "rocker",
                "57.325",
                lambda: np.degrees(norton("four-bar")["D"][0]),
                "°",
                360,
            ),
        ),
        note="figures as this repository's catalogue test quoted them; the book was not at hand",
    ),
    Case(
        "Planar linkages",
        "slider-crank, 40-120 mm, offset −20 mm, crank at 60°",
        "R. L. Norton, *Design of Machinery*, example 4-2",
        (
            Figure("slider", "126.84", lambda: 1e3 * norton("slider-crank")["D"][0], "mm"),
            Figure(
                "connecting rod",
                "152.91",
                lambda: 180 + np.degrees(turned(partial(norton, "slider-crank"), 0, "A", "B")()),
                "°",
                360,
            ),
        ),
        note="as above; the book counts the rod from its other end",
    ),
    Case(
        "Planar linkages",
        "slider-crank, 1-3 m, crank at 15°, 1 rad/s",
        "repository coleas33/linkage_sim, data/benchmarks/golden/slidercrank_kinematics.json, "
        "first step",
        (
            Figure("slider", "3.9547404244", lambda: slider_crank()["D"][0], "m"),
            Figure("its speed", "-0.3424642468", lambda: slider_crank()["D"][1], "m/s"),
            Figure("its acceleration", "-1.2580222059", lambda: slider_crank()["D"][2], "m/s²"),
            Figure("rod", "-0.0863803972", turned(slider_crank, 0, "A", "B"), "rad", 2 * np.pi),
            Figure("its speed", "-0.3231802424", turned(slider_crank, 1, "A", "B"), "rad/s"),
        ),
        note="the file has 16 digits, ten decimals are quoted",
    ),
    Case(
        "Planar linkages",
        "six-bar, crank at 10°, 1 rad/s",
        "repository coleas33/linkage_sim, data/benchmarks/golden/sixbar_kinematics.json, first step",
        (
            Figure("ternary link", "0.4853646400", turned(six_bar, 0, "A", "T"), "rad", 2 * np.pi),
            Figure("rocker", "2.4154022270", turned(six_bar, 0, "R"), "rad", 2 * np.pi),
            Figure("output", "-36.7622798505", turned(six_bar, 0, "O"), "rad", 2 * np.pi),
            Figure("link", "-37.3057465660", turned(six_bar, 0, "A", "T", "L"), "rad", 2 * np.pi),
            Figure("speed of rocker", "-0.1960237652", turned(six_bar, 1, "R"), "rad/s"),
            Figure("speed of output", "-0.7736917086", turned(six_bar, 1, "O"), "rad/s"),
            Figure("acceleration of rocker", "0.8492514997", turned(six_bar, 2, "R"), "rad/s²"),
            Figure("acceleration of output", "2.5332207978", turned(six_bar, 2, "O"), "rad/s²"),
        ),
        note="called a Watt I there; ground and coupler are its ternary links, which makes it a "
        "Stephenson III. Ten decimals of 16 digits",
    ),
    Case(
        "Planar linkages",
        "Andrews' squeezing mechanism, at the start",
        "E. Hairer, G. Wanner, *Solving Ordinary Differential Equations II*, the seven body "
        "mechanism; initial values of the Test Set for IVP Solvers (CWI, Bari)",
        _angles(
            START,
            0,
            ("theta", "0.0000000000"),
            ("gamma", "0.4552798192"),
            ("phi", "0.2226683902"),
            ("delta", "0.4873649795"),
            ("omega", "-0.2226683902"),
            ("epsilon", "1.2305474445"),
        ),
        note="30 digits are printed, ten decimals quoted. The crank's angle is the source's",
    ),
    Case(
        "Planar linkages",
        "Andrews' squeezing mechanism, after 0.03 s",
        "Test Set for IVP Solvers, reference solution of the problem andrews at 0.03 s",
        (
            *_angles(
                END,
                0,
                ("theta", "-15.75637106"),
                ("gamma", "0.04082224"),
                ("phi", "-0.53473012"),
                ("delta", "0.52440997"),
                ("omega", "0.53473012"),
                ("epsilon", "1.04808074"),
            ),
            *_angles(
                END,
                1,
                ("theta", "-1424.379295"),
                ("gamma", "11.032912"),
                ("phi", "19.293375"),
                ("delta", "0.573570"),
                ("omega", "-19.293375"),
                ("epsilon", "0.323179"),
            ),
            *_angles(
                END,
                2,
                ("theta", "51850"),
                ("gamma", "324103"),
                ("phi", "566749"),
                ("delta", "16744"),
                ("omega", "-566749"),
                ("epsilon", "9827"),
            ),
        ),
        note="the crank's angle, speed and acceleration are the source's. It prints 16 digits of an "
        "integration whose speeds close the loops to 1e-9 m/s, but its accelerations only to "
        "2e-3 m/s², 1e-6 of their size: only as many digits are quoted",
    ),
    Case(
        "Planar linkages",
        "five-bar, motors 250 mm apart, links of 205 mm, pen at (0, 300) mm",
        "repository five-bar-robot, src/motion_planning, test_inverse of class FiveBar (seen as an "
        "excerpt that does not name its owner)",
        (
            Figure("left motor, one elbow", "0.52040625", extreme(five_bar, min, "A1"), "rad"),
            Figure("left motor, the other", "1.83160416", extreme(five_bar, max, "A1"), "rad"),
            Figure("right motor, one elbow", "1.30998849", extreme(five_bar, min, "A2"), "rad"),
            Figure("right motor, the other", "2.6211864", extreme(five_bar, max, "A2"), "rad"),
            Figure("working modes", "4", lambda: len(five_bar().modes)),
        ),
    ),
    Case(
        "Planar linkages",
        "five-bar; Stephenson and Watt six-bars",
        "K. M. Lynch, F. C. Park, *Modern Robotics* (2017), example 2.4",
        (
            Figure("freedoms of the five-bar", "2", lambda: freedom("five-bar").generic),
            Figure("of the Stephenson", "1", lambda: freedom("six-bar-stephenson").generic),
            Figure("of the Watt", "1", lambda: freedom("six-bar-watt").generic),
        ),
    ),
    Case(
        "Planar linkages",
        "N-four-bar mechanism, two windows of 1 m",
        "Library of computational benchmark problems, A02 (M. González et al. 2006), as in "
        "RehabEngGroup/MBSbenchmarksInOpenSim, help/benchmarks/A02_N_FourBarMechanism.rst",
        (
            Figure(
                "freedoms where it stands upright",
                "1",
                lambda: freedom(mechanism(WINDOWS.format(angle=90))).home,
            ),
            Figure(
                "freedoms where it lies flat, N + 1",
                "3",
                lambda: freedom(mechanism(WINDOWS.format(angle=0))).home,
            ),
        ),
    ),
)

# Spatial loops

RSSR = """
name = "rssr"
title = "RSSR, its rod with a ball at each end"
driven = ["A"]
[home]
A = "30 deg"
[guess]
D = "70 deg"
[bodies]
crank = {}
rod = {}
rocker = {}
[joints]
A = { kind = "revolute", parent = "base", child = "crank", actuated = true }
B = { kind = "spherical", parent = "crank", child = "rod", on_parent = { at = [0.05, 0, 0] } }
C = { kind = "spherical", parent = "rod", child = "rocker", on_parent = { at = [0.2, 0, 0] }, on_child = { at = [0.11, 0, 0] } }
D = { kind = "revolute", parent = "base", child = "rocker", on_parent = { at = [0.16, 0.04, 0.03], turns = [["x", "70 deg"]] } }
"""

CARDAN = """
name = "cardan"
title = "Two shafts at 30 degrees, a universal joint between"
driven = ["A"]
[home]
A = 0
[bodies]
in = {}
out = {}
[joints]
A = { kind = "revolute", parent = "base", child = "in", actuated = true, on_parent = { axis = [1, 0, 0], x = [0, 0, 1] }, on_child = { axis = [1, 0, 0], x = [0, 0, 1] } }
U = { kind = "universal", parent = "in", child = "out", on_parent = { axis = [0, 1, 0], x = [0, 0, 1] }, on_child = { axis = [0, 0, 1], x = [0, -1, 0] } }
B = { kind = "revolute", parent = "base", child = "out", on_parent = { axis = ["cos(30 deg)", "sin(30 deg)", 0], x = [0, 0, 1] }, on_child = { axis = [1, 0, 0], x = [0, 0, 1] } }
"""

BENNETT = {"a": 48.517960986215606e-3, "alpha": -2.525127906877729, "beta": -1.6415475452692962}


@cache
def bennett() -> State:
    solver = compiled("bennett", parameters=BENNETT)
    return state(solver, [-2.278633566902332])


@cache
def cardan() -> State:
    return state(compiled(mechanism(CARDAN)), [np.radians(60)], [1.0], [0.0])


def count(source: parakin.Mechanism | str, of: str) -> Callable[[], float]:
    """Grübler's count of a mechanism, or its true mobility."""
    return lambda: float(getattr(freedom(source), of))


SPATIAL = (
    Case(
        "Spatial loops",
        "Bennett linkage of 48.518 and 83.709 mm",
        "repository hucik14/rational-linkages, python/tests/test_RationalMechanism.py, "
        "test_get_design (a motion of K. Brunnthaler et al. 2005)",
        (
            Figure(
                "longer link, by Bennett's condition",
                "83.7087611213",
                lambda: 1e3 * compiled("bennett", parameters=BENNETT).graph.parameters["b"],
                "mm",
            ),
            Figure("second joint", "1.5073336115", lambda: bennett()["B"][0], "rad", 2 * np.pi),
            Figure("third joint", "2.2786335669", lambda: bennett()["C"][0], "rad", 2 * np.pi),
            Figure("fourth joint", "-1.5073336115", lambda: bennett()["D"][0], "rad", 2 * np.pi),
        ),
        note="the first joint's angle is the source's; ten decimals of 16 digits",
    ),
    Case(
        "Spatial loops",
        "Bennett, Goldberg and Bricard linkages",
        "G. T. Bennett (1903), M. Goldberg (1943), R. Bricard (1927): overconstrained, one freedom; "
        "the Bricard as in the library of computational benchmark problems, A04",
        (
            Figure("Bennett, Grübler's count", "-2", count("bennett", "grubler")),
            Figure("Bennett, freedoms", "1", count("bennett", "generic")),
            Figure("Goldberg 5R, Grübler's count", "-1", count(mechanism(GOLDBERG), "grubler")),
            Figure("Goldberg 5R, freedoms", "1", count(mechanism(GOLDBERG), "generic")),
            Figure("Bricard, Grübler's count", "0", count("bricard", "grubler")),
            Figure("Bricard, freedoms", "1", count("bricard", "generic")),
        ),
    ),
    Case(
        "Spatial loops",
        "RSSR",
        "textbooks: Kutzbach's count 6(4 − 1 − 4) + 8, of which one is the rod's spin",
        (
            Figure("Kutzbach's count", "2", count(mechanism(RSSR), "grubler")),
            Figure("freedoms", "2", count(mechanism(RSSR), "generic")),
            Figure("idle", "1", lambda: len(freedom(mechanism(RSSR)).idle)),
        ),
    ),
    Case(
        "Spatial loops",
        "universal joint between shafts at 30°, driving shaft at 60°, 1 rad/s",
        "textbooks: tan γ₂ = tan γ₁ / cos β, ω₂/ω₁ = cos β / (1 − sin² β cos² γ₁), "
        "and its derivative; here arctan 2, 8√3/15 and −16/75",
        (
            Figure("driven shaft", "63.4349488", lambda: np.degrees(cardan()["B"][0]), "°", 360),
            Figure("its speed", "0.9237604307", lambda: cardan()["B"][1], "rad/s"),
            Figure("its acceleration", "-0.2133333333", lambda: cardan()["B"][2], "rad/s²"),
        ),
        note="a theorem, evaluated to ten figures; angles count from where the driving "
        "shaft's arm of the cross lies in the plane of the shafts",
    ),
)

# Planar parallel robots

TRIPOD = """
name = "planar 3-RPR"
driven = ["platform.x", "platform.y", "platform.yaw"]
[parameters]
x2 = {x2}
y2 = {y2}
x3 = {x3}
y3 = {y3}
u2 = {u2}
v2 = {v2}
u3 = {u3}
v3 = {v3}
[platform]
body = "platform"
[home]
platform = {{ x = {x}, y = {y}, yaw = {yaw} }}
[bodies]
platform = {{}}
[limbs.leg]
count = 3
[limbs.leg.each]
a = [0, "x2", "x3"]
b = [0, "y2", "y3"]
u = [0, "u2", "u3"]
v = [0, "v2", "v3"]
reach = {reach}
lean = {lean}
[limbs.leg.bodies]
"cylinder{{i}}" = {{}}
"piston{{i}}" = {{}}
[limbs.leg.joints]
"A{{i}}" = {{ kind = "revolute", parent = "base", child = "cylinder{{i}}", on_parent = {{ at = ["a", "b", 0] }} }}
"P{{i}}" = {{ kind = "prismatic", parent = "cylinder{{i}}", child = "piston{{i}}", actuated = true, on_parent = {{ axis = [1, 0, 0] }}, on_child = {{ axis = [1, 0, 0] }} }}
"B{{i}}" = {{ kind = "revolute", parent = "piston{{i}}", child = "platform", on_child = {{ at = ["u", "v", 0] }} }}
[limbs.leg.guess]
"P{{i}}" = "reach"
"A{{i}}" = "lean"
"""


def tripod(
    base: Sequence[tuple[float, float]],
    platform: Sequence[tuple[float, float]],
    pose: tuple[float, float, float],
) -> parakin.Mechanism:
    """A planar 3-RPR: second and third joints of base and platform, their firsts the origins."""
    (x2, y2), (x3, y3) = base
    (u2, v2), (u3, v3) = platform
    x, y, yaw = pose
    places = {"x2": x2, "y2": y2, "x3": x3, "y3": y3, "u2": u2, "v2": v2, "u3": u3, "v3": v3}
    tops = [(0.0, 0.0), (u2, v2), (u3, v3)]
    legs = []
    for (a, b), (u, v) in zip([(0.0, 0.0), (x2, y2), (x3, y3)], tops, strict=True):
        across = x + u * np.cos(yaw) - v * np.sin(yaw) - a
        up = y + u * np.sin(yaw) + v * np.cos(yaw) - b
        legs.append((float(np.hypot(across, up)), float(np.arctan2(up, across))))
    text = TRIPOD.format(
        x=x, y=y, yaw=yaw, reach=[leg for leg, _ in legs], lean=[turn for _, turn in legs], **places
    )
    return mechanism(text)


@cache
def sauer(second: float) -> Search:
    """Sauer's second platform, poses for the length of its second strut."""
    platform = [(3.0, 0.0), (3.0, 3.0)]
    solver = compiled(tripod([(5.0, 0.0), (0.0, 6.0)], platform, (1.0, 4.0, 0.0)), LEGS)
    return parakin.modes(solver, {"P1": 5.0, "P2": second, "P3": 3.0})


@cache
def sauers_first() -> Search:
    platform = [(np.sqrt(2.0), 0.0), (0.0, np.sqrt(2.0))]
    solver = compiled(tripod([(4.0, 0.0), (0.0, 4.0)], platform, (1.0, 2.0, -np.pi / 4)), LEGS)
    return parakin.modes(solver, dict.fromkeys(LEGS, float(np.sqrt(5.0))))


def pose_at(search: Callable[[], Search], yaw: float, name: str) -> Callable[[], float]:
    """A coordinate of the assembly whose platform is turned nearly so."""

    def away(branch: Mode) -> float:
        return -float(np.cos(branch.coordinates["platform.yaw"] - yaw))

    return lambda: min(search().modes, key=away).coordinates[name]


@cache
def schulz(*driven: str) -> Search:
    """Schulz's 3-RPR at his pose, by lengths or by directions of its legs."""
    pose = (10.0, 80.0, float(np.radians(-20)))
    robot = tripod([(40.0, 10.0), (90.0, -20.0)], [(25.0, 0.0), (60.0, 0.0)], pose)
    return parakin.modes(compiled(robot, driven))


LEGS = ("P1", "P2", "P3")
SAUER = "T. Sauer, *Numerical Analysis*, Reality Check 1, Kinematics of the Stewart platform"
SCHULZ = (
    "S. Schulz, repository stefanschulz85/Assembly-Modes-of-a-3-RPR-parallel-Mechanism-when-Using-"
    "the-Linear-Actuators-Orientations, README and General Code"
)

PLANAR_ROBOTS = (
    Case(
        "Planar parallel robots",
        "planar Stewart platform 3-RPR, all struts √5",
        SAUER,
        (
            Figure("x, turned by −45°", "1", pose_at(sauers_first, -np.pi / 4, "platform.x")),
            Figure("y", "2", pose_at(sauers_first, -np.pi / 4, "platform.y")),
            Figure(
                "its turn",
                "-45.00000000",
                lambda: np.degrees(pose_at(sauers_first, -np.pi / 4, "platform.yaw")()),
                "°",
                360,
            ),
            Figure("x, turned by 45°", "2", pose_at(sauers_first, np.pi / 4, "platform.x")),
            Figure("y", "1", pose_at(sauers_first, np.pi / 4, "platform.y")),
            Figure(
                "its turn",
                "45.00000000",
                lambda: np.degrees(pose_at(sauers_first, np.pi / 4, "platform.yaw")()),
                "°",
                360,
            ),
        ),
        note="exact figures",
    ),
    Case(
        "Planar parallel robots",
        "planar Stewart platform 3-RPR, struts 5, p₂, 3",
        SAUER + ", steps 4 to 6; two poses for p₂ = 4: solutions such as "
        "sayedRaheel/Forward-Kinematics-of-Stewart-Platform",
        (
            Figure("poses for p₂ = 4", "2", lambda: len(sauer(4.0).modes)),
            Figure("poses for p₂ = 5", "4", lambda: len(sauer(5.0).modes)),
            Figure("poses for p₂ = 7", "6", lambda: len(sauer(7.0).modes)),
        ),
    ),
    Case(
        "Planar parallel robots",
        "3-RPR with its joints in line, at (10, 80) and −20°",
        SCHULZ,
        (
            Figure("poses for the lengths", "6", lambda: len(schulz(*LEGS).modes)),
            Figure("poses for the directions", "2", lambda: len(schulz("A1", "A2", "A3").modes)),
        ),
    ),
    Case(
        "Planar parallel robots",
        "3-RRR",
        "textbooks: two elbows to each of three legs",
        (Figure("working modes", "8", lambda: len(parakin.modes(compiled("3-rrr")).modes)),),
    ),
)

MOTORS = ("A1", "A2", "A3")


@cache
def delta_of_v3() -> State:
    solver = compiled(
        "delta", parameters={"arm": 0.2, "rod": 0.46, "r_base": 0.1, "r_platform": 0.074}
    )
    return state(solver, [0.15, 0.0, -0.42])  # its first arm points along −y, ours along x


def orientations(*motors: float) -> FloatArray:
    """All assemblies of the Agile Eye as rotation matrices (n, 9)."""
    search = parakin.modes(compiled("agile-eye", MOTORS), dict(zip(MOTORS, motors, strict=True)))
    angles = [
        [b.coordinates[f"platform.{n}"] for n in ("roll", "pitch", "yaw")] for b in search.modes
    ]
    matrices: FloatArray = Rotation.from_euler("XYZ", angles).as_matrix()
    return matrices.reshape(-1, 9)


def moving_orientations() -> float:
    """How many of the Agile Eye's assemblies are others when its motors have moved."""
    before, after = orientations(0.3, -0.2, 0.1), orientations(-0.1, 0.25, 0.4)
    apart = np.abs(after[:, None] - before[None]).max(axis=2) > 1e-6
    return float(apart.all(axis=1).sum())


SPHERICAL = (
    Case(
        "Spherical robots",
        "Agile Eye",
        "I. A. Bonev, D. Chablat, P. Wenger, Working and assembly modes of the Agile Eye, "
        "IEEE ICRA (2006), abstract",
        (
            Figure("working modes", "8", lambda: len(parakin.modes(compiled("agile-eye")).modes)),
            Figure("assembly modes", "4", moving_orientations),
        ),
        note="there are four more solutions, left out of the paper, in which the eye stays put "
        "whatever the motors do; `parakin.modes` reports all eight",
    ),
)

DELTAS = (
    Case(
        "Delta robots",
        "Delta, arms 200 mm, rods 460 mm, radii 100 and 74 mm, at (0, −150, −420) mm",
        "repository Arvin-Mohammadi/Delta-Robot-Trajectory-Planning-V3, Code/DeltaKinematics.py, "
        "test at its end",
        tuple(
            Figure(
                f"motor {i}",
                published,
                lambda i=i: np.degrees(delta_of_v3()[f"A{i}"][0]),  # type: ignore[misc]
                "°",
                360,
            )
            for i, published in ((1, "-9.83458745"), (2, "24.15228444"), (3, "24.15228444"))
        ),
    ),
    Case(
        "Delta robots",
        "Delta, parallelograms with balls at their corners",
        "K. M. Lynch, F. C. Park, *Modern Robotics* (2017), example 2.7",
        (
            Figure(
                "Grübler's count", "15", count(with_balls("delta-revolute", *"CDEF"), "grubler")
            ),
            Figure("freedoms", "15", count(with_balls("delta-revolute", *"CDEF"), "generic")),
        ),
    ),
    Case(
        "Delta robots",
        "Delta, linear Delta",
        "R. Clavel, Delta, a fast robot with parallel geometry (1988): three freedoms",
        (
            Figure("freedoms of the Delta", "3", count("delta", "generic")),
            Figure("of the linear Delta", "3", count("linear-delta", "generic")),
        ),
    ),
)

# Hexapods

DIETMAIER_BASE = (
    (0.0, 0.0, 0.0),
    (1.107915, 0.0, 0.0),
    (0.549094, 0.756063, 0.0),
    (0.735077, -0.223935, 0.525991),
    (0.514188, -0.526063, -0.368418),
    (0.590473, 0.094733, -0.205018),
)
DIETMAIER_PLATFORM = (
    (0.0, 0.0, 0.0),
    (0.542805, 0.0, 0.0),
    (0.956919, -0.528915, 0.0),
    (0.665885, -0.353482, 1.402538),
    (0.478359, 1.158742, 0.107672),
    (-0.137087, -0.235121, 0.353913),
)
DIETMAIER_LEGS = (1.0, 0.645275, 1.086284, 1.503439, 1.281933, 0.771071)

# The forty postures: the first platform joint, then the platform's x and y axes.
DIETMAIER_POSTURES = """
0.534004  0.006175 -0.845460  0.063686 -0.273293  0.959820  0.992514 -0.083083 -0.089512
0.863326  0.005644 -0.504616  0.191288  0.943757  0.269690 -0.727039 -0.048353  0.684891
0.458734 -0.373483 -0.806271  0.368860  0.040707  0.928593  0.924343 -0.121006 -0.361867
0.832285 -0.282752  0.476816 -0.382982 -0.266292 -0.884541 -0.475822 -0.763879  0.435984
0.825080 -0.318926  0.466400 -0.260310 -0.306586 -0.915556 -0.226750 -0.902315  0.366622
0.958098 -0.284039 -0.037012 -0.251037 -0.049498  0.966711 -0.003112 -0.998645 -0.051941
0.535060 -0.749596 -0.389637  0.275453  0.490428  0.826805  0.958347 -0.207624 -0.196123
0.539848  0.678840  0.497734  0.872889 -0.487412 -0.022226 -0.426919 -0.785023  0.448865
0.855766 -0.334679  0.394532 -0.262159 -0.305119 -0.915519  0.075330 -0.952276  0.295798
0.993577  0.079665 -0.080359  0.085868  0.958900 -0.270438 -0.970578  0.019223 -0.240017
0.689418  0.593656 -0.415060 -0.210582 -0.971899  0.105202 -0.251239 -0.050195 -0.966623
0.636112  0.771452  0.014956  0.403995 -0.570369 -0.715169  0.546803 -0.476187  0.688660
0.998901 -0.041564 -0.021652 -0.768310 -0.038046 -0.638946  0.637073  0.051153 -0.769104
0.803268 -0.296007  0.516856  0.347484  0.924976  0.153864  0.661165 -0.125334 -0.739697
0.891375 -0.079827 -0.446182 -0.772754  0.124475  0.622380 -0.530468  0.411756 -0.740986
0.854376 -0.294203  0.428352 -0.512685 -0.128567 -0.848896 -0.651892 -0.585147  0.482327
0.955868 -0.046996 -0.290013 -0.040450  0.983337 -0.177232 -0.932229  0.026696  0.360882
0.993726  0.111786  0.003613  0.160650  0.963663 -0.213412 -0.857007  0.028930 -0.514492
0.998523  0.031196  0.044477 -0.967647  0.094597 -0.233901  0.251917  0.413708 -0.874862
0.485481 -0.200818 -0.850871  0.236223 -0.102021  0.966328  0.965581 -0.086772 -0.245202
0.442199 -0.713495 -0.543494  0.635109  0.328442  0.699116  0.772001 -0.299794 -0.560480
0.917778 -0.111176  0.381213  0.099504  0.981801  0.161759  0.279495  0.128443 -0.951517
0.443038 -0.558620 -0.701185  0.508690  0.195638  0.838427  0.858129 -0.193983 -0.475379
0.521848  0.810720  0.265345  0.744610 -0.620756  0.245392 -0.654481 -0.606711  0.451172
0.989132  0.116671  0.089471  0.200592  0.972717 -0.116557 -0.670069  0.049431 -0.740651
0.477891 -0.781099 -0.401876  0.826712  0.562537  0.009983  0.168452 -0.230553 -0.958368
0.679796  0.348061 -0.645547 -0.316631 -0.570962  0.757461  0.948521 -0.196694  0.248232
0.781100  0.068798 -0.620604 -0.541607 -0.173803  0.822469 -0.831932  0.251220 -0.494751
0.995368 -0.051199  0.081376 -0.944301  0.327693  0.030214  0.148425  0.506047 -0.849639
0.991613 -0.127016  0.023867 -0.357494 -0.163559  0.919482  0.216483 -0.972242 -0.088775
0.585910  0.161498 -0.794121 -0.085610 -0.404087  0.910706  0.992920 -0.110149  0.044465
0.667532  0.738317 -0.096379 -0.274641 -0.902132  0.332762 -0.848378  0.064457 -0.525452
0.719131  0.633883 -0.284681 -0.368748 -0.923636  0.104505 -0.443455  0.075996 -0.893069
0.968094  0.236773 -0.082048  0.108314  0.512433  0.851869 -0.756896 -0.513036  0.404850
0.870078 -0.451122 -0.198631 -0.102377 -0.020892  0.994526 -0.141894 -0.989249 -0.035388
0.999628  0.026176 -0.007724 -0.901448 -0.011589 -0.432732  0.413966  0.269235 -0.869566
0.903174 -0.418445  0.095812 -0.681556  0.427412 -0.593970 -0.702125 -0.153285  0.695359
0.707963  0.685868 -0.168443 -0.389440 -0.897709  0.206045 -0.667549  0.120969 -0.734674
0.489122  0.696230 -0.525379  0.777174 -0.215031  0.591407 -0.628581 -0.220816  0.745739
0.484612 -0.873935 -0.037278  0.853425  0.469308  0.226749  0.505719 -0.640298 -0.578158
"""

CDSL_BASE = (
    (59.14, 78.0, 0.0),
    (59.14, -78.0, 0.0),
    (37.98, -90.22, 0.0),
    (-97.12, -12.22, 0.0),
    (-97.12, 12.22, 0.0),
    (37.98, 90.22, 0.0),
)
CDSL_PLATFORM = (
    (83.14, 3.0, 0.0),
    (83.14, -3.0, 0.0),
    (-38.97, -73.5, 0.0),
    (-44.17, -70.5, 0.0),
    (-44.17, 70.5, 0.0),
    (-38.97, 73.5, 0.0),
)

UPS = """
"U{i}" = {{ kind = "universal", parent = "base", child = "cylinder{i}", on_parent = {{ at = {base}, axis = [1, 0, 0], x = [0, 1, 0] }}, on_child = {{ axis = [0, 1, 0], x = [-1, 0, 0] }} }}
"P{i}" = {{ kind = "prismatic", parent = "cylinder{i}", child = "piston{i}", actuated = true }}
"S{i}" = {{ kind = "spherical", parent = "piston{i}", child = "platform", on_child = {{ at = {top} }} }}
"""

POSE = tuple(f"platform.{n}" for n in ("x", "y", "z", "roll", "pitch", "yaw"))
SIX = tuple(f"P{i}" for i in range(1, 7))


def hexapod(
    base: Sequence[tuple[float, ...]], top: Sequence[tuple[float, ...]], pose: FloatArray
) -> parakin.Mechanism:
    """A 6-UPS of any joints, its home a pose, angles about the platform's own x, y and z."""
    turned = Rotation.from_euler("XYZ", pose[3:]).apply(np.array(top)) + pose[:3] - np.array(base)
    guess = []
    for i, leg in enumerate(turned, start=1):
        length = np.linalg.norm(leg)
        guess.append(f"P{i} = {length}")
        guess.append(f"U{i}.1 = {np.arctan2(-leg[1], leg[2])}")
        guess.append(f"U{i}.2 = {np.arcsin(leg[0] / length)}")
    home = ", ".join(
        f"{name.partition('.')[2]} = {value}" for name, value in zip(POSE, pose, strict=True)
    )
    legs = zip(range(1, 7), base, top, strict=True)
    return mechanism(
        "\n".join(
            [
                'name = "6-UPS"',
                f"driven = {list(POSE)}",
                "[platform]",
                'body = "platform"',
                "[home]",
                f"platform = {{ {home} }}",
                "[guess]",
                *guess,
                "[bodies]",
                "platform = {}",
                *(f"cylinder{i} = {{}}\npiston{i} = {{}}" for i in range(1, 7)),
                "[joints]",
                *(UPS.format(i=i, base=list(a), top=list(b)) for i, a, b in legs),
            ]
        )
    )


@cache
def dietmaier() -> tuple[FloatArray, FloatArray]:
    """Published postures (40, 9), and those that a search from the lengths alone finds (n, 9)."""
    published = np.array([line.split() for line in DIETMAIER_POSTURES.split("\n") if line], float)
    first = np.stack([published[0, 3:6], published[0, 6:9]], axis=1)
    axes = np.column_stack([first, np.cross(first[:, 0], first[:, 1])])
    pose = np.hstack([published[0, :3], Rotation.from_matrix(axes).as_euler("XYZ")])
    robot = hexapod(DIETMAIER_BASE, DIETMAIER_PLATFORM, pose)
    solver = parakin.compile(robot, SIX, derivatives=0, machine_code=False)
    search = parakin.modes(solver, dict(zip(SIX, DIETMAIER_LEGS, strict=True)))
    poses = np.array([[branch.coordinates[name] for name in POSE] for branch in search.modes])
    turned = Rotation.from_euler("XYZ", poses[:, 3:]).as_matrix()
    return published, np.hstack([poses[:, :3], turned[:, :, 0], turned[:, :, 1]])


def postures() -> float:
    return float(len(dietmaier()[1]))


def farthest_posture() -> float:
    """Of each published posture from the nearest that was found."""
    published, ours = dietmaier()
    return float(np.abs(ours[None] - published[:, None]).max(axis=2).min(axis=1).max())


@cache
def cdsl() -> State:
    solver = compiled(hexapod(CDSL_BASE, CDSL_PLATFORM, np.array([0, 0, -111.31, 0, 0, 0.0])))
    return state(solver, [0.0, 0.0, -111.31, 0.0, 0.0, np.radians(-30)])


@cache
def fichter() -> float:
    """The yaw [deg] at which a symmetric hexapod is singular."""
    solver = compiled("gough-stewart")
    turning = polynomial345(0.0, 2.0, 1.0)
    laws = {name: constant(solver.home[name]) for name in solver.driven}
    motion = from_laws("turning", laws | {"platform.yaw": turning}, 1.0, 100.0)
    (crossing,) = parakin.singularities(solver, solver.solve(motion), motion).crossings
    return float(np.degrees(turning(np.array([crossing.time]))[0][0]))


HEXAPODS = (
    Case(
        "Hexapods",
        "general 6-6, all assemblies real",
        "P. Dietmaier, The Stewart-Gough platform of general geometry can have 40 real postures, "
        "Advances in Robot Kinematics (1998); geometry and all solutions in "
        "janverschelde/PHCpack, src/Demo/stewgou40",
        (
            Figure("real postures", "40", postures),
            Figure("largest difference of any of their 360 figures", "0.00000", farthest_posture),
        ),
        note="found by `parakin.modes` from the six lengths alone. The published solutions "
        "have 15 digits, but of a system of equations whose coefficients were cut to ten, "
        "some of them badly conditioned: five decimals are compared",
    ),
    Case(
        "Hexapods",
        "hexapod of the Contact Dynamics Simulation Laboratory, turned by −30°",
        "A. Kumagai, J. P. Brown (2006), repository "
        "jotux/Steward-Platform-Forward-Kinematics-Solver, src/formdata.txt and stew_inverse.m",
        tuple(
            Figure(
                f"leg {i}",
                published,
                lambda i=i: cdsl()[f"P{i}"][0],  # type: ignore[misc]
            )
            for i, published in enumerate(
                ("162.107", "116.891", "162.106", "116.890", "162.104", "116.891"), start=1
            )
        ),
    ),
    Case(
        "Hexapods",
        "6-UPS, 6-SPS",
        "K. M. Lynch, F. C. Park, *Modern Robotics* (2017), example 2.8",
        (
            Figure("freedoms of the 6-UPS", "6", count("gough-stewart", "generic")),
            Figure("of the 6-SPS", "12", count(with_balls("gough-stewart", "U"), "generic")),
            Figure(
                "of them legs that spin",
                "6",
                lambda: len(freedom(with_balls("gough-stewart", "U")).idle),
            ),
        ),
    ),
    Case(
        "Hexapods",
        "symmetric 6-UPS turned about its normal",
        "E. F. Fichter, A Stewart platform-based manipulator: general theory and practical "
        "construction, Int. J. Robot. Res. 5 (1986)",
        (Figure("turn at which it is singular", "90.0000000", fichter, "°"),),
        note="exact, whatever the height",
    ),
    Case(
        "Hexapods",
        "6-RUS and 6-PUS",
        "J.-P. Merlet, *Parallel Robots* (2006): two positions of each motor for a given pose",
        (
            Figure(
                "working modes of the 6-RUS",
                "64",
                lambda: len(parakin.modes(compiled("6-rus")).modes),
            ),
            Figure("of the 6-PUS", "64", lambda: len(parakin.modes(compiled("6-pus")).modes)),
        ),
        note="a theorem, 2⁶",
    ),
)

# Fewer freedoms

G, H, HEIGHT = 83.2358e-3, 86.614e-3, 203.835e-3  # of the 3-RPS: pins, balls, height


@cache
def tripod_platform() -> State:
    """The 3-RPS tilted by 20 degrees about an axis at 120 degrees: ZYZ angles 30, 20, −30."""
    tilt = Rotation.from_euler("ZYZ", [30, 20, -30], degrees=True)
    roll, pitch, _ = tilt.as_euler("XYZ")
    solver = compiled("3-rps", parameters={"r_base": G, "r_platform": H, "height": HEIGHT})
    return state(solver, [HEIGHT, roll, pitch])


LOWER = (
    Case(
        "Fewer freedoms",
        "3-RPS, tilted by 20° towards 30°",
        "repository weixuanzh/ME470_FWT_MATLAB, RPS_inverse_kinematics.m: x = −h(1 − cos β)cos 2α/2, "
        "y = h(1 − cos β)sin 2α/2 and the length d₁, for g = 83.2358, h = 86.614, z = 203.835 mm",
        (
            Figure(
                "x, parasitic", "-1.305866", lambda: 1e3 * tripod_platform()["platform.x"][0], "mm"
            ),
            Figure(
                "y, parasitic", "2.261826", lambda: 1e3 * tripod_platform()["platform.y"][0], "mm"
            ),
            Figure("d₁, first leg", "178.189650", lambda: 1e3 * tripod_platform()["P1"][0], "mm"),
        ),
        note="from the formulas printed there, to six decimals",
    ),
    Case(
        "Fewer freedoms",
        "3-RPS, 3-PRS, 3-UPU, Tricept",
        "titles of K.-M. Lee, D. K. Shah (1988), J. A. Carretero et al. (2000), L.-W. Tsai (1996); "
        "for the Tricept Grübler's formula 6(9 − 1 − 11) + 21",
        (
            Figure("freedoms of the 3-RPS", "3", count("3-rps", "generic")),
            Figure("of the 3-PRS", "3", count("3-prs", "generic")),
            Figure("of the 3-UPU", "3", count("3-upu", "generic")),
            Figure("of the Tricept", "3", count("tricept", "generic")),
        ),
    ),
)

# Motion platforms


@cache
def simulator() -> parakin.Solver:
    return compiled("flight-simulator")


def slider(name: str, printed: float) -> Callable[[], float]:
    return lambda: printed + simulator().home[name]


@cache
def general_evolution() -> xr.Dataset:
    """The third example at 1.5 s."""
    return simulator().solve("general").sel(time=1.5, method="nearest")


def slider_speed(name: str) -> float:
    return float(general_evolution().velocity.sel(coordinate=name))


def equation_5(platform: str, *joints: tuple[str, int]) -> Callable[[], float]:
    """An angle of the platform less what equation (5) makes of the joints', all from home."""

    def off() -> float:
        position, home = general_evolution().position, general_evolution().home
        turned = (position - home).sel(coordinate=[platform, *(name for name, _ in joints)])
        signs = [1, *(-sign for _, sign in joints)]
        return float(np.dot(signs, turned))

    return off


def equation_11(line: int, name: str) -> Callable[[], float]:
    """A slider's speed less what a line of equation (11), as printed, says of it."""

    def off() -> float:
        y, yd, ydd = closed_form.example(3, 1.5)
        paper = closed_form.Parameters()
        printed = closed_form.printed_eq_11(paper, closed_form.state(paper, y, yd, ydd), yd)
        return slider_speed(name) - float(printed[line])

    return off


STAICU = "S. Staicu, Inverse kinematics of a parallel flight simulator"
PLATFORMS = (
    Case(
        "Motion platforms",
        "parallel flight simulator, central configuration",
        STAICU + ", section 2",
        (
            Figure("A1A2 = s_A", "0.29", slider("A2", 0.29), "m"),
            Figure("B2B3 = s_B", "0.33", slider("B3", 0.33), "m"),
            Figure("C2C3 = s_C", "0.33", slider("C3", 0.33), "m"),
            Figure("freedoms", "3", count("flight-simulator", "generic")),
        ),
        note="the lengths follow from the others that are printed. Grübler's formula, which the "
        "paper names, gives −3: six closure conditions repeat others",
    ),
    Case(
        "Motion platforms",
        "parallel flight simulator, general evolution at 1.5 s",
        STAICU + ", eqs. (5) and (11)",
        (
            Figure(
                "ψ − (φ₁₀ − φ₃₂) of leg A",
                "0.0000000000",
                equation_5("platform.psi", ("A1", 1), ("A3", -1)),
                "rad",
            ),
            Figure("φ − φ₄₃", "0.0000000000", equation_5("platform.phi", ("A4", 1)), "rad"),
            Figure("v₂₁ of leg A less line 1", "0.0000000000", equation_11(0, "A2"), "m/s"),
            Figure("v₃₂ of leg B less line 2", "0.0000000000", equation_11(1, "B3"), "m/s"),
        ),
        note="equations, to ten decimals",
    ),
    Case(
        "Motion platforms",
        "parallel flight simulator, general evolution at 1.5 s, leg C",
        STAICU + ", eq. (11), third line, evaluated as printed",
        (Figure("speed of slider C", "0.2093", lambda: slider_speed("C3"), "m/s"),),
        wrong="two signs of the equation are misprinted: its own displacement grows at 0.2491 m/s "
        "([](paper.md))",
    ),
)

HYBRIDS = (
    Case(
        "Hybrids",
        "stages in series",
        "textbooks: freedoms of stages in series add up, 3 + 6 and 3 + 3",
        (
            Figure("freedoms of a hexapod on a 3-RPS", "9", count("hexapod-on-3rps", "generic")),
            Figure("of a wrist on a Delta", "6", count("wrist-on-delta", "generic")),
        ),
    ),
)

CASES: tuple[Case, ...] = (
    *PLANAR,
    *SPATIAL,
    *PLANAR_ROBOTS,
    *SPHERICAL,
    *DELTAS,
    *HEXAPODS,
    *LOWER,
    *PLATFORMS,
    *HYBRIDS,
)


def difference(figure: Figure) -> str:
    """Ours less the published figure, to one decimal more than is printed."""
    off = round(figure.value - float(figure.published), figure.decimals + 1)
    return f"{off:.0e}" if off else "0"


def tables() -> str:
    """The tables of docs/published.md, a family each."""
    lines: list[str] = []
    for family in dict.fromkeys(case.family for case in CASES):
        lines += [f"## {family}", ""]
        for case in (case for case in CASES if case.family == family):
            lines += [f"**{sentence(case.mechanism)}** {sentence(case.source)}", ""]
            lines += ["| figure | published | ours | difference |", "|---|---|---|---|"]
            for figure in case.figures:
                unit = f" {figure.unit}" if figure.unit else ""
                ours = f"{figure.value:.{figure.decimals}f}"
                ours = ours if float(ours) else ours.removeprefix("-")
                lines.append(
                    f"| {figure.what} | {figure.published}{unit} | {ours}{unit} "
                    f"| {difference(figure)} |"
                )
            lines.append("")
            if case.wrong:
                lines += [f"They disagree: {case.wrong}.", ""]
            if case.note:
                lines += [sentence(case.note), ""]
    return "\n".join(lines)


def sentence(text: str) -> str:
    return f"{text[0].upper()}{text[1:]}."


if __name__ == "__main__":
    print(tables(), end="")
