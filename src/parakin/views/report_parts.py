"""The parts of a report's page: sections, figures, tables and lists, as HTML."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.text import Text

_TONES = {"bold red": "bad", "bold yellow": "warn"}
_MANY = 12  # rows: longer tables may break between pages


def section(heading: str, *parts: str) -> str:
    """A section of the page."""
    return f"<section>\n<h2>{escape(heading)}</h2>\n" + "\n".join(parts) + "\n</section>"


def drawn(svg: str, caption: str) -> str:
    """A figure with its caption."""
    return f"<figure>{svg}<figcaption>{escape(caption)}</figcaption></figure>"


def table(headings: Sequence[str], rows: Sequence[Sequence[str]], kind: str = "") -> str:
    """A table of cells of HTML; empty columns are left out."""
    full = [k for k in range(len(headings)) if any(row[k] for row in rows)]
    headings, rows = [headings[k] for k in full], [[row[k] for k in full] for row in rows]
    lines = [f"<tr>{''.join(f'<td>{cell}</td>' for cell in row)}</tr>" for row in rows]
    head = "".join(f"<th>{escape(heading)}</th>" for heading in headings)
    short = f' class="{kind}{" short" if len(lines) <= _MANY else ""}"'
    return (
        f'<div class="scroll"><table{short}><thead><tr>{head}</tr></thead>\n<tbody>\n'
        + "\n".join(lines)
        + "\n</tbody></table></div>"
    )


def lines(shown: Iterable[Text]) -> str:
    """Lines for a terminal as a list, in similar colours."""
    items = []
    for line in shown:
        tone = _TONES.get(str(line.style), "")
        mark = f' class="{tone}"' if tone else ""
        items.append(f"<li{mark}>{escape(line.plain.strip())}</li>")
    return f"<ul>\n{''.join(items)}\n</ul>"


def at(value: str, time: float) -> str:
    """A value and when it was met."""
    return f"{value}<small>at {time:.4g} s</small>"
