"""Where a rig can go: level in a plane, and in space, coloured by what limits it there; and where
the drives of a hexapod still hold its load.

    python examples/workspace.py [FOLDER]

draws them into the folder.
"""

from __future__ import annotations

import sys
from pathlib import Path

import parakin
from parakin.views import workspace_plot

HERE = Path(__file__).parent
FIGURES = HERE.parent / "docs" / "figures"


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    rig = parakin.compile(HERE / "rig.toml")
    level = parakin.workspace(rig, over=["platform.x", "platform.z"])
    title = "Where a rig goes level, ahead and up, and what limits it"
    workspace_plot.workspaces(level, title).savefig(folder / "workspace-slice.png", dpi=110)
    space = parakin.workspace(rig, points=81)
    title = "Where a rig goes level, in space"
    workspace_plot.workspaces(space, title).savefig(folder / "workspace-surface.png", dpi=110)
    loaded = parakin.load("gough-stewart").with_payload("100 kg at platform")
    held = parakin.workspace(
        parakin.compile(loaded),
        over=["platform.x", "platform.z"],
        within={"platform.x": (-1.5, 1.5), "platform.z": (0.05, 2.0)},
        forces=True,
    )
    figure = workspace_plot.workspaces(held, "Where the drives hold the load", "effort")
    figure.savefig(folder / "workspace-forces.png", dpi=110)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else FIGURES)
