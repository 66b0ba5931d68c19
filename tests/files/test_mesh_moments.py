"""Masses from meshes: against closed forms of tetrahedra and boxes; open meshes are refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import parakin
from parakin.errors import InputError
from parakin.model.evaluation import graph_of

pytest.importorskip("trimesh")

MODEL = """name = "m"
[bodies.a.mesh]
file = "{}"
density = 3000
scale = 0.5
on_body = {{at = [1, 2, 3], turns = [["z", "90 deg"]]}}
[joints.A]
kind = "revolute"
parent = "base"
child = "a"
"""
TETRAHEDRON = """v 0 0 0
v 1 0 0
v 0 2 0
v 0 0 3
f 1 3 2
f 1 2 4
f 2 3 4
f 1 4 3
"""


def load(folder: Path, mesh: str, name: str = "m.obj") -> parakin.Mechanism:
    (folder / "m.toml").write_text(MODEL.format(name))
    (folder / "m.obj").write_text(mesh)
    return parakin.load(folder / "m.toml")


def test_a_tetrahedron_weighs_what_its_integrals_say(tmp_path: Path) -> None:
    """With legs a, b, c along the axes: V = abc/6, the centroid is (a, b, c)/4; about the corner
    the integral of x² is V a²/10, of xy V ab/20.
    """
    legs = np.array([1.0, 2.0, 3.0])
    volume, centroid = 1.0, legs / 4
    second = volume * (np.outer(legs, legs) + np.diag(legs**2)) / 20
    about_corner = np.trace(second) * np.eye(3) - second
    tensor = about_corner - volume * (
        centroid @ centroid * np.eye(3) - np.outer(centroid, centroid)
    )
    mechanism = load(tmp_path, TETRAHEDRON)
    mesh = mechanism.bodies[0].mesh
    assert mesh is not None
    assert mesh.moments is not None
    assert mesh.moments.volume == pytest.approx(volume, rel=1e-12)
    np.testing.assert_allclose(mesh.moments.centroid, centroid, rtol=1e-12)
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    expected = [tensor[pair] for pair in pairs]
    np.testing.assert_allclose(mesh.moments.inertia, expected, rtol=1e-12)
    # Half as large, a quarter of a turn about z, 3000 kg/m³.
    R = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    mass = graph_of(mechanism).dynamics.masses[1]
    assert mass.mass == pytest.approx(3000 / 8)
    np.testing.assert_allclose(mass.com, np.array([1, 2, 3]) + R @ centroid / 2)
    np.testing.assert_allclose(mass.inertia, 3000 / 32 * R @ tensor @ R.T, atol=1e-9)


def test_a_mechanism_built_in_python_has_its_meshes_read_when_it_is_compiled(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read = load(tmp_path, TETRAHEDRON)
    monkeypatch.chdir(tmp_path)
    mesh = read.bodies[0].mesh
    assert mesh is not None
    bare = mesh.model_copy(update={"moments": None})
    body = read.bodies[0].model_copy(update={"mesh": bare})
    mechanism = read.model_copy(update={"bodies": (body,), "origin": ""})
    solver = parakin.compile(mechanism, ["A"], machine_code=False)
    assert solver.graph.dynamics.masses[1].mass == pytest.approx(375.0)


def test_without_the_library_that_reads_meshes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(InputError) as refusal:
        load(tmp_path, TETRAHEDRON)
    assert "bodies.a.mesh.file: found trimesh is not installed" in str(refusal.value)
    assert "pip install 'parakin[view]'" in str(refusal.value)


REFUSED = {
    "open": (TETRAHEDRON.replace("f 1 4 3\n", ""), "an open mesh: 3 edges without two triangles"),
    "inside out": (
        TETRAHEDRON.replace("f 1 3 2", "f 1 2 3")
        .replace("f 1 2 4", "f 1 4 2")
        .replace("f 2 3 4", "f 2 4 3")
        .replace("f 1 4 3", "f 1 3 4"),
        "found a mesh of volume -1",
    ),
    "both ways": (TETRAHEDRON.replace("f 1 3 2", "f 1 2 3"), "face inwards and outwards"),
    "flat": (TETRAHEDRON.replace("0 0 3", "0.1 0.1 0"), "found a mesh of volume 0"),
    "nothing": ("v 0 0 0\n", "m.obj: found"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_meshes_that_enclose_no_volume_are_refused(case: str, tmp_path: Path) -> None:
    text, said = REFUSED[case]
    with pytest.raises(InputError) as refusal:
        load(tmp_path, text)
    assert said in str(refusal.value)
    assert "m.obj" in refusal.value.place


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("../m.obj", "m.toml: bodies.a.mesh.file: found '../m.obj'; expected a file in the folder"),
        ("none.obj", "none.obj: found no such file"),
        ("m.step", "found the suffix '.step'"),
    ],
)
def test_other_files_are_not_read(name: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as refusal:
        load(tmp_path, TETRAHEDRON, name)
    assert said in str(refusal.value)
