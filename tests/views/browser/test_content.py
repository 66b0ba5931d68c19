"""What pages may show: the catalogue, and the files named and no others."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import parakin
from parakin.views.browser.content import Content, read_mesh

FOUR_BAR = (Path(parakin.__file__).parent / "catalogue" / "four-bar.toml").read_text("utf-8")


_STL = """solid s
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 1 0
endloop
endfacet
endsolid s
"""


def test_only_meshes_that_are_named_are_read(tmp_path: Path) -> None:
    shape, path = tmp_path / "coupler.stl", tmp_path / "mine.toml"
    shape.write_text(_STL, "ascii")
    body = re.search(r"(?m)^coupler = \{.*$", FOUR_BAR)
    assert body is not None, "the catalogue's file has changed"
    place = 'scale = 0.001, on_body = { at = [0, 0, "10 mm"] }'
    mesh = f'coupler = {{ mesh = {{ file = "coupler.stl", {place} }} }}'
    path.write_text(FOUR_BAR.replace(body[0], mesh), "utf-8")
    script = (
        "import sys; seen = []; "
        "sys.addaudithook(lambda e, given: seen.append(str(given[0])) if e == 'open' else None); "
        "from parakin.views.browser.content import Content; "
        "loaded = Content(sys.argv[1], meshes=tuple(sys.argv[2:])).load(sys.argv[1]); "
        "print(len(loaded.meshes), any('coupler.stl' in name for name in seen), loaded.problem)"
    )
    run = [sys.executable, "-c", script, str(path)]
    said = subprocess.run(run, capture_output=True, text=True, check=True).stdout
    assert said.startswith("0 False Not read")
    said = subprocess.run([*run, str(shape)], capture_output=True, text=True, check=True).stdout
    assert said.startswith("1 True ")
    loaded = Content(str(path), meshes=(str(shape),)).load(str(path))
    corners = np.unique(np.round(loaded.meshes["coupler"].vertices, 9), axis=0)
    np.testing.assert_allclose(corners, [[0, 0, 0.01], [0, 0.001, 0.01], [0.001, 0, 0.01]])


def test_meshes_of_limbs_are_numbered(tmp_path: Path) -> None:
    path = tmp_path / "legs.toml"
    path.write_text(
        """
name = "legs"
[bodies]
[joints]
[limbs.leg]
count = 2
each = { x = [0, 1] }
[limbs.leg.bodies]
"leg{i}" = { mesh = { file = "x{i}.stl", on_body = { at = ["x", 0, 0] } } }
[limbs.leg.joints]
"A{i}" = { kind = "revolute", parent = "base", child = "leg{i}", on_parent = { at = ["x", 0, 0] } }
""",
        "utf-8",
    )
    bodies = parakin.load(path).bodies
    assert [body.mesh and body.mesh.file for body in bodies] == ["x1.stl", "x2.stl"]


def test_a_broken_mesh_is_reported_by_its_name(tmp_path: Path) -> None:
    for name, content in (
        ("a.stl", b"\x00" * 90),
        ("b.obj", b"f 1 2 3"),
        ("c.glb", b"glTF"),
        ("d.ply", b""),
    ):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(parakin.InputError, match=re.escape(name)):
            read_mesh(tmp_path / name)
    with pytest.raises(parakin.InputError, match="suffix"):
        read_mesh(tmp_path / "e.dae")


def test_payloads_are_those_of_the_first_mechanism() -> None:
    content = Content("four-bar", payloads=("2 kg at coupler",))
    first = content.load("four-bar")
    assert [load.mass.mass for load in first.graph.dynamics.loads] == [2.0]
    assert content.playback(first, "turn").forces is not None
    assert content.load("slider-crank").graph.dynamics.loads == ()
