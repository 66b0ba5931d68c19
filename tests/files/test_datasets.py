"""Results written as CSV, NetCDF and Parquet, and read again."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import parakin
from parakin.arrays import ORDERS
from parakin.files import datasets

SOLVE = ("solve", "flight-simulator", "general")

Parakin = Callable[..., tuple[int, str, str]]


@pytest.fixture(autouse=True)
def _here(here: Path) -> None:
    """Every test runs in the folder."""


def read_csv(text: str) -> tuple[list[str], np.ndarray[tuple[int, int], np.dtype[np.float64]]]:
    header, *rows = csv.reader(io.StringIO(text))
    return header, np.array([[float(cell) if cell else np.nan for cell in row] for row in rows])


def test_csv_has_the_columns_told_and_every_bit(
    run: Parakin, general: xr.Dataset, solver: parakin.Solver
) -> None:
    assert run(*SOLVE, "-o", "general.csv")[0] == 0
    header, values = read_csv(Path("general.csv").read_text())
    coordinates = [f"{name}.{order}" for name in solver.coordinates for order in ORDERS[:3]]
    assert header == ["time", *coordinates, "status", "residual", "stopped_by"]
    for name in ("A2", "B3", "C3", "platform.x", "platform.y", "platform.phi", "platform.psi"):
        assert name in solver.coordinates
    expected = datasets.frame(general.drop_dims("body")).to_numpy(dtype=float)
    assert values.tobytes() == expected.tobytes()
    np.testing.assert_array_equal(values[:, 0], general["time"])
    for order in ORDERS[:3]:
        column = header.index(f"C3.{order}")
        np.testing.assert_array_equal(values[:, column], general[order].sel(coordinate="C3"))


def test_netcdf_opens_in_xarray_as_the_dataset(run: Parakin, general: xr.Dataset) -> None:
    assert run(*SOLVE, "-o", "general.nc", "--bodies")[0] == 0
    with xr.open_dataset("general.nc") as opened:
        xr.testing.assert_equal(opened, general)
        assert opened.attrs == general.attrs
        for name in general.variables:
            assert opened[name].dtype.kind == general[name].dtype.kind
        for name in (*ORDERS[:3], "residual", "time"):
            assert opened[name].attrs["units"] == general[name].attrs["units"]
            assert opened[name].values.tobytes() == general[name].values.tobytes()


def test_parquet_holds_the_same_table_as_csv(run: Parakin, general: xr.Dataset) -> None:
    import pandas as pd

    assert run(*SOLVE, "-o", "general.parquet", "--bodies")[0] == 0
    pd.testing.assert_frame_equal(
        pd.read_parquet("general.parquet"), datasets.frame(general), check_exact=True
    )


def test_bodies_come_before_the_last_three_columns(run: Parakin, general: xr.Dataset) -> None:
    assert run(*SOLVE, "-o", "bodies.csv", "--bodies")[0] == 0
    header, values = read_csv(Path("bodies.csv").read_text())
    vectors = ("position", "velocity", "angular_velocity", "acceleration", "angular_acceleration")
    for body in general["body"].values:
        for vector in vectors:
            assert [f"{body}.{vector}.{axis}" in header for axis in "xyz"] == [True] * 3
        assert [f"{body}.orientation.{part}" in header for part in "wxyz"] == [True] * 4
    assert header[-3:] == ["status", "residual", "stopped_by"]
    column = values[:, header.index("rod.angular_velocity.z")]
    np.testing.assert_array_equal(
        column, general["body_angular_velocity"].sel(body="rod", axis="z")
    )
    # The rod turns with the platform's psi about z.
    psi = values[:, header.index("platform.psi.velocity")]
    np.testing.assert_allclose(column, psi, atol=1e-12)


@pytest.mark.parametrize("suffix", [".csv", ".nc", ".parquet"])
def test_windows_are_written_as_one_result(
    suffix: str, solver: parakin.Solver, general: xr.Dataset, here: Path
) -> None:
    import pandas as pd

    motion = solver.motion("general")
    windows = list(solver.stream(motion, 700, bodies=True))
    assert [ds.sizes["time"] for ds in windows] == [700, 700, 700, 700, 201]
    datasets.write(windows, here / f"windows{suffix}")
    datasets.write([xr.concat(windows, "time", data_vars="minimal")], here / f"whole{suffix}")
    if suffix == ".csv":
        assert (here / "windows.csv").read_bytes() == (here / "whole.csv").read_bytes()
        assert (here / "windows.csv").read_text().count("time") == 1
    elif suffix == ".nc":
        with xr.open_dataset("windows.nc") as windowed, xr.open_dataset("whole.nc") as whole:
            xr.testing.assert_identical(windowed, whole)
            turned = "body_orientation"  # q and -q are the same orientation
            xr.testing.assert_allclose(
                windowed.drop_vars(turned), general.drop_vars(turned), rtol=1e-11, atol=1e-11
            )
            same = (windowed[turned] * general[turned]).sum("quaternion")
            np.testing.assert_allclose(abs(same), 1.0, rtol=1e-11)
    else:
        pd.testing.assert_frame_equal(
            pd.read_parquet("windows.parquet"), pd.read_parquet("whole.parquet"), check_exact=True
        )


def test_what_cannot_be_written_is_read_back_until_the_failure_is_raised(tmp_path: Path) -> None:
    """HDF5 reads what it wrote, in pieces of its own, and crashes on anything else."""
    rng = np.random.default_rng(0)
    model = np.zeros(20_000, dtype=np.uint8)
    with datasets._DeferredFailure(tmp_path / "a", "w+") as file:
        for step in range(400):
            if step == 200:
                file._failure = OSError("full")
            start, size = int(rng.integers(0, 15_000)), int(rng.integers(1, 5_000))
            part = rng.integers(0, 256, size, dtype=np.uint8)
            file.seek(start)
            assert file.write(part) == size
            assert file.tell() == start + size
            model[start : start + size] = part
            start, size = int(rng.integers(0, 15_000)), int(rng.integers(1, 5_000))
            found = bytearray(size)
            file.seek(start)
            known = file.readinto(found)
            assert found[:known] == model[start : start + known].tobytes()
            assert not any(model[start + known : start + size])
        file._failure = None


def test_what_was_written_before_a_failure_is_read_back_too(tmp_path: Path) -> None:
    with datasets._DeferredFailure(tmp_path / "a", "w+") as file:
        file.write(b"x" * 6000)
        file._failure = OSError("full")
        file.seek(5000)
        file.write(b"y" * 10)
        found = bytearray(1020)
        file.seek(4995)
        file.readinto(found)
        assert found == b"x" * 5 + b"y" * 10 + b"x" * 990 + bytes(15)
        with pytest.raises(OSError, match="full"):
            file.raise_failure()
        file._failure = None
