"""Where the platform's point can go, as meshes or lines in the scene of its mechanism.

Knows no page and no control: a workspace comes as `parakin.workspace` returns it.
"""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from parakin.design.probing import EDGE_WORDS
from parakin.design.workspace import workspace
from parakin.solving.solver import Solver
from parakin.views.colours import colours_of
from parakin.views.units import unit_of
from parakin.views.workspace_shares import decided, shares
from parakin.views.workspace_text import size_words, stopped_words

if TYPE_CHECKING:
    import xarray as xr

    from parakin.arrays import FloatArray, IndexArray

SLIDES = ("platform.x", "platform.y", "platform.z")
_NAMED = 11  # things that limit most of the boundary; the rest is shown alike
_OTHERS, _REST = "others", "#666666"
_NOTHING = -1  # number of what is no limit: the edge of what was looked at is not drawn
_OPACITY = 0.55


class Surface(NamedTuple):
    """A workspace's boundary in the base's frame: facets (p, d, 3) [m], triangles or lines; which
    of the words limits each (p,), -1 for none; the words, with a colour each; and a legend in HTML.
    """

    facets: FloatArray
    numbers: IndexArray
    words: tuple[str, ...]
    colours: tuple[str, ...]
    told: str


def slides_of(driven: tuple[str, ...]) -> tuple[str, ...]:
    """The platform's slides among driven coordinates, if there are enough to span something."""
    found = tuple(name for name in SLIDES if name in driven)
    return found if len(found) > 1 else ()


def surface_of(solver: Solver, y: FloatArray) -> Surface | str:
    """What a workspace about driven values (k,) looks like, or why there is none."""
    over = slides_of(solver.driven)
    found = workspace(solver, dict(zip(solver.driven, y.tolist(), strict=True)), over=over)
    if found.attrs["stopped"]:
        return stopped_words(found)
    own = found["boundary_connected"].values
    numbers = decided(found["boundary_stopped_by"].values[own])
    limits = [word for word in shares(found) if word != EDGE_WORDS]
    named = limits[:_NAMED]
    words = tuple(named) + ((_OTHERS,) if len(limits) > _NAMED else ())
    colours = tuple({**colours_of(named), _OTHERS: _REST}[word] for word in words)
    at = {word: k for k, word in enumerate(named)} | {EDGE_WORDS: _NOTHING}
    places = np.array([at.get(str(word), len(named)) for word in found["stop"].values])
    facets = _placed(solver, y, over, found["boundary"].values[own])
    known = bool(np.isfinite(facets).all())
    return Surface(
        facets, places[numbers], words, colours, _told(found, words, colours, whole=known)
    )


def _placed(
    solver: Solver, y: FloatArray, over: tuple[str, ...], corners: FloatArray
) -> FloatArray:
    """The platform's point (p, d, 3) in the base's frame where coordinates moved are as at corners
    (p, d, moved). A slide that is not moved may follow from those that are.
    """
    points = corners.reshape(-1, len(over))
    driven = y[:, None].repeat(len(points), axis=1)
    driven[[solver.driven.index(name) for name in over]] = points.T
    tick = None if len(over) == len(SLIDES) else solver.at(driven)
    found = np.empty((len(points), len(SLIDES)))
    for axis, name in enumerate(SLIDES):
        if name in solver.driven:
            found[:, axis] = driven[solver.driven.index(name)]
        elif tick is not None:
            found[:, axis] = tick.position[solver.coordinates.index(name)]
        found[:, axis] += solver.plan.offset(solver.graph.index(name, "workspace"))
    return found.reshape(*corners.shape[:2], len(SLIDES))


def _told(
    found: xr.Dataset, words: tuple[str, ...], colours: tuple[str, ...], *, whole: bool
) -> str:
    """The legend as HTML; whole: whether it is known where all of the boundary is."""
    over = found["over"].values.tolist()
    units = [unit_of(unit == "rad") for unit in found["driven_unit"].values]
    each = zip(found["driven"].values.tolist(), found["pose"].values.tolist(), units, strict=True)
    held = [
        f"{name} = {unit.plain(value, '.1f')}" for name, value, unit in each if name not in over
    ]
    known = shares(found)
    if _OTHERS in words:
        known[_OTHERS] = sum(
            share for word, share in known.items() if word not in (*words, EDGE_WORDS)
        )
    lines = [f"<b>Workspace</b> of the platform's point, {size_words(found)}"]
    if held:
        lines.append(f"at {escape(', '.join(held))}")
    for word, colour in zip(words, colours, strict=True):
        share = known.get(word, 0.0)
        lines.append(f'<span style="color:{colour}">■</span> {escape(word)} ({100 * share:.0f} %)')
    if EDGE_WORDS in known:
        lines.append("It goes on beyond what was looked at; nothing is drawn there.")
    if not whole:
        lines.append("Part of the outline is not drawn: where it is was not found.")
    return f'<div style="font-size:0.85em;padding:0 0.75em">{"<br>".join(lines)}</div>'


def add_surface(api: Any, surface: Surface, root: str) -> list[Any]:
    """Add it to a scene (viser's `SceneApi`), a mesh or lines for each colour. Returns the nodes.
    Of lines, those whose ends are not known are left out.
    """
    lines = surface.facets.shape[1] == 2
    known = np.isfinite(surface.facets).all(axis=(1, 2))
    nodes = []
    for number, colour in enumerate(surface.colours):
        mine = surface.facets[(surface.numbers == number) & known]
        if not len(mine):
            continue
        name, rgb = f"{root}/{number}", _rgb(colour)
        if lines:
            mine = mine.astype(np.float32)
            look = {"thickness": 4.0, "thickness_units": "screen"}
            nodes.append(api.add_line_segments(name, mine, colors=rgb, **look))
            continue
        vertices, faces = np.unique(mine.reshape(-1, 3), axis=0, return_inverse=True)
        node = api.add_mesh_simple(
            name,
            vertices,
            faces.reshape(-1, 3),
            color=rgb,
            opacity=_OPACITY,
            side="double",
            cast_shadow=False,
            receive_shadow=False,
        )
        nodes.append(node)
    return nodes


def _rgb(colour: str) -> tuple[int, int, int]:
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)
