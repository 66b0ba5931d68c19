"""Which coordinates to move, where the user does not say: the platform's, if it has freedoms."""

from __future__ import annotations

import numpy as np
from scipy.linalg import qr

from parakin.design.strength import rates_at
from parakin.kinematics.configuration import coordinate_scales
from parakin.model.mechanism import Mechanism
from parakin.solving.compiler import compile as compile_mechanism

_DEPENDENT = 1e-6  # of the largest: what of a coordinate's motion others do not tell already


def driven_for(mechanism: Mechanism) -> tuple[str, ...]:
    """The mechanism's own driven coordinates if they are the platform's, or if there is no
    platform; else as many of the platform's as are independent at home, in the order of x, y, z and
    its angles; its own if these are fewer. Raises InputError, AssemblyError, DrivenError.
    """
    own = mechanism.driven
    if mechanism.platform is None or all(name.startswith("platform.") for name in own):
        return own
    solver = compile_mechanism(mechanism, machine_code=False)
    graph, chart = solver.graph, solver.atlas.followed
    platform = [k for k, c in enumerate(graph.coordinates) if c.name.startswith("platform.")]
    platform = [k for k in platform if k in chart.places]
    y = np.array([[solver.home[name]] for name in own])
    plan = solver.plan
    found = np.array([plan.home[k] - plan.offset(k) for k in plan.iterated]).reshape(-1, 1)
    out = chart.at_rest(y, found)
    scales = coordinate_scales(graph)
    rates = rates_at(chart, out, y, tuple(platform))[:, :, 0] / scales[platform][:, None]
    if not platform or not np.isfinite(rates).all():
        return own
    _, triangle, order = qr(rates.T, mode="economic", pivoting=True)
    sizes = np.abs(np.diag(triangle))
    count = int((sizes > _DEPENDENT * sizes.max(initial=0.0)).sum())
    if count < len(own):
        return own
    return tuple(graph.coordinates[platform[k]].name for k in sorted(order[: len(own)]))
