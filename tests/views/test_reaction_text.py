"""Indeterminate reactions in words."""

from __future__ import annotations

from parakin.analysis.indeterminacy import Indeterminacy
from parakin.views.reaction_text import reaction_lines


def test_words() -> None:
    across = ("force z", "moment x", "moment y")
    found = Indeterminacy(20, {"A": across, "B": across}, {"A": across, "B": ("force x",)})
    first, second = (line.plain for line in reaction_lines(found))
    assert first == (
        "  reactions: 6 of 20 components are indeterminate, in A, B; efforts are not concerned"
    )
    assert second == (
        "  all would be determinate if these joints gave way: A (force z, moments x and y); "
        "B (force x)"
    )
    assert reaction_lines(Indeterminacy(20, {}, {})) == []
