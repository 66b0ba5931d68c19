"""Reactions against the balance of a single free body."""

from __future__ import annotations

import math

import pytest

import parakin
from parakin import Mechanism


def test_the_damping_of_a_spherical_joint_is_part_of_its_reaction() -> None:
    """What one joint exerts on a body follows from its motion, damped or not."""

    def hung(viscous: float) -> parakin.solving.forces.Forces:
        ball = {"name": "S", "kind": "spherical", "parent": "base", "child": "bob"}
        told = {
            "name": "hung",
            "driven": ["S.1", "S.2", "S.3"],
            "bodies": [{"name": "bob", "mass": 2, "com": (0.1, 0.2, -0.5), "inertia": (1, 1, 1)}],
            "joints": [ball | {"actuated": True, "friction": {"viscous": viscous}}],
        }
        solver = parakin.compile(Mechanism.model_validate(told), machine_code=False)
        found = solver.at([0.1, 0.2, 0.3], [1.0, 0.4, 0.2], reactions=True).forces
        assert found is not None
        return found

    free, damped = hung(0.0), hung(3.0)
    assert damped.reaction_force == pytest.approx(free.reaction_force, rel=1e-12)
    assert damped.reaction_moment == pytest.approx(free.reaction_moment, rel=1e-12)
    square = 1.0 + 0.4**2 + 0.2**2 + 2 * 1.0 * 0.2 * math.sin(0.2)  # of w, by its three turns
    assert (damped.effort - free.effort) @ [1.0, 0.4, 0.2] == pytest.approx(3.0 * square)
