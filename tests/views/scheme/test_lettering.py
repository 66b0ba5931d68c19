"""Labels avoid what is in their way."""

from __future__ import annotations

import numpy as np

from parakin.views.scheme.lettering import Label, Obstacles, placed


def test_a_label_makes_way_for_a_line() -> None:
    label = Label("here", np.array([100.0, 100.0]), 4.0, "black", size=8.0)
    ((_, free),) = placed([label], Obstacles(), (200, 200))
    taken = Obstacles()
    taken.line(free + np.array([[-30.0, 0.0], [30.0, 0.0]]))
    ((_, moved),) = placed([label], taken, (200, 200))
    assert abs(moved[1] - free[1]) > 4.0
