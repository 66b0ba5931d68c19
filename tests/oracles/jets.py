"""The kernel's elementary functions on third-order jets: automatic differentiation, 40 digits."""

from __future__ import annotations

import closed_form
from closed_form import Jet, jet

from parakin.algebra.spatial import Functions


def jet_functions() -> Functions:
    def minimum(a: Jet | float, b: Jet | float) -> Jet:
        a, b = jet(a), jet(b)
        return a if a.value <= b.value else b

    def copysign(a: Jet | float, b: Jet | float) -> Jet:
        a, b = jet(a), jet(b)
        return -a if b.value < 0 else a

    return Functions(
        lambda x: closed_form.sin(jet(x)),
        lambda x: closed_form.cos(jet(x)),
        lambda x: closed_form.sqrt(jet(x)),
        lambda y, x: closed_form.atan2(jet(y), jet(x)),
        minimum,
        copysign,
        lambda x: 1.0 / jet(x),
    )
