"""Closed forms of the catalogue's mechanisms, as textbooks have them.

Plain NumPy on samples side by side; nothing here is taken from parakin. Each form takes the
dimensions (SI, by name) and the driven coordinates (arrays, by name) and gives other coordinates
by name, angles up to whole turns.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[Any]
Named = Mapping[str, Any]
Form = Callable[[Named, Named], dict[str, Array]]

FORMS: dict[str, Form] = {}


def form(*names: str) -> Callable[[Form], Form]:
    def note(function: Form) -> Form:
        for name in names:
            FORMS[name] = function
        return function

    return note


def meeting(p: Array, r: float, q: Array | complex, s: float, side: float) -> Array:
    """Where circles about `p` and `q` meet, in the complex plane; side 1: left of p to q."""
    line = q - p
    length = np.abs(line)
    along = (r * r - s * s + length**2) / (2 * length)
    place: Array = p + line / length * (along + 1j * side * np.sqrt(r * r - along**2))
    return place


def cosine_sine(a: Array, b: Array, c: Array, side: float) -> Array:
    """The angle t of a cos t + b sin t = c."""
    return np.arctan2(b, a) + side * np.arccos(c / np.hypot(a, b))


def cis(angle: Any) -> Array:
    return np.exp(1j * np.asarray(angle))


@form("four-bar")
def four_bar(p: Named, y: Named) -> dict[str, Array]:
    """Freudenstein's equation, the open branch."""
    a, b, c, d, crank = p["a"], p["b"], p["c"], p["d"], y["A"]
    k1, k2, k3 = d / a, d / c, (a * a - b * b + c * c + d * d) / (2 * a * c)
    A = np.cos(crank) - k1 - k2 * np.cos(crank) + k3
    B = -2 * np.sin(crank)
    C = k1 - (k2 + 1) * np.cos(crank) + k3
    root = np.sqrt(B * B - 4 * A * C)
    stable = np.where(B > 0, np.arctan2(-B - root, 2 * A), np.arctan2(2 * C, root - B))
    rocker = 2 * stable
    coupler = np.angle(d + c * cis(rocker) - a * cis(crank))
    return {"B": coupler - crank, "C": rocker - coupler, "D": rocker}


@form("slider-crank")
def slider_crank(p: Named, y: Named) -> dict[str, Array]:
    rod = -np.arcsin((p["a"] * np.sin(y["A"]) - p["offset"]) / p["b"])
    place = p["a"] * np.cos(y["A"]) + p["b"] * np.cos(rod)
    return {"B": rod - y["A"], "C": -rod, "D": place}


@form("five-bar")
def five_bar(p: Named, y: Named) -> dict[str, Array]:
    """The law of cosines in either arm."""
    found: dict[str, Array] = {}
    ends = []
    for name, side in (("1", -1), ("2", 1)):
        arm = y["platform.x"] + 1j * y["platform.y"] - side * p["base"] / 2
        r = np.abs(arm)
        cosine = (p["proximal"] ** 2 + r**2 - p["distal"] ** 2) / (2 * p["proximal"] * r)
        motor = np.angle(arm) - side * np.arccos(cosine)
        distal = np.angle(arm - p["proximal"] * cis(motor))
        found |= {f"A{name}": motor, f"B{name}": distal - motor}
        ends.append(distal)
    return found | {"P": ends[1] - ends[0], "platform.yaw": ends[0]}


@form("six-bar-watt")
def watt(p: Named, y: Named) -> dict[str, Array]:
    B = p["crank"] * cis(y["A"])
    C = meeting(B, p["coupler"], p["ground"], p["rocker"], 1)
    coupler, rocker = (C - B) / p["coupler"], (C - p["ground"]) / p["rocker"]
    E = B + coupler * (p["x_E"] + 1j * p["y_E"])
    F = p["ground"] + rocker * (p["x_F"] + 1j * p["y_F"])
    return _dyad(p, y, coupler, rocker, E, F, np.angle(rocker), -1)


@form("six-bar-stephenson")
def stephenson(p: Named, y: Named) -> dict[str, Array]:
    B = p["crank"] * cis(y["A"])
    C = meeting(B, p["coupler"], p["ground"], p["rocker"], 1)
    coupler, rocker = (C - B) / p["coupler"], (C - p["ground"]) / p["rocker"]
    E = B + coupler * (p["x_E"] + 1j * p["y_E"])
    F = p["x_F"] + 1j * p["y_F"] + 0 * B
    return _dyad(p, y, coupler, rocker, E, F, 0.0, -1)


def _dyad(
    p: Named, y: Named, coupler: Array, rocker: Array, E: Array, F: Array, carrier: Any, side: float
) -> dict[str, Array]:
    G = meeting(E, p["link_E"], F, p["link_F"], side)
    return {
        "B": np.angle(coupler) - y["A"],
        "C": np.angle(rocker / coupler),
        "D": np.angle(rocker),
        "E": np.angle((G - E) / coupler),
        "F": np.angle(G - F) - carrier,
        "G": np.angle((G - F) / (G - E)),
    }


@form("rssr")
def rssr(p: Named, y: Named) -> dict[str, Array]:
    """|tip of crank - tip of rocker| = rod, as a cos t + b sin t = c."""
    tip = p["crank"] * np.array([np.cos(y["A"]), np.sin(y["A"]), 0 * y["A"]])
    u, v = np.array([1, 0, 0]), np.array([0, np.cos(p["gamma"]), np.sin(p["gamma"])])
    w = np.array([p["x_D"], p["y_D"], p["z_D"]])[:, None] - tip
    c = (p["rod"] ** 2 - p["rocker"] ** 2 - (w**2).sum(0)) / (2 * p["rocker"])
    return {"D": cosine_sine(u @ w, v @ w, c, 1)}


@form("bennett")
def bennett(p: Named, y: Named) -> dict[str, Array]:
    """tan(A/2) tan(B/2) stays what it is; opposite angles are opposite."""
    k = np.sin((p["beta"] + p["alpha"]) / 2) / np.sin((p["beta"] - p["alpha"]) / 2)
    half = np.arctan2(k * np.cos(y["A"] / 2), np.sin(y["A"] / 2))
    return {"B": 2 * half, "C": -y["A"], "D": -2 * half}


@form("bricard")
def bricard(p: Named, y: Named) -> dict[str, Array]:
    """Chen, You and Tarnai's closure equation of the threefold-symmetric loop."""
    s, c = np.sin(p["alpha"]), np.cos(p["alpha"])
    A = y["A"]
    other = cosine_sine(
        s * s + (1 + c * c) * np.cos(A),
        -2 * c * np.sin(A),
        -c * c - s * s * np.cos(A),
        1,
    )
    return {"B": other, "C": A, "D": other, "E": A, "F": other}


# Platforms: position p (n, 3) and orientation R (n, 3, 3) of each sample.


def pose(y: Named, angles: str = "XYZ") -> tuple[Array, Array]:
    """Roll, pitch and yaw are turns about x, y and z; `angles` says in which order."""
    some = np.asarray(next(iter(y.values())))
    rows = {name: np.broadcast_to(y.get(f"platform.{name}", 0.0), some.shape) for name in "xyz"}
    names = {"X": "roll", "Y": "pitch", "Z": "yaw"}
    turns = [np.broadcast_to(y.get(f"platform.{names[a]}", 0.0), some.shape) for a in angles]
    rotation = Rotation.from_euler(angles, np.stack(turns, axis=1)).as_matrix()
    return np.stack([rows[name] for name in "xyz"], axis=1), rotation


def around(radius: float, angle: float, z: float = 0.0) -> Array:
    return np.array([radius * np.cos(angle), radius * np.sin(angle), z])


def thirds(start: float = 0.0) -> list[tuple[str, float]]:
    """Three limbs all around: their numbers, as text, and where they stand."""
    return [(str(i + 1), start + 2 * np.pi * i / 3) for i in range(3)]


def pairs(p: Named) -> list[tuple[str, float, float]]:
    """Six limbs, in pairs on the base; each pair parts to neighbouring corners of the platform."""
    return [
        (
            str(2 * i + j + 1),
            2 * np.pi * i / 3 + side * p["a_base"] / 2,
            2 * np.pi * i / 3 + side * (np.pi / 3 - p["a_platform"] / 2),
        )
        for i in range(3)
        for j, side in enumerate((-1, 1))
    ]


@form("3-rrr")
def planar_3rrr(p: Named, y: Named) -> dict[str, Array]:
    """The law of cosines in each arm."""
    found = {}
    centre = y["platform.x"] + 1j * y["platform.y"]
    for i, angle in thirds(-5 * np.pi / 6):
        reach = centre + p["r_platform"] * cis(angle + y["platform.yaw"]) - p["r_base"] * cis(angle)
        r = np.abs(reach)
        cosine = (p["proximal"] ** 2 + r**2 - p["distal"] ** 2) / (2 * p["proximal"] * r)
        motor = np.angle(reach) - np.arccos(cosine)
        distal = np.angle(reach - p["proximal"] * cis(motor))
        found[f"A{i}"], found[f"B{i}"] = motor, distal - motor
        found[f"C{i}"] = y["platform.yaw"] - distal
    return found


@form("3-rpr")
def planar_3rpr(p: Named, y: Named) -> dict[str, Array]:
    found = {}
    centre = y["platform.x"] + 1j * y["platform.y"]
    for i, angle in thirds(-5 * np.pi / 6):
        top = p["r_platform"] * cis(angle + p["twist"] + y["platform.yaw"])
        leg = centre + top - p["r_base"] * cis(angle)
        found[f"P{i}"], found[f"A{i}"] = np.abs(leg), np.angle(leg)
        found[f"B{i}"] = y["platform.yaw"] - np.angle(leg)
    return found


@form("agile-eye")
def agile_eye(p: Named, y: Named) -> dict[str, Array]:
    """The middle axis of a leg is normal to its motor's axis u and its platform's axis v."""
    _, R = pose(y)
    found = {}
    e = np.eye(3)
    for i in range(3):
        u, start, v = -e[i], e[(i + 2) % 3], R[:, :, (i + 1) % 3]
        w = np.cross(v, u)
        w /= np.linalg.norm(w, axis=1)[:, None]
        found[f"A{i + 1}"] = np.arctan2(w @ np.cross(u, start), w @ start)
        found[f"B{i + 1}"] = np.arctan2((v * np.cross(u, w)).sum(1), -v @ u)
    return found


@form("gough-stewart", "octahedral-hexapod")
def gough_stewart(p: Named, y: Named) -> dict[str, Array]:
    """Leg lengths are distances."""
    centre, R = pose(y)
    found = {}
    for i, base, top in pairs(p):
        leg = centre + R @ around(p["r_platform"], top) - around(p["r_base"], base)
        found[f"P{i}"] = np.linalg.norm(leg, axis=1) - p["stroke_0"]
    return found


def tilted(p: Named, y: Named) -> tuple[Array, Array]:
    """A platform on three balls, each in the upright plane of its leg, 120 degrees apart.

    z, roll and pitch are given. The balls stay in their planes where R is symmetric in its upper
    left corner (which gives yaw), x = r (R11 - R22)/2 and y = -r R21.
    """
    roll, pitch = y["platform.roll"], y["platform.pitch"]
    yaw = np.arctan2(-np.sin(roll) * np.sin(pitch), np.cos(roll) + np.cos(pitch))
    _, R = pose({**y, "platform.yaw": yaw})
    r = p["r_platform"]
    x = r / 2 * (R[:, 0, 0] - R[:, 1, 1])
    return np.stack([x, -r * R[:, 1, 0], y["platform.z"]], axis=1), R


def parasitic(centre: Array, R: Array) -> dict[str, Array]:
    return {
        "platform.x": centre[:, 0],
        "platform.y": centre[:, 1],
        "platform.yaw": np.arctan2(-R[:, 0, 1], R[:, 0, 0]),
    }


@form("3-rps")
def rps(p: Named, y: Named) -> dict[str, Array]:
    centre, R = tilted(p, y)
    found = parasitic(centre, R)
    for i, angle in thirds():
        leg = centre + R @ around(p["r_platform"], angle) - around(p["r_base"], angle)
        found[f"P{i}"] = np.linalg.norm(leg, axis=1)
        found[f"A{i}"] = np.arctan2(leg @ around(1.0, angle), leg[:, 2])
    return found


@form("3-prs")
def prs(p: Named, y: Named) -> dict[str, Array]:
    centre, R = tilted(p, y)
    found = parasitic(centre, R)
    for i, angle in thirds():
        ball = centre + R @ around(p["r_platform"], angle)
        inwards = p["r_base"] - ball @ around(1.0, angle)
        found[f"P{i}"] = ball[:, 2] - np.sqrt(p["link"] ** 2 - inwards**2)
        found[f"R{i}"] = -np.arcsin(inwards / p["link"])
    return found


@form("tricept")
def tricept(p: Named, y: Named) -> dict[str, Array]:
    """The central leg points to the platform: first a turn about x, then one about y."""
    x, yy, z = y["platform.x"], y["platform.y"], y["platform.z"]
    roll, pitch = np.arctan2(-yy, z), np.arctan2(x, np.hypot(yy, z))
    centre, R = pose({**y, "platform.roll": roll, "platform.pitch": pitch})
    found = {"U0.1": roll, "U0.2": pitch, "P0": np.linalg.norm(centre, axis=1)}
    found |= {"platform.roll": roll, "platform.pitch": pitch, "platform.yaw": 0 * roll}
    for i, angle in thirds(np.pi / 2):
        leg = centre + R @ around(p["r_platform"], angle) - around(p["r_base"], angle)
        found[f"P{i}"] = np.linalg.norm(leg, axis=1)
    return found


@form("3-upu")
def upu(p: Named, y: Named) -> dict[str, Array]:
    """The platform does not turn."""
    centre, _ = pose(y)
    found = {f"platform.{name}": 0 * centre[:, 0] for name in ("roll", "pitch", "yaw")}
    for i, angle in thirds(np.pi / 2):
        leg = centre + around(p["r_platform"] - p["r_base"], angle)
        found[f"P{i}"] = np.linalg.norm(leg, axis=1)
        along, across = leg @ around(1.0, angle), leg @ around(1.0, angle + np.pi / 2)
        found[f"U{i}.1"] = np.arctan2(along, leg[:, 2])
        found[f"U{i}.2"] = -np.arctan2(across, np.hypot(along, leg[:, 2]))
        found[f"V{i}.1"], found[f"V{i}.2"] = -found[f"U{i}.2"], -found[f"U{i}.1"]
    return found


def delta_arms(p: Named, centre: Array, edge: float) -> dict[str, Array]:
    """Arm angles: |elbow - edge of the plate| = rod, as a cos t + b sin t = c, elbows out."""
    found = {}
    for i, angle in thirds():
        w = centre + around(edge - p["r_base"], angle)  # from the motor to the plate's edge
        c = ((w**2).sum(1) + p["arm"] ** 2 - p["rod"] ** 2) / (2 * p["arm"])
        found[f"A{i}"] = cosine_sine(w @ around(1.0, angle), -w[:, 2], c, -1)
    return found


@form("delta")
def delta(p: Named, y: Named) -> dict[str, Array]:
    centre, _ = pose(y)
    level = {f"platform.{name}": 0 * centre[:, 0] for name in ("roll", "pitch", "yaw")}
    return level | delta_arms(p, centre, p["r_platform"])


@form("delta-revolute")
def delta_revolute(p: Named, y: Named) -> dict[str, Array]:
    """As the Delta; the parallelogram swings by the rod's component along the arm's axis."""
    found = delta(p, y)
    centre, _ = pose(y)
    for i, angle in thirds():
        out, arm = around(1.0, angle), found[f"A{i}"]
        w = centre + around(p["r_platform"] - p["r_base"], angle)
        elbow = p["arm"] * (np.cos(arm)[:, None] * out - np.sin(arm)[:, None] * np.eye(3)[2])
        rod = (w - elbow) / p["rod"]
        swing = -np.arcsin(rod @ around(1.0, angle + np.pi / 2))
        slope = np.arctan2(-rod[:, 2], rod @ out)  # downwards, as arms count
        found |= {f"B{i}": slope - arm, f"G{i}": -slope}
        found |= {f"C{i}": swing, f"D{i}": swing, f"E{i}": -swing, f"F{i}": -swing}
    return found


@form("linear-delta")
def linear_delta(p: Named, y: Named) -> dict[str, Array]:
    centre, _ = pose(y)
    found = {f"platform.{name}": 0 * centre[:, 0] for name in ("roll", "pitch", "yaw")}
    for i, angle in thirds():
        level = (centre + around(p["r_platform"] - p["r_base"], angle))[:, :2]
        found[f"P{i}"] = centre[:, 2] + np.sqrt(p["rod"] ** 2 - (level**2).sum(1))
    return found


def crank_with_rod(shaft: Array, u: Array, v: Array, crank: float, rod: float, end: Array) -> Array:
    """The angle from u to v at which the crank's tip is `rod` from `end`; the crank pushes."""
    w = end - shaft
    c = ((w**2).sum(1) + crank**2 - rod**2) / (2 * crank)
    return cosine_sine(w @ u, w @ v, c, -1)


@form("6-rus")
def rus(p: Named, y: Named) -> dict[str, Array]:
    """M cos t + N sin t = L, as every builder's notes on rotary hexapods have it."""
    centre, R = pose(y)
    found = {}
    for i, base, top in pairs(p):
        end = centre + R @ around(p["r_platform"], top)
        u = (-1) ** int(i) * around(1.0, base + np.pi / 2)
        shaft = around(p["r_base"], base)
        found[f"A{i}"] = crank_with_rod(shaft, u, np.eye(3)[2], p["crank"], p["rod"], end)
    return found


@form("6-pus")
def pus(p: Named, y: Named) -> dict[str, Array]:
    centre, R = pose(y)
    found = {}
    for i, base, top in pairs(p):
        w = centre + R @ around(p["r_platform"], top) - around(p["r_base"], base)
        found[f"P{i}"] = w[:, 2] - np.sqrt(p["rod"] ** 2 - w[:, 0] ** 2 - w[:, 1] ** 2)
    return found


@form("seat-2dof", "seat-3dof")
def seat(p: Named, y: Named) -> dict[str, Array]:
    """The post holds surge, sway and yaw; a crank and a rod at each drive."""
    height = y.get("platform.z", p.get("post"))
    centre, R = pose({**y, "platform.z": height}, "ZYX")
    found = {"platform.yaw": 0 * centre[:, 0], "platform.x": 0 * centre[:, 0]}
    found |= {"U.1": y["platform.pitch"], "U.2": y["platform.roll"]}
    ends = [(-p["back"], p["half"], -1), (-p["back"], -p["half"], -1)]
    if "front" in p:
        ends.append((p["front"], 0, 1))
    for i, (x, left, out) in enumerate(ends, start=1):
        end, u = np.array([x, left, 0]), np.array([out, 0, 0])
        shaft = end - p["crank"] * u + np.array([0, 0, p["shaft"]])
        tip = centre + R @ end
        found[f"A{i}"] = crank_with_rod(shaft, u, np.eye(3)[2], p["crank"], p["rod"], tip)
    return found


@form("wrist-on-delta")
def wrist_on_delta(p: Named, y: Named) -> dict[str, Array]:
    """The wrist's centre is where the tool points back to; its angles are the tool's."""
    tip, R = pose(y, "ZYX")
    centre = tip + p["tool"] * R[:, :, 2]
    wrist = {"W1": y["platform.yaw"], "W2": y["platform.pitch"], "W3": y["platform.roll"]}
    return delta_arms(p, centre, p["r_plate"]) | wrist


@form("hexapod-on-3rps")
def hexapod_on_3rps(p: Named, y: Named) -> dict[str, Array]:
    """The stage by Newton's iteration on the legs' equations, the upper legs as distances."""
    angles = [angle for _, angle in thirds()]
    lengths = np.stack([y[f"L{i}"] for i in (1, 2, 3)])
    balls = {"r_platform": p["r_stage"]}

    def stage(q: Array) -> tuple[Array, Array]:
        return tilted(balls, dict(zip(STAGE, q, strict=True)))

    def gaps(q: Array) -> Array:
        centre, R = stage(q)
        ends = [centre + R @ around(p["r_stage"], a) - around(p["r_ground"], a) for a in angles]
        squares: Array = np.stack([(end**2).sum(1) for end in ends]) - lengths**2
        return squares

    q = np.zeros_like(lengths)
    q[0] = np.sqrt(p["leg"] ** 2 - (p["r_ground"] - p["r_stage"]) ** 2)
    for _ in range(12):
        h = 1e-6
        slopes = np.stack([(gaps(q + h * e) - gaps(q - h * e)) / (2 * h) for e in _STEPS], axis=1)
        q = q - np.linalg.solve(slopes.transpose(2, 0, 1), gaps(q).T[:, :, None])[:, :, 0].T
    low, S = stage(q)
    high, R = pose(y)
    found = {}
    for i, base, top in pairs(p):
        foot = low + S @ around(p["r_base"], base)
        found[f"P{i}"] = np.linalg.norm(high + R @ around(p["r_platform"], top) - foot, axis=1)
    for i, angle in thirds():
        leg = low + S @ around(p["r_stage"], angle) - around(p["r_ground"], angle)
        found[f"A{i}"] = np.arctan2(leg @ around(1.0, angle), leg[:, 2])
    return found


STAGE = ("platform.z", "platform.roll", "platform.pitch")
_STEPS = np.eye(3)[:, :, None]
