"""Forces in Datasets: dimensions, units, and the same in the schema and in files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import parakin


def test_a_result_labels_its_forces() -> None:
    solver = parakin.compile("seat-3dof")
    ds = solver.solve("sway", reactions=["P", "U"], energies=True)
    assert ds["effort"].dims == ("time", "actuator")
    assert ds["effort"].attrs["units"] == "N m"
    assert ds["actuator"].values.tolist() == ["A1", "A2", "A3"]
    assert ds["effort_unit"].values.tolist() == ["N m"] * 3
    assert ds["reaction_force"].dims == ("time", "joint", "axis")
    assert ds["reaction_force"].sel(joint="P", axis="z").shape == (ds.sizes["time"],)
    assert set(ds.data_vars) >= {"motor_torque", "motor_current", "kinetic_energy", "power_lost"}
    power = ds["effort"] * ds["velocity"].sel(coordinate=ds["actuator"].values).values
    assert ds["power"].values == pytest.approx(power.values)


def test_the_schema_is_that_of_the_result() -> None:
    solver = parakin.compile("seat-3dof")
    asked: dict[str, Any] = {"reactions": True, "energies": True, "bodies": ["seat.head"]}
    ds, schema = solver.solve("sway", **asked), solver.schema("sway", **asked)
    assert schema.sizes == ds.sizes
    for name, variable in ds.variables.items():
        assert schema.variables[name].dims == variable.dims
        assert schema.variables[name].dtype == variable.dtype
        if name not in ("stops_met",):
            assert schema.variables[name].attrs == variable.attrs
    assert np.isnan(schema["effort"].values).all()


def test_without_forces_nothing_is_added() -> None:
    ds = parakin.compile("seat-3dof").solve("sway")
    assert "effort" not in ds
    assert "actuator" not in ds.dims


@pytest.mark.parametrize("suffix", [".nc", ".csv", ".parquet"])
def test_files_hold_forces(tmp_path: Path, suffix: str) -> None:
    solver = parakin.compile("seat-2dof")
    path = tmp_path / f"sway{suffix}"
    ds = solver.solve("sway", reactions=["U"], energies=True)
    parakin.save(solver.stream("sway", 1000, reactions=["U"], energies=True), path)
    if suffix == ".nc":
        back = xr.open_dataset(path, engine="h5netcdf")
        assert back["effort"].values == pytest.approx(ds["effort"].values, rel=1e-12)
        assert back["reaction_moment"].dims == ("time", "joint", "axis")
        return
    import pandas as pd

    table = pd.read_csv(path) if suffix == ".csv" else pd.read_parquet(path)
    assert table["A1.effort"].to_numpy() == pytest.approx(ds["effort"].values[:, 0], rel=1e-12)
    force = ds["reaction_force"].sel(joint="U", axis="z").values
    assert table["U.reaction_force.z"].to_numpy() == pytest.approx(force, rel=1e-12)
    assert "kinetic_energy" in table


def test_a_result_with_forces_is_a_motion(tmp_path: Path) -> None:
    solver = parakin.compile("seat-2dof")
    path = tmp_path / "sway.csv"
    parakin.save(solver.solve("sway", reactions=True, energies=True), path)
    again = solver.solve(path)
    assert not again["status"].values.any()
