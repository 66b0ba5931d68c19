"""Datasets written as CSV, NetCDF or Parquet, window by window, whole or not at all."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

import numpy as np

from parakin.arrays import OF_MECHANISM, ORDERS, PER_ACTUATOR, PER_JOINT
from parakin.files.writing import check_suffix, replacing
from parakin.model.validation import refuse_control

if TYPE_CHECKING:
    import pandas as pd

    from parakin.labelled import Result

_PAGE = 4096  # bytes, or rows of a table
SUFFIXES = (".csv", ".nc", ".parquet")
_NEEDS = {".nc": ("h5netcdf", "h5py"), ".parquet": ("pyarrow",)}
_BODY = {
    "position": "body_position",
    "orientation": "body_orientation",
    "velocity": "body_velocity",
    "angular_velocity": "body_angular_velocity",
    "acceleration": "body_acceleration",
    "angular_acceleration": "body_angular_acceleration",
}


def check_output(path: Path) -> None:
    """Raises InputError if the suffix of `path` is unknown or its library is not installed."""
    needs = _NEEDS.get(path.suffix.lower(), ())
    check_suffix(path, SUFFIXES, dict(zip(needs, needs, strict=True)), "files")


def frame(ds: Result) -> pd.DataFrame:
    """The result as a flat table, see `columns`."""
    import pandas as pd

    return pd.DataFrame(columns(ds))


def columns(ds: Result) -> dict[str, Any]:
    """The result as a flat table, SI, a row per sample: `time`, `A2.position`, ..., `status`,
    `residual`, `stopped_by`: numbers alone, so that any program can read them.

    Bodies, if there are any, come before the last three: `rod.position.x`, ...; then forces:
    `P1.effort`, ..., `A2.reaction_force.x`, ...
    """
    table: dict[str, Any] = {"time": ds["time"].values}
    orders = {order: ds[order].values for order in ORDERS if order in ds}
    for k, name in enumerate(ds["coordinate"].values.tolist()):
        for order, values in orders.items():
            table[f"{name}.{order}"] = values[:, k]
    if "body" in ds:
        for b, body in enumerate(ds["body"].values.tolist()):
            for label, variable in _BODY.items():
                axes = ds["quaternion" if label == "orientation" else "axis"].values.tolist()
                for a, axis in enumerate(axes):
                    table[f"{body}.{label}.{axis}"] = ds[variable].values[:, b, a]
    table |= _forces(ds)
    table["status"] = ds["status"].values
    table["residual"] = ds["residual"].values
    table["stopped_by"] = ds["stopped_by"].values
    return table


def _forces(ds: Result) -> dict[str, Any]:
    """Columns of forces and energies, those of each actuator and joint together."""
    table: dict[str, Any] = {}
    for place, (dimension, names) in enumerate(
        (("actuator", PER_ACTUATOR), ("joint", PER_JOINT), ("idle", ("idle_effort",)))
    ):
        known = [name for name in names if name in ds]
        for k, label in enumerate(ds[dimension].values.tolist() if known else []):
            for name in known:
                values = ds[name].values
                if dimension == "joint":
                    for a, axis in enumerate("xyz"):
                        table[f"{label}.{name}.{axis}"] = values[:, k, a]
                else:
                    table[f"{label}.{name}"] = values[:, k]
        if place == 0 and "effort_conditioning" in ds:
            table["effort_conditioning"] = ds["effort_conditioning"].values
    return table | {name: ds[name].values for name in OF_MECHANISM if name in ds}


def write(windows: Iterable[Result], path: Path) -> None:
    """Write consecutive windows of one result to `path`, in the format of its suffix.

    Doubles are written in full. If it fails, nothing is left behind. Raises InputError if the
    path cannot be written.
    """
    check_output(path)
    writer: Callable[[Iterable[Result], Path], None] = {
        ".csv": _csv,
        ".nc": _netcdf,
        ".parquet": _parquet,
    }[path.suffix.lower()]
    with replacing(path) as temporary:
        writer(_checked(windows, path), temporary)


def _checked(windows: Iterable[Result], path: Path) -> Iterator[Result]:
    """The windows. Raises InputError on texts that no file can hold."""
    for ds in windows:
        for name, value in ds.attrs.items():
            for text in (name, value):
                if isinstance(text, str):
                    refuse_control(text, f"{path}: attribute {name}")
        yield ds


def write_csv(windows: Iterable[Result], stream: TextIO) -> None:
    """Write consecutive windows of one result as CSV to an open stream: numbers in full, as
    Python and pandas write them, and nothing where one is NaN.
    """
    writer = csv.writer(stream, lineterminator="\n")
    for number, ds in enumerate(windows):
        table = columns(ds)
        if number == 0:
            writer.writerow(table)
        for start in range(0, len(table["time"]), _PAGE):
            page = [_cells(values[start : start + _PAGE]) for values in table.values()]
            writer.writerows(zip(*page, strict=True))


def _cells(values: Any) -> list[Any]:
    """Numbers of a column."""
    cells: list[Any] = values.tolist()
    if values.dtype.kind == "f":
        for k in np.flatnonzero(np.isnan(values)):
            cells[k] = ""
    return cells


def _csv(windows: Iterable[Result], path: Path) -> None:
    with path.open("w", encoding="utf-8", newline="") as stream:
        write_csv(windows, stream)


def _parquet(windows: Iterable[Result], path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    writer = None
    with path.open("wb") as stream:  # pyarrow takes no name that is not UTF-8
        try:
            for ds in windows:
                table = pa.Table.from_pandas(frame(ds), preserve_index=False)
                if writer is None:
                    known = ds.attrs.items()  # but not what later windows will know better
                    meta = {k: str(v) for k, v in known if k != "stops_met"}
                    schema = table.schema.with_metadata({**(table.schema.metadata or {}), **meta})
                    writer = pq.ParquetWriter(stream, schema)
                writer.write_table(table.cast(writer.schema))
        finally:
            if writer is not None:
                writer.close()


def _netcdf(windows: Iterable[Result], path: Path) -> None:
    import h5netcdf

    iterator: Iterator[Result] = iter(windows)
    first = next(iterator)
    with _DeferredFailure(path, "w+") as stream, h5netcdf.File(stream, "w") as file:
        file.dimensions = {
            str(name): None if name == "time" else size for name, size in first.sizes.items()
        }
        file.attrs.update(first.attrs)
        for name, variable in first.variables.items():
            values = variable.values
            text = values.dtype.kind in "UO"
            attributes = dict(variable.attrs)
            if values.dtype.kind == "b":  # as xarray itself does
                values, attributes["dtype"] = values.astype(np.int8), "bool"
            chunks = None
            if "time" in variable.dims:
                chunks = tuple(
                    min(size, 4096) if dim == "time" else size
                    for dim, size in zip(variable.dims, values.shape, strict=True)
                )
            made = file.create_variable(
                str(name),
                variable.dims,
                _text_type() if text else values.dtype,
                chunks=chunks,
            )
            made.attrs.update(attributes)
            if "time" not in variable.dims:
                made[...] = values.astype(object) if text else values
        if "coordinate" in first:
            for name in (name for name in (*ORDERS, "home") if name in first):
                file[name].attrs["coordinates"] = "unit actuated driven"
        if "actuator" in first:
            for name in (name for name in PER_ACTUATOR if name in first):
                file[name].attrs["coordinates"] = "effort_unit"
        if "stop" in first:
            for name in ("limit_low", "limit_high"):
                file[name].attrs["coordinates"] = "stop_unit"
        _append(file, first, 0)
        total = first.sizes["time"]
        for ds in iterator:
            stream.raise_failure()
            _append(file, ds, total)
            total += ds.sizes["time"]
            file.attrs["stops_met"] = ds.attrs["stops_met"]  # those of the windows before too


class _DeferredFailure(io.FileIO):
    """A file for HDF5, which crashes if a write fails: the failure is kept and raised later.

    What could not be written is kept too, in pages of memory: HDF5 reads back what it wrote, and
    crashes on anything else.
    """

    _failure: OSError | None = None

    def __init__(self, path: Path, mode: str) -> None:
        super().__init__(path, mode)
        self._pages: dict[int, bytearray] = {}

    def write(self, data: Any) -> int:
        rest = memoryview(data).cast("B")
        start, size = self.tell(), len(rest)
        while len(rest) and self._failure is None:
            try:
                rest = rest[super().write(rest) or 0 :]
            except OSError as error:
                self._failure = error
        for page, place, part in _paged(start + size - len(rest), len(rest)):
            if page not in self._pages:
                self._pages[page] = bytearray(_PAGE)
                self.seek(page * _PAGE)
                super().readinto(self._pages[page])
            self._pages[page][place : place + len(part)] = rest[part.start : part.stop]
        if len(rest):  # in pages, which do not move the file's own place
            self.seek(start + size)
        return size

    def readinto(self, buffer: Any, /) -> int:
        if self._failure is None:
            return super().readinto(buffer) or 0
        whole = memoryview(buffer).cast("B")
        start, size = self.tell(), len(whole)
        known = super().readinto(whole) or 0
        whole[known:] = bytes(size - known)
        for page, place, part in _paged(start, size):
            if page in self._pages:
                kept = self._pages[page][place : place + len(part)]
                whole[part.start : part.stop] = kept
        self.seek(start + size)
        return size

    def truncate(self, size: int | None = None) -> int:
        try:
            return super().truncate(size)
        except OSError as error:
            self._failure = self._failure or error
            return size or 0

    def __exit__(self, *error: object) -> None:
        self.close()
        self.raise_failure()

    def raise_failure(self) -> None:
        if self._failure is not None:
            raise self._failure


def _paged(start: int, size: int) -> Iterator[tuple[int, int, range]]:
    """Bytes of a file by page: the page, the place in it, and which of the bytes."""
    done = 0
    while done < size:
        page, place = divmod(start + done, _PAGE)
        count = min(_PAGE - place, size - done)
        yield page, place, range(done, done + count)
        done += count


def _text_type() -> Any:
    import h5py

    return h5py.string_dtype()


def _append(file: Any, ds: Result, start: int) -> None:
    stop = start + ds.sizes["time"]
    file.resize_dimension("time", stop)
    for name, variable in ds.variables.items():
        if "time" in variable.dims:
            file[str(name)][start:stop] = np.ascontiguousarray(variable.values)
