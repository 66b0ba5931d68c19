"""Masses of solids against integration over points, and what is refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from parakin import Body, InputError
from parakin.model.bodies import BodyMesh, MeshMoments
from parakin.model.expressions import Parameters
from parakin.model.masses import Mass, combined, mass_of

DENSITY = 2700.0


def weighed(**told: Any) -> Mass:
    found = mass_of(Body(name="b", **told), Parameters({"r": "20 mm"}), "b")
    assert found is not None
    return found


def refused(**told: Any) -> InputError:
    with pytest.raises(InputError) as refusal:
        mass_of(Body(name="b", **told), Parameters({}), "b")
    return refusal.value


# Inside a solid that stands on the origin along z, of length 0.4 m, sampled on a fine grid.
INSIDE = {
    "cylinder": lambda x, y, z: x**2 + y**2 < 0.05**2,
    "tube": lambda x, y, z: (x**2 + y**2 < 0.05**2) & (x**2 + y**2 > 0.03**2),
    "cone": lambda x, y, z: x**2 + y**2 < (0.05 - 0.03 * z / 0.4) ** 2,
    "box": lambda x, y, z: (abs(x) < 0.03) & (abs(y) < 0.05),
}
TOLD: dict[str, dict[str, Any]] = {
    "cylinder": {"diameter": 0.1},
    "tube": {"diameter": 0.1, "bore": "60 mm"},
    "cone": {"diameter": 0.1, "diameter_to": 0.04},
    "box": {"width": 0.06, "height": 0.1, "across": [1, 0, 0]},
}


def integrated(kind: str) -> tuple[float, np.ndarray, np.ndarray]:
    """Mass, centre and tensor of a solid by sampling a grid of points."""
    n, m = 400, 200
    side = (np.arange(n) + 0.5) / n * 0.1 - 0.05
    along = (np.arange(m) + 0.5) / m * 0.4
    x, y, z = np.meshgrid(side, side, along, indexing="ij", sparse=True)
    inside = np.broadcast_to(INSIDE[kind](x, y, z), (n, n, m))
    cell = DENSITY * (0.1 / n) ** 2 * (0.4 / m)
    mass = cell * inside.sum()
    points = [np.broadcast_to(a, inside.shape)[inside] for a in (x, y, z)]
    com = np.array([a.mean() for a in points])
    r = np.array(points) - com[:, None]
    tensor = cell * ((r * r).sum() * np.eye(3) - r @ r.T)
    return mass, com, tensor


@pytest.mark.parametrize("kind", INSIDE)
def test_solids_weigh_what_their_points_do(kind: str) -> None:
    found = weighed(solid={"kind": kind, "to": [0, 0, 0.4], "density": DENSITY, **TOLD[kind]})
    mass, com, tensor = integrated(kind)
    assert found.mass == pytest.approx(mass, rel=2e-3)
    assert found.com == pytest.approx(com, abs=1e-3)
    assert np.array(found.inertia) == pytest.approx(tensor, rel=5e-3, abs=1e-6)


def test_a_sphere_and_a_rod_of_the_handbook() -> None:
    ball = weighed(solid={"kind": "sphere", "at": [1, 2, 3], "diameter": 0.2, "mass": 5.0})
    assert ball.com == (1.0, 2.0, 3.0)
    assert np.array(ball.inertia) == pytest.approx(2 / 5 * 5.0 * 0.1**2 * np.eye(3))
    rod = weighed(solid={"kind": "cylinder", "to": [2, 0, 0], "diameter": 1e-6, "mass": 3.0})
    assert np.diag(rod.inertia) == pytest.approx([0.0, 1.0, 1.0], abs=1e-9)  # m l²/12


def test_a_bar_askew_has_the_inertia_of_one_along_an_axis_turned() -> None:
    along = np.array([1.0, 2.0, -2.0]) / 3.0
    straight = weighed(solid={"kind": "cylinder", "to": [0, 0, 0.6], "diameter": 0.2, "mass": 4})
    askew = weighed(
        solid={"kind": "cylinder", "to": (0.6 * along).tolist(), "diameter": 0.2, "mass": 4}
    )
    assert askew.com == pytest.approx(0.3 * along)
    bend, _, round_ = np.diag(straight.inertia)
    expected = bend * (np.eye(3) - np.outer(along, along)) + round_ * np.outer(along, along)
    assert np.array(askew.inertia) == pytest.approx(expected)


def test_a_dumbbell_is_huygens_and_steiner() -> None:
    ball = {"kind": "sphere", "diameter": 0.2, "mass": 5.0}
    found = weighed(solid=[{**ball, "at": [0.5, 0, 0]}, {**ball, "at": [-0.5, 0, 0]}])
    own = 2 / 5 * 5.0 * 0.1**2
    assert found.mass == 10.0
    assert found.com == pytest.approx((0.0, 0.0, 0.0))
    assert np.diag(found.inertia) == pytest.approx([2 * own, *(2 * (own + 5.0 * 0.25),) * 2])
    assert combined([]).mass == 0.0


def test_products_are_elements_of_the_tensor_and_axes_may_be_turned() -> None:
    told = {"xx": 2.0, "yy": 3.0, "zz": 4.0, "xy": 0.1, "xz": -0.2, "yz": 0.3}
    found = weighed(mass="2 kg", com=["r", 0, "1 cm"], inertia=told)
    assert found == (
        2.0,
        (0.02, 0.0, 0.01),
        ((2.0, 0.1, -0.2), (0.1, 3.0, 0.3), (-0.2, 0.3, 4.0)),
    )
    turned = weighed(
        mass=2,
        inertia={"xx": 2, "yy": 3, "zz": 4, "on_body": {"turns": [["z", "90 deg"]]}},
    )
    assert np.diag(turned.inertia) == pytest.approx([3.0, 2.0, 4.0])


def test_a_mesh_has_its_moments_by_scale_and_density() -> None:
    """A cube of 100 mm, in millimetres."""
    side = 100.0
    moment = side**5 / 6
    moments = MeshMoments(
        volume=side**3, centroid=(50.0, 0.0, 0.0), inertia=(moment, moment, moment, 0.0, 0.0, 0.0)
    )
    mesh = BodyMesh(file="cube.stl", scale=1e-3, density=1000.0, moments=moments)
    found = weighed(mesh=mesh)
    assert found.mass == pytest.approx(1.0)
    assert found.com == pytest.approx((0.05, 0.0, 0.0))
    assert np.diag(found.inertia) == pytest.approx([0.01 / 6] * 3)
    assert "a mesh that was not read" in refused(mesh={"file": "cube.stl", "density": 1.0}).found


def test_a_mesh_turned_inside_out_weighs_the_same() -> None:
    """A box of 2 x 1 x 1 on one side of the origin, mirrored at it."""
    moments = MeshMoments(
        volume=2.0, centroid=(1.0, 0.5, 0.0), inertia=(1 / 3, 5 / 6, 5 / 6, 0.1, 0.0, 0.0)
    )
    plain, mirrored = (
        weighed(mesh=BodyMesh(file="box.stl", scale=scale, density=3.0, moments=moments))
        for scale in (2.0, -2.0)
    )
    assert mirrored.mass == plain.mass == pytest.approx(3.0 * 2.0 * 2.0**3)
    assert mirrored.inertia == plain.inertia
    assert mirrored.com == pytest.approx(-np.array(plain.com))


@pytest.mark.parametrize("scale", [0, 0.0, math.nan, math.inf, -math.inf])
def test_a_mesh_has_a_size(scale: float) -> None:
    error = refused(mesh={"file": "cube.stl", "density": 1.0, "scale": scale})
    assert error.expected == "a finite number other than zero"


BEYOND = "sizes of which mass or inertia is beyond all numbers"


@pytest.mark.parametrize(
    ("told", "found"),
    [
        ({"mass": -1}, "-1"),
        ({"mass": "3 m"}, "'3 m', a length"),
        ({"com": [0, 0, 0]}, "com without a mass"),
        ({"inertia": [1, 1, 1]}, "inertia without a mass"),
        ({"mass": 1, "inertia": [1, 1, 3]}, "principal moments 1, 1, 3 kg m²"),
        ({"mass": 1, "inertia": [1, -1, 1]}, "principal moments -1, 1, 1 kg m²"),
        ({"mass": 0, "inertia": [1, 1, 1]}, "an inertia of no mass"),
        ({"mass": 1, "solid": {"kind": "point", "mass": 1}}, "mass and solid"),
        (
            {"solid": {"kind": "cylinder", "to": [0, 0, 1], "diameter": 1}},
            "neither density nor mass",
        ),
        (
            {"solid": {"kind": "sphere", "diameter": 1, "mass": 1, "density": 1}},
            "both density and mass",
        ),
        (
            {"solid": {"kind": "tube", "to": [0, 0, 1], "diameter": 1, "bore": 1, "mass": 1}},
            "1 m",
        ),
        ({"solid": {"kind": "sphere", "diameter": 0, "mass": 1}}, "0 m"),
        (
            {"solid": {"kind": "cylinder", "to": [0, 0, 0], "diameter": 1, "mass": 1}},
            "the axis [0.0, 0.0, 0.0]",
        ),
        ({"mass": math.nan}, "nan"),
        ({"solid": {"kind": "sphere", "diameter": 1e150, "density": 1}}, BEYOND),
        (
            {"solid": {"kind": "cylinder", "to": [0, 0, 1e200], "diameter": 1, "density": 1}},
            BEYOND,
        ),
        (
            {"solid": {"kind": "cylinder", "to": [0, 0, 1], "diameter": 1e160, "density": 1}},
            BEYOND,
        ),
    ],
)
def test_what_no_body_has_is_refused(told: dict[str, Any], found: str) -> None:
    assert refused(**told).found == found


def test_the_triangle_inequality_is_met_by_thin_plates() -> None:
    assert weighed(mass=1, inertia=[1, 2, 3]).mass == 1.0
