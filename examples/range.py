"""How far a rig goes, what stops it and how fast it may move, in one figure.

    python examples/range.py [FOLDER]

draws it into the folder.
"""

from __future__ import annotations

import sys
from pathlib import Path

import parakin
from parakin.views import range_plot

HERE = Path(__file__).parent
FIGURES = HERE.parent / "docs" / "figures"


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    found = parakin.range(parakin.compile(HERE / "rig.toml"), pairs=True)
    title = "Range of a rig from home: what stops each coordinate alone, and in pairs"
    range_plot.ranges(found, title).savefig(folder / "range.png", dpi=110)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else FIGURES)
