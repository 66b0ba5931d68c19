"""parakin: kinematics and forces of parallel mechanisms, from a file to machine code.

>>> import parakin
>>> solver = parakin.compile("flight-simulator")
>>> result = solver.solve("general")

The packages follow the flow of the data; each imports only those listed before it (`analysis` and
`exports` do not import each other):

- `errors`, `arrays`, `caching`, `labelled`, `notebook`, `version`: messages, types of arrays,
  properties worked out once, arrays by name, tables in notebooks, the version; all may import them
- `algebra`: vectors, rotations, dual numbers, small linear systems, on any scalar
- `model`: the user's description of a mechanism, and its numerical form, in any design
- `motion`: what drives a mechanism over time
- `files`: mechanisms and motions in, results out
- `kinematics`: the recursion of Staicu's paper, loop closure, assembly
- `mechanics`: wrenches on bodies and what joints carry, by virtual powers
- `planning`: joints to cut, rows and their order for given driven coordinates
- `kernel`: one pose, its rates (eq. 10) and forces, in machine code or on NumPy
- `solving`: compiling solvers, following motions, simulating, labelled results, assembly modes
- `analysis`: mobility, singularities, stiffness, small motions, sensitivities (beside it, real time
  when it comes)
- `exports`: models and code for other programs
- `design`: how far, how fast and how hard a mechanism moves, where it can go, and what stops it
- `views`: figures, films, reports, schemes, pages in the browser
- `verbs`: commands as functions, `parakin.check`, `draw`, ...: all but `list`, `modes`, `solve` and
  `simulate`, which are `parakin.catalogue`, `parakin.modes`, `Solver.solve` and `Solver.simulate`
- `cli`: the command line

and `catalogue` is data. Names are imported when first used, so importing parakin takes no time.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from parakin.version import __version__ as __version__

if TYPE_CHECKING:
    from parakin.analysis.linearisation import linearise
    from parakin.analysis.sensitivities import sensitivities
    from parakin.analysis.singularities import singularities
    from parakin.analysis.stiffness import stiffness
    from parakin.design.certificate import certify
    from parakin.design.range import range
    from parakin.design.workspace import workspace
    from parakin.errors import (
        AssemblyError,
        DrivenError,
        InputError,
        NotSolvedError,
        ParakinError,
    )
    from parakin.files.reading import catalogue, load
    from parakin.model.bodies import Body, Frame
    from parakin.model.mechanism import Joint, Mechanism, Platform
    from parakin.motion import laws
    from parakin.motion.laws import from_laws
    from parakin.motion.motion import Motion
    from parakin.motion.sampled import from_arrays
    from parakin.solving.batches import simulate_batch
    from parakin.solving.compiler import compile
    from parakin.solving.modes import modes
    from parakin.solving.results import history, require_solved
    from parakin.solving.solver import Solver
    from parakin.solving.status import Status
    from parakin.solving.tick import Tick
    from parakin.verbs import (
        check,
        draw,
        export,
        film,
        plot,
        record,
        report,
        save,
        view,
    )

_MODULES = {
    "catalogue": "files.reading",
    "load": "files.reading",
    "compile": "solving.compiler",
    "modes": "solving.modes",
    "sensitivities": "analysis.sensitivities",
    "singularities": "analysis.singularities",
    "linearise": "analysis.linearisation",
    "simulate_batch": "solving.batches",
    "stiffness": "analysis.stiffness",
    "certify": "design.certificate",
    "range": "design.range",
    "workspace": "design.workspace",
    "check": "verbs",
    "draw": "verbs",
    "export": "verbs",
    "film": "verbs",
    "plot": "verbs",
    "record": "verbs",
    "report": "verbs",
    "save": "verbs",
    "view": "verbs",
    "Solver": "solving.solver",
    "Tick": "solving.tick",
    "from_arrays": "motion.sampled",
    "from_laws": "motion.laws",
    "history": "solving.results",
    "require_solved": "solving.results",
    "Status": "solving.status",
    "Motion": "motion.motion",
    "Mechanism": "model.mechanism",
    "Body": "model.bodies",
    "Frame": "model.bodies",
    "Joint": "model.mechanism",
    "Platform": "model.mechanism",
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
    "certify",
    "check",
    "compile",
    "draw",
    "export",
    "film",
    "from_arrays",
    "from_laws",
    "history",
    "laws",
    "linearise",
    "load",
    "modes",
    "plot",
    "range",
    "record",
    "report",
    "require_solved",
    "save",
    "sensitivities",
    "simulate_batch",
    "singularities",
    "stiffness",
    "view",
    "workspace",
]


def __getattr__(name: str) -> Any:
    if name == "laws":
        return importlib.import_module("parakin.motion.laws")
    if name not in _MODULES:
        raise AttributeError(f"module 'parakin' has no attribute {name!r}")
    return getattr(importlib.import_module(f"parakin.{_MODULES[name]}"), name)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
