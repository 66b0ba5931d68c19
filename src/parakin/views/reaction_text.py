"""Which reactions are indeterminate, in words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich.text import Text

if TYPE_CHECKING:
    from parakin.analysis.indeterminacy import Indeterminacy


def reaction_lines(found: Indeterminacy) -> list[Text]:
    """Nothing where all are determinate; else how many are not, in which joints, and what would
    have to give way there.
    """
    if not found.count:
        return []
    released = "; ".join(f"{joint} ({_listed(parts)})" for joint, parts in found.releases.items())
    return [
        Text(
            f"  reactions: {found.count} of {found.components} components are indeterminate, in "
            f"{', '.join(found.unknown)}; efforts are not concerned"
        ),
        Text(f"  all would be determinate if these joints gave way: {released}"),
    ]


def _listed(parts: Sequence[str]) -> str:
    """For example: force z, moments x and y."""
    texts = []
    for kind in ("force", "moment"):
        axes = [part.removeprefix(f"{kind} ") for part in parts if part.startswith(kind)]
        if axes:
            named = " and ".join(filter(None, (", ".join(axes[:-1]), axes[-1])))
            texts.append(f"{kind}{'s' if len(axes) > 1 else ''} {named}")
    return ", ".join(texts)
