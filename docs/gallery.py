"""The gallery, made when the documents are built: each mechanism of the catalogue with its picture,
its first motion as a scene that plays, its scheme, its file and its source.

Sphinx extension. It writes `docs/gallery/` (pages) and `docs/recorded/` (pictures and scenes).
"""

from __future__ import annotations

import html
import logging
from pathlib import Path
from typing import Any

import parakin
from parakin.views.browser.content import Content, LoadedMechanism
from parakin.views.browser.standalone import standalone_page
from parakin.views.scheme.scheme import save, scheme
from parakin.views.solids.painting import picture

_HERE = Path(__file__).parent
_FRAME = """```{{raw}} html
<iframe src="../scenes/{name}.html" title="{name}" loading="lazy"
  style="width: 100%; aspect-ratio: 4 / 3; border: 1px solid #ccc"></iframe>
```"""

_SCHEME = """```{{raw}} html
<img src="../pictures/{name}.svg" alt="kinematic scheme of {name}" style="background: white">
```"""
_STYLE = """<style>
.gallery {display: grid; grid-template-columns: repeat(auto-fill, minmax(14rem, 1fr)); gap: 1rem}
.gallery a {text-decoration: none; color: inherit; font-size: 0.9rem; line-height: 1.3}
.gallery img {width: 100%; aspect-ratio: 1; object-fit: contain; background: white}
</style>"""


def setup(_: Any) -> dict[str, Any]:
    logging.getLogger("websockets").setLevel(logging.WARNING)  # Sphinx prints what others log
    build()  # now, since Sphinx looks for the folder of scenes before any event
    return {"parallel_read_safe": True}


def build() -> None:
    """Write pages, pictures, schemes and scenes."""
    pages, extra = _HERE / "gallery", _HERE / "recorded"
    for folder in (pages, extra / "pictures", extra / "scenes"):
        folder.mkdir(parents=True, exist_ok=True)
    names = list(parakin.catalogue())
    for name in names:
        content = Content(name)
        loaded = content.load(name)
        playback = content.playback(loaded, loaded.motions[0]) if loaded.motions else None
        picture(loaded.drawing).savefig(extra / "pictures" / f"{name}.png", dpi=80)
        save(scheme(loaded.graph), extra / "pictures" / f"{name}.svg")
        _changed(extra / "scenes" / f"{name}.html", standalone_page(loaded, playback))
        _changed(pages / f"{name}.md", _page(loaded))
    _changed(pages / "index.md", _index(names))


def _changed(path: Path, text: str) -> None:
    """Written only where it differs, so that Sphinx does not read it again."""
    if not path.exists() or path.read_text("utf-8") != text:
        path.write_text(text, "utf-8")


def _index(names: list[str]) -> str:
    titles = parakin.catalogue()
    cards = "\n".join(
        f'<a href="{name}.html"><img src="../pictures/{name}.png" alt=""><b>{name}</b><br>'
        f"{html.escape(titles[name])}</a>"
        for name in names
    )
    listed = "\n".join(names)
    return (
        "# Gallery\n\nEvery mechanism of the catalogue. Its page has a scene that plays: turn it "
        "with the mouse. `parakin view NAME` opens the whole viewer.\n\n"
        f"```{{raw}} html\n{_STYLE}\n<div class=gallery>\n{cards}\n</div>\n```\n\n"
        f"```{{toctree}}\n:hidden:\n\n{listed}\n```\n"
    )


def _page(loaded: LoadedMechanism) -> str:
    mechanism = loaded.mechanism
    file = Path(parakin.__file__).parent / "catalogue" / f"{loaded.name}.toml"
    motion = ""
    if loaded.motions:
        title = str(mechanism.motions[loaded.motions[0]].get("title", loaded.motions[0]))
        motion = f"The scene plays the motion `{loaded.motions[0]}`: {title}."
    said = [
        f"# {loaded.name}",
        f"**{mechanism.title}**",
        f"Source: {mechanism.source}." if mechanism.source else "",
        mechanism.notes.strip(),
        f"Driven: {', '.join(f'`{name}`' for name in mechanism.driven)}.",
        f"```{{note}}\n{loaded.problem}\n```" if loaded.problem else "",
        _FRAME.format(name=loaded.name),
        motion,
        _SCHEME.format(name=loaded.name),
        f"`parakin view {loaded.name}` opens the viewer. The file:",
        f"```toml\n{file.read_text('utf-8').rstrip()}\n```",
    ]
    return "\n\n".join(part for part in said if part) + "\n"
