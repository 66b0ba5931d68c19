"""Motions from CSV files: a column of times and columns of the driven coordinates."""

from __future__ import annotations

import csv
import itertools
import math
import re
import stat
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from parakin.arrays import ORDERS, FloatArray
from parakin.errors import InputError, nearest, printable, reason
from parakin.model.expressions import Parameters
from parakin.model.units import ATOM, TIME, Dimension
from parakin.motion.motion import Motion
from parakin.motion.sampled import from_arrays

MAX_BYTES = 2 * 10**9
_RESULTS = re.compile(  # columns of our own results other than those of driven coordinates
    r"status|residual|(effort_)?conditioning|stopped_by|force_imbalance"
    r"|(kinetic|potential)_energy|power_(lost|applied)|(energy|closure)_drift"
    r"|.+\.(effort(_band)?|power|motor_(torque(_band)?|speed|power|current)|idle_effort)"
    r"|.+\.reaction_(force|moment)\.[xyz]"
    r"|.+\.(orientation|(angular_)?(position|velocity|acceleration|jerk))(\.[wxyz])?"
)
_COLUMN = re.compile(r"([^\[\]]*?)\s*(?:\[(.*)\])?")
_UNIT = re.compile(rf"{ATOM}(?:\s*/\s*s\*\*[23]|(?:\s*[*/·]\s*|\s+){ATOM})*")


class _Column(NamedTuple):
    at: int
    header: str
    factor: float  # the column's unit in SI


def read_motion_csv(
    path: str | Path,
    dimensions: Mapping[str, Dimension],
    smoothing: float | Mapping[str, float] | None = None,
    max_gap: float | None = None,
) -> Motion:
    """The motion in a CSV file, named after the file.

    The header names the columns: `time`, for each driven coordinate (the keys of `dimensions`)
    `NAME` or `NAME.position` and, for all or for none, `NAME.velocity` and `NAME.acceleration`,
    to which `NAME.jerk` may be
    added. A unit may follow in brackets, `platform.x [mm]`; otherwise it is SI. Columns are
    separated by commas, semicolons or tabs, whichever the header has most of; numbers have a
    decimal point. Lines with # may precede the header. The text is UTF-8.

    So that a result can be a motion, columns of bodies and of other coordinates are ignored if
    they name their quantity (`A2.position`), and so are `status`, `residual`, `conditioning` and
    `stopped_by`.

    dimensions: LENGTH or ANGLE, by driven coordinate. smoothing, max_gap: as in `from_arrays`.
    Raises InputError, with the file and, where possible, line and column, on anything else.
    """
    path = Path(path)
    time, given = _read(path, dimensions)
    try:
        return from_arrays(
            printable(path.stem),
            tuple(dimensions),
            time,
            given["position"],
            *(given.get(quantity) for quantity in ORDERS[1:]),
            smoothing=smoothing,
            max_gap=max_gap,
        )
    except InputError as error:
        raise error.within(str(path)) from None


def read_histories(
    path: Path, dimensions: Mapping[str, Dimension]
) -> tuple[FloatArray, FloatArray]:
    """Times (n,) [s] and values (columns, n) in SI of a CSV file of these columns, written as for
    `read_motion_csv`. Raises InputError, also on times that do not increase.
    """
    time, given = _read(path, dimensions)
    if len(time) < 2 or not (np.diff(time) > 0.0).all():
        raise InputError(str(path), f"{len(time)} samples", "two or more, at times that increase")
    return time, given["position"]


def read_efforts(path: Path, dimensions: Mapping[str, Dimension]) -> tuple[FloatArray, FloatArray]:
    """Times (n,) [s] and efforts (m, n) in SI of a CSV file with a column for each of these
    coordinates: `NAME` or, as in our own results, `NAME.effort`. Raises InputError.
    """
    _, header = next(_lines(path), (0, ""))
    headers = _cells(header, max(",;\t", key=header.count), f"{path}, header") if header else []
    names = [match[1] if (match := _COLUMN.fullmatch(each)) else each for each in headers]
    if any(f"{name}.effort" in names for name in dimensions):
        return read_histories(path, {f"{name}.effort": d for name, d in dimensions.items()})
    for name in names:
        coordinate, _, quantity = name.rpartition(".")
        if coordinate in dimensions and quantity in ORDERS:
            expected = f"efforts: {coordinate}, or {coordinate}.effort"
            raise InputError(f"{path}, column {name!r}", f"a {quantity}", expected)
    return read_histories(path, dimensions)


def _read(
    path: Path, dimensions: Mapping[str, Dimension]
) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Times, and values (columns, n) by quantity. Raises InputError."""
    lines = _lines(path)
    _, header = next(lines, (0, ""))
    if not header:
        raise InputError(str(path), "no text", "a header and samples")
    delimiter = max(",;\t", key=header.count)
    headers = _cells(header, delimiter, f"{path}, header")
    columns = _columns(headers, dimensions, str(path))
    quantities = [q for q in ORDERS if _complete(columns, q, dimensions, str(path))]
    wanted = [columns["time", ""]]
    wanted += [columns[name, quantity] for quantity in quantities for name in dimensions]
    table = _table(path, lines, delimiter, len(headers), wanted)
    time, values = table[:, 0], table[:, 1:].T.reshape(len(quantities), len(dimensions), -1)
    return time, dict(zip(quantities, values, strict=True))


def _lines(path: Path) -> Iterator[tuple[int, str]]:
    """The header and the lines below it, numbered from 1 in the file, without blank ones."""
    try:
        status = path.stat()
        if not stat.S_ISREG(status.st_mode):
            raise InputError(str(path), "a folder or special file", "a CSV file")
        if status.st_size > MAX_BYTES:
            raise InputError(str(path), f"{status.st_size} bytes", f"at most {MAX_BYTES}")
        with path.open(encoding="utf-8-sig") as file:
            numbered = ((n, line) for n, line in enumerate(file, 1) if not line.isspace())
            yield from itertools.dropwhile(lambda item: item[1].lstrip().startswith("#"), numbered)
    except UnicodeDecodeError:
        raise InputError(str(path), "bytes that are not UTF-8", "a text file in UTF-8") from None
    except (OSError, ValueError) as error:  # ValueError: a null character in the path
        raise InputError(str(path), reason(error), "a readable CSV file") from None


def _cells(line: str, delimiter: str, place: str) -> list[str]:
    try:
        return [cell.strip() for cell in next(csv.reader([line.strip("\n")], delimiter=delimiter))]
    except csv.Error as error:  # a cell of more than 131072 characters, a null character
        raise InputError(place, str(error), "cells of text or numbers") from None


def _table(
    path: Path,
    lines: Iterator[tuple[int, str]],
    delimiter: str,
    width: int,
    wanted: Sequence[_Column],
) -> FloatArray:
    """The numbers in the wanted columns, SI, a row per sample."""
    first = next(lines, None)
    if first is None:
        raise InputError(str(path), "only a header", "samples below it")
    rows = _rows(itertools.chain([first], lines), delimiter, width, str(path))
    used = [column.at for column in wanted]
    try:
        table = np.loadtxt(
            rows, delimiter=delimiter, usecols=used, comments=None, quotechar='"', ndmin=2
        )
    except ValueError as error:
        _refuse_cell(path, delimiter, wanted)
        raise InputError(str(path), str(error), "numbers") from None
    if not np.isfinite(table).all():
        _refuse_cell(path, delimiter, wanted)
    with np.errstate(over="ignore"):
        table *= [column.factor for column in wanted]
    if not np.isfinite(table).all():
        header = wanted[int(np.argmin(np.isfinite(table).all(axis=0)))].header
        raise InputError(f"{path}, column {header!r}", "a number beyond all in SI", "smaller ones")
    return table


def _rows(
    lines: Iterator[tuple[int, str]], delimiter: str, width: int, place: str
) -> Iterator[str]:
    """The lines, each checked to have `width` cells: loadtxt with `usecols` does not."""
    for number, line in lines:
        where = f"{place}, line {number}"
        cells = len(_cells(line, delimiter, where)) if '"' in line else line.count(delimiter) + 1
        if cells != width:
            raise InputError(where, f"{cells} cells", f"{width}, as in the header")
        yield line


def _columns(
    headers: Sequence[str], dimensions: Mapping[str, Dimension], place: str
) -> dict[tuple[str, str], _Column]:
    """Columns by coordinate and quantity, ("time", "") among them, without those to ignore."""
    columns: dict[tuple[str, str], _Column] = {}
    known = ["time", *dimensions, *(f"{n}.{q}" for n in dimensions for q in ORDERS)]
    for index, header in enumerate(headers):
        match = _COLUMN.fullmatch(header)
        name, unit = match.groups() if match else (header, None)
        coordinate, _, quantity = name.rpartition(".")
        if quantity not in ORDERS:
            coordinate, quantity = name, "" if name == "time" else "position"
        where = f"{place}, column {index + 1}"
        if (coordinate, quantity) in columns:
            twice = columns[coordinate, quantity].header
            raise InputError(where, f"{header!r} after {twice!r}", "one column each")
        factor = 1.0
        if coordinate in dimensions or name == "time":
            dimension = TIME if name == "time" else dimensions[coordinate]
            order = 0 if name == "time" else ORDERS.index(quantity)
            dimension = dimension._replace(time=dimension.time - order)
            factor = _factor(unit, dimension, f"{where} {header!r}")
        elif not _RESULTS.fullmatch(name):
            raise InputError(where, f"{header!r}", nearest(name, known))
        columns[coordinate, quantity] = _Column(index, header, factor)
    for coordinate, quantity in [("time", ""), *((name, "position") for name in dimensions)]:
        if (coordinate, quantity) not in columns:
            found = f"no column {coordinate!r} among {', '.join(headers)}"
            raise InputError(place, found, f"columns {', '.join(('time', *dimensions))}")
    return columns


def _factor(unit: str | None, dimension: Dimension, place: str) -> float:
    if unit is None:
        return 1.0
    if not _UNIT.fullmatch(unit.strip()):
        raise InputError(place, f"the unit [{unit}]", "a unit such as mm, deg/s or m/s^2")
    return Parameters({}).evaluate(f"1 {unit}", dimension, place)


def _complete(
    columns: Mapping[tuple[str, str], _Column],
    quantity: str,
    dimensions: Mapping[str, Dimension],
    place: str,
) -> bool:
    """Whether there are columns of `quantity`. Raises InputError if only some have one."""
    lacking = [name for name in dimensions if (name, quantity) not in columns]
    if 0 < len(lacking) < len(dimensions):
        found = f"columns of {quantity}, but none for {lacking[0]!r}"
        raise InputError(place, found, "columns for all driven coordinates or for none")
    return not lacking


def _refuse_cell(path: Path, delimiter: str, wanted: Sequence[_Column]) -> None:
    """Raises InputError on the first cell that is not a finite number."""
    for number, line in itertools.islice(_lines(path), 1, None):
        cells = _cells(line, delimiter, f"{path}, line {number}")
        for column, cell in ((c, cells[c.at]) for c in wanted if c.at < len(cells)):
            try:  # as loadtxt, unlike float(), refuses 1_000 and digits beyond ASCII
                sound = math.isfinite(float(cell)) and cell.isascii() and "_" not in cell
            except ValueError:
                sound = False
            if not sound:
                where = f"{path}, line {number}, column {column.header!r}"
                raise InputError(where, repr(cell), "a finite number with a decimal point")
