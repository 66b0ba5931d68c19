"""Results that are no motions, written whole: a flat table as CSV, or a Dataset as NetCDF."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from parakin.files.writing import check_suffix, replacing

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

SUFFIXES = (".csv", ".nc")


def check_table(path: Path) -> None:
    """Raises InputError if the suffix of `path` is unknown or its library is not installed."""
    needs = {"h5netcdf": "h5netcdf"} if path.suffix.lower() == ".nc" else {}
    check_suffix(path, SUFFIXES, needs, "files")


def write(table: pd.DataFrame, ds: xr.Dataset, path: Path) -> None:
    """Write one of the two in the format of the suffix, whole or not at all. Raises InputError."""
    check_table(path)
    with replacing(path) as temporary:
        if path.suffix.lower() == ".nc":
            ds.to_netcdf(temporary, engine="h5netcdf")
        else:
            table.to_csv(temporary, index=False, lineterminator="\n")
