"""Which coordinates a workspace is over, and of what kind it then is."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from parakin.design.asked import check_driven
from parakin.errors import InputError, nearest
from parakin.solving.solver import Solver

_OF_SLIDES = ("constant-orientation", "reachable", "dexterous")
KINDS = (*_OF_SLIDES[:1], "orientation", "mixed", *_OF_SLIDES[1:])
_COUNTS = (2, 3)


class Moving(NamedTuple):
    """The kind of a workspace, and the coordinates moved in it."""

    kind: str
    over: tuple[str, ...]


def moving(solver: Solver, over: Sequence[str] | None, kind: str | None) -> Moving:
    """What is moved, as asked for. No kind: that of what is moved. No coordinates: all that the
    kind is about; of no kind the slides, or, if there are not two or three, whatever is driven of
    the platform. Raises InputError.
    """
    if kind is not None and kind not in KINDS:
        raise InputError("kind", repr(kind), nearest(str(kind), KINDS))
    if over is None:
        names = _by_default(solver, kind)
    else:
        names = (over,) if isinstance(over, str) else tuple(over)
        _check_names(solver, names)
    if len(names) not in _COUNTS:
        count = f"{len(names)} driven {_what(kind)} of the platform"
        if over is not None or len(names) == 1:
            count = "one coordinate alone" if len(names) == 1 else f"{len(names)} coordinates"
        raise InputError("over", count, "two or three to move")
    return Moving(_kind_of(solver, names, kind), names)


def _what(kind: str | None) -> str:
    if kind in (None, "mixed"):
        return "coordinates"
    return "angles" if kind == "orientation" else "slides"


def _by_default(solver: Solver, kind: str | None) -> tuple[str, ...]:
    """All that a kind is about, of the platform if any of that is driven."""

    def fitting(*angles: bool) -> tuple[str, ...]:
        some = tuple(n for n in solver.driven if solver.graph.is_angle(n) in angles)
        return tuple(name for name in some if name.startswith("platform.")) or some

    if kind in _OF_SLIDES:
        return fitting(False)
    if kind == "orientation":
        return fitting(True)
    slides = fitting(False)
    return slides if kind is None and len(slides) in _COUNTS else fitting(False, True)


def _check_names(solver: Solver, names: tuple[str, ...]) -> None:
    for name in names:
        check_driven(solver, name, "over")
    if len(set(names)) != len(names):
        raise InputError("over", "a coordinate twice", "each once")


def _kind_of(solver: Solver, names: tuple[str, ...], kind: str | None) -> str:
    """The kind, if these coordinates fit it. Raises InputError."""
    angles = [solver.graph.is_angle(name) for name in names]
    if kind is None:
        return (
            "mixed" if len(set(angles)) > 1 else ("constant-orientation", "orientation")[angles[0]]
        )
    if kind == "mixed":
        if len(set(angles)) == 1:
            found = f"{'angles' if angles[0] else 'slides'} alone in a workspace of kind mixed"
            raise InputError("over", found, "at least one slide and one angle")
        return kind
    for name, angle in zip(names, angles, strict=True):
        if angle != (kind == "orientation"):
            found = f"{name!r} in a workspace of kind {kind}"
            raise InputError("over", found, f"{_what(kind)} alone")
    return kind
