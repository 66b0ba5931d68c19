"""A plan: how a mechanism is solved for its driven coordinates. Data, made once, never changed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from parakin.arrays import FloatArray
from parakin.kinematics.closure import Row
from parakin.model.graph import Graph, Tree


@dataclass(frozen=True)
class Affine:
    """A coordinate that is affine in the driven ones: constant + sum of factor * driven."""

    constant: float
    factors: tuple[tuple[int, float], ...]


Form = Literal["linear", "quadratic", "turn", "turn with constant", "turn by two", "newton"]


@dataclass(frozen=True)
class Block:
    """Unknowns and as many rows, to be solved together once the blocks before are.

    (An angle may have two rows, in an overconstrained loop: together they have one root.)

    `form` says how (a single unknown has a closed form); `sign` is that of the determinant at
    home, which tells this branch from the other; `needs` are the unknowns of earlier blocks that
    the rows depend on. A `regular` block is never singular of itself; `reference` is what its
    conditioning is measured by, the arm an angle turns on at home [m, or as its row counts], or
    the determinant that several unknowns have there, their rows being of these `lengths`.
    """

    unknowns: tuple[int, ...]
    rows: tuple[Row, ...]
    form: Form = "newton"
    sign: float = 1.0
    needs: tuple[int, ...] = ()
    regular: bool = False
    reference: float = 1.0
    lengths: tuple[float, ...] = ()


@dataclass(frozen=True)
class Plan:
    """How to solve a mechanism for its driven coordinates.

    `home`: all coordinates at home, as their joints count; `zero`: at the mechanism's own home,
    which is another where a solver stands on another branch. `blocks` are in order of solution;
    `idle` are coordinates of idle freedoms, held at home; `unsolved` those of the tree that need
    not be solved as they are affine on this branch.
    """

    graph: Graph
    tree: Tree
    driven: tuple[int, ...]
    home: FloatArray
    zero: FloatArray
    affine: Mapping[int, Affine]
    blocks: tuple[Block, ...]
    idle: tuple[int, ...] = ()
    unsolved: tuple[int, ...] = ()

    def offset(self, coordinate: int) -> float:
        """What a coordinate counted from home has there, as its joint counts; else 0."""
        return float(self.zero[coordinate]) if coordinate in self.graph.from_home else 0.0
