"""The annotation of schemes can be read."""

from __future__ import annotations

import pytest

from parakin.files.reading import catalogue, load
from parakin.model.evaluation import graph_of
from parakin.views.scheme.scheme import scheme


@pytest.mark.parametrize("name", catalogue())
def test_labels_do_not_cover_one_another(name: str) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure = scheme(graph_of(load(name)), table=False)
    renderer = FigureCanvasAgg(figure).get_renderer()  # type: ignore[no-untyped-call]
    boxes = [text.get_window_extent(renderer) for text in figure.axes[0].texts]
    width, height = figure.bbox.size
    for k, a in enumerate(boxes):
        assert a.x0 >= 0
        assert a.y0 >= 0
        assert a.x1 <= width
        assert a.y1 <= height
        for b in boxes[:k]:
            common = max(0.0, min(a.x1, b.x1) - max(a.x0, b.x0))
            common *= max(0.0, min(a.y1, b.y1) - max(a.y0, b.y0))
            assert common < 0.15 * min(a.width * a.height, b.width * b.height)


def texts(name: str) -> list[str]:
    axes = scheme(graph_of(load(name)), table=False).axes[0]
    return [text.get_text() for text in axes.texts]


def test_the_bases_frame_is_there_and_the_platforms_where_it_is_another() -> None:
    assert {"x", "y", "z"} <= set(texts("four-bar"))
    assert not {"x′", "y′", "z′"} & set(texts("four-bar"))  # which has no platform
    assert {"x", "y", "z", "x′", "y′", "z′"} <= set(texts("gough-stewart"))


def test_links_are_named_where_they_are_few() -> None:
    assert {"crank", "coupler", "rocker"} <= set(texts("four-bar"))
    said = set(texts("gough-stewart"))
    assert "platform" in said
    assert not any(name.startswith(("cylinder", "piston")) for name in said)
