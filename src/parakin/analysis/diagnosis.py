"""What is wrong, or likely a slip, in a mechanism: found before a motion is solved."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from parakin.algebra.angles import nearest_angle
from parakin.algebra.spatial import as_array
from parakin.analysis.indeterminacy import Indeterminacy, indeterminacy
from parakin.analysis.mobility import Mobility, mobility
from parakin.errors import AssemblyError, DrivenError
from parakin.files.force_histories import histories
from parakin.files.reading import load_motion
from parakin.kinematics.assembly import assembled
from parakin.kinematics.cones import cone_angles, cones_of
from parakin.kinematics.configuration import Configuration
from parakin.model.evaluation import graph_of
from parakin.model.expressions import Bare
from parakin.model.graph import Graph
from parakin.model.mechanism import Mechanism
from parakin.model.units import ANGLE, LENGTH
from parakin.solving.compiler import compile as compile_mechanism
from parakin.solving.results import flag_words
from parakin.solving.solver import Solver
from parakin.solving.stops import beyond_words

_FAR = 0.8  # [rad, or characteristic lengths]: not near a guess any more
_WIDE = 100.0  # [m] between joints: a machine as wide was meant in millimetres
_LISTED = 5  # places named in a warning


@dataclass(frozen=True)
class Diagnosis:
    """What `check` found.

    graph, home: the mechanism in numbers, and all coordinates as it is assembled, as their joints
    count; mobility: its mobility there; indeterminacy: of reactions. refusal: why it cannot be
    solved for what is driven, or None. warnings: what would be flagged at the first sample of a
    motion, and what is likely a slip in the file.
    """

    graph: Graph
    home: tuple[float, ...]
    mobility: Mobility
    indeterminacy: Indeterminacy
    refusal: DrivenError | AssemblyError | None
    warnings: tuple[str, ...]


def diagnosis(mechanism: Mechanism) -> Diagnosis:
    """Assemble a mechanism, determine its mobility, and look for what is wrong with it.

    Raises InputError, on a bad motion of the mechanism or a bad history of its forces too, and
    AssemblyError if home cannot be assembled.
    """
    graph, bare = _graph_of(mechanism)
    histories(mechanism, graph.dynamics.wrenches)
    home = assembled(graph)
    found = mobility(graph, home, len(mechanism.driven))
    refusal, solver = _compiled(mechanism)
    positions = _positions(graph, home)
    if refusal is None:
        _check_motions(graph, positions, bare)
    bare += _turning(mechanism, graph)
    warnings = [f"home is outside limits: {each}" for each in beyond_words(graph, positions)]
    warnings += [*_strays(graph, home), *_units(bare, _width(graph, home))]
    if found.special:
        warnings.append(
            f"home is special: mobility {found.home} there, {min(found.nearby)} in general"
        )
    if solver is not None:
        warnings += _flags(solver)
    reactions = indeterminacy(graph, home)
    return Diagnosis(graph, tuple(home.q.tolist()), found, reactions, refusal, tuple(warnings))


def unit_slips(mechanism: Mechanism) -> list[str]:
    """Numbers without a unit, other than those of motions, that were probably meant in degrees or
    millimetres: the warnings of `diagnosis` about them. Raises InputError.
    """
    graph, bare = _graph_of(mechanism)
    try:
        width = _width(graph, assembled(graph))
    except AssemblyError:  # which is told by whatever needs it assembled
        width = 0.0
    return _units([*bare, *_turning(mechanism, graph)], width)


def _graph_of(mechanism: Mechanism) -> tuple[Graph, list[Bare]]:
    """The mechanism in numbers, and those that have no unit, by their places in the file."""
    bare: list[Bare] = []
    graph = graph_of(mechanism, bare)
    return graph, [b._replace(place=b.place.removeprefix(f"{mechanism.where}: ")) for b in bare]


def _compiled(
    mechanism: Mechanism,
) -> tuple[DrivenError | AssemblyError | None, Solver | None]:
    """Why it cannot be solved for what is driven, or a solver."""
    try:
        return None, compile_mechanism(mechanism, machine_code=False)
    except (DrivenError, AssemblyError) as error:
        return error, None


def _turning(mechanism: Mechanism, graph: Graph) -> list[Bare]:
    """Parameters without a unit, above a turn, whose sine, cosine or tangent is taken."""
    text = str(mechanism.model_dump(exclude={"origin"}))  # whose name may be no UTF-8
    return [
        Bare(f"parameters.{name}", graph.parameters[name], ANGLE)
        for name, given in mechanism.parameters.items()
        if not isinstance(given, str) and re.search(rf"\b(?:sin|cos|tan)\([^()]*\b{name}\b", text)
    ]


def _check_motions(graph: Graph, positions: Mapping[str, float], bare: list[Bare]) -> None:
    """Raises InputError if one of the mechanism's own motions makes no sense."""
    mechanism = graph.mechanism
    values = {name: positions[name] for name in mechanism.driven}
    for motion in mechanism.motions:
        found: list[Bare] = []
        load_motion(motion, graph, values, bare=found)
        bare += [b._replace(place=f"motions.{motion}, {b.place}") for b in found]


def _positions(graph: Graph, home: Configuration) -> dict[str, float]:
    """Every coordinate at home, as it is counted, and every cone angle."""
    values = {
        c.name: 0.0 if k in graph.from_home else float(home.q[k])
        for k, c in enumerate(graph.coordinates)
    }
    return values | cone_angles(home.circuits, cones_of(graph, home.q.tolist()))


def _strays(graph: Graph, home: Configuration) -> list[str]:
    """Coordinates that ended far from their guess, or slides of the opposite sign."""
    strays = []
    for k, guess in graph.guess.items():
        found = float(home.q[k])
        if graph.coordinates[k].angle:
            astray = abs(nearest_angle(found - guess)) > _FAR
        else:
            astray = abs(found - guess) > _FAR * graph.length or found * guess < 0.0
        if astray:
            strays.append(graph.coordinates[k].name)
    if not strays:
        return []
    return [
        f"far from the guess, or of opposite sign: {', '.join(strays)}. Perhaps another assembly "
        "mode was meant (`parakin modes` lists them)"
    ]


def _width(graph: Graph, home: Configuration) -> float:
    """How far joints are apart at home."""
    joints = [
        as_array(home.pose(joint.parent).p + home.pose(joint.parent).R @ joint.F.p)
        for joint in graph.joints
    ]
    return float(np.linalg.norm(np.ptp(np.array(joints), axis=0)))


def _units(bare: Sequence[Bare], width: float) -> list[str]:
    """Bare numbers that were probably meant in degrees or millimetres, in a mechanism so wide."""
    warnings = []
    turns = {b.place: b.value for b in bare if b.dimension == ANGLE and abs(b.value) > 2 * math.pi}
    if turns:
        first = next(iter(turns.values()))
        warnings.append(
            f"angles without a unit are radians, and some are above a turn: {_listed(turns)}. "
            f"Perhaps '{first:g} deg' was meant"
        )
    lengths = {b.place: b.value for b in bare if b.dimension == LENGTH and abs(b.value) > 1.0}
    if lengths and not width < _WIDE:
        first = next(iter(lengths.values()))
        warnings.append(
            f"lengths without a unit are metres, and the mechanism is {width:,.0f} m wide: "
            f"{_listed(lengths)}. Perhaps '{first:g} mm' was meant"
        )
    return warnings


def _listed(places: Mapping[str, float]) -> str:
    named = [f"{place} = {value:g}" for place, value in places.items()]
    return ", ".join(named[:_LISTED]) + (", ..." if len(named) > _LISTED else "")


def _flags(solver: Solver) -> list[str]:
    """Motions whose first sample is flagged; without motions, home if it is."""
    flags = []
    for motion in solver.mechanism.motions:
        words = flag_words(next(solver.stream(motion, 1)), 0)
        if words:
            flags.append(f"motion {motion}: the first sample is flagged: {words}")
    if not solver.mechanism.motions:
        tick = solver.at([solver.home[name] for name in solver.driven])
        if tick.status:
            flags.append(f"home is flagged: {tick.why()}")
    return flags
