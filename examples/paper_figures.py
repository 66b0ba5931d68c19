"""Figures 2-11 of the paper, and the misprint of its equation (11), into docs/figures.

    python examples/paper_figures.py [FOLDER]

The scheme of the mechanism, and three evolutions of the platform, each as displacement, velocity
and acceleration of the three sliders; as PNG and SVG. Needs matplotlib.
"""

import sys
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

import parakin
from parakin.views.plots import histories, save
from parakin.views.scheme import scheme

SLIDERS = ["A2", "B3", "C3"]
EVOLUTIONS = {"vertical": 3, "rectilinear": 6, "general": 9}


def printed_velocity_of_c(result: xr.Dataset, solver: parakin.Solver) -> xr.DataArray:
    """v32 of leg C by the third line of eq. (11) as it is printed, two of its signs wrong."""
    b = solver.graph.parameters["b"]
    at = {str(name): result.sel(coordinate=name) for name in result.coordinate.values}
    gamma = at["A1"].position - at["A3"].position  # psi + alpha_1 - alpha_2
    turning = at["platform.psi"].velocity  # omega_30 of the rod
    phi, phi_rate = at["platform.phi"].position, at["platform.phi"].velocity
    lean, tilt = at["C1.1"].position, at["C1.2"].position
    x, y = at["platform.x"].velocity, at["platform.y"].velocity
    across = (
        -x * np.sin(lean)
        + y * np.cos(lean)
        + b / 2 * turning * np.sin(phi) * np.sin(gamma - lean)  # should be minus
        + b / 2 * phi_rate * np.cos(phi) * np.cos(gamma - lean)
    )
    sunk: xr.DataArray = b / 2 * phi_rate * np.sin(phi) * np.cos(tilt)
    printed: xr.DataArray = across * np.sin(tilt) - sunk  # should be plus
    return printed


def misprint(result: xr.Dataset, solver: parakin.Solver) -> Figure:
    """The slider's velocity as it is, and as the printed equation has it."""
    figure = histories(result, ["C3"], solver.mechanism.symbols, ["velocity"])
    axes = figure.axes[0]
    (line,) = axes.get_lines()[:1]
    line.set_label("corrected")
    printed = printed_velocity_of_c(result, solver)
    axes.plot(result.time, printed, color="#D55E00", linestyle="--", linewidth=1.2, label="printed")
    axes.set_ylabel(r"$v_{32}^C$ [m/s]")
    axes.legend(frameon=False, loc="lower center")
    return figure


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    solver = parakin.compile("flight-simulator")
    symbols = solver.mechanism.symbols
    rates = {name: s.replace("λ", "v") for name, s in symbols.items()}
    second = {name: s.replace("λ", "γ") for name, s in symbols.items()}
    scheme.save(scheme.scheme(solver.graph), folder / "figure-02.svg")
    for evolution, number in EVOLUTIONS.items():
        result = parakin.require_solved(solver.solve(evolution))
        for k, (order, names) in enumerate(
            [("position", symbols), ("velocity", rates), ("acceleration", second)]
        ):
            figure = histories(result, SLIDERS, names, [order])
            figure.axes[0].set_ylabel(
                ["displacement $λ$ [m]", "velocity $v$ [m/s]", "acceleration $γ$ [m/s²]"][k]
            )
            for suffix in ("png", "svg"):
                save(figure, folder / f"figure-{number + k:02d}.{suffix}")
    save(histories(result, SLIDERS, symbols), folder / "general.png")
    for suffix in ("png", "svg"):
        save(misprint(result, solver), folder / f"equation-11.{suffix}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "docs/figures"))
