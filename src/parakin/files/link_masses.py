"""Masses of the links of other programs' models, on the bodies that they become."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from parakin.algebra.spatial import Matrix, Pose, Vector
from parakin.files.links import Owners
from parakin.files.vocabulary import listed
from parakin.model.bodies import Inertia
from parakin.model.masses import Mass, combined


def massive(masses: Mapping[str, Mass], owner: Owners) -> set[str]:
    """The bodies on which any link weighs something."""
    return {owner[name][0] for name in masses if name in owner}


def by_body(masses: Mapping[str, Mass], owner: Owners) -> dict[str, dict[str, Any]]:
    """By body, what its table says of its mass: links fixed to one another weigh together."""
    parts: dict[str, list[Mass]] = {}
    for name, mass in masses.items():
        if name in owner:
            body, at = owner[name]
            parts.setdefault(body, []).append(_seen_from(mass, at))
    return {body: told(own[0] if len(own) == 1 else combined(own)) for body, own in parts.items()}


def _seen_from(mass: Mass, at: Pose[float]) -> Mass:
    """In the frame of a body on which the link stands at `at`."""
    com = at.p + at.R @ mass.com
    return Mass(mass.mass, com, at.R @ mass.inertia @ at.R.T)


def told(mass: Mass) -> dict[str, Any]:
    """A mass as a body's table has it."""
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = mass.inertia
    xy, xz, yz = (xy + yx) / 2, (xz + zx) / 2, (yz + zy) / 2
    found: dict[str, Any] = {"mass": mass.mass, "com": tuple(mass.com)}
    if any((xy, xz, yz)):
        found["inertia"] = Inertia(xx=xx, yy=yy, zz=zz, xy=xy, xz=xz, yz=yz)
    elif any((xx, yy, zz)):
        found["inertia"] = (xx, yy, zz)
    return found


def of_principal(mass: float, com: Vector[float], R: Matrix[float], moments: Vector[float]) -> Mass:
    """From principal moments along the columns of R."""
    a, b, c = moments
    diagonal = Matrix((Vector((a, 0.0, 0.0)), Vector((0.0, b, 0.0)), Vector((0.0, 0.0, c))))
    return Mass(mass, com, R @ diagonal @ R.T)


def not_weighed(masses: Mapping[str, Mass], owner: Owners) -> str:
    """A sentence on links within screws, whose masses belong to no body; "" if there are none."""
    return listed("Masses left out of links within screws", [m for m in masses if m not in owner])
