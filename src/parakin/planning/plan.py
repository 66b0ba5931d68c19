"""A plan: how a mechanism is solved for its driven coordinates. Data, made once, never changed."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from parakin.algebra.spatial import Functions, Scalar
from parakin.arrays import FloatArray
from parakin.caching import cached_property
from parakin.kinematics.closure import Row
from parakin.kinematics.cones import Cone, cones_of
from parakin.model.designs import Designs, alike
from parakin.model.graph import Graph, Tree
from parakin.planning.forms import ITERATED, Form, Iterated


@dataclass(frozen=True)
class Affine:
    """A coordinate that is affine in the driven ones: constant + sum of factor * driven."""

    constant: float
    factors: tuple[tuple[int, float], ...]


@dataclass(frozen=True)
class Block:
    """Unknowns and the rows that determine them, to be solved together once the blocks before are.

    `form` says how; `needs` are the unknowns of earlier blocks that the rows depend on.
    """

    unknowns: tuple[int, ...]
    rows: tuple[Row, ...]
    form: Form = ITERATED
    needs: tuple[int, ...] = ()

    @property
    def iterated(self) -> bool:
        """Whether it has no closed form."""
        return isinstance(self.form, Iterated)


class Opening(NamedTuple):
    """Of a plan whose dimensions are scalars: that of the file's own design in numbers, all
    coordinates at home, and the functions of the scalars.
    """

    own: Plan
    home: tuple[Scalar, ...]
    functions: Functions


@dataclass(frozen=True)
class Plan:
    """How to solve a mechanism for its driven coordinates.

    `home`: all coordinates at home, as their joints count; `own_home`: at the mechanism's own home,
    which is another where a solver stands on another branch. `blocks` are in order of solution;
    `idle` are coordinates of idle freedoms, held at home; `unsolved` those of the tree that need
    not be solved as they are affine on this branch. `designs`: parameters that are left open; the
    plan serves for them too, `opened`.
    """

    graph: Graph
    tree: Tree
    driven: tuple[int, ...]
    home: FloatArray
    own_home: FloatArray
    affine: Mapping[int, Affine]
    blocks: tuple[Block, ...]
    idle: tuple[int, ...] = ()
    unsolved: tuple[int, ...] = ()
    designs: Designs | None = None
    opening: Opening | None = None

    @cached_property
    def cones(self) -> Mapping[str, Cone]:
        """Cone angles by name."""
        if self.opening is not None:
            return cones_of(self.graph, self.opening.home, self.opening.functions)
        return cones_of(self.graph, self.own_home.tolist())

    def opened(
        self, parameters: Sequence[Scalar], standing: Mapping[int, Scalar], functions: Functions
    ) -> Plan:
        """The plan for scalar values of the parameters that are left open, and of coordinates at
        the design's home, as their joints count, as far as they matter.
        """
        assert self.designs is not None
        graph = alike(self.graph, self.designs.opened(parameters, functions).graph)
        graph = replace(graph, from_home=self.graph.from_home)
        home: list[Scalar] = self.own_home.tolist()
        for k, value in standing.items():
            home[k] = value
        return replace(self, graph=graph, opening=Opening(self, tuple(home), functions))

    def standing(self, coordinates: Collection[int | str]) -> list[int]:
        """The coordinates whose values at home matter to these: those that are counted from it,
        and those of joints of cone angles.
        """
        cones = {name: joint for name, joint in self.graph.cones.items() if name in coordinates}
        around = [k for joint in cones.values() for k in joint.turns]
        return sorted({*self.graph.from_home, *around})

    def offset(self, coordinate: int) -> float:
        """What a coordinate counted from home has there, as its joint counts; else 0."""
        if coordinate not in self.graph.from_home:
            return 0.0
        if self.opening is not None:
            return self.opening.home[coordinate]  # type: ignore[return-value]
        return float(self.own_home[coordinate])

    @property
    def unknowns(self) -> list[int]:
        """All coordinates that are solved for, in order of solution."""
        return [k for block in self.blocks for k in block.unknowns]

    @property
    def iterated(self) -> list[int]:
        """Coordinates found by iteration, to be given a guess, in the order of input."""
        return [k for block in self.blocks if block.iterated for k in block.unknowns]

    def blocks_before(self, number: int) -> list[int]:
        """The blocks that one follows from, directly or not, in order of solution."""
        of = {k: place for place, block in enumerate(self.blocks) for k in block.unknowns}
        found: set[int] = set()
        waiting = [number]
        while waiting:
            needed = {of[k] for k in self.blocks[waiting.pop()].needs if k in of} - found
            found |= needed
            waiting += needed
        return sorted(found)

    @property
    def unsigned(self) -> bool:
        """Whether some figure of conditioning keeps no sign where it passes zero."""
        return bool(self.unsolved) or any(block.form.unsigned for block in self.blocks)
