"""The gallery, made when the documents are built: each mechanism of the catalogue with its picture,
its first motion as a scene that plays, its file and its source.

Sphinx extension. It writes `docs/gallery/` (pages and pictures) and `docs/recorded/` (scenes).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import parakin
from parakin.painting import picture
from parakin.recording import recorded
from parakin.repertoire import Repertoire, Shown

_HERE = Path(__file__).parent
_FRAME = """```{{raw}} html
<iframe src="../scenes/{name}.html" title="{name}" loading="lazy"
  style="width: 100%; aspect-ratio: 4 / 3; border: 1px solid #ccc"></iframe>
```"""


def setup(app: Any) -> dict[str, Any]:
    app.connect("builder-inited", lambda _: build())
    return {"parallel_read_safe": True}


def build() -> None:
    """Write pages, pictures and scenes."""
    pages, scenes = _HERE / "gallery", _HERE / "recorded" / "scenes"
    for folder in (pages, scenes):
        folder.mkdir(parents=True, exist_ok=True)
    names = list(parakin.catalogue())
    for name in names:
        repertoire = Repertoire(name)
        shown = repertoire.load(name)
        take = repertoire.play(shown, shown.motions[0]) if shown.motions else None
        picture(shown.drawing).savefig(pages / f"{name}.png", dpi=120)
        _changed(scenes / f"{name}.html", recorded(shown, take))
        _changed(pages / f"{name}.md", _page(shown))
    _changed(pages / "index.md", _index(names))


def _changed(path: Path, text: str) -> None:
    """Written only where it differs, so that Sphinx does not read it again."""
    if not path.exists() or path.read_text("utf-8") != text:
        path.write_text(text, "utf-8")


def _index(names: list[str]) -> str:
    titles = parakin.catalogue()
    cards = "\n\n".join(
        f"[![{name}]({name}.png){{width=45%}}]({name}.md)\n[{titles[name]}]({name}.md)"
        for name in names
    )
    listed = "\n".join(names)
    return (
        "# Gallery\n\nEvery mechanism of the catalogue. Its page has a scene that plays: turn it "
        "with the mouse. `parakin view NAME` opens the whole viewer.\n\n"
        f"{cards}\n\n```{{toctree}}\n:hidden:\n\n{listed}\n```\n"
    )


def _page(shown: Shown) -> str:
    mechanism = shown.mechanism
    file = Path(parakin.__file__).parent / "catalog" / f"{shown.name}.toml"
    motion = ""
    if shown.motions:
        title = str(mechanism.motions[shown.motions[0]].get("title", shown.motions[0]))
        motion = f"The scene plays the motion `{shown.motions[0]}`: {title}."
    said = [
        f"# {shown.name}",
        f"**{mechanism.title}**",
        f"Source: {mechanism.source}." if mechanism.source else "",
        mechanism.notes.strip(),
        f"Driven: {', '.join(f'`{name}`' for name in mechanism.driven)}.",
        f"```{{note}}\n{shown.problem}\n```" if shown.problem else "",
        _FRAME.format(name=shown.name),
        motion,
        f"![{shown.name} at home]({shown.name}.png)",
        f"`parakin view {shown.name}` opens the viewer. The file:",
        f"```toml\n{file.read_text('utf-8').rstrip()}\n```",
    ]
    return "\n\n".join(part for part in said if part) + "\n"
