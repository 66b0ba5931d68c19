"""What objects show of themselves in a notebook: lines and tables, as HTML."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from importlib.metadata import entry_points


def heading(name: str, text: str) -> str:
    """A line with a name in bold."""
    return f"<p><b>{escape(name)}</b>{': ' if text else ''}{escape(text)}</p>"


def lines(**texts: str) -> str:
    """A line for each text that is not empty, after what it is."""
    shown = [f"{key}: {escape(text)}" for key, text in texts.items() if text]
    return f"<p>{'<br>'.join(shown)}</p>" if shown else ""


def table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table of text; all cells are escaped."""
    head = "".join(f"<th>{escape(text)}</th>" for text in headings)
    body = "".join(
        f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>\n" for row in rows
    )
    return f"<table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{body}</tbody>\n</table>"


def picture(kind: str, shown: object) -> str:
    """A picture of something, by whatever is installed as an entry point of this kind to draw it;
    "" if nothing is.
    """
    return "".join(
        point.load()(shown) for point in entry_points(group="parakin.notebook", name=kind)
    )
