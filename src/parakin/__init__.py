"""parakin: kinematics of parallel mechanisms, from a file to machine code.

>>> import parakin
>>> solver = parakin.compile("flight-simulator")
>>> result = solver.solve("general")

Names are looked up when first used, so that importing parakin costs nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from parakin.branches import modes
    from parakin.compiler import compile
    from parakin.errors import (
        AssemblyError,
        DrivenError,
        InputError,
        NotSolvedError,
        ParakinError,
    )
    from parakin.files import catalogue, load
    from parakin.mechanism import Body, Frame, Joint, Mechanism, Platform
    from parakin.motion import Motion
    from parakin.results import require_solved
    from parakin.singularities import singularities
    from parakin.solver import Solver, Tick
    from parakin.status import Status

_ROOMS = {
    "catalogue": "files",
    "load": "files",
    "compile": "compiler",
    "modes": "branches",
    "singularities": "singularities",
    "Solver": "solver",
    "Tick": "solver",
    "require_solved": "results",
    "Status": "status",
    "Motion": "motion",
    "Mechanism": "mechanism",
    "Body": "mechanism",
    "Frame": "mechanism",
    "Joint": "mechanism",
    "Platform": "mechanism",
    "ParakinError": "errors",
    "InputError": "errors",
    "AssemblyError": "errors",
    "DrivenError": "errors",
    "NotSolvedError": "errors",
}
__all__ = [
    "AssemblyError",
    "Body",
    "DrivenError",
    "Frame",
    "InputError",
    "Joint",
    "Mechanism",
    "Motion",
    "NotSolvedError",
    "ParakinError",
    "Platform",
    "Solver",
    "Status",
    "Tick",
    "catalogue",
    "compile",
    "load",
    "modes",
    "require_solved",
    "singularities",
]


def __getattr__(name: str) -> Any:
    if name not in _ROOMS:
        raise AttributeError(f"module 'parakin' has no attribute {name!r}")
    return getattr(importlib.import_module(f"parakin.{_ROOMS[name]}"), name)
