"""Motions from TOML tables: a law of time for each driven coordinate."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from parakin.errors import InputError, nearest
from parakin.files.parsing import flattened
from parakin.model.expressions import Parameters, Value
from parakin.model.units import ANGLE, FREQUENCY, TIME, Dimension
from parakin.model.validation import Table, Text, validated
from parakin.motion.checks import SLACK, refuse_unless_positive
from parakin.motion.laws import (
    Law,
    chirp,
    constant,
    cosine,
    from_laws,
    polynomial345,
    polynomial4567,
    sine,
    sines,
    waypoints,
)
from parakin.motion.motion import Motion


class _Constant(Table):
    law: Literal["constant"]
    value: Value


class _RestToRest(Table):
    law: Literal["cosine", "poly345", "poly4567"]
    by: Value | None = None
    to: Value | None = None
    from_: Value | None = Field(None, alias="from")
    begin: Value = 0.0
    duration: Value | None = None


class _Term(Table):
    amplitude: Value
    frequency: Value
    phase: Value = 0.0


class _Sine(_Term):
    law: Literal["sine"]
    center: Value | None = None


class _Sines(Table):
    law: Literal["sines"]
    terms: Annotated[list[_Term], Field(min_length=1)]
    center: Value | None = None


class _Chirp(Table):
    law: Literal["chirp"]
    amplitude: Value
    from_frequency: Value
    to_frequency: Value
    phase: Value = 0.0
    center: Value | None = None


class _Waypoints(Table):
    law: Literal["waypoints"]
    times: list[Value]
    values: list[Value]


_LawTable = Annotated[
    _Constant | _RestToRest | _Sine | _Sines | _Chirp | _Waypoints, Field(discriminator="law")
]


class _MotionTable(Table):
    duration: Value
    rate: Value = 1000.0  # samples per second
    title: Text = ""
    laws: dict[str, _LawTable] = Field(default_factory=dict)


def laws_by_coordinate(table: Mapping[str, Any], place: str) -> dict[str, Any]:
    """Law tables by coordinate: a table that holds only tables is part of a coordinate's name.

    Raises InputError on a name that is given twice.
    """
    return flattened(table, place, lambda t: bool(t) and all(map(_is_table, t.values())))


def _is_table(value: object) -> bool:
    return isinstance(value, Mapping)


def motion_from_table(
    table: Mapping[str, Any],
    name: str,
    parameters: Parameters,
    home: Mapping[str, float],
    dimensions: Mapping[str, Dimension],
    place: str,
    rate: float | None = None,
) -> Motion:
    """The motion in a TOML table: duration, rate, and laws by driven coordinate.

    dimensions: LENGTH or ANGLE, by driven coordinate. home: their positions at home [m or rad],
    where laws start or oscillate by default, and where a coordinate without a law rests. rate:
    samples per second, instead of the table's. Laws must begin and end within the motion.
    Raises InputError, with places below `place`.
    """
    table = dict(table)
    if isinstance(table.get("laws"), Mapping):
        table["laws"] = laws_by_coordinate(table["laws"], f"{place}.laws")
    checked = validated(_MotionTable, table, place)
    span = parameters.evaluate(checked.duration, TIME, f"{place}.duration")
    refuse_unless_positive(span, f"{place}.duration")
    if rate is None:
        rate = parameters.evaluate(checked.rate, FREQUENCY, f"{place}.rate")
        refuse_unless_positive(rate, f"{place}.rate")
    for coordinate in checked.laws:
        if coordinate not in dimensions:
            found = f"{coordinate!r}, not driven"
            raise InputError(f"{place}.laws", found, nearest(coordinate, dimensions))
    laws = {coordinate: constant(home[coordinate]) for coordinate in dimensions}
    for coordinate, law in checked.laws.items():
        try:
            laws[coordinate] = _law(
                law, parameters.evaluate, dimensions[coordinate], home[coordinate], span
            )
        except InputError as error:
            inner = f"{place}.laws.{coordinate}.{error.place}"
            raise InputError(inner, error.found, error.expected) from None
    return from_laws(name, laws, span, rate)


class _Lawful(Table):
    law: _LawTable


def law_from_table(
    table: Mapping[str, Any],
    parameters: Parameters,
    dimension: Dimension,
    place: str,
    home: float = 0.0,
) -> Law:
    """A law of its own, of no motion, about zero or `home`. Raises InputError, also on one whose
    end is that of its motion.
    """
    checked = validated(_Lawful, {"law": dict(table)}, place.removesuffix(".law")).law
    endless = isinstance(checked, _Chirp) or (
        isinstance(checked, _RestToRest) and checked.duration is None
    )
    if endless:
        found = f"the law {checked.law!r} without a duration"
        raise InputError(place, found, "one with a duration of its own")
    try:
        return _law(checked, parameters.evaluate, dimension, home, np.inf)
    except InputError as error:
        raise InputError(f"{place}.{error.place}", error.found, error.expected) from None


def _law(
    table: _LawTable,
    value: Callable[[Value, Dimension, str], float],
    dimension: Dimension,
    home: float,
    span: float,
) -> Law:
    """The law in `table` for a motion of `span` seconds. Raises InputError, with its keys as
    places.
    """

    def center(text: Value | None, key: str = "center") -> float:
        return home if text is None else value(text, dimension, key)

    def term(table: _Term, key: str = "") -> tuple[float, float, float]:
        return (
            value(table.amplitude, dimension, f"{key}amplitude"),
            value(table.frequency, FREQUENCY, f"{key}frequency"),
            value(table.phase, ANGLE, f"{key}phase"),
        )

    match table:
        case _Constant():
            return constant(value(table.value, dimension, "value"))
        case _Sine():
            return sine(center(table.center), *term(table))
        case _Sines():
            terms = [term(inner, f"terms[{i}].") for i, inner in enumerate(table.terms)]
            return sines(center(table.center), terms)
        case _Chirp():
            return chirp(
                center(table.center),
                value(table.amplitude, dimension, "amplitude"),
                value(table.from_frequency, FREQUENCY, "from_frequency"),
                value(table.to_frequency, FREQUENCY, "to_frequency"),
                span,
                value(table.phase, ANGLE, "phase"),
            )
        case _Waypoints():
            times = [value(text, TIME, f"times[{i}]") for i, text in enumerate(table.times)]
            values = [value(text, dimension, f"values[{i}]") for i, text in enumerate(table.values)]
            _refuse_outside(min(times, default=0.0), max(times, default=0.0), span, "times")
            return waypoints(times, values)
        case _RestToRest():
            start = center(table.from_, "from")
            if (table.by is None) == (table.to is None):
                found = "neither" if table.by is None else "both"
                raise InputError("by and to", found, "one of them")
            by = center(table.to, "to") - start
            if table.by is not None:
                by = value(table.by, dimension, "by")
            begin = value(table.begin, TIME, "begin")
            duration = span - begin
            if table.duration is not None:
                duration = value(table.duration, TIME, "duration")
            _refuse_outside(begin, begin + duration, span, "begin")
            make = {"cosine": cosine, "poly345": polynomial345, "poly4567": polynomial4567}
            return make[table.law](start, by, duration, begin)


def _refuse_outside(begin: float, end: float, span: float, place: str) -> None:
    if not 0 <= begin <= end <= span * (1 + SLACK):
        found = f"a law from {begin:g} s to {end:g} s"
        raise InputError(place, found, f"one within the motion, 0 s to {span:g} s")
