"""Three things that happen to a hexapod: its payload is let go, a leg loses its force, it parks.

    python examples/simulations.py [FOLDER]

draws a figure of each into the folder: heave and attitude of the platform, and efforts of the legs.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import parakin

if TYPE_CHECKING:
    import xarray as xr

FIGURES = Path(__file__).parents[1] / "docs" / "figures"
LEGS = [f"P{k}" for k in range(1, 7)]


def let_go() -> xr.Dataset:
    """100 kg fall off, and the legs still push as if they were there."""
    hexapod = parakin.compile(parakin.load("gough-stewart").with_payload("100 kg at platform"))
    return hexapod.simulate(0.4, hold=True, loads={"payload": 0.0}, rate=500)


def leg_lost() -> xr.Dataset:
    """One leg gives nothing any more, the others what they gave."""
    return parakin.compile("gough-stewart").simulate(0.3, {"P1": 0.0}, hold=True, rate=500)


def park() -> xr.Dataset:
    """Servos draw the legs in until they run into their stops, at 170 mm."""
    hexapod = parakin.load("gough-stewart")
    stop = {"stiffness": "2 MN/m", "dissipation": "2 s/m"}
    given: dict[str, Any] = hexapod.model_dump(exclude_unset=True)
    for joint in given["joints"]:
        if joint["name"] in LEGS:
            joint["stop"] = stop
    given["limits"] = {**given.get("limits", {}), **dict.fromkeys(LEGS, ("170 mm", "inf"))}
    lowering = {"law": "poly345", "by": "-195 mm", "duration": "1.5 s"}
    servo = {"stiffness": "200 kN/m", "damping": "8 kN s/m", "most": "2 kN", "target": lowering}
    rig = parakin.compile(parakin.Mechanism(**given))
    return rig.simulate(2.0, dict.fromkeys(LEGS, servo), hold=True, rate=500)


def drawn(result: xr.Dataset, title: str) -> Any:
    figure, (heave, attitude, effort) = plt.subplots(
        3, 1, sharex=True, figsize=(7, 6), layout="constrained"
    )
    time = result["time"]
    heave.plot(time, 1e3 * result["position"].sel(coordinate="platform.z"))
    heave.set(ylabel="platform.z [mm]", title=title)
    for name in ("roll", "pitch", "yaw"):
        angle = np.degrees(result["position"].sel(coordinate=f"platform.{name}"))
        attitude.plot(time, angle, label=name)
    attitude.set(ylabel="attitude [deg]")
    attitude.legend(ncols=3, fontsize="small")
    effort.plot(time, result["effort"], label=result["actuator"].values)
    effort.set(xlabel="time [s]", ylabel="effort [N]")
    effort.legend(ncols=6, fontsize="small")
    for axes in (heave, attitude, effort):
        axes.grid(alpha=0.3)
    return figure


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name, run, title in (
        ("let-go", let_go, "A payload let go"),
        ("leg-lost", leg_lost, "A leg's force lost"),
        ("park", park, "A rig that parks on its stops"),
    ):
        drawn(run(), title).savefig(folder / f"{name}.png", dpi=110)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else FIGURES)
