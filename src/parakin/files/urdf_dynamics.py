"""What weighs and resists in a URDF: <inertial> of links, <dynamics> of joints."""

from __future__ import annotations

from typing import TYPE_CHECKING

from parakin.algebra.spatial import Pose, matrix
from parakin.errors import InputError
from parakin.files.parsing import numbers
from parakin.files.resistances import acting
from parakin.files.vocabulary import line_of, listed
from parakin.model.dynamics import Passive
from parakin.model.masses import Mass, check_possible

if TYPE_CHECKING:
    from collections.abc import Callable

    from lxml.etree import _Element

_MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
_UNCOUNTED = ("armature", "rotor_inertia", "spring_reference", "spring_stiffness")
# Of joints that read: what the values of <dynamics> mean along or about.
_ALONG = ("revolute", "prismatic")


class Weights:
    """Masses by link, and what joints meet; `notes` are of what is left out."""

    def __init__(
        self, root: _Element, placed: Callable[[_Element | None, str], Pose[float]], origin: str
    ) -> None:
        """placed: reads an <origin>. Raises InputError on values that are none."""
        self._placed = placed
        self._left: list[str] = []
        self._impossible: list[str] = []
        self.masses: dict[str, Mass] = {}
        for link in root.iterfind("link"):
            inertial = link.find("inertial")
            if inertial is not None:
                name = str(link.get("name"))
                place = f"{line_of(inertial, origin)}: inertial of {name!r:.80}"
                mass = self._mass(inertial, place)
                if mass.mass:
                    try:
                        check_possible(mass.inertia, place)
                    except InputError as error:
                        self._impossible.append(f"{name} ({error.found})")
                        continue
                    self.masses[name] = mass

    def _mass(self, inertial: _Element, place: str) -> Mass:
        at = self._placed(inertial.find("origin"), f"{place}: origin")
        told, moments = inertial.find("mass"), inertial.find("inertia")
        (mass,) = numbers(None if told is None else told.get("value"), 1, (0.0,), f"{place}: mass")
        if mass < 0.0:
            raise InputError(f"{place}: mass", f"{mass:g}", "zero or more")
        xx, yy, zz, xy, xz, yz = (
            numbers(None if moments is None else moments.get(k), 1, (0.0,), f"{place}: {k}")[0]
            for k in _MOMENTS
        )
        tensor = matrix([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        return Mass(mass, at.p, at.R @ tensor @ at.R.T)

    def passive(self, joint: _Element, kind: str, place: str) -> tuple[Passive, ...]:
        """What a joint of one of our kinds meets. Raises InputError on less than nothing."""
        dynamics = joint.find("dynamics")
        if dynamics is None:
            return ()
        for key in _UNCOUNTED:
            if dynamics.get(key) is not None:
                self._left.append(f"{key} of {joint.get('name')!r}")
        viscous, coulomb = (
            numbers(dynamics.get(key), 1, (0.0,), f"{place}: {key}")[0]
            for key in ("damping", "friction")
        )
        for key, value in (("damping", viscous), ("friction", coulomb)):
            if value < 0.0:
                raise InputError(f"{place}: {key}", f"{value:g}", "zero or more")
        if kind not in _ALONG and kind != "fixed" and (viscous or coulomb):
            self._left.append(f"<dynamics> of {joint.get('name')!r}, a {kind} joint")
        return acting([Passive(viscous=viscous, coulomb=coulomb)]) if kind in _ALONG else ()

    def leave_out(self, names: list[str]) -> None:
        """Takes note of joints of which the kind was changed, and what they met with it."""
        self._left += [f"<dynamics> of {name!r}, whose kind is changed" for name in names]

    def notes(self) -> str:
        """Sentences on what has no counterpart in a mechanism."""
        return listed("Not used", self._left) + listed(
            "Masses left out of links with inertias that no body has", self._impossible
        )
