"""Published figures come out as published, and the document says what the cases give."""

from __future__ import annotations

from pathlib import Path

import pytest
from published_cases import CASES, Case, Figure, tables

FIGURES = [
    pytest.param(case, figure, id=f"{case.mechanism}, {figure.what}")
    for case in CASES
    for figure in case.figures
]
FAMILIES = {
    "Planar linkages",
    "Spatial loops",
    "Planar parallel robots",
    "Spherical robots",
    "Delta robots",
    "Hexapods",
    "Fewer freedoms",
    "Motion platforms",
    "Hybrids",
}
DOCUMENT = Path(__file__).parents[2] / "docs" / "published.md"


@pytest.mark.parametrize(("case", "figure"), FIGURES)
def test_figures_come_out_as_published_unless_the_source_is_wrong(
    case: Case, figure: Figure
) -> None:
    off = figure.value - float(figure.published)
    assert figure.agrees != bool(case.wrong), f"{off:+.3g} {figure.unit}"


def test_every_family_of_mechanisms_has_a_case() -> None:
    assert {case.family for case in CASES} == FAMILIES
    assert all(case.source and case.figures for case in CASES)


def test_a_wider_bound_is_explained() -> None:
    for case in CASES:
        assert case.note or all(figure.within is None for figure in case.figures)


@pytest.mark.repository
def test_the_document_holds_the_tables_of_the_cases() -> None:
    """`python tests/oracles/published_cases.py` prints what follows its introduction."""
    assert DOCUMENT.read_text("utf-8").partition("\n## ")[2] == tables().removeprefix("## ")
