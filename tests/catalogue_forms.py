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
    return p + line / length * (along + 1j * side * np.sqrt(r * r - along**2))


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
    found = {}
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


def limbs(p: Named, count: int, *names: str) -> list[tuple[str, list[float]]]:
    """Each limb's number, as text, and its values of `names`."""
    return [(str(i), [p[f"{n}_{i}"] for n in names]) for i in range(1, count + 1)]


@form("3-rrr")
def planar_3rrr(p: Named, y: Named) -> dict[str, Array]:
    """The law of cosines in each arm."""
    found = {}
    centre = y["platform.x"] + 1j * y["platform.y"]
    for i, (angle,) in limbs(p, 3, "angle"):
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
    for i, (angle,) in limbs(p, 3, "angle"):
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


@form("gough-stewart")
def gough_stewart(p: Named, y: Named) -> dict[str, Array]:
    """Leg lengths are distances."""
    centre, R = pose(y)
    found = {}
    for i, (base, top) in limbs(p, 6, "base", "top"):
        leg = centre + R @ around(p["r_platform"], top) - around(p["r_base"], base)
        found[f"P{i}"] = np.linalg.norm(leg, axis=1) - p["stroke_0"]
    return found
