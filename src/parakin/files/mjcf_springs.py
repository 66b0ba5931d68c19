"""Springs and dampers between points in a MuJoCo model: spatial tendons of two sites."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from parakin.errors import InputError, nearest
from parakin.files.link_springs import LinkSpring
from parakin.files.parsing import numbers
from parakin.files.vocabulary import line_of
from parakin.model.placement import vector

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lxml.etree import _Element

_KEYS = {"name", "stiffness", "damping", "springlength"}
_SHOWN = {"group", "width", "rgba", "material", "user"}


class Tendons:
    """Those that are springs, and their elements; whatever else a tendon does is not read."""

    def __init__(
        self, mujoco: Any, root: _Element, model: Any, names: Sequence[str], origin: str
    ) -> None:
        """names: of the bodies, by number. Raises InputError on values that are none."""
        self._mujoco, self._model, self._names, self._origin = mujoco, model, names, origin
        self.springs: list[LinkSpring] = []
        self._taken: list[_Element] = []
        if any(True for _ in root.iterfind("default//tendon")):
            return  # which may say more of them
        for element in filter(_is_spring, root.iterfind("tendon/*")):
            sites = [self._site(end) for end in element]
            if len({int(model.site_bodyid[k]) for k in sites}) == 2:
                self.springs.append(self._spring(element, sites))
                self._taken += [*element.iterancestors("tendon"), element, *element]

    def _spring(self, element: _Element, sites: Sequence[int]) -> LinkSpring:
        """Its length, where none is told, is that of the model's first pose."""
        place, model = line_of(element, self._origin), self._model

        def told(key: str, default: float) -> float:
            (value,) = numbers(element.get(key), 1, (default,), f"{place}: {key}")
            if value < 0.0 and value != default:
                raise InputError(f"{place}: {key}", f"{value:g}", "zero or more")
            return value

        stiffness, damping, length = (
            told(key, default)
            for key, default in (("stiffness", 0.0), ("damping", 0.0), ("springlength", -1.0))
        )
        if length < 0.0:
            data = self._mujoco.MjData(model)
            self._mujoco.mj_kinematics(model, data)
            length = math.dist(*(data.site_xpos[k] for k in sites))
        bits, off = self._mujoco.mjtDisableBit, int(model.opt.disableflags)
        stiffness = 0.0 if off & bits.mjDSBL_SPRING else stiffness
        damping = 0.0 if off & bits.mjDSBL_DAMPER else damping
        name = element.get("name") or f"tendon{len(self.springs)}"
        a, b = ((self._names[model.site_bodyid[k]], vector(model.site_pos[k])) for k in sites)
        return LinkSpring(name, (a, b), stiffness, damping, length)

    def _site(self, end: _Element) -> int:
        name, model = str(end.get("site")), self._model
        known = {model.site(k).name: k for k in range(model.nsite)}
        if name not in known:
            found = f"unknown site {name!r:.80}"
            raise InputError(line_of(end, self._origin), found, nearest(name, known))
        return known[name]

    def read(self, element: _Element) -> bool:
        """Whether an element is one of the springs, or holds some."""
        return any(element is taken for taken in self._taken)


def _is_spring(element: _Element) -> bool:
    """Whether a tendon is a straight line between two sites, with a spring or damper that is
    linear, and nothing else.
    """
    keys = {str(key) for key in element.attrib}
    single = all(len(str(element.get(key, "")).split()) <= 1 for key in _KEYS - {"name"})
    ends = [str(end.tag) for end in element] == ["site", "site"]
    acts = bool(keys & {"stiffness", "damping"})
    return element.tag == "spatial" and keys <= _KEYS | _SHOWN and single and ends and acts
